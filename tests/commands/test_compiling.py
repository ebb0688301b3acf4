"""What a run shows while filters are compiled."""

from __future__ import annotations

from pathlib import Path

import pytest

from pymeshfair.commands.display import ProgressBar, ProgressLines
from pymeshfair.running.job import Compiling, StepStarted
from pymeshfair.running.supervise import workers_of_runs
from tests.running.runs import BONE

from .command_line import run_process

EVENTS = (StepStarted(1, 2, "Implicit Fairing"), Compiling(1, 0.0, True), Compiling(1, 2.5, False), Compiling(2, 2.5, True))


def test_lines_say_that_filters_are_compiled(capfd: pytest.CaptureFixture[str]) -> None:
    """Compiling is told once when it begins."""
    with ProgressLines() as show:
        for event in (*EVENTS, Compiling(2, 4.25, False)):
            show(event)
    assert capfd.readouterr().err.count("  compiling filters for this machine") == 1


def test_the_bar_says_that_filters_are_compiled_as_long_as_they_are() -> None:
    """The words beside the bar name the step, and how long compiling has taken so far; then the step alone."""
    with ProgressBar() as show:
        for event in EVENTS:
            show(event)
        assert show._bar.tasks[0].description == ("step 1 of 2: Implicit Fairing: compiling filters for this machine, 2 s so far")
        show(Compiling(2, 4.25, False))
        assert show._bar.tasks[0].description == "step 1 of 2: Implicit Fairing"


def test_a_worker_that_nobody_takes_is_ended() -> None:
    """A recipe that turns out to be wrong leaves no process behind; one that is taken is the one that was started ahead."""
    with workers_of_runs() as pool:
        pool.prepare()
        (waiting,) = pool._idle
        assert not waiting.has_ended()
    assert waiting.has_ended()
    with workers_of_runs() as pool:
        pool.prepare()
        (waiting,) = pool._idle
        with pool.lend() as taken:
            assert taken is waiting
        assert not taken.has_ended()
    assert taken.has_ended()


def test_a_run_that_can_keep_no_kernels_leaves_nothing(tmp_path: Path) -> None:
    """Where no folder for them can be written, no file is left in the temporary folder, either."""
    (tmp_path / "temporary").mkdir()
    # Code for another processor is not what an installation has compiled.
    environment = {"NUMBA_CACHE_DIR": "/proc/nowhere", "NUMBA_CPU_NAME": "generic", "TMPDIR": str(tmp_path / "temporary")}
    done = run_process("run", "smooth_taubin", BONE, "-o", tmp_path / "out.ply", "--no-measures", environment=environment)
    assert done.returncode == 0, done.stderr
    assert "compiling filters for this machine" in done.stderr
    assert not list((tmp_path / "temporary").iterdir())
