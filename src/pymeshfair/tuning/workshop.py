"""Keeps workers: one that runs what was asked last, and one that is ready when the first had to be killed."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import shutil
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias, cast

from ..errors import RunError
from ..operating_system import this_system
from ..running.environment import program_of, worker_environment
from ..running.memory import default_memory
from ..running.messages import Assignment, parse_talk, to_line
from ..scripts.script import Script

#: the numbers of a result, and its mesh for the browser
Result: TypeAlias = tuple[dict[str, Any], bytes]
#: bytes of the longest report of a worker
_LONGEST = 1 << 26


class Worker:
    """One worker process."""

    def __init__(self, process: asyncio.subprocess.Process, stage: Path) -> None:
        """See `started`."""
        self._process = process
        self._talk = asyncio.create_task(self._listen())
        self.stage = stage
        self.step = 0
        self.on_event: Callable[[dict[str, Any]], None] = lambda event: None

    @classmethod
    async def started(cls, scan: Path, stage: Path, scene: Path | None) -> Worker:
        """A new process that begins to read the scan, and writes it to `scene` for the browser if that is given."""
        stage.mkdir(parents=True)
        process = await asyncio.create_subprocess_exec(
            *program_of("pymeshfair.tuning.worker"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=worker_environment(None),
            limit=_LONGEST,
            **this_system().own_session(),
        )
        worker = cls(process, stage)
        worker.send(
            {
                "scan": str(scan),
                "stage": str(stage),
                "scene": None if scene is None else str(scene),
                "memory_limit": default_memory(),
            }
        )
        return worker

    def send(self, order: Mapping[str, Any]) -> None:
        """Give an order."""
        assert self._process.stdin is not None
        self._process.stdin.write(to_line(order))

    async def until(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The first report that is wanted; events on the way are passed on.

        Raises:
            RunError: the process has ended, or could not read the scan.
        """
        assert self._process.stdout is not None
        while line := await self._process.stdout.readline():
            report: dict[str, Any] = json.loads(line)
            if wanted(report):
                return report
            if "failed" in report:
                raise RunError(report["failed"])
            if "event" in report:
                self.step = report["index"] if report["event"] == "StepStarted" else self.step
                self.on_event(report)
        status = await self._process.wait()
        raise RunError(f"the worker process ended with status {status}; the filter probably crashed on this mesh")

    async def end(self) -> None:
        """Kill it, with whatever it has started."""
        with contextlib.suppress(ProcessLookupError):
            this_system().kill(cast("Any", self._process))
        self._talk.cancel()
        await self._process.wait()
        shutil.rmtree(self.stage, ignore_errors=True)

    async def _listen(self) -> None:
        """MeshLab tells its progress on stderr."""
        assert self._process.stderr is not None
        with contextlib.suppress(ValueError):  # a line without end
            async for line in self._process.stderr:
                talk = parse_talk(line.decode("utf-8", "replace").rstrip())
                if talk.fraction is not None and self.step:
                    self.on_event({"event": "StepProgress", "index": self.step, "fraction": talk.fraction})


class Workshop:
    """Runs the recipe that was asked for last, on one scan.

    Args:
        scan: the file.
        folder: for what is made; it comes to be when it is needed.
    """

    def __init__(self, scan: Path, folder: Path) -> None:
        """See the class; nothing is started before `open`."""
        self._scan = scan
        self._folder = folder
        self._numbers = itertools.count(1)
        self._worker: Worker | None = None
        self._spare: Worker | None = None
        self._busy: asyncio.Task[Result] | None = None
        self._opening: Result | None = None
        self._lock = asyncio.Lock()

    async def open(self) -> Result:
        """What is told of the scan, and the scan for the browser; the first time a worker is started that reads it.

        Raises:
            RunError: the scan cannot be read.
        """
        async with self._lock:
            if self._opening is None:
                scene = self._folder / "scan.scene"
                self._worker = await self._started(scene)
                report = await self._worker.until(lambda report: "ready" in report)
                self._opening = report["ready"], scene.read_bytes()
        return self._opening

    async def begin(self, number: int, script: Script, on_event: Callable[[dict[str, Any]], None]) -> asyncio.Task[Result]:
        """Run a script; a run that is still going on is killed, and its task cancelled.

        Args:
            number: of the run.
            script: the steps.
            on_event: called with what goes on.

        Returns:
            The task that gives what came of it; it raises `RunError` if the run failed.
        """
        async with self._lock:
            await self._stop()
            self._worker = self._worker or await self._started(None)
            self._spare = self._spare or await self._started(None)
            self._busy = asyncio.create_task(self._run(self._worker, number, script, on_event))
            return self._busy

    async def stop(self) -> bool:
        """Kill the run that is going on; whether there was one."""
        async with self._lock:
            return await self._stop()

    async def close(self) -> None:
        """Kill everything."""
        async with self._lock:
            await self._stop()
            for worker in (self._worker, self._spare):
                if worker is not None:
                    await worker.end()
            self._worker = self._spare = None

    async def _stop(self) -> bool:
        """As `stop`; the spare worker takes the place of the killed one."""
        task, self._busy = self._busy, None
        if task is None or task.done():
            return False
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError, RunError):
            await task
        killed, self._worker, self._spare = self._worker, self._spare, None
        if killed is not None:
            await killed.end()
        return True

    async def _run(self, worker: Worker, number: int, script: Script, on_event: Callable[[dict[str, Any]], None]) -> Result:
        stage = worker.stage / str(number)
        (stage / "new").mkdir(parents=True)
        (stage / "old").mkdir()
        assignment = Assignment(script.steps, self._scan, stage, output=stage / "result.ply")
        worker.step, worker.on_event = 0, on_event
        worker.send({"run": number, "assignment": assignment.to_document()})
        try:
            report = await worker.until(lambda report: report.get("run") == number)
        except RunError:  # it died; the spare one takes its place
            self._worker, self._spare = self._spare, None
            await worker.end()
            raise
        if "failed" in report:
            raise RunError(report["failed"])
        done = report["done"]
        scene = Path(done.pop("scene")).read_bytes()
        shutil.rmtree(stage, ignore_errors=True)
        return {**done, "seconds": report["seconds"]}, scene

    async def _started(self, scene: Path | None) -> Worker:
        return await Worker.started(self._scan, self._folder / f"worker-{next(self._numbers)}", scene)
