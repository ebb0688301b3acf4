"""A run by tiles: the checks before it, and the work in place of that in one piece, which reads and writes by parts."""

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..errors import FilterInputError, ParameterError, Place, RunError, StepFailedError
from ..files.errors import ContentsError, InputError, OutputError
from ..files.formats import extension
from ..files.inputs import check_input, check_magic, unchanged
from ..files.outputs import check_output
from ..files.provenance import described_file
from ..files.writing import StagedFile
from ..filters.execution import part_of
from ..operating_system import this_system
from ..processes.cluster import LostSchedulerError, Scheduler
from ..processes.environment import packages_here
from ..processes.process import Items
from ..running.job import Event, Job, Message, PhaseStarted, RunResult, StepFinished, StepProgress, StepReport, StepStarted
from ..running.report import Report, plain
from ..running.supervise import run_job
from ..scripts.script import ScriptError
from .cloud import Cloud, do_step, write_cloud
from .memory import Budget, budget, cloud_room, slice_rows, surface_room
from .mesh import MeshFile, MeshTiles, box_around, cut, do_move
from .plan import LOOP, NORMALS, POINT_NORMALS, STRAYS, CloudStep, Move, Plan, cost_of, plan_of
from .sources import CLOUD_FORMATS, E57Cloud, Source, file_cloud, open_cloud
from .workers import FullDiskError, Tasks, open_tasks, work_folder, work_path

#: bytes of memory where the system does not say how many there are
_USUAL_MEMORY = 4_000_000_000


@dataclass(frozen=True)
class Tiling:
    """The settings of work by tiles."""

    scheduler: Scheduler | None = None  # of dask, None for processes of this machine
    most: int | None = None  # points or vertices of a tile, None for as many as fit
    resume: bool = False  # go on with the files of a run that was killed, and keep those of this one if it ends early


#: tiles on this machine, as large as fits
AS_FITS = Tiling()


def run_by_tiles(
    job: Job,
    tiling: Tiling = AS_FITS,
    on_event: Callable[[Event], None] = lambda event: None,
    *,
    check_wanted: Callable[[], None] = lambda: None,
) -> RunResult:
    """Carry out a job by tiles; its `memory_limit` is for the command and all its workers together.

    Raises:
        ScriptError: a step cannot be done by tiles.
        ParameterError: too little memory, or something asked for that needs the whole mesh.
        InputError, OutputError, StepFailedError, TileError, KeyboardInterrupt: as `run_job` says.
    """
    plan = plan_of(job.recipe.script)
    check(job, plan)
    memory = job.memory_limit or this_system().usable_memory() or _USUAL_MEMORY
    share = budget(memory, this_system().processors())

    def work(job: Job, stage: Path, items: Items, on_event: Callable[[Event], None]) -> Report:
        with ExitStack() as opened:
            opened.enter_context(unchanged(job.input))
            tasks = opened.enter_context(open_tasks(tiling.scheduler, share, job, items, memory=memory, check=check_wanted))
            opened.enter_context(as_failures_of_run(job))
            on_event(PhaseStarted("reading"))
            described = described_file(job.input) | {"side_files": [], "others": []}
            unit = open_cloud(job.input).unit if plan.cloud else None
            described |= {"unit": unit} if unit else {}
            key = {
                "the input": described["sha256"],
                "the recipe": job.recipe.digest,
                "the versions of packages": packages_here(),
                "the memory of a tile": share.tile,
                "the size of the tiles": tiling.most,
                "the start of the machine": this_system().boot(),
            }
            keep = (BaseException,) if tiling.resume else (LostSchedulerError,)
            folder = opened.enter_context(work_folder(job.output, key, resume=tiling.resume, keep=keep))
            tasks.work = folder
            course = _Course(job, tiling, share, tasks, folder.path, stage / "new" / job.output.name, on_event)
            report = course.do_cloud(plan.cloud) if plan.cloud else course.move(plan.moves)
        peaks = sorted(tasks.peaks.values())[-share.workers :]
        workers = {"workers": share.workers, "memory_limit": memory, "processor_seconds": round(tasks.seconds, 3)}
        return replace(
            report,
            input=described,
            warnings=(*job.doubts_of_unit(unit), *report.warnings, *filter(None, [folder.note])),
            tiles={**(report.tiles or {}), **workers},
            peak_memory=(this_system().peak_memory() or 0) + sum(peaks) if peaks else None,
        )

    return run_job(job, on_event, work=work)


def can_be_cut(job: Job) -> bool:
    """Whether a job can be done by tiles: its recipe, its files, its limits and its memory allow it."""
    try:
        check(job, plan_of(job.recipe.script))
        budget(job.memory_limit or this_system().usable_memory() or _USUAL_MEMORY, this_system().processors())
    except (ScriptError, ParameterError, RunError):
        return False
    return not (job.keep_all or job.keep_broken)


@dataclass
class _Course:
    """The steps of one run."""

    job: Job
    tiling: Tiling
    share: Budget
    tasks: Tasks
    folder: Path  # for the files of the work
    staged: Path  # the output, in the staging folder
    on_event: Callable[[Event], None]
    steps: list[StepReport] = field(default_factory=list)

    def do_cloud(self, plan: tuple[CloudStep, ...]) -> Report:
        """Do the steps on a cloud and write the result; the report."""
        source, notes = open_cloud(self.job.input), tuple[str, ...]()
        if isinstance(source, E57Cloud):
            rewritten = self.folder / ("input.ply" if extension(self.job.output) == "ply" else "input.las")
            notes = self.tasks.run(source.rewrite, rewritten, slice_rows(self.share.tile, source.row))
            source = file_cloud(rewritten)
        cloud = Cloud(source, self.folder)
        tilings = []
        for step in plan:
            self._pass_to(step.step)
            values: dict[str, Any] = {}
            with self._step(step.step, values):
                cloud, reported, sizes = do_step(
                    cloud,
                    step,
                    self.tasks,
                    self.share.tile,
                    progress=self._progress(step.step),
                    most=self.tiling.most,
                )
                values |= reported
            tilings.append({name: sizes[name] for name in ("tiles", "points_per_tile")})
            if step is plan[0]:
                before = _measures(sizes["points"], 0, sizes["low"], sizes["high"])
        self._pass_to(len(self.job.recipe.script.steps) + 1)
        self.on_event(PhaseStarted("writing"))
        size = slice_rows(self.share.tile, cloud.source.row)
        written = self.tasks.run_again(write_cloud, cloud, self.staged, size)
        count, low, high = self.tasks.run(cloud.survey, size)
        assert written == count
        report = self._report(before, _measures(count, 0, low.tolist(), high.tolist()), {"stages": tilings})
        return replace(report, warnings=(*report.warnings, *notes))

    def _pass_to(self, number: int) -> None:
        """Name the steps before one that were done with others, or do nothing."""
        for passed in range(len(self.steps) + 1, number):
            with self._step(passed, {}):
                pass

    def move(self, plan: tuple[Move, ...]) -> Report:
        """Move the vertices of a mesh and write the result; the report."""
        mesh, folder = MeshFile(self.job.input), self.folder
        for move in plan:
            values: dict[str, Any] = {}
            with self._step(move.step, values):
                progress, start = self._progress(move.step), 0.0
                if move is plan[0]:
                    start, cutting = 0.4, part_of(progress, 0.0, 0.4)
                    costs, most = [cost_of(move.filter, move.values) for move in plan], self.tiling.most
                    surface, sizes = cut(mesh, folder, self.tasks, self.share.tile, costs=costs, most=most, progress=cutting)
                    tiles = surface.cells.tiles(sizes["points_per_tile"])
                values |= do_move(surface, move, tiles, self.tasks, part_of(progress, start, 1.0))
        self.on_event(PhaseStarted("writing"))
        work = MeshTiles(surface)
        low, high = box_around(self.tasks.map(work.finish, tiles))
        size = slice_rows(self.share.tile, mesh.vertices.dtype.itemsize)
        self.tasks.run_again(mesh.write, self.staged, tuple(work.part(first) for first, _ in tiles), size)
        counts = sizes["points"], sizes["faces"]
        stage = {"tiles": len(tiles), "points_per_tile": sizes["points_per_tile"]}
        before, after = _measures(*counts, sizes["low"], sizes["high"]), _measures(*counts, low.tolist(), high.tolist())
        return self._report(before, after, {"stages": [stage] * len(plan)})

    def _report(self, before: dict[str, Any], after: dict[str, Any], tiles: dict[str, Any]) -> Report:
        sides = [b and a / b - 1.0 for b, a in zip(before["sides"], after["sides"], strict=True)]
        change = {"sides": [None if s == 0 and not b else s for s, b in zip(sides, before["sides"], strict=True)]}
        report = Report(
            input={},
            output=described_file(self.staged, named=self.job.output) | {"side_files": []},
            steps=tuple(self.steps),
            staged=(StagedFile(self.staged, self.job.output),),
            warnings=("done by tiles, so that only the numbers of elements and the box were measured",),
            tiles=tiles,
        )
        if not self.job.measures:
            return report
        unknown = dict.fromkeys(("area", "volume", "moved", "turned"))
        return replace(report, before=before, after=after, change=change | unknown)

    @contextmanager
    def _step(self, number: int, values: dict[str, Any]) -> Iterator[None]:
        """One step of the recipe, with its events; `values` takes what the filter reports, under "notes" its sentences."""
        script = self.job.recipe.script
        step = script.steps[number - 1]
        self.on_event(StepStarted(number, len(script.steps), step.filter.name))
        started = time.perf_counter()
        try:
            yield
        except FilterInputError as error:
            place = Place.of_step(number, len(script.steps), step.filter.name, file=script.path, line=step.line)
            raise StepFailedError(place, str(error)) from error
        seconds = time.perf_counter() - started
        notes = tuple(values.pop("notes", ()))
        for text in notes:
            self.on_event(Message(text, step=number))
        declared, parameters = step.filter, plain(step.with_defaults().values)
        self.steps.append(StepReport(number, declared.name, declared.python_name, seconds, parameters, plain(values), notes))
        self.on_event(StepFinished(number, seconds))

    def _progress(self, number: int) -> Callable[[float], None]:
        return lambda share: self.on_event(StepProgress(number, share))


def _measures(vertices: int, faces: int, low: list[float], high: list[float]) -> dict[str, Any]:
    """The measures of a mesh by tiles."""
    sides = [b - a for a, b in zip(low, high, strict=True)] if vertices else [0.0] * 3
    return {"vertices": vertices, "faces": faces, "diagonal": sum(s * s for s in sides) ** 0.5, "sides": sides}


def check(job: Job, plan: Plan) -> None:
    """Refuse what cannot be done by tiles, before anything is done."""
    if not (plan.cloud or plan.moves):
        raise ParameterError("the recipe has no steps, so there is nothing to do by tiles")
    formats = CLOUD_FORMATS if plan.cloud else ("ply",)
    if job.all_guards or job.map is not None or job.others:
        raise ParameterError(
            "limits of the result, an intervention map and further layers need the whole mesh at once; leave them out, or --tiles"
        )
    check_input(job.input, (*formats, "e57") if plan.cloud else formats)
    try:
        check_magic(job.input)
        source = open_cloud(job.input) if plan.cloud else MeshFile(job.input)
        if isinstance(source, MeshFile):
            source.check()
    except ContentsError as error:
        raise InputError(job.input, str(error)) from error
    check_output(job.output, job.made_from, overwrite=job.overwrite, formats=formats)
    kinds = ["las" if kind == "laz" else kind for kind in map(extension, (job.input, job.output))]
    if kinds[0] != kinds[1] and kinds[0] != "e57":
        raise OutputError(job.output, f"by tiles a .{extension(job.input)} file becomes a .{kinds[0]} file")
    _check_room(job, plan, source)


def _check_room(job: Job, plan: Plan, source: Source | E57Cloud | MeshFile) -> None:
    folder = job.output.absolute().parent
    if not isinstance(source, MeshFile):
        most = (max((s.neighbors for s in plan.cloud if s.filter == name), default=0) for name in (LOOP, STRAYS, POINT_NORMALS))
        needed = cloud_room(len(source), source.row, *most)
    else:
        vertices, faces = len(source), source.tables["face"].element.count
        row = source.vertices.dtype.itemsize + 24 + faces * source.tables["face"].dtype.itemsize // vertices
        needed = surface_room(vertices, faces, row, rounds=any(step.filter == NORMALS for step in plan.moves))
    former = sum(file.stat().st_size for file in work_path(job.output).glob("**/*") if file.is_file())
    free = shutil.disk_usage(folder).free + former
    if needed > free:
        raise OutputError(
            job.output,
            f"the work needs {needed / 1e9:.3g} GB, and the disk of {folder} has {free / 1e9:.3g} GB free: free some, or name an "
            "output on another disk",
        )


@contextmanager
def as_failures_of_run(job: Job) -> Iterator[None]:
    """Failures of tasks in the words of a run."""
    try:
        yield
    except ContentsError as error:
        raise InputError(job.input, str(error)) from error
    except (FullDiskError, OSError) as error:
        words = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise OutputError(job.output, f"there is no room for the files of the work: {words}".lower()) from error
