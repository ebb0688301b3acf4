"""One run at a time to one output."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.writing import output_lock
from pymeshfair.running.job import Job, StepStarted
from pymeshfair.running.supervise import run_job

from .runs import BONE, SMOOTH, names_in, recipe_of

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs locks of files")


def test_the_second_of_two_runs_to_one_output_is_refused(tmp_path: Path) -> None:
    """While a run goes on, another one to the same file fails at once and says so; one to another file does not."""
    output = tmp_path / "out.ply"
    refused: list[str] = []

    def show(event: object) -> None:
        if isinstance(event, StepStarted):
            with pytest.raises(OutputError, match="another run is writing it") as caught:
                run_job(Job(recipe_of(SMOOTH), BONE, output))
            refused.append(str(caught.value))
            run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "other.ply"))

    run_job(Job(recipe_of(SMOOTH), BONE, output), show)
    assert len(refused) == 1
    assert {n for n in names_in(tmp_path) if "provenance" not in n} == {"out.ply", "other.ply"}


def test_a_dead_process_holds_no_lock(tmp_path: Path) -> None:
    """A process that was killed while it had the lock leaves a file, which stops nobody and goes with the next."""
    program = (
        "import os, signal, sys; from pathlib import Path; from pymeshfair.files.writing import output_lock\n"
        f"with output_lock(Path({str(tmp_path / 'out.ply')!r})): os.kill(os.getpid(), signal.SIGKILL)"
    )
    assert subprocess.run([sys.executable, "-c", program]).returncode == -9
    assert len(names_in(tmp_path)) == 1
    with output_lock(tmp_path / "out.ply"):
        pass
    assert names_in(tmp_path) == set()


def test_never_two_at_once(tmp_path: Path) -> None:
    """Of many threads that try again and again, one at a time has the lock, though each removes the file."""
    inside, most, rounds = 0, 0, 0

    def work() -> None:
        nonlocal inside, most, rounds
        own = 0
        while own < 50:  # a try that fails counts for nothing
            with contextlib.suppress(OutputError), output_lock(tmp_path / "out.ply"):
                inside += 1
                most = max(most, inside)
                own, rounds = own + 1, rounds + 1
                inside -= 1

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == 1
    assert rounds == 200
    assert names_in(tmp_path) == set()
