"""Runs recipes on the scan of the tuning page, or on a part of a large scan, and compares the results with the scan.

A `Workshop` keeps a process with a `Bench`, so that libraries, the scan and the results of earlier steps stay loaded when a
parameter changes.
"""

import asyncio
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np

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
from ..report.scene import Shown, least_box, pack_scene, shown_mesh
from ..running.job import Event, Job, PhaseStarted, StepProgress, StepStarted
from ..running.measuring import measure
from ..running.read import ReadMesh, read_mesh
from ..running.session import Outcome, RunCache, Session, changed_shape, removed_contents, without_values
from ..running.supervise import MODULES, parse_talk

#: the largest number of vertices of a scan that is used whole; the approximate number of vertices in the part of a larger scan
MOST_VERTICES, PART = 200_000, 50_000
#: the side of the cube for coordinates (see `pack_scene`), in longest sides of the scan; results may be larger than the scan
_ROOM = 1.5
#: a run stops if a file with this name appears in its folder
STOP = "stop"

#: the numbers of a result, and its mesh for the browser
Result: TypeAlias = tuple[dict[str, Any], bytes]


@dataclass(frozen=True)
class Scan:
    """The scan of the tuning page."""

    path: Path
    vertices: int
    diagonal: float  # of the bounding box, in mesh units
    mean_edge: float  # the mean edge length, or for a cloud the mean distance to the nearest point, in mesh units
    part: int | None  # the approximate number of vertices of the part that is used; None for the whole scan
    warnings: tuple[str, ...]  # about the file


def prepared_scan(path: Path, *, most: int = MOST_VERTICES, part: int = PART) -> Scan:
    """Reads a scan; if it has more than `most` vertices, only a part of it will be used."""
    read = read_mesh(path)
    count = len(read.mesh.vertices)
    return Scan(path, count, read.measured.diagonal, read.measured.resolution(), part if count > most else None, read.warnings)


def part_of(mesh: MeshData, count: int) -> MeshData:
    """Returns about `count` vertices: those nearest to the highest vertex (in z) that is near the median x and y."""
    vertices = mesh.vertices
    offsets = vector_lengths(vertices[:, :2] - np.median(vertices[:, :2], axis=0))
    central = np.flatnonzero(offsets <= max(float(offsets.min()), 0.01 * mesh.diagonal))
    distances = vector_lengths(vertices - vertices[central[vertices[central, 2].argmax()]])
    return mesh.part(distances <= np.partition(distances, count)[count])


class Stopped(RunError):  # noqa: N818 - a request, not an error
    """The page has stopped the run."""


class Bench:
    """One scan, and the results of recipes on it."""

    def __init__(self, scan: Path, part: int | None) -> None:
        """Reads and measures the scan, or a part of about `part` vertices."""
        read = read_mesh(scan)
        if part is not None:
            mesh = part_of(read.mesh, part)
            read = ReadMesh(scan, mesh, measure(mesh), read.warnings)
        self._before = state_of(read)
        self._unit = self._file_unit = self._before.mesh.unit
        self._scan = self._drawable("scan", self._before.mesh)
        centre, half = least_box([self._scan])
        self._box = centre, _ROOM * half
        self._result: tuple[Job, Outcome, Shown] | None = None
        self._earlier = RunCache()

    def opening(self) -> Result:
        return {"measures": measure_rows({"scan": self._before.measures}, self._unit)}, self._pack(self._scan)

    def run(self, job: Job, stage: Path) -> Result:
        """Carries out the steps of a job; returns warnings, the trials of automatic parameters, and the mesh."""
        session = Session(job, stage, stoppable((stage / STOP).exists, report))
        outcome = session.carry_out(self._before.mesh, earlier=self._earlier)
        self._result = job, outcome, self._drawable("result", outcome.result)
        tried = [step.values.get("tried", []) for step in outcome.steps]
        self._unit, doubts = job.unit_of(self._file_unit), job.doubts_of_unit(self._file_unit)
        warnings = [*job.recipe.warnings, *doubts, *session.warnings]
        return {"warnings": warnings, "tried": tried}, self._pack(self._result[2])

    def measure(self, stage: Path) -> Result:
        """Compares the result of the last run with the scan; returns numbers, further warnings of the run, and the mesh."""
        assert self._result is not None
        job, outcome, shown = self._result
        report_event = stoppable((stage / STOP).exists, report)
        report_event(PhaseStarted("comparing"))
        measured = measure(outcome.result)
        after = state_of(ReadMesh(stage / "result.ply", outcome.result, measured, ()))
        warnings = [*removed_contents(job, outcome), *without_values(outcome.result), *changed_shape(job, outcome, measured)[2]]
        report_event(PhaseStarted("comparing"))
        compared = compare(self._before, after)
        numbers = {
            "measures": measure_rows({"scan": self._before.measures, "result": after.measures}, self._unit),
            "distance": distance_table(compared.comparison, self._unit),
            "lines": comparison_lines(compared.comparison, self._unit),
            "warnings": warnings,
        }
        scalars = {**shown.scalars, "distance": compared.after_distance.at_vertices[shown.kept]}
        return numbers, self._pack(replace(shown, scalars=scalars), compared.comparison.rounding)

    def _drawable(self, name: str, mesh: MeshData) -> Shown:
        scalars = {"curvature": mean_curvature(mesh.vertices, mesh.faces)} if len(mesh.faces) else {}
        like = self._scan if mesh is not self._before.mesh and same_elements(mesh, self._before.mesh) else None
        return shown_mesh(name, mesh, scalars=scalars, like=like)

    def _pack(self, shown: Shown, rounding: float = 0.0) -> bytes:
        limits = {key: symmetric_limits(v, rounding if key == "distance" else 0.0) for key, v in shown.scalars.items()}
        return pack_scene([shown], limits, box=self._box, unit=self._unit).message


def stoppable(is_stopped: Callable[[], bool], send: Callable[[Event], None]) -> Callable[[Event], None]:
    """Returns a function that sends events, or raises `Stopped` if `is_stopped`."""

    def send_or_stop(event: Event) -> None:
        if is_stopped():
            raise Stopped("stopped")
        send(event)

    return send_or_stop


#: returns the bench of a scan; each process reads the scan once
_bench = cache(Bench)


def at_bench(scan: Scan, work: str, *arguments: Any) -> Result:
    """Calls a method of the bench of a scan."""
    return cast("Result", getattr(_bench(scan.path, scan.part), work)(*arguments))


#: seconds to wait for a filter to stop before its process is killed
_PATIENCE = 1.0


class Workshop:
    """Runs recipes on one scan, one at a time."""

    def __init__(self, scan: Scan, folder: Path) -> None:
        """Starts no process before `open`; the folder is for temporary files."""
        self._scan = scan
        self._folder = self._stage = folder
        self._process: Process | None = None
        self._task: asyncio.Task[Result] | None = None
        self._lock = asyncio.Lock()

    async def open(self) -> Result:
        async with self._lock:
            await self._stop()
            return await self._result("opening")

    async def begin(self, recipe: Recipe, overrides: tuple[str, ...], on_event: Callable[[Event], None]) -> asyncio.Task[Result]:
        """Stops the current run, and starts a recipe; the task raises `RunError` if the run fails."""
        async with self._lock:
            await self._stop()
            self._stage = Path(tempfile.mkdtemp(dir=self._folder))
            (self._stage / "new").mkdir()
            job = Job(recipe, self._scan.path, self._stage / "result.ply", overrides=overrides)
            self._task = asyncio.create_task(self._result("run", job, self._stage, on_event=on_event))
            return self._task

    async def measure(self, running: asyncio.Task[Result]) -> asyncio.Task[Result]:
        """Starts to measure the result of a run; raises `Stopped` if another run or a stop has ended that run."""
        async with self._lock:
            if running is not self._task:
                raise Stopped("stopped")
            self._task = asyncio.create_task(self._result("measure", self._stage))
            return self._task

    async def stop(self) -> None:
        async with self._lock:
            await self._stop()

    async def close(self) -> None:
        async with self._lock:
            await self._stop()
            await self._end_process()

    async def _stop(self) -> None:
        task, self._task = self._task, None
        if task is None or task.done():
            return
        (self._stage / STOP).touch()
        await asyncio.wait({task}, timeout=_PATIENCE)
        if not task.done():
            task.cancel()
            await asyncio.wait({task})
            await self._end_process()
        if not task.cancelled():
            task.exception()  # else asyncio prints it when the page that waited for the task is closed

    async def _end_process(self) -> None:
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
            await self._end_process()
            raise RunError(f"{error}; it probably crashed on this mesh") from error
        if answer.error is None:
            numbers, scene = answer.result
            return {**numbers, "seconds": round(time.perf_counter() - started, 2)}, scene
        if isinstance(answer.error, MemoryError | PymeshfairError | OSError) and not isinstance(answer.error, Stopped):
            raise RunError(str(answer.error)) from answer.error
        raise answer.error
