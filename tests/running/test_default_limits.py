"""What a run may take if nobody says anything: a share of the memory, and a time for reading by the size of the file."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from pymeshfair.running.errors import RunTimeout
from pymeshfair.running.job import Job
from pymeshfair.running.memory import default_memory
from pymeshfair.running.messages import Assignment
from pymeshfair.running.supervise import run_job

from .runs import BONE, SMOOTH, names_in, recipe_of


@pytest.mark.skipif(sys.platform == "win32", reason="the system does not say how much memory there is")
def test_a_run_is_held_to_a_share_of_the_memory(tmp_path: Path) -> None:
    """Without --memory a worker gets 80 % of what the machine or the container has, and no more."""
    given = Assignment.of(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply"), tmp_path).memory_limit
    assert given == default_memory()
    assert given is not None
    assert 0 < given <= 0.8 * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def test_reading_has_its_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that takes longer to read than files of its size do ends the run, which names it; nothing is left behind."""
    monkeypatch.setattr("pymeshfair.running.watch._LOAD_SECONDS", 0.0)
    monkeypatch.setattr("pymeshfair.running.watch._LOAD_RATE", 1e12)
    with pytest.raises(RunTimeout, match=r"reading bone.ply: stopped after"):
        run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply"))
    assert names_in(tmp_path) == set()
