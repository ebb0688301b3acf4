"""What only POSIX has, and the fallback that runs use elsewhere."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pymeshfair.errors import RunTimeout, StepFailedError, WorkerDied
from pymeshfair.files.writing import STAGE_PREFIX, staging_folder
from pymeshfair.operating_system import FORCE_PORTABLE, System, this_system
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job

from .runs import BONE, CRASHES, SLOW, SMOOTH, names_in, recipe_of

NEEDS_POSIX = pytest.mark.skipif(os.name != "posix", reason="needs POSIX")
SYSTEMS = [System(is_posix=False), pytest.param(System(is_posix=True), marks=NEEDS_POSIX)]


@pytest.fixture
def portable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes this process and its workers use the fallback."""
    monkeypatch.setenv(FORCE_PORTABLE, "1")


def test_the_system_is_that_of_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """POSIX is used where it is, the fallback elsewhere and where the environment says so."""
    assert this_system().is_posix == (os.name == "posix")
    monkeypatch.setenv(FORCE_PORTABLE, "1")
    assert not this_system().is_posix
    monkeypatch.delenv(FORCE_PORTABLE)
    monkeypatch.setattr(os, "name", "nt")
    assert not this_system().is_posix


@pytest.mark.parametrize("system", SYSTEMS, ids=["portable", "posix"])
def test_a_child_is_seen_to_run_and_to_end(system: System) -> None:
    """A child runs until it is killed, and is gone afterwards."""
    program = [sys.executable, "-c", "input()"]
    with subprocess.Popen(program, stdin=subprocess.PIPE, **system.own_session()) as child:
        assert not system.has_ended(child)
        system.kill(child)
        deadline = time.monotonic() + 30
        while not system.has_ended(child):
            assert time.monotonic() < deadline
            time.sleep(0.01)


@pytest.mark.parametrize("system", SYSTEMS, ids=["portable", "posix"])
def test_a_child_without_a_group_of_its_own_is_killed_too(system: System) -> None:
    """A new fork that has not made its session yet does not live on."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as child:
        system.kill(child)
        assert child.wait(30) == -signal.SIGKILL


@pytest.mark.parametrize("system", SYSTEMS, ids=["portable", "posix"])
def test_files_and_folders_are_flushed_and_moved(system: System, tmp_path: Path) -> None:
    """A file and a folder can be flushed; a file held open gets its new name, or a second one has it."""
    with (tmp_path / "new").open("xb"):
        system.move_open_file(tmp_path / "new", tmp_path / "old")
    assert (tmp_path / "old").exists()
    system.flush(tmp_path / "old")
    system.flush(tmp_path)
    assert system.processors() >= 1


def test_a_run_needs_nothing_of_posix(portable: None, tmp_path: Path) -> None:
    """With the fallback a run writes the same bytes, and its temporary folder goes."""
    target = tmp_path / "clean.ply"
    result = run_job(Job(recipe_of(SMOOTH), BONE, target, memory_limit=1 << 40))
    assert names_in(tmp_path) == {"clean.ply", "clean.ply.provenance.json"}
    assert result.peak_memory is None
    fallback = target.read_bytes()
    os.environ.pop(FORCE_PORTABLE)
    run_job(Job(recipe_of(SMOOTH), BONE, target, overwrite=True))
    assert target.read_bytes() == fallback


@pytest.mark.slow
def test_every_bad_end_is_told_without_posix(portable: None, tmp_path: Path) -> None:
    """With the fallback a filter that refuses, a worker that crashes and one that is too slow are errors of their kinds."""
    refused = ("apply_coord_taubin_fairing", {"selected": True})
    with pytest.raises(StepFailedError, match=r"step 1 of 1, 'Taubin Fairing'"):
        run_job(Job(recipe_of(refused), BONE, tmp_path / "a.ply"))
    with pytest.raises(WorkerDied, match="step 1 of 1"):
        run_job(Job(recipe_of(CRASHES), BONE, tmp_path / "a.ply"))
    with pytest.raises(RunTimeout):
        run_job(Job(recipe_of(SLOW), BONE, tmp_path / "a.ply", timeout=4.0))
    assert names_in(tmp_path) == set()


def test_without_locks_no_folder_in_use_is_taken_for_an_abandoned_one(portable: None, tmp_path: Path) -> None:
    """Where nobody can tell who is alive, a folder stays rather than being removed under a run, however old it is."""
    with staging_folder(tmp_path / "a.ply") as one:
        os.utime(one, (0, 0))
        with staging_folder(tmp_path / "b.ply"):
            assert one.exists()
    assert not [name for name in names_in(tmp_path) if name.startswith(STAGE_PREFIX)]
