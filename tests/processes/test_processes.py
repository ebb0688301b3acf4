"""Processes that do work: copies of this one do what new ones do, each dies alone, and none is left behind."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import pytest

from pymeshfair.errors import ParameterError, RunError, RunTimeout, StepFailedError, WorkerDied
from pymeshfair.files.provenance import sha256_of
from pymeshfair.processes.process import LostProcessError, Pool, Process
from pymeshfair.processes.worker import DefectError, Order, answer, is_lack_of_memory, use_up
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import MODULES, run_job, workers_of_runs
from tests.running.runs import BONE, CRASHES, SLOW, SMOOTH, Given, names_in, recipe_of

IMPLICIT: Given = ("apply_coord_implicit_fairing", {})
#: a program that forks its workers, as the command does, and runs a recipe in them; its `sys.stdout` is a copy of descriptor 1
FORKS = """
import sys
from pathlib import Path
from pymeshfair.processes.environment import ONE_BLAS_THREAD
import os
os.environ.update(ONE_BLAS_THREAD)
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job, workers_of_runs
from pymeshfair.recipe import load_recipe

sys.stdout = os.fdopen(os.dup(1), "w")
with workers_of_runs(1, 2) as pool:
    pool.prepare()
    (process,) = pool._idle
    print(type(process._process).__name__)
    for name in sys.argv[3:]:
        run_job(Job(load_recipe(sys.argv[1]), Path(sys.argv[2]), Path(name), threads=2), workers=pool)
    print(pool._idle == [process])
"""


@pytest.fixture(autouse=True)
def tests_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process imports the functions of this module."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))


def number_of_this() -> int:
    """The process that does the task."""
    return os.getpid()


def die() -> None:
    """End the process that does the task."""
    os.kill(os.getpid(), signal.SIGKILL)


def refuse(word: str) -> None:
    """An error of ours."""
    raise ParameterError(f"no {word}")


def fail() -> None:
    """A defect."""
    raise ZeroDivisionError("by nothing")


def test_answers_and_errors_come_back() -> None:
    """A result, an error of ours with its words, and a defect with its traceback; the same process does the next order."""
    with Pool() as pool:
        first = pool.submit(number_of_this).result()
        assert str(first.result) == first.process.split()[-1] != str(os.getpid())
        assert first.peak_memory is None or first.peak_memory > 10e6
        refused = pool.submit(refuse, "thing").result()
        assert isinstance(refused.error, ParameterError)
        assert str(refused.error) == "no thing"
        broken = pool.submit(fail).result()
        assert isinstance(broken.error, DefectError)
        assert "ZeroDivisionError" in str(broken.error)
        assert "in fail" in broken.details
        assert pool.submit(number_of_this).result().result == first.result


def lack(kind: type[Exception], words: str) -> None:
    """An error of a library that gets no memory."""
    raise kind(words)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (MemoryError, ""),
        (RuntimeError, "can't start new thread"),
        (RuntimeError, "std::bad_alloc"),
        (OSError, "[Errno 12] Cannot allocate memory"),
        (ImportError, "libscipy.so: failed to map segment from shared object"),
    ],
)
def test_a_lack_of_memory_is_no_defect(kind: type[Exception], words: str) -> None:
    """Whatever the words in which a library says that memory ran out, the answer of the process is that memory ran out."""
    assert isinstance(answer(lack, kind, words).error, MemoryError)


@pytest.mark.parametrize(
    "error",
    [
        FileNotFoundError(errno.ENOENT, "No such file or directory", "a scan out of memory, really"),
        RuntimeError("File does not exists: memoryerror.ply"),
        RuntimeError("Unable to open file: /scans/out of memory/bone.ply"),
        OSError("no decoder", 5),
    ],
)
def test_the_name_of_a_file_is_no_lack_of_memory(error: Exception) -> None:
    """An error that names a file keeps its kind, whatever the words of the name."""
    assert not is_lack_of_memory(error)


@pytest.mark.parametrize(
    ("words", "is_lack"),
    [
        ("Unable to open file: /scans/an out of memory test/bone.ply", False),
        ('Error encountered while loading file:\n"my out of memory scan.ply"', False),
        ("cannot identify image file '/scans/a bad_alloc or out of memory picture.png'", False),
        ("out of memory while reading /scans/an out of memory test/bone.ply", True),
        ("terminate called after throwing an instance of 'std::bad_alloc'", True),
        ("/usr/lib/libscipy.so: failed to map segment from shared object", True),
    ],
)
def test_names_with_blanks_are_no_lack_of_memory(words: str, is_lack: bool) -> None:
    """The words of paths and of quoted files do not count; the same words beside them do."""
    for kind in (RuntimeError, OSError):
        assert isinstance(answer(lack, kind, words).error, MemoryError) == is_lack


@pytest.mark.slow
def test_a_lost_process_costs_a_retry() -> None:
    """One that was killed before its order is replaced; an order that kills each is given up."""
    with Pool() as pool:
        number = pool.submit(number_of_this).result().result
        os.kill(number, signal.SIGKILL)
        assert pool.submit(number_of_this).result().result != number
        with pytest.raises(LostProcessError, match="ended with status -9"):
            pool.submit(die).result()


def test_a_process_that_was_killed_while_it_was_idle_is_not_lent() -> None:
    """The next run of a pool whose waiting process was killed, as for lack of memory, gets another one."""
    with Pool() as pool:
        with pool.lend() as process:
            number = process.do(Order.of(number_of_this)).result
        os.kill(number, signal.SIGKILL)
        while not process.has_ended():
            time.sleep(0.01)
        with pool.lend() as other:
            assert other.do(Order.of(number_of_this)).result != number


def test_a_process_that_is_used_up_is_not_lent_again() -> None:
    """A task that leaves something behind is the last of its process."""
    with Pool() as pool:
        number = pool.submit(number_of_this).result().result
        assert pool.submit(use_up).result().is_used_up
        assert pool.submit(number_of_this).result().result != number


def test_a_closed_pool_lends_nothing() -> None:
    """It has ended its processes, also those that were lent."""
    with Pool() as pool, pool.lend() as process:
        pool.close()
        assert process.wait() == -signal.SIGKILL
    with pytest.raises(RunError, match="the workers are ended"), pool.lend():
        pass


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")
def test_a_forked_worker_writes_what_a_new_one_writes(tmp_path: Path) -> None:
    """Byte for byte, in the first run of a copy of the command's process and in its second."""
    recipe = "smooth_implicit"
    from pymeshfair.recipe import load_recipe

    names = [tmp_path / "first.ply", tmp_path / "second.ply"]
    done = subprocess.run([sys.executable, "-c", FORKS, recipe, BONE, *names], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["ForkedProcess", "True"]
    fresh = run_job(Job(load_recipe(recipe), BONE, tmp_path / "fresh.ply", threads=2))
    assert {sha256_of(name) for name in names} == {sha256_of(fresh.output)}


def test_a_crash_costs_its_worker_alone(tmp_path: Path) -> None:
    """The step and the signal are named, nothing is left behind, and the next run gets another process."""
    with workers_of_runs(1, 2) as pool:
        pool.prepare()
        with pytest.raises(WorkerDied, match=r"step 2 of 2, .* \(test.mlx:4\): the worker process crashed \(SIGSEGV\)") as caught:
            run_job(Job(recipe_of(SMOOTH, CRASHES), BONE, tmp_path / "out.ply"), workers=pool)
        assert "Segmentation fault" in caught.value.details
        assert names_in(tmp_path) == set()
        run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply"), workers=pool)


class _Known(Pool):
    """A pool that remembers the numbers of the processes that it lent."""

    numbers: ClassVar[list[int]] = []

    @contextmanager
    def lend(self) -> Iterator[Process]:
        with super().lend() as process:
            self.numbers.append(process.pid)
            yield process


def test_a_worker_that_hangs_is_ended(tmp_path: Path) -> None:
    """When its time is up a worker is killed and waited for."""
    with (known := _Known(modules=MODULES)):
        with pytest.raises(RunTimeout, match="step 1 of 1, 'Taubin Smooth'"):
            run_job(Job(recipe_of(SLOW), BONE, tmp_path / "out.ply", timeout=3.0), workers=known)
        with pytest.raises(ProcessLookupError):
            os.kill(known.numbers[0], 0)
    assert names_in(tmp_path) == set()


def test_the_process_of_a_run_that_failed_is_not_lent_again(tmp_path: Path) -> None:
    """What the run has left in its memory would count for the next one."""
    fails: Given = ("apply_coord_bilaplacian_smoothing", {"detail_size": "0edge"})
    with (known := _Known(modules=MODULES)):
        run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "first.ply"), workers=known)
        with pytest.raises(StepFailedError):
            run_job(Job(recipe_of(fails), BONE, tmp_path / "second.ply"), workers=known)
        run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "third.ply"), workers=known)
    first, second, third = known.numbers[-3:]
    assert (first == second, second == third) == (True, False)


def test_nothing_in_the_working_folder_is_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files there with the names of libraries, as a folder of scans from elsewhere may have, are not run by any process."""
    traps = {f"{name}.py" for name in ("json", "numpy", "pymeshlab", "runpy")}
    for name in traps:
        (tmp_path / name).write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    run_job(Job(recipe_of(SMOOTH, IMPLICIT), BONE, tmp_path / "fresh.ply"))
    assert names_in(tmp_path) == traps | {"fresh.ply", "fresh.ply.provenance.json"}


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")
def test_a_fork_is_ended_before_it_has_a_group(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that refuses its options at once does not wait five seconds for a worker that has only begun."""
    monkeypatch.setattr(os, "setsid", lambda: time.sleep(20))
    process = Process(forked=True)
    process.close()
    assert process._process.returncode == -signal.SIGKILL


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")
def test_a_process_with_threads_is_not_forked(tmp_path: Path) -> None:
    """Where a library starts a thread as it is loaded every worker is a new interpreter, and the run is none the worse."""
    (tmp_path / "lib").mkdir()
    program = "import threading, time\nthreading.Thread(target=time.sleep, args=(1e6,), daemon=True).start()\n"
    (tmp_path / "lib" / "sitecustomize.py").write_text(program)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "lib")}
    command = [sys.executable, "-c", FORKS, "smooth_taubin", str(BONE), str(tmp_path / "a.ply")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["Popen", "True"]
