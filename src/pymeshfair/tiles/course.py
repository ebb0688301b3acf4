"""A run by tiles, from the checks to the files in their places, as `pymeshfair.running.supervise` does one in one piece."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from ..errors import FilterInputError, Place, StepFailedError
from ..files.output_lock import output_lock
from ..files.outputs import check_output
from ..files.provenance import described_file, formatted, provenance_path
from ..files.reading import unchanged
from ..files.staging import staging_folder
from ..files.writing import StagedFile, place, stage_file
from ..filters.execution import part_of
from ..operating_system import this_system
from ..running.interrupts import Interrupts
from ..running.job import Event, Job, PhaseStarted, RunResult, StepFinished, StepProgress, StepStarted
from ..running.memory import default_memory
from ..running.plain_values import plain
from ..running.record import record_of, result_of
from .checks import check, formats_of, told_as_run
from .cloud import Cloud, do_selection, write_cloud
from .division import Shape
from .memory import Budget, budget, slice_rows
from .mesh import MeshFile, MeshTiles, cut, do_move
from .moves import cost_of
from .plan import Move, Selection, plan_of
from .ply_slices import PlySlices
from .sources import open_cloud
from .surface import Surface
from .workers import Pool, open_pool


@dataclass(frozen=True)
class Tiling:
    """How to cut.

    Attributes:
        scheduler: address of a dask scheduler, None for processes of this machine.
        shape: of the tiles.
        most: points or vertices of a tile, None for as many as fit.
    """

    scheduler: str | None = None
    shape: Shape = "boxes"
    most: int | None = None


#: tiles on this machine, as large as fits
AS_FITS = Tiling()


def run_by_tiles(
    job: Job,
    tiling: Tiling = AS_FITS,
    on_event: Callable[[Event], None] = lambda event: None,
) -> RunResult:
    """Carry out a job by tiles; the output appears whole or not at all.

    Args:
        job: what to do; its `memory_limit` is for the command and all its workers together.
        tiling: how to cut.
        on_event: called with each event, in this thread.

    Raises:
        ScriptError: a step cannot be done by tiles.
        ParameterError: too little memory, or something asked for that needs the whole mesh.
        InputError, OutputError, StepFailedError, TileError, KeyboardInterrupt: as `run_job` says.
    """
    started, clock = datetime.now(timezone.utc), time.monotonic()
    job = replace(job, input=Path(job.input).absolute(), output=Path(job.output).absolute())
    plan = plan_of(job.recipe.script)
    check(job, plan)
    memory = job.memory_limit or default_memory() or 4_000_000_000
    share = budget(memory, this_system().processors())
    queue: SimpleQueue[tuple[str, Any]] = SimpleQueue()
    with Interrupts(queue) as interrupts, output_lock(job.output), staging_folder(job.output) as stage:
        with ExitStack() as opened:
            opened.enter_context(unchanged(job.input))
            most = memory + job.input.stat().st_size  # what a worker maps of a file's length counts as its memory
            pool = opened.enter_context(open_pool(tiling.scheduler, share.workers, share.threads, queue, memory=most))
            opened.enter_context(told_as_run(job))
            on_event(PhaseStarted("reading"))
            described = described_file(job.input) | {"side_files": [], "others": []}
            course = _Course(job, tiling, share, pool, stage, on_event)
            report = course.run(plan)
            peaks = sorted(pool.peaks.values())[-share.workers :]
        interrupts.check()
        report["peak_memory"] = (this_system().peak_memory() or 0) + sum(peaks) if peaks else None
        report |= {"input": described, "warnings": list(report["warnings"]), "counted": True, "traits": {}}
        seconds = time.monotonic() - clock
        record = record_of(job, report, {}, {}, started=started, seconds=seconds)
        record["tiles"] = report["tiles"] | {"workers": share.workers, "memory_limit": memory}
        record["run"]["processor_seconds_of_tiles"] = round(pool.seconds, 3)
        provenance = stage_file(stage / "provenance.json", provenance_path(job.output), formatted(record))
        check_output(job.output, job.made_from, overwrite=job.overwrite, formats=formats_of(plan))  # again
        place([StagedFile(course.made, job.output), provenance], stage, outdated=provenance.target)
    return result_of(job, record, [])


class _Course:
    """The steps of one run."""

    def __init__(
        self, job: Job, tiling: Tiling, share: Budget, pool: Pool, stage: Path, on_event: Callable[[Event], None]
    ) -> None:
        self._job = job
        self._tiling = tiling
        self._share = share
        self._pool = pool
        self._stage = stage
        self._on_event = on_event
        self.made = stage / "new" / job.output.name

    def run(self, plan: list[Selection] | list[Move]) -> dict[str, Any]:
        """Do the steps and write the result; the report."""
        selections = [step for step in plan if isinstance(step, Selection)]
        return self._select(selections) if selections else self._move([step for step in plan if isinstance(step, Move)])

    def _select(self, plan: list[Selection]) -> dict[str, Any]:
        cloud = Cloud(open_cloud(self._job.input), self._stage / "new")
        steps: list[dict[str, Any]] = []
        tilings = []
        for selection in plan:
            with self._step(selection.step, steps) as told:
                cloud, values, known = do_selection(
                    cloud,
                    selection,
                    self._pool,
                    self._share.tile,
                    shape=self._tiling.shape,
                    progress=self._progress(selection.step),
                    most=self._tiling.most,
                )
                told["values"] = values
            tilings.append({name: known[name] for name in ("tiles", "points_per_tile")})
            if selection is plan[0]:
                before = _measures(known["points"], 0, known["low"], known["high"])
            if selection.deletes:
                with self._step(selection.step + 1, steps):
                    pass
        self._on_event(PhaseStarted("writing"))
        size = slice_rows(self._share.tile, cloud.source.row)
        written = self._pool.run(write_cloud, cloud, self.made, size)
        count, low, high = self._pool.run(cloud.survey, size)
        assert written == count
        return self._report(steps, before, _measures(count, 0, low.tolist(), high.tolist()), {"stages": tilings})

    def _move(self, plan: list[Move]) -> dict[str, Any]:
        mesh, folder = MeshFile(PlySlices(self._job.input)), self._stage / "new"
        steps: list[dict[str, Any]] = []
        for move in plan:
            with self._step(move.step, steps):
                progress, start = self._progress(move.step), 0.0
                if move is plan[0]:
                    start, cutting = 0.4, part_of(progress, 0.0, 0.4)
                    surface, known = self._cut(mesh, folder, plan, cutting)
                    tiles = surface.cells.tiles(known["points_per_tile"])
                box = do_move(surface, move, tiles, self._pool, part_of(progress, start, 1.0))
        self._on_event(PhaseStarted("writing"))
        work = MeshTiles(surface)
        self._pool.map(work.finish, tiles, lambda share: None)
        size = slice_rows(self._share.tile, mesh.file.vertices.dtype.itemsize)
        self._pool.run(mesh.write, self.made, tuple(work.part(first) for first, _ in tiles), size)
        counts = known["points"], known["faces"]
        told = {"tiles": len(tiles), "points_per_tile": known["points_per_tile"]}
        return self._report(
            steps, _measures(*counts, known["low"], known["high"]), _measures(*counts, *box), {"stages": [told] * len(plan)}
        )

    def _cut(
        self, mesh: MeshFile, folder: Path, plan: list[Move], progress: Callable[[float], None]
    ) -> tuple[Surface, dict[str, Any]]:
        shape, most = self._tiling.shape, self._tiling.most
        costs = [cost_of(move.filter, move.values) for move in plan]
        return cut(mesh, folder, self._pool, self._share.tile, costs=costs, shape=shape, most=most, progress=progress)

    def _report(
        self, steps: list[dict[str, Any]], before: dict[str, Any], after: dict[str, Any], tiles: dict[str, Any]
    ) -> dict[str, Any]:
        sides = [b and a / b - 1.0 for b, a in zip(before["sides"], after["sides"], strict=True)]
        return {
            "steps": steps,
            "before": before,
            "after": after,
            "change": {"sides": [None if s == 0 and not b else s for s, b in zip(sides, before["sides"], strict=True)]}
            | dict.fromkeys(("area", "volume", "moved", "turned")),
            "warnings": ["done by tiles, so that only the numbers of elements and the box were measured"],
            "output": described_file(self.made, named=self._job.output) | {"side_files": []},
            "tiles": tiles,
        }

    @contextmanager
    def _step(self, number: int, steps: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        """One step of the recipe, told as it begins and ends; the report of it, to be filled in."""
        script = self._job.recipe.script
        step = script.steps[number - 1]
        told: dict[str, Any] = {"parameters": plain(step.with_defaults().values), "values": {}, "notes": []}
        self._on_event(StepStarted(number, len(script.steps), step.filter.name))
        started = time.perf_counter()
        try:
            yield told
        except FilterInputError as error:
            place = Place.of_step(number, len(script.steps), step.filter.name, file=script.path, line=step.line)
            raise StepFailedError(place, str(error)) from error
        told["seconds"] = time.perf_counter() - started
        steps.append(told)
        self._on_event(StepFinished(number, told["seconds"]))

    def _progress(self, number: int) -> Callable[[float], None]:
        return lambda share: self._on_event(StepProgress(number, share))


def _measures(vertices: int, faces: int, low: list[float], high: list[float]) -> dict[str, Any]:
    """What is measured of a mesh by tiles."""
    sides = [b - a for a, b in zip(low, high, strict=True)] if vertices else [0.0] * 3
    return {"vertices": vertices, "faces": faces, "diagonal": sum(s * s for s in sides) ** 0.5, "sides": sides}
