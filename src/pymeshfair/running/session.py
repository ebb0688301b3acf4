"""The work of a worker: reads the mesh, applies the steps, writes the result to the staging folder, and reports."""

import errno
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

from ..calling import StoppedError
from ..errors import FilterInputError, Place, RunError, StepFailedError
from ..files.errors import InputError, OutputError
from ..files.formats import ATTRIBUTES, attributes_of
from ..files.inputs import Reading, read_file
from ..files.outputs import save_mesh
from ..files.provenance import described_file, read_provenance
from ..files.writing import StagedFile
from ..filters.compilation import on_compilation
from ..mesh_data import MeshData
from ..meshlab.loading import MeshLabLoadError, load_pymeshlab
from ..recipe import RecipeInfo
from ..scripts.script import Script, Step
from ..scripts.warnings import lengths_out_of_proportion
from .document import Document, State
from .guarding import PRINTABLE, breaches, print_faults, wall_words, wrap_words
from .job import Compiling, Event, Job, Message, PhaseStarted, StepFinished, StepProgress, StepReport, StepStarted
from .measuring import MeasuredMesh, measure
from .origins import Origins, find_origins, stage_map
from .plain_values import plain
from .report import Report
from .shape_change import ShapeChange, milder, shape_change, warnings_of
from .suitability import ERASED, instead, traits_asked_for
from .talk import mark

#: the least change of progress that is reported
_SMALLEST_PROGRESS = 0.005


#: the measures of a mesh, the traits that a recipe asks for, and the warning if it is not for such a scan
_Measured: TypeAlias = tuple[MeasuredMesh, Mapping[str, Any], str | None]


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of the steps."""

    before: MeasuredMesh  # the mesh as it was read
    result: MeshData  # the mesh after the steps, without a matrix
    steps: tuple[StepReport, ...]  # the report of each step
    traits: Mapping[str, Any]  # those of the scan that the recipe asked for


class Earlier:
    """Measures and intermediate states of earlier runs on one mesh: after a change of a later step only that step runs again."""

    def __init__(self, states: int = 8) -> None:
        """See the class; so many states of the mesh are kept, the ones used last."""
        self._states = states
        self._measured: tuple[RecipeInfo, _Measured] | None = None
        self._kept: list[tuple[tuple[Step, ...], State, tuple[StepReport, ...]]] = []  # the one used last is the last

    def measured(self, info: RecipeInfo, measure: Callable[[], _Measured]) -> _Measured:
        """The measures of the mesh for a recipe of this head."""
        if self._measured is None or self._measured[0] != info:
            self._measured = info, measure()
        return self._measured[1]

    def longest(self, steps: tuple[Step, ...]) -> tuple[State | None, tuple[StepReport, ...]]:
        """The layers after as many of the steps as are kept, and the reports of these steps."""
        fitting = [entry for entry in self._kept if entry[0] == steps[: len(entry[0])]]
        if not fitting:
            return None, ()
        entry = max(fitting, key=lambda entry: len(entry[0]))
        self._kept.remove(entry)
        self._kept.append(entry)
        return entry[1:]

    def keep(self, steps: tuple[Step, ...], state: State, done: tuple[StepReport, ...]) -> None:
        """Keep the layers after some steps."""
        self._kept.append((steps, state, done))
        del self._kept[: -self._states or None]


class Session:
    """One run in this process."""

    def __init__(self, job: Job, stage: Path, on_event: Callable[[Event], None]) -> None:
        """See the class; the paths of the job are absolute, and `new` in the staging folder takes what is written."""
        self.warnings: list[str] = []  # those so far
        self._job = job
        self._stage = stage
        self._steps = job.recipe.script.steps
        self._event = on_event
        self._document = Document(stage / "meshlab", on_progress=self._progress, on_note=self._note)
        self._number, self._told = 0, 0.0
        self._notes: list[str] = []
        self._unit: str | None = None

    def run(self) -> Report:
        """Carry the job out; the report for the supervisor."""
        on_compilation(lambda so_far: self._event(Compiling(**vars(so_far))))
        self._event(PhaseStarted("reading"))
        read, source = self._load(self._job.input)
        self._unit = self._job.unit_of(read.unit)
        self._job.lengths_in(self._unit)  # refused before anything is done
        self._warn(*self._job.doubts_of_unit(read.unit))
        others = [self._load(path) for path in self._job.others]
        outcome = self.carry_out(read, [mesh for mesh, _ in others])
        source["others"] = [described for _, described in others]
        return self._write(outcome, source)

    def carry_out(self, read: MeshData, others: Sequence[MeshData] = (), earlier: Earlier | None = None) -> Outcome:
        """Apply the steps to a mesh, with others as further layers; nothing is read or written.

        `earlier` has states that runs on the same meshes have kept; this run adds to them.
        """
        input_id = self._document.add(read)
        for mesh in others:
            self._document.add(mesh)
        self._document.current_id = input_id
        earlier = earlier or Earlier(states=0)
        before, traits, unsuited = earlier.measured(self._job.recipe.info, lambda: self._measured(read))
        self._warn(*lengths_out_of_proportion(Script(self._steps), diagonal=before.diagonal))
        if taken := self._job.recipe.info.superseded:
            self._warn(f"{self._job.recipe.name} is superseded: {taken}")
        if unsuited:
            self._warn(unsuited)
        steps = self._carried_out(earlier)
        document = self._document
        self._lose(document.losses)
        result = document.current
        # The input is not lost where a step made a new layer of it.
        kept = document.current_id != input_id and input_id in document.ids
        if len(document.ids) > 1 + kept:
            text = f"the recipe ends with {len(document.ids)} layers; only the current one, {result.label!r}, is written"
            self._lose([text])
        if result.matrix is not None:
            result = result.without_matrix()
            self._warn("the layer's matrix was applied to its coordinates, as files do not hold it")
        if not len(result.vertices):
            raise self._failed("nothing is left of the mesh after the last step")
        return Outcome(before, result, steps, traits)

    def _measured(self, read: MeshData) -> _Measured:
        before = self._looked(read, InputError(self._job.input, "it has coordinates that are not finite"))
        return before, *traits_asked_for(self._job.recipe, before, as_shipped=not self._job.overrides)

    def _load(self, path: Path) -> tuple[MeshData, dict[str, Any]]:
        """Read a file; its mesh, and which file it was."""
        reading = read_file(
            path, allow_outside=self._job.allow_outside, unchecked=self._unchecked if self._job.unchecked else None
        )
        self._warn(*(f"{path.name}: {doubt}" for doubt in reading.doubts))
        described = described_file(path) | {"side_files": [described_file(side) for side in reading.side_files]}
        described |= {"unit": reading.mesh.unit} if reading.mesh.unit else {}
        return reading.mesh, described

    def _unchecked(self, path: Path) -> Reading:
        load_pymeshlab()
        from ..door import load_unchecked

        return load_unchecked(path, self._stage / "meshlab")

    # --------------------------------------------------------------------------------------------------------------- steps

    def _carried_out(self, earlier: Earlier) -> tuple[StepReport, ...]:
        """Carry out the steps, but for the first ones that were carried out earlier."""
        state, done = earlier.longest(self._steps)
        if state is not None:
            self._document.restore(state)
        for number, step in enumerate(done, 1):
            self._event(StepStarted(number, len(self._steps), self._steps[number - 1].filter.name))
            for text in step.messages:
                self._event(Message(text, step=number))
            self._event(StepFinished(number, step.seconds))
        for number in range(len(done) + 1, len(self._steps) + 1):
            done = (*done, self._step(number))
            if (state := self._document.state) is not None:
                earlier.keep(self._steps[:number], state, done)
        return done

    def _step(self, number: int) -> StepReport:
        step = self._steps[number - 1]
        self._number, self._told, self._notes = number, 0.0, []
        self._event(StepStarted(number, len(self._steps), step.filter.name))
        os.write(2, mark(number))
        started = time.perf_counter()
        try:
            parameters, values = self._document.apply(step)
            if not self._document.ids:
                raise self._failed("it left no mesh")
        except (StepFailedError, MemoryError, MeshLabLoadError):
            raise
        except StoppedError as error:
            raise error.__cause__ or error from None
        except Exception as error:
            if caused_by_memory(error):
                raise MemoryError from error
            if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):  # in the files for MeshLab
                raise OutputError(self._job.output, (error.strerror or str(error)).lower()) from error
            raise self._failed(reason_of(error, step)) from error
        seconds = time.perf_counter() - started
        os.write(2, mark(0))
        self._event(StepFinished(number, seconds))
        self._number = 0
        name, python_name = step.filter.name, step.filter.python_name
        return StepReport(number, name, python_name, seconds, plain(parameters), plain(values), tuple(self._notes))

    def _failed(self, reason: str) -> StepFailedError:
        """The failure of the current step, or of the last one when all are done."""
        steps = self._steps
        number = self._number or len(steps)
        filter = steps[number - 1].filter.name if steps else ""
        return StepFailedError(Place.of_step(number, len(steps), filter), reason)

    def _note(self, text: str) -> None:
        self._notes.append(text)
        self._event(Message(text, step=self._number))

    def _progress(self, fraction: float) -> None:
        if self._number and abs(fraction - self._told) >= _SMALLEST_PROGRESS:
            self._told = fraction
            self._event(StepProgress(self._number, min(max(fraction, 0.0), 1.0)))

    # ------------------------------------------------------------------------------------------------------------- writing

    def _write(self, outcome: Outcome, source: Mapping[str, Any]) -> Report:
        before = outcome.before
        self._event(PhaseStarted("writing"))
        self._lose(self._gone(before.mesh, outcome.result))
        after = self._looked(outcome.result, self._failed("the result has coordinates that are not finite"), before)
        origins = find_origins(after.mesh, before.mesh)
        change = None
        if before.measures is not None and after.measures is not None:
            change = shape_change(origins, (before.measures, after.measures))
            other_recipe = cache(lambda: instead(self._job.recipe, before))  # measures the scan
            self._warn(*warnings_of(change, self._steps, other_recipe))
            # Who sets how much a recipe smooths has asked for what goes.
            tasks = ("denoise", "clean") if self._job.overrides else ("denoise", "clean", "smooth")
            if self._job.recipe.info.task in tasks and (change.relief_lost or 0.0) > ERASED:
                better = other_recipe()
                ways = [way for way in (milder(self._steps), better and f"take {better}") if way]
                self._warn(
                    f"{change.relief_lost:.0%} of the relief beside the noise is gone: compare the result with the scan; if that "
                    f"was detail: {', or '.join([*ways, 'leave it as it is'])}; `pymeshfair suggest` ranks recipes by what they "
                    "would take"
                )
        report = Report(
            input=source,
            steps=outcome.steps,
            traits=plain(outcome.traits),
            before=before.described,
            after=after.described,
            change=None if change is None else plain(asdict(change)),
        )
        if self._job.is_watched:
            report = self._watched(report, origins, change, before, after)
        if not report.breaches or self._job.keep_broken:
            try:
                report = self._checked(self._saved(report, after), report, before.mesh, after.mesh)
            except OSError as error:
                raise OutputError(self._job.output, (error.strerror or str(error)).lower()) from error
        return replace(report, warnings=tuple(self.warnings))

    def _gone(self, read: MeshData, result: MeshData) -> list[str]:
        """Attributes that the steps have removed, in words."""
        texts = []
        # A recipe of curves makes them of a surface, and that the surface is gone is no news.
        of_curves = self._job.recipe.info.task == "curves"
        lost = attributes_of(read) - attributes_of(result)
        if not of_curves and (gone := [a for a in ATTRIBUTES if a in lost]):
            texts.append(f"after the steps the mesh has no {' and no '.join(gone)} any more")
        if result.source is not read.source and read.source is not None and read.source.extras:
            texts.append(f"a step made a new mesh, without what {read.label} has besides: {'; '.join(read.source.extras)}")
        return texts

    def _saved(self, report: Report, after: MeasuredMesh) -> Report:
        """Write the files to the staging folder."""
        output = self._job.output
        saved = save_mesh(
            after.mesh,
            output,
            self._stage / "new",
            resolution=after.resolution,
            record=read_provenance(output),
            own_texture_names=self._job.own_texture_names,
        )
        self._lose(saved.warnings)
        staged = (saved.output, *saved.side_files)
        described = [described_file(f.staged, named=f.target) for f in staged] + [described_file(path) for path in saved.reused]
        return replace(report, output=described[0] | {"side_files": described[1:]}, staged=staged)

    def _checked(self, saved: Report, unsaved: Report, scan: MeshData, mesh: MeshData) -> Report:
        """The report of the written file, with its walls; where it must be printable and is not, of a run that wrote none."""
        if (PRINTABLE, None) not in self._job.all_guards.require:
            return saved
        wrapped = any(step.filter.python_name == "generate_alpha_wrap" for step in self._steps)
        written = read_file(saved.staged[0].staged).mesh
        faults = list(print_faults(written, self._stage / "checked", wrapped=wrapped))
        broken = (*saved.breaches, *(plain(asdict(fault)) for fault in faults))
        if broken:
            return replace(saved if self._job.keep_broken or not faults else unsaved, breaches=broken)
        if wrapped:
            with suppress(RunError):  # where MeshLab ends on the scan, the run goes on
                if not any(print_faults(scan)):
                    self._warn("the scan is watertight, none of its faces cuts another: prepare_for_print keeps its surface")
        last = saved.steps[-1]
        words = [text for text in (wall_words(mesh, self._unit), wrapped and wrap_words(scan, mesh)) if text]
        for text in words:
            self._event(Message(text, step=len(saved.steps)))
        return replace(saved, steps=(*saved.steps[:-1], replace(last, messages=(*last.messages, *words))))

    def _watched(
        self, report: Report, origins: Origins, change: ShapeChange | None, before: MeasuredMesh, after: MeasuredMesh
    ) -> Report:
        """Find the limits that were broken, and write the intervention map."""
        follows = self._job.map is not None or replace(self._job.all_guards, require=())
        if not origins.followed and follows:
            self._warn("a step made a new mesh, so that its elements cannot be followed: distances are those from the input")
        broken = breaches(self._job.all_guards, origins, change, before, after, self._unit)
        maps: tuple[StagedFile, ...] = ()
        if self._job.map is not None:
            tolerance = self._job.lengths_in(self._unit)[1].resolve(diagonal=before.diagonal, mean_edge=before.resolution)
            maps = stage_map(self._stage / "new", self._job.map, origins, tolerance)
        return replace(report, breaches=tuple(plain(asdict(breach)) for breach in broken), maps=maps)

    def _looked(self, mesh: MeshData, refusal: Exception, former: MeasuredMesh | None = None) -> MeasuredMesh:
        """Measure a mesh, which may be connected like a former one."""
        try:
            return measure(mesh, wanted=self._job.measures, former=former)
        except FilterInputError as error:
            raise refusal from error

    def _lose(self, texts: Sequence[str]) -> None:
        """Warn of what is not kept, or refuse that."""
        if texts and self._job.keep_all:
            raise OutputError(self._job.output, f"{'; '.join(texts)}. With --keep-all that is an error")
        self._warn(*texts)

    def _warn(self, *texts: str) -> None:
        for text in texts:
            self.warnings.append(text)
            self._event(Message(text, "warning"))


def reason_of(error: Exception, step: Step) -> str:
    """The message of an error without the filter's name, which the supervisor adds."""
    words = " ".join(str(error).split())
    for prefix in (f"Failed to apply filter: {step.filter.python_name} Details: ", f"{step.filter.python_name}: "):
        words = words.removeprefix(prefix)
    return words


def caused_by_memory(error: BaseException | None) -> bool:
    """Whether an error, or one that it comes from, says that there was no memory left."""
    while error is not None:
        if isinstance(error, MemoryError) or "bad_alloc" in str(error):
            return True
        error = error.__cause__
    return False
