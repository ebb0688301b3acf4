"""The workers of the page: one for the last request, and a spare one in case the first is killed."""

import asyncio
import contextlib
import itertools
import shutil
import tempfile
import time
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

from ..errors import PymeshfairError, RunError
from ..operating_system import this_system
from ..processes.process import LostProcessError, Process
from ..processes.worker import Answer, Order
from ..recipe import Recipe
from ..running.job import Event, Job, StepProgress, StepStarted
from ..running.supervise import MODULES, parse_talk
from ..scripts.script import Script
from .bench import STOP, Result, Stopped, measure_result, open_scan, run_recipe

#: seconds in which a filter that can be stopped stops
_PATIENCE = 1.0


class Worker:
    """One process with a scan."""

    def __init__(self, scan: Path, stage: Path) -> None:
        """Start it, and let it read the scan."""
        self._process = Process(None, MODULES)
        self._scan = scan
        self.stage = stage
        stage.mkdir(parents=True)
        self._run = stage
        self._opening = asyncio.create_task(self._result(open_scan, scan))

    async def opened(self) -> Result:
        """The measures and the mesh of the scan."""
        return await asyncio.shield(self._opening)

    async def run(self, number: int, script: Script, on_event: Callable[[Event], None]) -> Result:
        """Run a script on the scan."""
        await self.opened()
        self._run = Path(tempfile.mkdtemp(prefix=f"{number}-", dir=self.stage))
        (self._run / "new").mkdir()
        job = Job(Recipe("tuned", script), self._scan, self._run / "result.ply")
        return await self._result(run_recipe, job, self._run, on_event=on_event)

    async def measure(self) -> Result:
        """The numbers of the last result."""
        return await self._result(measure_result, self._scan, self._run)

    def ask_to_stop(self) -> None:
        """Let what runs stop at its next sign of life."""
        with contextlib.suppress(OSError):
            (self._run / STOP).touch()

    async def end(self) -> None:
        """Kill it and the processes that it has started."""
        self._process.kill()
        with contextlib.suppress(PymeshfairError):
            await self._opening
        await asyncio.to_thread(self._process.close)
        shutil.rmtree(self.stage, ignore_errors=True)

    async def _result(
        self, task: Callable[..., Result], *arguments: Any, on_event: Callable[[Event], None] = lambda event: None
    ) -> Result:
        order = Order.of(task, *arguments, memory_limit=this_system().usable_memory())
        loop, started = asyncio.get_running_loop(), time.perf_counter()

        def tell(event: Event) -> None:
            loop.call_soon_threadsafe(on_event, event)

        answer = await asyncio.to_thread(self._follow, order, tell)
        if answer.error is None:
            numbers, scene = answer.result
            return {**numbers, "seconds": round(time.perf_counter() - started, 2)}, scene
        if isinstance(answer.error, Stopped):
            raise answer.error
        if isinstance(answer.error, MemoryError | PymeshfairError | OSError):
            raise RunError(str(answer.error)) from answer.error
        raise answer.error

    def _follow(self, order: Order, on_event: Callable[[Any], None]) -> Answer:
        """Give an order and wait for the answer, in a thread."""
        step = 0

        def take(kind: str, item: Any) -> None:
            nonlocal step
            if kind == "event":
                step = item.index if isinstance(item, StepStarted) else step
                on_event(item)
            elif kind == "talk" and step and (fraction := parse_talk(item).fraction) is not None:
                on_event(StepProgress(step, fraction))

        return self._process.do(order, take)


class Workshop:
    """Runs the recipe that was asked for last, on one scan."""

    def __init__(self, scan: Path, folder: Path) -> None:
        """See the class; nothing is started before `open`, and the folder for what is made comes to be when it is needed."""
        self._scan = scan
        self._folder = folder
        self._numbers = itertools.count(1)
        self._number = 0  # of the run that was begun last; 0 once it was stopped
        self._worker: Worker | None = None
        self._spare: Worker | None = None
        self._busy: asyncio.Task[Result] | None = None
        self._opening: Result | None = None
        self._lock = asyncio.Lock()

    async def open(self) -> Result:
        """The measures of the scan, and the scan for the browser; the first call starts a worker that reads it."""
        async with self._lock:
            if self._opening is None:
                self._worker = self._started()
                self._opening = await self._worker.opened()
        return self._opening

    async def begin(self, number: int, script: Script, on_event: Callable[[Event], None]) -> asyncio.Task[Result]:
        """Run a script; a run that is still going on is stopped first. The task raises `RunError` if the run failed."""
        async with self._lock:
            await self._stop()
            self._worker = self._worker or self._started()
            self._spare = self._spare or self._started()
            self._number = number
            self._busy = asyncio.create_task(self._done(self._worker, self._worker.run(number, script, on_event)))
            return self._busy

    async def measure(self, number: int) -> asyncio.Task[Result] | None:
        """Measure what a run gave; None if another one has begun by now."""
        async with self._lock:
            if number != self._number or self._worker is None:
                return None
            self._busy = asyncio.create_task(self._done(self._worker, self._worker.measure()))
            return self._busy

    async def stop(self) -> None:
        """Stop what is going on."""
        async with self._lock:
            await self._stop()

    async def close(self) -> None:
        """Kill everything."""
        async with self._lock:
            await self._stop()
            for worker in (self._worker, self._spare):
                if worker is not None:
                    await worker.end()
            self._worker = self._spare = None

    async def _stop(self) -> None:
        """As `stop`. What does not stop by itself is killed, and the spare worker takes its place."""
        task, self._busy, self._number = self._busy, None, 0
        if task is None or task.done() or self._worker is None:
            return
        self._worker.ask_to_stop()
        await asyncio.wait({task}, timeout=_PATIENCE)
        if task.done():
            return
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError, RunError):
            await task
        killed, self._worker, self._spare = self._worker, self._spare, None
        await killed.end()

    async def _done(self, worker: Worker, work: Coroutine[Any, Any, Result]) -> Result:
        try:
            return await work
        except LostProcessError as error:  # the spare one takes its place
            self._worker, self._spare = self._spare, None
            await worker.end()
            raise RunError(f"{error}; the filter probably crashed on this mesh") from error

    def _started(self) -> Worker:
        return Worker(self._scan, self._folder / f"worker-{next(self._numbers)}")
