"""An upgraded script does what the old one meant, in plain pymeshlab, wherever `upgrade` says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from upgraded_meaning import measured, renamed, verdict


@pytest.mark.slow
def test_scripts_with_old_names_do_what_their_grades_say(tmp_path: Path) -> None:
    """Of 100 scripts and more, one for each old name, none that "means the same" leaves other bits on one of three meshes."""
    cases = renamed(tmp_path)
    assert len(cases) >= 100
    verdicts = {case.name: verdict(results) for case, results in zip(cases, measured(cases), strict=True)}
    assert not [case.name for case in cases if case.same_meaning and verdicts[case.name] == "differs"]
    assert sum(words == "agrees" for words in verdicts.values()) >= 90
