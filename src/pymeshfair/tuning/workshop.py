"""The workers of the page: one for the last request, and a spare one in case the first is killed."""

import asyncio
import contextlib
import shutil
import tempfile
import time
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

from ..errors import PymeshfairError, RunError
from ..operating_system import this_system
from ..processes.process import LostProcessError, Process
from ..processes.worker import Order
from ..recipe import Recipe
from ..running.job import Event, Job, StepProgress, StepStarted
from ..running.supervise import MODULES, parse_talk
from ..scripts.script import Script
from .bench import STOP, Result, Stopped, at_bench

#: seconds in which a filter that can be stopped stops
_PATIENCE = 1.0


class Worker:
    """One process with a scan, which it reads at once."""

    def __init__(self, scan: Path, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._process = Process(None, MODULES)
        self._scan = scan
        self._stage = self._run = Path(tempfile.mkdtemp(prefix="worker-", dir=folder))
        self._opening = asyncio.create_task(self._result("opening"))

    async def opened(self) -> Result:
        """The measures and the mesh of the scan."""
        return await asyncio.shield(self._opening)

    async def run(self, script: Script, on_event: Callable[[Event], None]) -> Result:
        """Run a script on the scan."""
        await self.opened()
        self._run = Path(tempfile.mkdtemp(dir=self._stage))
        (self._run / "new").mkdir()
        job = Job(Recipe("tuned", script), self._scan, self._run / "result.ply")
        return await self._result("run", job, self._run, on_event=on_event)

    async def measure(self) -> Result:
        """The numbers of the last result."""
        return await self._result("measure", self._run)

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
        shutil.rmtree(self._stage, ignore_errors=True)

    async def _result(self, work: str, *arguments: Any, on_event: Callable[[Event], None] = lambda event: None) -> Result:
        order = Order.of(at_bench, self._scan, work, *arguments, memory_limit=this_system().usable_memory())
        loop, started = asyncio.get_running_loop(), time.perf_counter()
        step = 0

        def take(kind: str, item: Any) -> None:
            nonlocal step
            if kind == "event":
                step = item.index if isinstance(item, StepStarted) else step
                loop.call_soon_threadsafe(on_event, item)
            elif kind == "talk" and step and (fraction := parse_talk(item).fraction) is not None:
                loop.call_soon_threadsafe(on_event, StepProgress(step, fraction))

        answer = await asyncio.to_thread(self._process.do, order, take)
        if answer.error is None:
            numbers, scene = answer.result
            return {**numbers, "seconds": round(time.perf_counter() - started, 2)}, scene
        if isinstance(answer.error, MemoryError | PymeshfairError | OSError) and not isinstance(answer.error, Stopped):
            raise RunError(str(answer.error)) from answer.error
        raise answer.error


class Workshop:
    """Runs the recipe that was asked for last, on one scan."""

    def __init__(self, scan: Path, folder: Path) -> None:
        """Nothing is started before `open`."""
        self._scan = scan
        self._folder = folder
        self._worker: Worker | None = None
        self._spare: Worker | None = None
        self._busy: asyncio.Task[Result] | None = None
        self._lock = asyncio.Lock()

    async def open(self) -> Result:
        """The measures of the scan, and the scan for the browser."""
        async with self._lock:
            self._worker = self._worker or Worker(self._scan, self._folder)
            return await self._worker.opened()

    async def begin(self, script: Script, on_event: Callable[[Event], None]) -> asyncio.Task[Result]:
        """Run a script; a run that is still going on is stopped first. The task raises `RunError` if the run failed."""
        async with self._lock:
            await self._stop()
            self._worker = self._worker or Worker(self._scan, self._folder)
            self._spare = self._spare or Worker(self._scan, self._folder)
            return self._begun(self._worker, self._worker.run(script, on_event))

    async def measure(self, running: asyncio.Task[Result]) -> asyncio.Task[Result] | None:
        """Measure what a run gave; None if it was stopped by now, such as by another one."""
        async with self._lock:
            if running is not self._busy or self._worker is None:
                return None
            return self._begun(self._worker, self._worker.measure())

    async def stop(self) -> None:
        """Stop what is going on."""
        async with self._lock:
            await self._stop()

    async def close(self) -> None:
        """Kill everything."""
        async with self._lock:
            await self._stop()
            for worker in filter(None, (self._worker, self._spare)):
                await worker.end()
            self._worker = self._spare = None

    async def _stop(self) -> None:
        """What does not stop by itself is killed, and the spare worker takes its place."""
        task, self._busy = self._busy, None
        if task is None or task.done() or self._worker is None:
            return
        self._worker.ask_to_stop()
        await asyncio.wait({task}, timeout=_PATIENCE)
        if not task.done():
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError, RunError):
                await task
            await self._lose(self._worker)

    def _begun(self, worker: Worker, work: Coroutine[Any, Any, Result]) -> asyncio.Task[Result]:
        self._busy = asyncio.create_task(self._done(worker, work))
        return self._busy

    async def _done(self, worker: Worker, work: Coroutine[Any, Any, Result]) -> Result:
        try:
            return await work
        except LostProcessError as error:
            await self._lose(worker)
            raise RunError(f"{error}; the filter probably crashed on this mesh") from error

    async def _lose(self, worker: Worker) -> None:
        self._worker, self._spare = self._spare, None
        await worker.end()
