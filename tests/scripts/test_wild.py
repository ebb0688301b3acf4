"""Real scripts of MeshLab 2010 to 2025: each is read, or what is wrong with it is said line by line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pymeshfair.scripts import ScriptError, format_script, parse_script, read_script, upgrade_script
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


def test_all_real_scripts_but_two_are_upgraded_once_and_for_all() -> None:
    """42 of 44 become valid, 31 of them with the meaning they had; upgraded again they stay the same bytes.

    The two others ask for a filter that never was and for one that has no successor.
    """
    same, refused = 0, {}
    for path in SCRIPTS:
        try:
            upgraded = upgrade_script(path.read_bytes(), path.name)
        except ScriptError as error:
            refused[path.name.partition("__")[0]] = str(error)
            continue
        same += not upgraded.warnings
        text = format_script(upgraded.script, known_mesh=False)
        again = upgrade_script(text.encode(), "again")
        assert again.changes == ()
        assert format_script(again.script, known_mesh=False) == text
    assert refused.keys() == {"emb_46228350227_normals.mlx", "marian42+pointcloudprinter"}
    assert all("there is no such filter today" in message for message in refused.values())
    assert same == 31
