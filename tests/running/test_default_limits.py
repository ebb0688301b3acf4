"""What a run may take by default: a share of the memory, and a time for reading by the size of the file."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from queue import SimpleQueue
from threading import Timer

import pytest

from pymeshfair.errors import RunTimeout
from pymeshfair.operating_system import this_system
from pymeshfair.processes.process import Items, Process
from pymeshfair.processes.worker import Answer, Order
from pymeshfair.running.job import Compiling, Event, Job, PhaseStarted, Report
from pymeshfair.running.supervise import Watch, run_job

from .runs import BONE, SMOOTH, names_in, recipe_of


@pytest.mark.skipif(sys.platform == "win32", reason="the system does not say how much memory there is")
def test_a_run_is_held_to_a_share_of_the_memory() -> None:
    """Without --memory a worker gets 80 % of what the machine or the container has, and no more."""
    given = this_system().usable_memory()
    assert given is not None
    assert 0 < given <= 0.8 * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def test_reading_has_its_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that takes longer to read than files of its size do ends the run, which names it; nothing is left behind."""
    monkeypatch.setattr("pymeshfair.running.supervise._LOAD_SECONDS", 0.0)
    monkeypatch.setattr("pymeshfair.running.supervise._LOAD_RATE", 1e12)
    with pytest.raises(RunTimeout, match=r"reading bone.ply: stopped after .* s, ten times as long"):
        run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply"))
    assert names_in(tmp_path) == set()


def test_further_layers_have_their_time_for_reading(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The time to read grows with the sizes of all files that are read, not with that of the first alone."""
    monkeypatch.setattr("pymeshfair.running.supervise._LOAD_SECONDS", 0.0)
    monkeypatch.setattr("pymeshfair.running.supervise._LOAD_RATE", 1.0)
    job = Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply", others=(BONE, BONE))
    process = Process()
    process.close()
    watch = Watch(job, process, SimpleQueue(), lambda event: None)
    watch._take("event", PhaseStarted("reading"))
    assert watch._load_seconds == 3 * BONE.stat().st_size


def test_compiling_is_no_part_of_the_time_for_reading(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However long a slow machine compiles, reading goes on after that and has what was left of its time, and no more."""
    monkeypatch.setattr("pymeshfair.running.supervise._LOAD_SECONDS", 1.0)
    monkeypatch.setattr("pymeshfair.running.supervise._LOAD_RATE", 1e12)
    job = Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply")
    items: Items = SimpleQueue()
    compiled = Report(input={}, steps=())

    def say(*events: Event) -> None:
        for event in events:
            items.put(("event", event))

    def finish() -> None:
        say(Compiling(1, 2.0, False))
        items.put(("answer", Answer(compiled)))
        items.put(("silent", None))

    process, order = Process(), Order.of(time.sleep, 60.0)  # it says nothing
    try:
        say(PhaseStarted("reading"), Compiling(1, 0.0, True))
        Timer(2.0, finish).start()
        assert Watch(job, process, items, lambda event: None).until_done(order, time.monotonic()) == compiled
        say(PhaseStarted("reading"), Compiling(1, 0.0, True), Compiling(1, 2.0, False))
        began = time.monotonic()
        with pytest.raises(RunTimeout, match="probably damaged"):
            Watch(job, process, items, lambda event: None).until_done(order, began)
        assert time.monotonic() - began >= 1.0
    finally:
        process.close()
