"""Real scripts of MeshLab 2010 to 2025: each is read, or what is wrong with it is said line by line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pymeshfair.scripts import format_script, parse_script, read_script
from tests.scripts.texts import problems

FOLDER = Path(os.environ.get("PYMESHFAIR_DATA", "/nowhere")) / "mlx_wild"
SCRIPTS = sorted(FOLDER.glob("*.mlx"))

pytestmark = pytest.mark.skipif(not SCRIPTS, reason="set PYMESHFAIR_DATA to the folder that has mlx_wild/")


@pytest.mark.parametrize("path", SCRIPTS or [FOLDER], ids=lambda p: p.stem)
def test_a_real_script_is_read_or_explained(path: Path) -> None:
    """A script reads and writes back alike, or every problem has its line and names a filter where it is about one."""
    data = path.read_bytes()
    found = problems(data)
    if found:
        assert all(p.line is not None and 1 <= p.line <= data.count(b"\n") + 1 for p in found)
        assert all(p.filter is not None for p in found if "well-formed" not in p.message)
    else:
        read = read_script(path)
        assert parse_script(format_script(read).encode(), "again") == read.with_defaults()


def test_what_is_wrong_with_real_scripts_is_mostly_their_age() -> None:
    """Of the 44 scripts 15 are good today; most of the others have renamed filters, and each is given its new name."""
    verdicts = [problems(path.read_bytes()) for path in SCRIPTS]
    renamed = [[p for p in found if "MeshLab has renamed this filter" in p.message] for found in verdicts]
    assert (len(SCRIPTS), sum(not found for found in verdicts)) == (44, 15)
    assert sum(map(bool, renamed)) > 44 / 2 - 15 / 2
    assert all(p.suggestion for found in renamed for p in found)
