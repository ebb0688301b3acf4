"""The data of a run: its job, its events, the worker's report, the result, and the provenance document."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from ..declaration import Length
from ..declaration.parameters import doubts_of_typed_unit, unit_of_scan
from ..errors import ParameterError
from ..files.formats import READABLE, WRITABLE, extension
from ..files.outputs import MadeFrom
from ..files.provenance import SCHEMA, described_file, provenance_path, read_provenance
from ..files.writing import StagedFile
from ..places import counted
from ..processes.environment import thread_settings, versions, worker_environment
from ..recipe import Recipe
from ..scripts.guards import NO_GUARDS, Guards
from ..scripts.warnings import lengths_out_of_proportion


@dataclass(frozen=True)
class Job:
    """One mesh file, one recipe, one file to write."""

    recipe: Recipe  # the steps, overrides included
    input: Path  # the mesh file to read
    output: Path  # the file to write; its extension says the format
    others: tuple[Path, ...] = ()  # mesh files for the layers 1, 2 ...; the input is layer 0, the current layer
    #: replace any existing `output`, even the input; False: only an unchanged output of a run with the same sources (`made_from`)
    overwrite: bool = False
    timeout: float | None = None  # the most seconds from start to end, or None
    memory_limit: int | None = None  # bytes that the worker may use, where the system can enforce it; None: 80 % of the memory
    allow_outside: bool = False  # let the input name textures, materials and buffers outside its own folder
    unchecked: bool = False  # let MeshLab read formats that pymeshfair cannot check
    keep_all: bool = False  # fail if the output lacks anything of the input or of the result
    threads: int | None = None  # the most threads that a filter may use; None: OMP_NUM_THREADS, or all processors
    overrides: tuple[str, ...] = ()  # the texts ``NAME=VALUE`` or ``STEP.PARAM=VALUE`` that changed the recipe, for the record
    command: tuple[str, ...] = ()  # the command line of the run, for the record
    guards: Guards = NO_GUARDS  # limits, which override those of the recipe
    keep_broken: bool = False  # write the output even if a limit is broken
    map: Path | None = None  # the .ply file for the intervention map, or None
    map_tolerance: Length | None = None  # in the map, a vertex counts as kept if it moved by at most this length; None: 0
    #: prefix the names of textures with the output's name, so that parallel runs into one folder do not collide
    own_texture_names: bool = False
    warnings: tuple[str, ...] = ()  # warnings from before the work, besides those of the recipe
    measures: bool = True  # measure the mesh before and after, which limits and comparison need
    #: the unit of the scan, one of `pymeshfair.declaration.parameters.METRES`; None: the unit of the file, or of the recipe
    unit: str | None = None

    def __post_init__(self) -> None:
        if self.timeout is not None and not self.timeout > 0.0:
            raise ParameterError(f"the time limit must be above 0 seconds, and it is {self.timeout:g}")

    @property
    def made_from(self) -> MadeFrom:
        return MadeFrom(self.input, self.recipe.digest, self.others, self.unit)

    @property
    def options(self) -> dict[str, Any]:
        """The options for the record, which `verify` and a resumed batch read; defaults are left out."""
        options: dict[str, Any] = {name: True for name in ("allow_outside", "unchecked", "keep_all") if getattr(self, name)}
        options |= {} if self.measures else {"no_measures": True}
        return options | ({} if self.unit is None else {"unit": self.unit})

    @property
    def map_files(self) -> tuple[Path, ...]:
        """The files of the intervention map, ``map.ply`` and ``map.removed.ply``; none if no map is wanted."""
        return () if self.map is None else (self.map, self.map.parent / f"{self.map.stem}.removed{self.map.suffix}")

    @property
    def all_guards(self) -> Guards:
        """The limits of the recipe, overridden by those of the job, in the units in which they are written."""
        return self.recipe.script.guards.overridden(self.guards)

    def unit_of(self, file_unit: str | None) -> str | None:
        """The unit of the scan, given the unit in its file; None if it is not known."""
        return unit_of_scan(self.unit, file_unit, self.recipe.script.unit)

    def doubts_of_unit(self, file_unit: str | None) -> tuple[str, ...]:
        """Warnings if the job's unit is not that of the scan's file, and if the recipe is for another unit than the scan's."""
        unit, recipe_unit = self.unit_of(file_unit), self.recipe.script.unit
        text = f"the recipe is for scans in {recipe_unit}, and this scan is in {unit}: numbers without a unit mean {unit}"
        return (*doubts_of_typed_unit(self.unit, file_unit), *([text] if recipe_unit and recipe_unit != unit else ()))

    def doubts_of_recipe(self, diagonal: float) -> tuple[str, ...]:
        """Warnings if lengths of the recipe do not suit a scan of this diagonal, and if the recipe is superseded."""
        advice = self.recipe.info.superseded
        superseded = [f"{self.recipe.name} is superseded: {advice}"] if advice else []
        return (*lengths_out_of_proportion(self.recipe.script, diagonal=diagonal), *superseded)

    def losses_of_unit(self, file_unit: str | None, faces: int = 0, edges: int = 0) -> tuple[str, ...]:
        """A warning if the output has another format, which cannot hold the input's unit; `faces` and `edges` are counts."""
        kind, source = WRITABLE[extension(self.output)], READABLE.get(extension(self.input))
        if file_unit is None or file_unit in kind.units or kind is source:
            return ()
        of_source = f"; .{source.extension} keeps it" if source is not None and source.writer else ""
        of_cells = "; .3mf and .glb keep it" if faces else "; .glb keeps it" if edges else ""
        advice = of_cells or of_source  # not for points: .3mf holds faces alone, and .glb rounds survey coordinates
        return (f"{self.output.name} does not hold the unit of {self.input.name}, {file_unit}{advice}",)

    def check_unit(self) -> None:
        """Refuse lengths with a unit if the scan's unit is not known, unless the input's format can state a unit."""
        unit, kind = self.unit_of(None), READABLE.get(extension(self.input))
        if kind is None or not kind.has_unit:
            self.lengths_in(unit)

    def lengths_in(self, unit: str | None) -> tuple[Guards, Length]:
        """The limits and the map's tolerance, with lengths converted to mesh units of a scan in this unit."""
        return self.all_guards.in_mesh_units(unit), (self.map_tolerance or Length(0.0)).in_mesh_units(unit)


@dataclass(frozen=True)
class PhaseStarted:
    """The run begins a phase."""

    phase: Literal["reading", "writing", "comparing"]


@dataclass(frozen=True)
class StepStarted:
    """A step begins."""

    index: int  # from 1 to `total`
    total: int  # the number of steps
    filter: str  # MeshLab's name of the filter


@dataclass(frozen=True)
class StepProgress:
    """Progress of a step: `fraction` from 0 to 1. Not every filter reports it, and some filters go from 0 to 1 several times."""

    index: int
    fraction: float


@dataclass(frozen=True)
class StepFinished:
    """A step has ended after `seconds`."""

    index: int
    seconds: float


@dataclass(frozen=True)
class Message:
    """A message for the user about a step or the run."""

    text: str  # a sentence
    level: Literal["info", "warning"] = "info"
    step: int = 0  # the number of its step, 0 for none; the message may arrive after the step has ended


@dataclass(frozen=True)
class Compiling:
    """Kernels are compiled for this machine; everything else waits."""

    kernels: int  # the number of kernels so far, including the one that is being compiled
    seconds: float  # the total time of the finished ones
    is_going_on: bool


Event: TypeAlias = PhaseStarted | StepStarted | StepProgress | StepFinished | Message | Compiling


@dataclass(frozen=True)
class StepReport:
    """The report of one step."""

    number: int  # from 1
    filter: str  # MeshLab's name of the filter
    python_name: str
    seconds: float
    parameters: Mapping[str, Any] = field(default_factory=dict)  # the values of all parameters; lengths in mesh units
    values: Mapping[str, Any] = field(default_factory=dict)  # the values that the filter reported
    messages: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunResult:
    """The result of a run."""

    output: Path  # the file that was written
    provenance: Path  # the provenance document beside it
    side_files: tuple[Path, ...]  # textures and material files of the output
    #: the measures of the mesh as read (`pymeshfair.filters.inspection.surface_measures.SurfaceMeasures`). Without measures,
    #: `before`, `after` and `change` are empty.
    before: Mapping[str, Any]
    after: Mapping[str, Any]  # the measures of the mesh as written
    change: Mapping[str, Any]  # the fields of `pymeshfair.running.shape_change.ShapeChange` by name
    steps: tuple[StepReport, ...]
    warnings: tuple[str, ...]  # about contents of the input that the output lacks, and about the run
    seconds: float  # from start to end
    peak_memory: int | None  # the most bytes that the worker used; None where the system does not measure it
    breaches: tuple[Mapping[str, Any], ...] = ()  # broken limits, each with the fields of `pymeshfair.running.guarding.Breach`
    maps: tuple[Path, ...] = ()  # the files of the intervention map
    unit: str | None = None  # the unit of all lengths above; None if it is not known

    @classmethod
    def of(cls, job: Job, record: Mapping[str, Any], side_files: Sequence[Path], maps: Sequence[Path] = ()) -> RunResult:
        measures, run = record["measures"], record["run"]
        return cls(
            output=job.output,
            provenance=provenance_path(job.output),
            side_files=tuple(side_files),
            **{name: measures[name] or {} for name in ("before", "after", "change")},
            steps=steps_of(record),
            warnings=tuple(record["warnings"]),
            seconds=run["seconds"],
            peak_memory=run["peak_memory_bytes"],
            breaches=tuple(record.get("guards", {}).get("breaches", ())),
            maps=tuple(maps),
            unit=measures["unit"],
        )

    def __repr__(self) -> str:
        sizes = [measures["vertices"] for measures in (self.before, self.after) if measures]
        counts = ((len(self.steps), "step"), (len(self.warnings), "warning"), (len(self.breaches), "broken limit"))
        words = [counted(count, word) for count, word in counts if count]
        words += [" -> ".join([*(f"{n:,}" for n in sizes[:-1]), counted(sizes[-1], "vertex", "vertices")])] if sizes else []
        return f"<RunResult {str(self.output)!r}: {', '.join(words)}, {self.seconds:.1f} s>"

    @property
    def record(self) -> dict[str, Any]:
        """The provenance document, read from its file; empty without the file."""
        return read_provenance(self.output) or {}


@dataclass(frozen=True, kw_only=True)
class Report:
    """A worker's report of a run. All mappings hold values of JSON, as in the provenance document."""

    input: Mapping[str, Any]  # the files that were read
    #: the file that was written, with its side files; None if a limit was broken and nothing was written
    output: Mapping[str, Any] | None = None
    steps: tuple[StepReport, ...]
    staged: tuple[StagedFile, ...] = ()  # the output and its side files in the staging folder
    before: Mapping[str, Any] | None = None  # the measures of the mesh as read; None if the job wants no measures
    after: Mapping[str, Any] | None = None  # the measures of the mesh as written
    change: Mapping[str, Any] | None = None  # the change of shape
    traits: Mapping[str, Any] = field(default_factory=dict)  # the traits that were measured for the recipe, see `traits_of`
    warnings: tuple[str, ...] = ()
    breaches: tuple[Mapping[str, Any], ...] = ()  # the limits that were broken
    maps: tuple[StagedFile, ...] = ()  # the files of the intervention map in the staging folder
    tiles: Mapping[str, Any] | None = None  # the tiles of the run; None if it was done in one piece
    peak_memory: int | None = None  # as in `RunResult`

    def record(self, job: Job, *, started: datetime, seconds: float) -> dict[str, Any]:
        script, unit = job.recipe.script, job.unit_of(self.input.get("unit"))
        assert self.output is not None
        options = job.options | ({"own_texture_names": True} if job.own_texture_names and self.output["side_files"] else {})
        guards: dict[str, Any] = {}
        if job.all_guards or job.map is not None:
            limits, tolerance = job.lengths_in(unit)
            maps = [described_file(file.staged, named=file.target) for file in self.maps]
            guards = {"limits": limits.texts(), "breaches": list(self.breaches), "maps": maps}
            guards |= {"map_tolerance": str(tolerance)} if job.map_tolerance else {}
        return {
            "schema": SCHEMA,
            "recipe": {
                "name": job.recipe.name,
                "file": None if script.path is None else str(script.path.absolute()),
                "overrides": list(job.overrides),
                "sha256": job.recipe.digest,
                "text": job.recipe.text,
            },
            **({"options": options} if options else {}),
            "input": self.input,
            "output": self.output,
            "steps": [
                {name: getattr(done, name) for name in _OF_STEP} | {"origin": step.filter.origin, "messages": list(done.messages)}
                for step, done in zip(script.steps, self.steps, strict=True)
            ],
            "measures": {"unit": unit} | {name: getattr(self, name) for name in ("before", "after", "change", "traits")},
            "warnings": [*job.recipe.warnings, *job.warnings, *self.warnings],
            **({"guards": guards} if guards else {}),
            **({} if self.tiles is None else {"tiles": self.tiles}),
            "versions": versions(),
            "threads": thread_settings(worker_environment(job.threads)),
            "run": {
                "started": started.isoformat(timespec="seconds").replace("+00:00", "Z"),
                "seconds": round(seconds, 3),
                "step_seconds": [round(done.seconds, 3) for done in self.steps],
                "peak_memory_bytes": self.peak_memory,
                "command": list(job.command),
            },
        }


#: the fields of a `StepReport` that the record of a step has unchanged
_OF_STEP = ("number", "filter", "python_name", "parameters", "values")


def steps_of(record: Mapping[str, Any]) -> tuple[StepReport, ...]:
    """The reports of all steps in a provenance document."""
    return tuple(
        StepReport(**{name: step[name] for name in _OF_STEP}, seconds=seconds, messages=tuple(step["messages"]))
        for step, seconds in zip(record["steps"], record["run"]["step_seconds"], strict=True)
    )


LONGEST_LIST = 64  # the most numbers of a recorded array; a larger array is recorded by its shape alone


def plain(value: Any) -> Any:
    """The value as JSON can hold it; non-finite numbers become the texts nan, inf and -inf."""
    match value:
        case None | bool() | int() | str():
            return value
        case np.bool_() | np.integer():
            return value.item()
        case float() | np.floating():
            number = float(value)
            return number if math.isfinite(number) else str(number)
        case Length():
            return value.amount if value.unit == "absolute" else str(value)
        case np.ndarray():
            return plain(value.tolist()) if value.size <= LONGEST_LIST else f"array of shape {value.shape}"
        case Mapping():
            return {str(k): plain(v) for k, v in value.items()}
        case list() | tuple() | set() | frozenset():
            return [plain(v) for v in value]
    for names in (("value",), ("red", "green", "blue", "alpha"), ("min", "max")):  # pymeshlab's length, colour, box
        if all(callable(getattr(value, name, None)) for name in names):
            values = [plain(getattr(value, name)()) for name in names]
            return values[0] if len(values) == 1 else values
    return str(value)
