"""The scan that is tuned on, or the part of a large one: what recipes make of it, and what the page shows of both.

A `Workshop` has a process that stays, with a `Bench` in it, so that libraries, the scan and what earlier steps made of it are
there when a parameter changes.
"""

import asyncio
import contextlib
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..declaration.parameters import unit_of_scan
from ..errors import PymeshfairError, RunError
from ..filters.geometry import vector_lengths
from ..filters.inspection import mean_curvature, symmetric_limits
from ..looking.comparison import compare, same_elements, state_of
from ..looking.words import comparison_lines, distance_table, measure_rows
from ..mesh_data import MeshData
from ..operating_system import this_system
from ..processes.process import LostProcessError, Process
from ..processes.worker import Order, report
from ..recipe import Recipe
from ..report.scene import Shown, pack_scene, shown_mesh
from ..running.job import Event, Job, PhaseStarted, StepProgress, StepStarted
from ..running.measuring import measure
from ..running.read import ReadMesh, read_mesh
from ..running.session import Earlier, Session
from ..running.supervise import MODULES, parse_talk
from ..scripts.script import Script

#: vertices of the largest scan that is taken whole at first, and of the part of a larger one
MOST_VERTICES, PART = 200_000, 50_000
#: the box of coordinates is so much larger than the scan, as results may grow
_ROOM = 1.5
#: the file in the folder of a run that asks it to stop
STOP = "stop"

#: the numbers of a result, and its mesh for the browser
Result: TypeAlias = tuple[dict[str, Any], bytes]


@dataclass(frozen=True)
class Scan:
    """A scan to tune on."""

    path: Path
    vertices: int  # how many it has
    diagonal: float  # of its bounding box, in mesh units
    mean_edge: float  # in mesh units
    part: int | None  # about so many of its vertices are tuned on; None for all
    warnings: tuple[str, ...]  # contents that reading could not keep


def prepared_scan(path: Path, *, most: int = MOST_VERTICES, part: int = PART) -> Scan:
    """Read a scan; one of over `most` vertices is tuned on a part of it."""
    read = read_mesh(path)
    count = len(read.mesh.vertices)
    return Scan(path, count, read.measured.diagonal, read.measured.resolution(), part if count > most else None, read.warnings)


def part_of(mesh: MeshData, count: int) -> MeshData:
    """About so many vertices around the foremost of those in the middle of the first view, so that they are seen from outside."""
    vertices = mesh.vertices
    aside = vector_lengths(vertices[:, :2] - np.median(vertices[:, :2], axis=0))
    central = np.flatnonzero(aside <= max(float(aside.min()), 0.01 * mesh.diagonal))
    distances = vector_lengths(vertices - vertices[central[vertices[central, 2].argmax()]])
    return mesh.part(distances <= np.partition(distances, count)[count])


class Stopped(RunError):  # noqa: N818 - says what happened
    """The page asked for the run to stop."""


class Bench:
    """One scan, and what recipes make of it."""

    def __init__(self, scan: Path, part: int | None) -> None:
        """Read and measure the scan, or a part of so many vertices."""
        read = read_mesh(scan)
        if part is not None:
            mesh = part_of(read.mesh, part)
            read = ReadMesh(scan, mesh, measure(mesh), read.warnings)
        self._before = state_of(read)
        self._unit = unit_of_scan(None, self._before.mesh.unit)
        vertices = self._before.mesh.vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        self._box = 0.5 * (low + high), 0.5 * _ROOM * float((high - low).max()) or 1.0
        self._scan = self._shown("scan", self._before.mesh)
        self._result: tuple[MeshData, Shown] | None = None
        self._earlier = Earlier()

    def opening(self) -> Result:
        """The measures and the mesh that the page shows before a run."""
        return {"measures": measure_rows({"scan": self._before.measures}, self._unit)}, self._packed(self._scan)

    def run(self, job: Job, stage: Path) -> Result:
        """Carry out the steps of a job; the mesh, without the numbers of `measure`, which take longer than many filters."""
        session = Session(job, stage, _stoppable(stage))
        outcome = session.carry_out(self._before.mesh, earlier=self._earlier)
        self._result = outcome.result, self._shown("result", outcome.result)
        numbers = {
            "warnings": session.warnings,
            "tried": [step.values.get("tried", []) for step in outcome.steps],
        }
        return numbers, self._packed(self._result[1])

    def measure(self, stage: Path) -> Result:
        """The numbers of the last result, and its mesh with distances as colours."""
        assert self._result is not None
        mesh, shown = self._result
        tell = _stoppable(stage)
        tell(PhaseStarted("comparing"))
        after = state_of(ReadMesh(stage / "result.ply", mesh, measure(mesh), ()))
        tell(PhaseStarted("comparing"))
        compared = compare(self._before, after)
        numbers = {
            "measures": measure_rows({"scan": self._before.measures, "result": after.measures}, self._unit),
            "distance": distance_table(compared.comparison, self._unit),
            "lines": comparison_lines(compared.comparison, self._unit),
        }
        scalars = {**shown.scalars, "distance": compared.after_distance.at_vertices[shown.kept]}
        return numbers, self._packed(replace(shown, scalars=scalars))

    def _shown(self, name: str, mesh: MeshData) -> Shown:
        first = self._before.mesh
        scalars = {"curvature": mean_curvature(mesh.vertices, mesh.faces)} if len(mesh.faces) else {}
        return shown_mesh(
            name, mesh, scalars=scalars, like=self._scan if mesh is not first and same_elements(mesh, first) else None
        )

    def _packed(self, shown: Shown) -> bytes:
        limits = {key: symmetric_limits(np.asarray(values)) for key, values in shown.scalars.items()}
        return pack_scene([shown], limits, box=self._box, unit=self._unit).message


def _stoppable(stage: Path) -> Callable[[Event], None]:
    """Reports events, and stops the work at the next one after the page has asked for that by a file."""

    def tell(event: Event) -> None:
        if (stage / STOP).exists():
            raise Stopped("stopped")
        report(event)

    return tell


#: the bench of a scan, which a process reads once
_bench = cache(Bench)


def at_bench(scan: Scan, work: str, *arguments: Any) -> Result:
    """The result of a method of the bench of a scan: the task of a process that stays."""
    result: Result = getattr(_bench(scan.path, scan.part), work)(*arguments)
    return result


#: seconds in which a filter that can be stopped stops
_PATIENCE = 1.0


class Workshop:
    """Runs recipes on one scan, one at a time."""

    def __init__(self, scan: Scan, folder: Path) -> None:
        """Nothing is started before `open`; results are written to the folder."""
        self._scan = scan
        self._folder = self._stage = folder
        self._process: Process | None = None
        self._busy: asyncio.Task[Result] | None = None
        self._lock = asyncio.Lock()

    async def open(self) -> Result:
        """The measures of the scan, and the scan for the browser."""
        async with self._lock:
            await self._stop()
            return await self._result("opening")

    async def begin(self, script: Script, on_event: Callable[[Event], None]) -> asyncio.Task[Result]:
        """Run a script; a run that is still going on is stopped first. The task raises `RunError` if the run failed."""
        async with self._lock:
            await self._stop()
            self._stage = Path(tempfile.mkdtemp(dir=self._folder))
            (self._stage / "new").mkdir()
            job = Job(Recipe("tuned", script), self._scan.path, self._stage / "result.ply")
            self._busy = asyncio.create_task(self._result("run", job, self._stage, on_event=on_event))
            return self._busy

    async def measure(self, running: asyncio.Task[Result]) -> asyncio.Task[Result] | None:
        """Measure what a run gave; None if it was stopped by now, such as by another one."""
        async with self._lock:
            if running is not self._busy:
                return None
            self._busy = asyncio.create_task(self._result("measure", self._stage))
            return self._busy

    async def stop(self) -> None:
        """Stop what is going on."""
        async with self._lock:
            await self._stop()

    async def close(self) -> None:
        """Stop, and end the process."""
        async with self._lock:
            await self._stop()
            await self._lose()

    async def _stop(self) -> None:
        """What does not stop by itself is killed."""
        task, self._busy = self._busy, None
        if task is None or task.done():
            return
        (self._stage / STOP).touch()
        await asyncio.wait({task}, timeout=_PATIENCE)
        if not task.done():
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError, RunError):
                await task
            await self._lose()

    async def _lose(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            await asyncio.to_thread(process.close)

    async def _result(self, work: str, *arguments: Any, on_event: Callable[[Event], None] = lambda event: None) -> Result:
        self._process = self._process or Process(None, MODULES)
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

        try:
            answer = await asyncio.to_thread(self._process.do, order, take)
        except LostProcessError as error:
            await self._lose()
            raise RunError(f"{error}; the filter probably crashed on this mesh") from error
        if answer.error is None:
            numbers, scene = answer.result
            return {**numbers, "seconds": round(time.perf_counter() - started, 2)}, scene
        if isinstance(answer.error, MemoryError | PymeshfairError | OSError) and not isinstance(answer.error, Stopped):
            raise RunError(str(answer.error)) from answer.error
        raise answer.error
