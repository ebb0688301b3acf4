"""The work of a worker: reads the mesh, applies the steps, writes the result to the staging folder, and reports."""

import errno
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias
from weakref import proxy

import numpy as np

from ..calling import StoppedError, reason
from ..errors import FilterInputError, Place, RunError, StepFailedError
from ..files.errors import InputError, OutputError, reason_of
from ..files.formats import ATTRIBUTES, attributes_of
from ..files.inputs import Reading, check_input, read_file, unchanged
from ..files.outputs import save_mesh
from ..files.polygons import numbered
from ..files.provenance import described_file, read_provenance
from ..files.writing import StagedFile
from ..filters.compilation import on_compilation
from ..filters.topology import border_edges
from ..mesh_data import MeshData
from ..mesh_data.mesh_data import FACE_ATTRIBUTES, VERTEX_ATTRIBUTES
from ..meshlab.loading import MeshLabLoadError, load_pymeshlab
from ..processes.worker import is_lack_of_memory
from ..scripts.script import Step
from .document import Document, State
from .guarding import PRINTABLE, breaches, print_faults, wall_words, wrap_words
from .job import Compiling, Event, Job, Message, PhaseStarted, Report, StepFinished, StepProgress, StepReport, StepStarted, plain
from .measuring import MeasuredMesh, measure
from .shape_change import Origins, ShapeChange, find_origins, shape_change, stage_map, warnings_of
from .suitability import instead, traits_asked_for
from .supervise import mark

_MERGING = ("meshing_remove_duplicate_vertices", "meshing_merge_close_vertices")  # steps that merge vertices
_SMALLEST_PROGRESS = 0.005  # the least change of progress that is reported

#: the measures of a mesh, and the result of `traits_asked_for`
_Measured: TypeAlias = tuple[MeasuredMesh, Mapping[str, Any], str | None]


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of the steps."""

    before: MeasuredMesh  # the mesh as it was read
    result: MeshData  # the mesh after the steps, without a transformation matrix
    steps: tuple[StepReport, ...]
    traits: Mapping[str, Any]  # the traits of the scan that were measured for the recipe
    mirrors: bool = False  # whether the matrix that was applied at the end mirrors


class RunCache:
    """A cache of runs on one mesh: after a change of a step, a run continues from the last snapshot before it.

    It keeps the measures of the mesh, and up to `states` snapshots of the layers after a step; it drops the least recently used.
    """

    def __init__(self, states: int = 8) -> None:
        self._states = states
        self._measured: tuple[object, _Measured] | None = None
        self._kept: list[tuple[tuple[Step, ...], State, tuple[StepReport, ...], str]] = []  # least recently used first

    def measured(self, asked: object, measure: Callable[[], _Measured]) -> _Measured:
        if self._measured is None or self._measured[0] != asked:
            self._measured = asked, measure()
        return self._measured[1]

    def longest(self, steps: tuple[Step, ...]) -> tuple[State | None, tuple[StepReport, ...], str]:
        fitting = [entry for entry in self._kept if entry[0] == steps[: len(entry[0])]]
        if not fitting:
            return None, (), ""
        entry = max(fitting, key=lambda entry: len(entry[0]))
        self._kept.remove(entry)
        self.keep(*entry)
        return entry[1:]

    def keep(self, steps: tuple[Step, ...], state: State, reports: tuple[StepReport, ...], emptied: str) -> None:
        self._kept.append((steps, state, reports, emptied))
        del self._kept[: -self._states or None]


class Session:
    """One run in this process."""

    def __init__(self, job: Job, stage: Path, on_event: Callable[[Event], None]) -> None:
        """The paths of the job must be absolute; new files are written to the folder `new` of the staging folder."""
        self.warnings: list[str] = []
        self._job, self._stage, self._event = job, stage, on_event
        self._steps = job.recipe.script.steps
        this = proxy(self)  # so that no cycle of references keeps the meshes of a run that is over
        self._document = Document(
            stage / "meshlab", on_progress=lambda share: this._progress(share), on_note=lambda text: this._note(text)
        )
        self._number, self._last_progress = 0, 0.0  # both of the current step; the number is 0 between steps
        self._emptied = ""  # words that name the step that left no faces of a mesh, or no points of a cloud; empty if none did
        self._notes = list[str]()
        self._unit: str | None = None

    def run(self) -> Report:
        with ExitStack() as stack:
            stack.callback(on_compilation(lambda so_far: self._event(Compiling(**vars(so_far)))))
            self._event(PhaseStarted("reading"))
            read, source = self._load(self._job.input)
            self._unit = self._job.unit_of(read.unit)
            self._job.lengths_in(self._unit)  # refuses lengths such as 0.05mm before the steps if the scan's unit is unknown
            self._warn(*self._job.doubts_of_unit(read.unit))
            read = replace(read, unit=self._job.unit or read.unit or self._unit)
            others = [self._load(path) for path in self._job.others]
            units = {mesh.unit: f"{mesh.label} is in {mesh.unit}" for mesh in (read, *(mesh for mesh, _ in others)) if mesh.unit}
            if len(units) > 1:
                self._warn(f"{', '.join(units.values())}: coordinates are taken as the files have them")
            outcome = self.carry_out(read, [mesh for mesh, _ in others])
            source["others"] = [described for _, described in others]
            return self._write(outcome, source)

    def carry_out(self, read: MeshData, others: Sequence[MeshData] = (), earlier: RunCache | None = None) -> Outcome:
        """Apply the steps to a mesh, with `others` as further layers; `earlier` is the cache of runs on the same meshes."""
        input_id = self._document.add(read)
        for mesh in others:
            self._document.add(mesh)
        self._document.current_id = input_id
        earlier = earlier or RunCache(states=0)
        asked = self._job.recipe.name, self._job.recipe.info, not self._job.overrides
        before, traits, unsuited = earlier.measured(asked, lambda: self._measured(read))
        self._warn(*self._job.doubts_of_recipe(before.diagonal))
        self._warn(*filter(None, [unsuited]), *self._seams(before))
        steps = self._run_steps(earlier)
        document = self._document
        self._lose(document.losses)
        result = document.current
        # The input's layer is not reported as lost if the result is a new layer beside it.
        input_stays = document.current_id != input_id and input_id in document.ids
        if (count := len(document.ids)) > 1 + input_stays:
            self._lose([f"the recipe ends with {count} layers; only the current one, {result.label!r}, is written"])
        mirrors = False
        if result.matrix is not None:
            mirrors = len(result.faces) > 0 and bool(np.linalg.det(result.matrix[:3, :3]) < 0.0)
            over = ", and turned the faces over, as it mirrors: Invert Faces Orientation turns them back" if mirrors else ""
            self._warn(f"the layer's matrix was applied to its coordinates, as files do not hold it{over}")
        if not len(result.vertices):
            raise self._failed("nothing is left of the mesh after the last step")
        return Outcome(before, replace(result.without_matrix(), unit=result.unit or read.unit), steps, traits, mirrors)

    def _measured(self, read: MeshData) -> _Measured:
        before = self._measure(read, InputError(self._job.input, "it has coordinates that are not finite"))
        return before, *traits_asked_for(self._job.recipe, before, as_shipped=not self._job.overrides)

    def _seams(self, before: MeasuredMesh) -> Iterator[str]:
        """A warning of border edges that coincide, as at seams of a texture, if steps may open gaps or distort the texture."""
        names, attributes = {step.filter.python_name for step in self._steps}, attributes_of(before.mesh)
        merges, keeps = not names.isdisjoint(_MERGING), "compute_texcoord_transfer_vertex_to_wedge" in names
        distorts = "vertex texture coordinates" in attributes and "wedge texture coordinates" not in attributes and not keeps
        advice = ["'Convert PerVertex UV into PerWedge UV'"] * distorts + ["'Remove Duplicate Vertices'"] * (not merges)
        if names and advice and before.measures is not None and before.measures.border_edges:
            ends = border_edges(before.mesh.faces)
            places = np.sort(numbered(before.mesh.vertices[ends.ravel()])[1].reshape(-1, 2), axis=1)
            counts = np.unique(places, axis=0, return_counts=True)[1]
            harm = f"the steps {'distort the texture' if merges else 'may open gaps'} there; begin with {' and '.join(advice)}"
            if (cut := counts[counts > 1].sum()) > 0:
                yield f"{cut:,} border edges lie exactly on others, as at seams of a texture: {harm}"

    def _load(self, path: Path) -> tuple[MeshData, dict[str, Any]]:
        unchecked = self._unchecked if self._job.unchecked else None
        check_input(path)
        with unchanged(path):  # so that the record has the checksum of what was read
            reading = read_file(path, allow_outside=self._job.allow_outside, unchecked=unchecked)
            described = described_file(path) | {"side_files": [described_file(side) for side in reading.side_files]}
        self._warn(*(f"{path.name}: {doubt}" for doubt in reading.doubts))
        return reading.mesh, described | ({"unit": reading.mesh.unit} if reading.mesh.unit else {})

    def _unchecked(self, path: Path) -> Reading:
        load_pymeshlab()
        from ..door import load_unchecked

        return load_unchecked(path, self._stage / "meshlab")

    def _run_steps(self, earlier: RunCache) -> tuple[StepReport, ...]:
        state, reports, self._emptied = earlier.longest(self._steps)
        if state is not None:
            self._document.restore(state)
        for number, report in enumerate(reports, 1):
            self._event(StepStarted(number, len(self._steps), self._steps[number - 1].filter.name))
            for text in report.messages:
                self._event(Message(text, step=number))
            self._event(StepFinished(number, report.seconds))
        for number in range(len(reports) + 1, len(self._steps) + 1):
            reports = (*reports, self._step(number))
            if (state := self._document.state) is not None:
                earlier.keep(self._steps[:number], state, reports, self._emptied)
        return reports

    def _step(self, number: int) -> StepReport:
        step = self._steps[number - 1]
        self._number, self._last_progress, self._notes = number, 0.0, []
        self._event(StepStarted(number, len(self._steps), step.filter.name))
        os.write(2, mark(number))
        started = time.perf_counter()
        try:
            former = self._document.fullness
            parameters, values = self._document.apply(step)
            if not self._document.ids:
                raise self._failed("it left no mesh")
            if (fullness := self._document.fullness) < former:
                self._emptied = f"; step {number}, {step.filter.name!r}, left no {('points', 'faces')[former - 1]}"
            elif fullness > former:
                self._emptied = ""
        except (StepFailedError, MemoryError, MeshLabLoadError):
            raise
        except StoppedError as error:
            raise error.__cause__ or error from None
        except Exception as error:
            if is_lack_of_memory(error):
                raise MemoryError from error
            if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):  # while writing for MeshLab
                raise OutputError(self._job.output, reason_of(error)) from error
            text, name = " ".join(reason(error).split()), step.filter.python_name  # `_failed` names the filter already
            raise self._failed(
                text.removeprefix(f"Failed to apply filter: {name} Details: ").removeprefix(f"{name}: ")
            ) from error
        seconds = time.perf_counter() - started
        os.write(2, mark(0))
        self._event(StepFinished(number, seconds))
        self._number = 0
        return StepReport(
            number, step.filter.name, step.filter.python_name, seconds, plain(parameters), plain(values), tuple(self._notes)
        )

    def _failed(self, reason: str) -> StepFailedError:
        number, count = self._number or len(self._steps), len(self._steps)
        name, line = (self._steps[number - 1].filter.name, self._steps[number - 1].line) if count else ("", None)
        place = Place.of_step(number, count, name, file=self._job.recipe.script.path, line=line)
        return StepFailedError(place, reason + self._emptied)

    def _note(self, text: str) -> None:
        self._notes.append(text)
        self._event(Message(text, step=self._number))

    def _progress(self, fraction: float) -> None:
        if self._number and abs(fraction - self._last_progress) >= _SMALLEST_PROGRESS:
            self._last_progress = fraction
            self._event(StepProgress(self._number, min(max(fraction, 0.0), 1.0)))

    def _write(self, outcome: Outcome, source: Mapping[str, Any]) -> Report:
        job, before, steps = self._job, outcome.before, outcome.steps
        self._event(PhaseStarted("writing"))
        self._lose([*removed_contents(job, outcome)])
        self._warn(*without_values(outcome.result))
        after = self._measure(outcome.result, self._failed("the result has coordinates that are not finite"), before)
        origins, change, doubts = changed_shape(job, outcome, after)
        self._warn(*doubts)
        if not origins.followed and (job.map is not None or replace(job.all_guards, require=())):
            self._warn("a step made a new mesh: distances of its vertices from the input are measured, not displacements")
        broken = breaches(job.all_guards, origins, change, before, after, self._unit)
        maps: tuple[StagedFile, ...] = ()
        output: dict[str, Any] | None = None
        staged: tuple[StagedFile, ...] = ()
        try:
            if job.map is not None:
                tolerance = job.lengths_in(self._unit)[1].resolve(diagonal=before.diagonal, mean_edge=before.resolution)
                maps = stage_map(self._stage / "new", job.map_files, origins, tolerance)
            if not broken or job.keep_broken:
                output, staged = self._saved(after, source.get("unit"))
            if staged and (PRINTABLE, None) in job.all_guards.require:
                wrapped = any(step.python_name == "generate_alpha_wrap" for step in steps)
                faults = list(print_faults(read_file(staged[0].staged).mesh, self._stage / "checked", wrapped=wrapped))
                output, staged = (None, ()) if faults and not job.keep_broken else (output, staged)
                broken += faults
                if not broken and steps:
                    notes = self._print_notes(before.mesh, after.mesh, wrapped=wrapped)
                    steps = (*steps[:-1], replace(steps[-1], messages=(*steps[-1].messages, *notes)))
        except OSError as error:
            raise OutputError(job.output, reason_of(error)) from error
        return Report(
            input=source,
            output=output,
            steps=steps,
            staged=staged,
            before=before.described,
            after=after.described,
            change=None if change is None else plain(asdict(change)),
            traits=plain(outcome.traits),
            warnings=tuple(self.warnings),
            breaches=tuple(plain(asdict(breach)) for breach in broken),
            maps=maps,
        )

    def _print_notes(self, scan: MeshData, mesh: MeshData, *, wrapped: bool) -> list[str]:
        if wrapped:
            with suppress(RunError):  # the run goes on if MeshLab crashes on the scan
                if not any(print_faults(scan)):
                    self._warn("the scan is watertight, and no face cuts another: the recipe prepare_for_print keeps its surface")
        notes = [text for text in (wall_words(mesh, self._unit), wrapped and wrap_words(scan, mesh)) if text]
        for text in notes:
            self._event(Message(text, step=len(self._steps)))
        return notes

    def _saved(self, after: MeasuredMesh, file_unit: str | None) -> tuple[dict[str, Any], tuple[StagedFile, ...]]:
        output = self._job.output
        names: dict[str, Any] = {"record": read_provenance(output), "own_texture_names": self._job.own_texture_names}
        saved = save_mesh(after.mesh, output, self._stage / "new", resolution=after.resolution, **names)
        self._lose([*saved.warnings, *self._job.losses_of_unit(file_unit, len(after.mesh.faces), len(after.mesh.edges))])
        staged = (saved.output, *saved.side_files)
        described = [described_file(f.staged, named=f.target) for f in staged] + [described_file(path) for path in saved.reused]
        return described[0] | {"side_files": described[1:]}, staged

    def _measure(self, mesh: MeshData, refusal: Exception, former: MeasuredMesh | None = None) -> MeasuredMesh:
        try:
            return measure(mesh, wanted=self._job.measures, former=former)
        except FilterInputError as error:
            raise refusal from error

    def _lose(self, texts: Sequence[str]) -> None:
        if texts and self._job.keep_all:
            raise OutputError(self._job.output, f"{'; '.join(texts)}. With --keep-all that is an error")
        self._warn(*texts)

    def _warn(self, *texts: str) -> None:
        for text in texts:
            self.warnings.append(text)
            self._event(Message(text, "warning"))


def changed_shape(job: Job, outcome: Outcome, after: MeasuredMesh) -> tuple[Origins, ShapeChange | None, list[str]]:
    """The origins of a result's elements, the change of shape (None without measures), and warnings about it."""
    before, doubts = outcome.before, list[str]()
    origins, change = find_origins(after.mesh, before.mesh), None
    if before.measures is not None and after.measures is not None:
        change = shape_change(origins, (before.measures, after.measures))
        other_recipe = cache(lambda: instead(job.recipe, before))  # slow: it measures the scan
        # No warning of lost relief if the user has set values of a smoothing recipe, such as its strength.
        keeps_relief = job.recipe.info.task in (("denoise", "clean") if job.overrides else ("denoise", "clean", "smooth"))
        doubts += warnings_of(change, job.recipe.script.steps, other_recipe, keeps_relief=keeps_relief)
        if not (outcome.mirrors or change.turned is None) and (before.measures.volume or 0) > 0 > (after.measures.volume or 0):
            doubts.append("the result is inside out, as after a matrix that mirrors: Invert Faces Orientation mends that")
    return origins, change, doubts


def removed_contents(job: Job, outcome: Outcome) -> Iterator[str]:
    """Sentences on the contents of the scan that the result lacks."""
    read, result = outcome.before.mesh, outcome.result
    removed = attributes_of(read) - attributes_of(result)
    # A recipe that makes curves of a surface removes the surface's attributes on purpose.
    if job.recipe.info.task != "curves" and (names := [a for a in ATTRIBUTES if a in removed]):
        yield f"after the steps the mesh has no {' and no '.join(names)} any more"
    if result.source is not read.source and read.source is not None and read.source.extras:
        yield f"a step made a new mesh, which lacks further contents of {read.label}: {'; '.join(read.source.extras)}"


def without_values(mesh: MeshData) -> Iterator[str]:
    """Sentences on the custom attributes that new elements lack."""
    if mesh.source is None:
        return
    of_file: Callable[[str], Mapping[str, Any]] = getattr(mesh.source.document, "custom", lambda element: {})
    vertices = ("vertex", "vertices", mesh.vertex_ids, mesh.vertex_attributes, VERTEX_ATTRIBUTES)
    faces = ("face", "faces", mesh.face_ids, mesh.face_attributes, FACE_ATTRIBUTES)
    for element, elements, ids, attributes, standard in (vertices, faces):
        if ids is None or not (new := ids < 0).any():
            continue
        lacking = [name for name in attributes if name not in standard and not attributes[name][new].any()]
        lacking += [name for name in of_file(element) if name not in attributes and name != "flags"]  # flags are MeshLab's own
        if lacking:
            yield f"{new.sum():,} of {len(new):,} {elements} are new, and have 0 as {', '.join(lacking)}"
