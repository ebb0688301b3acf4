"""Runs the tuned recipe on the whole scan, exactly as the command does."""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from ..recipe import Recipe
from ..running.job import Event, Job, RunResult
from ..running.supervise import run_job
from .bench import Stopped


class Finisher:
    """One run of a file into a file, in a thread."""

    def __init__(self) -> None:
        """See the class."""
        self._stopped = threading.Event()

    def stop(self) -> None:
        """Stop a run at its next sign of life."""
        self._stopped.set()

    async def run(
        self, recipe: Recipe, scan: Path, output: Path, overwrite: bool, on_event: Callable[[Event], None]
    ) -> RunResult:
        """Run the recipe; see `pymeshfair.running.supervise.run_job`."""
        stopped = self._stopped = threading.Event()

        def passed_on(event: Event) -> None:
            if stopped.is_set():
                raise Stopped("stopped")
            on_event(event)

        job = Job(recipe, scan, output, overwrite=overwrite, command=tuple(sys.argv))
        return await asyncio.to_thread(run_job, job, passed_on)
