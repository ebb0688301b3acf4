"""What a run may take if nobody says anything: a share of the memory, and a time for reading by the size of the file."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from queue import SimpleQueue
from threading import Timer
from typing import Any

import pytest

from pymeshfair.running.child import WorkerProcess
from pymeshfair.running.errors import RunTimeout
from pymeshfair.running.job import Compiling, Event, Job, PhaseStarted
from pymeshfair.running.memory import default_memory
from pymeshfair.running.messages import Assignment, encode_event
from pymeshfair.running.started import FreshProcess
from pymeshfair.running.supervise import run_job
from pymeshfair.running.watch import Watch

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
    with pytest.raises(RunTimeout, match=r"reading bone.ply: stopped after .* s, ten times as long"):
        run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply"))
    assert names_in(tmp_path) == set()


def test_compiling_is_no_part_of_the_time_for_reading(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However long a slow machine compiles, reading goes on after that and has what was left of its time, and no more."""
    monkeypatch.setattr("pymeshfair.running.watch._LOAD_SECONDS", 1.0)
    monkeypatch.setattr("pymeshfair.running.watch._LOAD_RATE", 1e12)
    job = Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply")
    reports: SimpleQueue[tuple[str, Any]] = SimpleQueue()

    def report(*said: Event) -> None:
        for event in said:
            reports.put(("report", encode_event(event)))

    def finish() -> None:
        report(Compiling(1, 2.0, False))
        for end in (("report", {"done": {"compiled": True}}), ("end", None), ("end", None)):
            reports.put(end)

    with WorkerProcess({}, SimpleQueue(), start=lambda: FreshProcess(None, "code")) as waiting:  # it does nothing
        report(PhaseStarted("reading"), Compiling(1, 0.0, True))
        Timer(2.0, finish).start()
        assert Watch(job, waiting, reports, lambda event: None).until_done(time.monotonic()) == {"compiled": True}
        report(PhaseStarted("reading"), Compiling(1, 0.0, True), Compiling(1, 2.0, False))
        began = time.monotonic()
        with pytest.raises(RunTimeout, match="probably damaged"):
            Watch(job, waiting, reports, lambda event: None).until_done(began)
        assert time.monotonic() - began >= 1.0
