"""Workers that are forked from one process: they do what fresh ones do, and die alone."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.files.provenance import sha256_of
from pymeshfair.filters.geometry import edge_lengths
from pymeshfair.running.errors import RunTimeout, WorkerDied
from pymeshfair.running.forks import ForkedProcess, ForkServer
from pymeshfair.running.job import Job
from pymeshfair.running.loaded import loaded, loaded_since
from pymeshfair.running.started import FreshProcess
from pymeshfair.running.supervise import run_job
from tests.meshes import tetrahedron

from .runs import BONE, CRASHES, SLOW, SMOOTH, Given, names_in, recipe_of

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")

IMPLICIT: Given = ("apply_coord_implicit_fairing", {})


def job_of(output: Path, *steps: Given, timeout: float | None = None) -> Job:
    """A job of these steps on the bone."""
    return Job(recipe_of(*steps), BONE, output, timeout=timeout, threads=2)


@pytest.fixture(scope="module")
def server() -> Iterator[ForkServer]:
    """One server for all tests here, as for all scans of a batch."""
    with ForkServer(threads=2) as server:
        yield server


def test_a_forked_worker_writes_what_a_fresh_one_writes(tmp_path: Path, server: ForkServer) -> None:
    """Byte for byte, with filters of both kinds: in the first fork, and in one that found everything loaded."""
    fresh = run_job(job_of(tmp_path / "fresh.ply", SMOOTH, IMPLICIT))
    for name in ("first.ply", "second.ply"):
        forked = run_job(job_of(tmp_path / name, SMOOTH, IMPLICIT), start=server.start)
        assert sha256_of(forked.output) == sha256_of(fresh.output)
        assert (forked.before, forked.after, forked.warnings) == (fresh.before, fresh.after, fresh.warnings)


def test_a_crash_costs_its_worker_alone(tmp_path: Path, server: ForkServer) -> None:
    """The step and the signal are named as ever, nothing is left behind, and the server forks the next worker."""
    with pytest.raises(WorkerDied, match=r"step 2 of 2, .* \(test.mlx:4\): the worker process crashed \(SIGSEGV\)") as caught:
        run_job(job_of(tmp_path / "out.ply", SMOOTH, CRASHES), start=server.start)
    assert "Segmentation fault" in caught.value.details
    assert names_in(tmp_path) == set()
    started: list[object] = []

    def start() -> ForkedProcess | FreshProcess:
        process = server.start()
        started.append(process)
        assert isinstance(process, ForkedProcess | FreshProcess)
        return process

    run_job(job_of(tmp_path / "out.ply", SMOOTH), start=start)
    assert isinstance(started[0], ForkedProcess)


def test_a_worker_that_hangs_is_ended(tmp_path: Path, server: ForkServer) -> None:
    """When its time is up a forked worker is killed and waited for, with its number."""
    pids: list[int] = []

    def start() -> ForkedProcess:
        process = server.start()
        assert isinstance(process, ForkedProcess)
        pids.append(process.pid)
        return process

    with pytest.raises(RunTimeout, match="step 1 of 1, 'Taubin Smooth'"):
        run_job(job_of(tmp_path / "out.ply", SLOW, timeout=3.0), start=start)
    with pytest.raises(ProcessLookupError):
        os.kill(pids[0], 0)
    assert names_in(tmp_path) == set()


def test_a_server_that_was_killed_is_replaced(tmp_path: Path) -> None:
    """The worker under way is lost with it, as if killed itself; the next is forked from a new server."""
    with ForkServer(threads=1) as server:
        run_job(job_of(tmp_path / "a.ply", SMOOTH), start=server.start)
        assert server.pid is not None
        os.kill(server.pid, signal.SIGKILL)
        first = server.pid
        run_job(job_of(tmp_path / "b.ply", SMOOTH), start=server.start)
        assert server.pid not in (None, first)
    assert sha256_of(tmp_path / "a.ply") == sha256_of(tmp_path / "b.ply")


def test_nothing_in_the_working_folder_is_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files there with the names of libraries, as a folder of scans from elsewhere may have, are not run by any process."""
    traps = {f"{name}.py" for name in ("json", "numpy", "pymeshlab", "runpy")}
    for name in traps:
        (tmp_path / name).write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    run_job(job_of(tmp_path / "fresh.ply", SMOOTH))
    with ForkServer(threads=2) as server:
        run_job(job_of(tmp_path / "forked.ply", SMOOTH), start=server.start)
        assert server.pid is not None
    made = {f"{name}{end}" for name in ("fresh.ply", "forked.ply") for end in ("", ".provenance.json")}
    assert names_in(tmp_path) == traps | made


def test_a_process_with_threads_is_not_forked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a library starts a thread as it is loaded every worker is a fresh process, and the run is none the worse."""
    (tmp_path / "lib").mkdir()
    program = "import threading, time\nthreading.Thread(target=time.sleep, args=(1e6,), daemon=True).start()\n"
    (tmp_path / "lib" / "sitecustomize.py").write_text(program)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "lib"))
    with ForkServer(threads=1) as server:
        process = server.start()
        assert isinstance(process, FreshProcess)
        process.kill()
        assert process.wait(10.0) == -signal.SIGKILL
        for stream in (process.stdin, process.stdout, process.stderr):
            stream.close()
        assert server.pid is None


def test_what_was_loaded_is_told_but_for_kernels_with_threads() -> None:
    """A kernel that a process has used since is named with its signature; one that starts numba's threads never is."""
    before = (loaded()[0], frozenset[tuple[str, str, tuple[object, ...]]]())
    edge_lengths(*tetrahedron())
    from pymeshfair.filters.mesh import normalised_mesh

    normalised_mesh(*tetrahedron()).restored(np.zeros((4, 3)))
    _, kernels = pickle.loads(loaded_since(before))
    names = {(module.rpartition(".")[2], name) for module, name, _ in kernels}
    assert names
    assert not {name for module, name in names if module == "normalised"} & {"_normalise", "_restore"}
