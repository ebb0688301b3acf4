"""The input of a run, its events, the report of its work, and the result and the provenance document that are made of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from ..declaration import Length
from ..declaration.parameters import unit_of_scan
from ..files.formats import READABLE, extension
from ..files.outputs import MadeFrom
from ..files.provenance import SCHEMA, described_file, provenance_path, read_provenance
from ..files.writing import StagedFile
from ..processes.environment import thread_settings, versions, worker_environment
from ..recipe import Recipe
from ..scripts.guards import NO_GUARDS, Guards


@dataclass(frozen=True)
class Job:
    """One mesh file, one recipe, one file to write."""

    recipe: Recipe  # the steps, overrides included
    input: Path  # the mesh file to read
    output: Path  # the file to write; its extension says the format
    others: tuple[Path, ...] = ()  # mesh files for the layers 1, 2 ... that the recipe names; the input stays the current one
    #: replace `output` whatever it is, the input itself included. Without it an existing file is replaced only if it is, to the
    #: byte, what the same run wrote there before: from the same input, with the same recipe and settings.
    overwrite: bool = False
    timeout: float | None = None  # seconds from start to end, or None
    memory_limit: int | None = None  # bytes that the worker may take, as far as the system can hold it; None: a share of all
    allow_outside: bool = False  # let the input name textures, materials and buffers outside its own folder
    unchecked: bool = False  # let MeshLab read formats that are not checked before
    keep_all: bool = False  # fail if anything of the input, or of the result, is not in the output
    threads: int | None = None  # that a filter may use; None means all processors, or what OMP_NUM_THREADS says
    overrides: tuple[str, ...] = ()  # the texts ``STEP.PARAM=VALUE`` that the recipe was changed by, for the record
    command: tuple[str, ...] = ()  # the command line that asked for the run, for the record alone
    guards: Guards = NO_GUARDS  # limits over those of the recipe
    keep_broken: bool = False  # write the output even if a guard was broken
    map: Path | None = None  # the .ply file for the intervention map, or None
    map_tolerance: Length | None = None  # vertices that moved by no more count as kept there; None: only those that did not
    #: put the output's name before the names of its textures, so that runs side by side into one folder do not ask for the same
    own_texture_names: bool = False
    warnings: tuple[str, ...] = ()  # about the recipe; the result and the record list them before those of the run
    measures: bool = True  # measure the mesh before and after; without, there are no limits and nothing to compare
    unit: str | None = (
        None  # of the scan, one of `pymeshfair.declaration.parameters.METRES`; None: that of its file, or of the recipe
    )

    @property
    def made_from(self) -> MadeFrom:
        """The sources of the output."""
        return MadeFrom(self.input, self.recipe.digest, self.others)

    @property
    def map_files(self) -> tuple[Path, ...]:
        """The two files of the intervention map, ``map.ply`` and ``map.removed.ply``; none if it is not wanted."""
        return () if self.map is None else (self.map, self.map.with_name(f"{self.map.stem}.removed{self.map.suffix}"))

    @property
    def all_guards(self) -> Guards:
        """The limits of the recipe and of the job, as they were given."""
        return self.recipe.script.guards.overridden(self.guards)

    def unit_of(self, file_unit: str | None) -> str | None:
        """The unit of the scan, given that of its file; None without any."""
        return unit_of_scan(self.unit, file_unit, self.recipe.script.unit)

    def doubts_of_unit(self, file_unit: str | None) -> tuple[str, ...]:
        """The warning where the recipe is for another unit than that of the scan, given that of its file."""
        unit, meant = self.unit_of(file_unit), self.recipe.script.unit
        if not meant or meant == unit:
            return ()
        return (f"the recipe is for scans in {meant}, and this one is in {unit}: its plain numbers mean {unit}",)

    def check_unit(self) -> None:
        """Refuse a length with a unit where nothing says that of the scan, as far as that is known before the file is read."""
        unit, kind = self.unit_of(None), READABLE.get(extension(self.input))
        if kind is None or not kind.has_unit:
            self.lengths_in(unit)

    def lengths_in(self, unit: str | None) -> tuple[Guards, Length]:
        """The limits, and the tolerance of the map, on a scan in that unit."""
        return self.all_guards.in_mesh_units(unit), (self.map_tolerance or Length(0.0)).in_mesh_units(unit)


@dataclass(frozen=True)
class PhaseStarted:
    """The run begins to read the input, to write the output, or to compare them."""

    phase: Literal["reading", "writing", "comparing"]


@dataclass(frozen=True)
class StepStarted:
    """A step begins."""

    index: int  # its number, from 1 to `total`
    total: int  # how many there are
    filter: str  # MeshLab's name of its filter


@dataclass(frozen=True)
class StepProgress:
    """Progress of a step: `fraction` from 0 to 1. Not every filter reports it, and some go from 0 to 1 several times."""

    index: int
    fraction: float


@dataclass(frozen=True)
class StepFinished:
    """A step has ended after `seconds`."""

    index: int
    seconds: float


@dataclass(frozen=True)
class Message:
    """Something a user wants to know: a filter's words (``"info"``), or what a run could not keep (``"warning"``)."""

    text: str  # a sentence
    level: Literal["info", "warning"] = "info"
    step: int = 0  # the number of the step that it is about, 0 if it is about none; words may arrive after the step has ended


@dataclass(frozen=True)
class Compiling:
    """Filters are compiled for this machine; until then what else goes on stands still."""

    kernels: int  # how many functions were compiled, the one in work among them
    seconds: float  # how long that has taken so far
    is_going_on: bool  # whether one is in work


Event: TypeAlias = PhaseStarted | StepStarted | StepProgress | StepFinished | Message | Compiling


@dataclass(frozen=True)
class StepReport:
    """The report of one step."""

    number: int  # from 1
    filter: str  # MeshLab's name of the filter
    python_name: str  # its name in Python
    seconds: float  # how long it took
    parameters: Mapping[str, Any] = field(default_factory=dict)  # all with the values that they had; lengths in mesh units
    values: Mapping[str, Any] = field(default_factory=dict)  # those that the filter reported
    messages: tuple[str, ...] = ()  # those of the filter


@dataclass(frozen=True)
class RunResult:
    """The result of a run."""

    output: Path  # the file that was written
    provenance: Path  # the file beside it that says how it came about
    side_files: tuple[Path, ...]  # textures and material files that belong to the output, as far as they were written
    #: the measures of the mesh as read (`pymeshfair.filters.inspection.surface_measures.SurfaceMeasures`). This and the next two
    #: are empty if the job wanted no measures.
    before: Mapping[str, Any]
    after: Mapping[str, Any]  # the measures of the mesh as written
    change: Mapping[str, Any]  # of the shape, `pymeshfair.running.shape_change.ShapeChange` by name
    steps: tuple[StepReport, ...]  # one report a step
    warnings: tuple[str, ...]  # everything that was in the input and is not in the output, or needs to be known about it
    seconds: float  # from start to end
    peak_memory: int | None  # bytes that the worker took at most, or None where the system does not say
    breaches: tuple[Mapping[str, Any], ...] = ()  # broken limits, each a `pymeshfair.running.guarding.Breach` by name
    maps: tuple[Path, ...] = ()  # the files of the intervention map
    unit: str | None = None  # of the lengths in all of these; None if it is not known

    @classmethod
    def of(cls, job: Job, record: Mapping[str, Any], side_files: Sequence[Path], maps: Sequence[Path] = ()) -> RunResult:
        """The result of a job, from the document that it has written."""
        measures, run = record["measures"], record["run"]
        return cls(
            output=job.output,
            provenance=provenance_path(job.output),
            side_files=tuple(side_files),
            before=measures["before"] or {},
            after=measures["after"] or {},
            change=measures["change"] or {},
            steps=steps_of(record),
            warnings=tuple(record["warnings"]),
            seconds=run["seconds"],
            peak_memory=run["peak_memory_bytes"],
            breaches=tuple(record.get("guards", {}).get("breaches", ())),
            maps=tuple(maps),
            unit=measures["unit"],
        )

    def __repr__(self) -> str:
        sizes = [f"{measures['vertices']:,}" for measures in (self.before, self.after) if measures]
        counts = ((len(self.steps), "step"), (len(self.warnings), "warning"), (len(self.breaches), "broken limit"))
        counted = [f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts if count]
        counted += [f"{' -> '.join(sizes)} vertices"] if sizes else []
        return f"<RunResult {str(self.output)!r}: {', '.join(counted)}, {self.seconds:.1f} s>"

    @property
    def record(self) -> dict[str, Any]:
        """The provenance document, read from its file; empty if that is gone."""
        return read_provenance(self.output) or {}


@dataclass(frozen=True, kw_only=True)
class Report:
    """The results of the work of a run. All mappings are in terms of JSON, as in the provenance document."""

    input: Mapping[str, Any]  # which files were read
    #: which file was written, with its side files; None if a limit was broken and nothing was written
    output: Mapping[str, Any] | None = None
    steps: tuple[StepReport, ...]  # one for each step
    staged: tuple[StagedFile, ...] = ()  # the output and its side files in the staging folder
    before: Mapping[str, Any] | None = None  # the measures of the mesh as read; None if none are wanted. So the next two.
    after: Mapping[str, Any] | None = None  # those of the mesh as written
    change: Mapping[str, Any] | None = None  # of the shape between them
    traits: Mapping[str, Any] = field(default_factory=dict)  # those of the scan that the recipe asked for
    warnings: tuple[str, ...] = ()  # for the user
    breaches: tuple[Mapping[str, Any], ...] = ()  # the limits that were broken
    maps: tuple[StagedFile, ...] = ()  # the files of the intervention map in the staging folder
    tiles: Mapping[str, Any] | None = None  # how the work was cut; None if it was done in one piece
    peak_memory: int | None = None  # bytes that it took at most; None where the system does not measure that

    def record(self, job: Job, *, started: datetime, seconds: float) -> dict[str, Any]:
        """The provenance document of a finished run."""
        script, unit = job.recipe.script, job.unit_of(self.input.get("unit"))
        assert self.output is not None
        options: dict[str, Any] = {name: True for name in ("allow_outside", "unchecked", "keep_all") if getattr(job, name)}
        options |= {} if job.measures else {"no_measures": True}
        options |= {} if job.unit is None else {"unit": job.unit}
        options |= {"own_texture_names": True} if job.own_texture_names and self.output["side_files"] else {}
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
            "measures": {
                "unit": unit,
                "before": self.before,
                "after": self.after,
                "change": self.change,
                "traits": self.traits,
            },
            "warnings": [*job.warnings, *self.warnings],
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


#: the entries of a step in the record that its report has alike
_OF_STEP = ("number", "filter", "python_name", "parameters", "values")


def steps_of(record: Mapping[str, Any]) -> tuple[StepReport, ...]:
    """The reports of all steps, from a provenance document."""
    return tuple(
        StepReport(**{name: step[name] for name in _OF_STEP}, seconds=seconds, messages=tuple(step["messages"]))
        for step, seconds in zip(record["steps"], record["run"]["step_seconds"], strict=True)
    )


LONGEST_LIST = 64  # arrays of more numbers are described, not listed


def plain(value: Any) -> Any:
    """The value as numbers, texts, lists and dictionaries; numbers that are not finite become the texts nan, inf and -inf."""
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
    for names in (("value",), ("red", "green", "blue", "alpha"), ("min", "max")):  # a length, a colour, a box of pymeshlab's
        if all(callable(getattr(value, name, None)) for name in names):
            values = [plain(getattr(value, name)()) for name in names]
            return values[0] if len(values) == 1 else values
    return str(value)
