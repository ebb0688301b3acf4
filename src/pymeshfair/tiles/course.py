"""Runs a recipe by tiles: parts of the mesh or cloud that fit into memory."""

import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FilterInputError, ParameterError, Place, RunError, StepFailedError
from ..files.errors import ContentsError, InputError, OutputError, reason_of
from ..files.formats import extension, listed
from ..files.inputs import check_input, check_magic, unchanged
from ..files.outputs import check_output
from ..files.provenance import described_file
from ..files.writing import StagedFile
from ..filters.execution import part_of
from ..filters.inspection.surface_measures import SurfaceMeasures, box_diagonal
from ..filters.outliers import found_words
from ..operating_system import this_system
from ..processes.cluster import Scheduler
from ..processes.environment import packages_here
from ..processes.process import Items
from ..running.job import (
    Event,
    Job,
    Message,
    PhaseStarted,
    Report,
    RunResult,
    StepFinished,
    StepProgress,
    StepReport,
    StepStarted,
    plain,
)
from ..running.supervise import run_job
from ..scripts.script import ScriptError
from .cloud import Cloud, do_step, write_cloud
from .mesh import MeshTiles, cut, do_move
from .plan import DELETE, NORMALS, Budget, PlannedStep, budget, cloud_room, plan_of, slice_rows
from .sources import CLOUD_FORMATS, E57Cloud, LasCloud, MeshFile, PlyFile, Source, open_cloud
from .workers import Tasks, open_tasks, work_folder, work_path

_USUAL_MEMORY = 4_000_000_000  # bytes of memory to assume if the system does not report them


def run_by_tiles(
    job: Job,
    on_event: Callable[[Event], None] = lambda event: None,
    *,
    scheduler: Scheduler | None = None,
    most: int | None = None,
    resume: bool = False,
    check_wanted: Callable[[], None] = lambda: None,
) -> RunResult:
    """Carries out a job by tiles of at most `most` points or vertices; None: tiles are as large as the memory allows.

    Tiles are sized so that command and workers together stay within the `memory_limit` of the job. With `resume` the run
    continues from the files of a killed run, and a failure keeps the temporary files. `check_wanted` may raise to stop.
    """
    plan, memory, share = check(job)

    def work(job: Job, stage: Path, items: Items, on_event: Callable[[Event], None]) -> Report:
        with ExitStack() as opened:
            opened.enter_context(unchanged(job.input))
            tasks = opened.enter_context(open_tasks(scheduler, share, job, items, memory=memory, check=check_wanted))
            opened.enter_context(_as_failures_of_run(job))
            on_event(PhaseStarted("reading"))
            unit = open_cloud(job.input).unit if plan[0].is_on_cloud else None
            described = described_file(job.input) | {"side_files": [], "others": []} | ({"unit": unit} if unit else {})
            key = {
                "the input": described["sha256"],
                "the recipe": job.recipe.digest,
                "the versions of packages": packages_here(),
                "the memory of a tile": share.tile,
                "the size of the tiles": most,
                "the start of the machine": this_system().boot(),
            }
            folder = opened.enter_context(work_folder(job.output, key, resume=resume))
            tasks.work = folder
            run = _TiledRun(job, most, share, tasks, folder.path, stage / "new" / job.output.name, on_event)
            report = run.do_cloud(plan) if plan[0].is_on_cloud else run.move(plan)
        peaks = sorted(tasks.peaks.values())[-share.workers :]
        return replace(
            report,
            input=described,
            warnings=(*job.doubts_of_unit(unit), *job.losses_of_unit(unit), *report.warnings, *filter(None, [folder.note])),
            tiles={**(report.tiles or {}), "workers": share.workers, "memory_limit": memory},
            peak_memory=(this_system().peak_memory() or 0) + sum(peaks) if peaks else None,
        )

    return run_job(job, on_event, work=work)


def can_be_cut(job: Job) -> bool:
    """Returns whether the recipe, files, options and memory of a job allow tiles."""
    try:
        check(job)
    except (ScriptError, ParameterError, RunError):
        return False
    return not job.keep_broken


@dataclass
class _TiledRun:
    job: Job
    most: int | None  # the largest number of points or vertices of a tile
    share: Budget
    tasks: Tasks
    folder: Path  # of temporary files
    staged: Path  # the output in the staging folder
    on_event: Callable[[Event], None]
    steps: list[StepReport] = field(default_factory=list)

    def do_cloud(self, plan: Sequence[PlannedStep]) -> Report:
        source, notes, tile = open_cloud(self.job.input), list[str](), self.share.tile
        if isinstance(source, E57Cloud):
            is_ply = extension(self.job.output) == "ply"
            rewritten = self.folder / ("input.ply" if is_ply else "input.las")
            notes = self.tasks.run(source.rewrite, rewritten, slice_rows(tile, source.row), self.job.output)
            source = PlyFile(rewritten, is_converted=True) if is_ply else LasCloud(rewritten)
        cloud, stages = Cloud(source, self.folder), []
        for step in plan:
            with self._step(step.step) as (values, progress):
                cloud, reported, sizes = do_step(cloud, step, self.tasks, tile, progress=progress, most=self.most)
                set_values = {**step.values, **sizes["lengths"]}
                found = found_words(reported.get("selected_vertices", 0), sizes["points"], set_values, sizes["copies"])
                if removed := reported.get("removed_vertices"):
                    found = (f"Removed {removed} duplicated vertices",)  # MeshLab's sentence
                values |= reported | {"notes": (*found, *reported.get("notes", ())), "lengths": sizes["lengths"]}
            stages.append(sizes)
        self._report_skipped(len(self.job.recipe.script.steps) + 1)
        self.on_event(PhaseStarted("writing"))
        size = slice_rows(tile, source.row)
        self.tasks.map(write_cloud, [(cloud, self.staged, size)], again=True)
        count, low, high = self.tasks.run(cloud.survey, size)
        return self._report(stages, {"points": count, "low": low, "high": high}, notes)

    def move(self, plan: Sequence[PlannedStep]) -> Report:
        mesh, tile, most = MeshFile(self.job.input), self.share.tile, self.most
        for step in plan:
            with self._step(step.step) as (values, progress):
                if step is plan[0]:
                    cutting, progress = part_of(progress, 0.0, 0.4), part_of(progress, 0.4, 1.0)
                    surface, sizes = cut(mesh, self.folder, self.tasks, tile, steps=plan, most=most, progress=cutting)
                    tiles = surface.cells.tiles(sizes["points_per_tile"])
                values |= do_move(surface, step, tiles, self.tasks, progress)
        self.on_event(PhaseStarted("writing"))
        work = MeshTiles(surface, with_normals=mesh.has("normals"))
        lows, highs = zip(*self.tasks.map(work.finish, tiles), strict=True)
        arguments = work.results, surface.cells.slots_of_tiles(tiles), self.staged, slice_rows(tile, mesh.row)
        self.tasks.map(mesh.write_points, [arguments], again=True)
        after = {**sizes, "low": np.min(lows, axis=0), "high": np.max(highs, axis=0)}
        return self._report([{**sizes, "tiles": len(tiles)}] * len(plan), after)

    def _report(self, stages: Sequence[dict[str, Any]], after: dict[str, Any], notes: Sequence[str] = ()) -> Report:
        """Returns the report; `stages` has the sizes before each step, `after` those of the result."""
        measures_before, measures_after = _measures(stages[0]), _measures(after)
        doubts = self.job.doubts_of_recipe(measures_before["diagonal"])
        report = Report(
            input={},
            output=described_file(self.staged, named=self.job.output) | {"side_files": []},
            steps=tuple(self.steps),
            staged=(StagedFile(self.staged, self.job.output),),
            warnings=(*doubts, "done by tiles, so that only the numbers of elements and the box were measured", *notes),
            tiles={"stages": [{name: stage[name] for name in ("tiles", "points_per_tile")} for stage in stages]},
        )
        if not self.job.measures:
            return report
        sides = [a / b - 1.0 if b else None for b, a in zip(measures_before["sides"], measures_after["sides"], strict=True)]
        unknown = dict.fromkeys(("area", "volume", "moved", "turned"))
        return replace(report, before=measures_before, after=measures_after, change={"sides": sides} | unknown)

    def _report_skipped(self, number: int) -> None:
        """Reports steps before `number` without a `PlannedStep`: deletions after a selection, projections of 0 iterations."""
        for skipped in range(len(self.steps) + 1, number):
            with self._step(skipped) as (values, _):
                is_deletion = self.job.recipe.script.steps[skipped - 1].filter.python_name == DELETE
                if is_deletion and (deleted := self.steps[-1].values.get("selected_vertices")):
                    values["notes"] = (f"Deleted {deleted} vertices, 0 faces.",)  # MeshLab's sentence

    @contextmanager
    def _step(self, number: int) -> Iterator[tuple[dict[str, Any], Callable[[float], None]]]:
        """Sends a step's events; yields a dict to fill (values, "notes", "lengths" in mesh units) and a progress function."""
        self._report_skipped(number)
        script, values = self.job.recipe.script, dict[str, Any]()
        step = script.steps[number - 1]
        self.on_event(StepStarted(number, len(script.steps), step.filter.name))
        started = time.perf_counter()
        try:
            yield values, lambda share: self.on_event(StepProgress(number, share))
        except FilterInputError as error:
            place = Place.of_step(number, len(script.steps), step.filter.name, file=script.path, line=step.line)
            raise StepFailedError(place, str(error)) from error
        seconds, notes = time.perf_counter() - started, tuple(values.pop("notes", ()))
        for text in notes:
            self.on_event(Message(text, step=number))
        declared, parameters = step.filter, plain({**step.with_defaults().values, **values.pop("lengths", {})})
        self.steps.append(StepReport(number, declared.name, declared.python_name, seconds, parameters, plain(values), notes))
        self.on_event(StepFinished(number, seconds))


def _measures(sizes: dict[str, Any]) -> dict[str, Any]:
    sides = [float(b - a) if sizes["points"] else 0.0 for a, b in zip(sizes["low"], sizes["high"], strict=True)]
    known = {"vertices": sizes["points"], "faces": sizes.get("faces", 0), "sides": sides}
    known["diagonal"] = box_diagonal(np.stack([sizes["low"], sizes["high"]])) if sizes["points"] else 0.0
    return dict.fromkeys(measure.name for measure in fields(SurfaceMeasures)) | known


def check(job: Job) -> tuple[list[PlannedStep], int, Budget]:
    """Refuses jobs that cannot be done by tiles; returns the steps, the memory in bytes, and the workers with their memory."""
    plan = plan_of(job.recipe.script)
    if not plan:
        raise ParameterError("the recipe has no steps, so there is nothing to do by tiles")
    is_cloud = plan[0].is_on_cloud
    readable = (*CLOUD_FORMATS, "e57") if is_cloud else ("ply",)
    if job.all_guards or job.map is not None or job.others or job.keep_all:
        raise ParameterError(
            "limits, an intervention map, further layers and --keep-all need the whole mesh; leave them out, or drop --tiles"
        )
    check_input(job.input)
    kind = extension(job.input)
    if kind not in readable:
        raise InputError(job.input, f"by tiles the recipe reads {listed(readable)}, not .{kind}: convert it, or drop --tiles")
    try:
        check_magic(job.input)
        needed = _room(plan, open_cloud(job.input) if is_cloud else MeshFile(job.input))
    except ContentsError as error:
        raise InputError(job.input, str(error)) from error
    check_output(job.output, job.made_from, overwrite=job.overwrite)
    writable = {"e57": CLOUD_FORMATS, "ply": ("ply",)}.get(kind, ("las", "laz"))
    if extension(job.output) not in writable:
        raise OutputError(job.output, f"by tiles a .{kind} file can become {listed(writable)}, not .{extension(job.output)}")
    folder = job.output.absolute().parent
    former = sum(file.stat().st_size for file in work_path(job.output).glob("**/*") if file.is_file())
    free = shutil.disk_usage(folder).free + former
    if needed > free:
        lack = f"the work needs {needed / 1e9:.3g} GB, and the disk of {folder} has {free / 1e9:.3g} GB free"
        raise OutputError(job.output, f"{lack}: free some, or name an output on another disk")
    memory = job.memory_limit or this_system().usable_memory() or _USUAL_MEMORY
    return plan, memory, budget(memory, this_system().processors())


def _room(plan: Sequence[PlannedStep], source: Source | E57Cloud) -> int:
    if not isinstance(source, MeshFile):
        return cloud_room(len(source), source.row, plan)
    # A face has 20 bytes in each cell that has one of its vertices: 23 bytes on average, and up to 46 while faces are sorted.
    vertices, faces = len(source), source.faces_table.element.count
    row = source.row + 116 + 24 * source.has("normals") + 48 * any(step.filter == NORMALS for step in plan)
    return max(36 * vertices + 46 * faces, row * vertices + (23 + source.faces_table.dtype.itemsize) * faces)


@contextmanager
def _as_failures_of_run(job: Job) -> Iterator[None]:
    try:
        yield
    except ContentsError as error:
        raise InputError(job.input, str(error)) from error
    except OSError as error:
        raise OutputError(job.output, f"the temporary files cannot be written: {reason_of(error)}") from error
