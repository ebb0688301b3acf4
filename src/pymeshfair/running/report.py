"""The report of the work of a run; the provenance document and the result that are made of it, in the types of JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from ..declaration import Length
from ..files.provenance import SCHEMA, described_file, provenance_path
from ..files.writing import StagedFile
from ..processes.environment import thread_settings, versions, worker_environment
from .job import Job, RunResult, StepReport


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


#: the entries of a step in the record that its report has alike
_OF_STEP = ("number", "filter", "python_name", "parameters", "values")


def record_of(job: Job, report: Report, *, started: datetime, seconds: float) -> dict[str, Any]:
    """The provenance document of a finished run."""
    script, unit = job.recipe.script, job.unit_of(report.input.get("unit"))
    assert report.output is not None
    options: dict[str, Any] = {name: True for name in ("allow_outside", "unchecked", "keep_all") if getattr(job, name)}
    options |= {} if job.measures else {"no_measures": True}
    options |= {} if job.unit is None else {"unit": job.unit}
    options |= {"own_texture_names": True} if job.own_texture_names and report.output["side_files"] else {}
    guards: dict[str, Any] = {}
    if job.is_watched:
        limits, tolerance = job.lengths_in(unit)
        maps = [described_file(file.staged, named=file.target) for file in report.maps]
        guards = {"limits": limits.texts(), "breaches": list(report.breaches), "maps": maps}
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
        "input": report.input,
        "output": report.output,
        "steps": [
            {name: getattr(done, name) for name in _OF_STEP} | {"origin": step.filter.origin, "messages": list(done.messages)}
            for step, done in zip(script.steps, report.steps, strict=True)
        ],
        "measures": {
            "unit": unit,
            "before": report.before,
            "after": report.after,
            "change": report.change,
            "traits": report.traits,
        },
        "warnings": [*job.warnings, *report.warnings],
        **({"guards": guards} if guards else {}),
        **({} if report.tiles is None else {"tiles": report.tiles}),
        "versions": versions(),
        "threads": thread_settings(worker_environment(job.threads)),
        "run": {
            "started": started.isoformat(timespec="seconds").replace("+00:00", "Z"),
            "seconds": round(seconds, 3),
            "step_seconds": [round(done.seconds, 3) for done in report.steps],
            "peak_memory_bytes": report.peak_memory,
            "command": list(job.command),
        },
    }


def result_of(job: Job, record: Mapping[str, Any], side_files: Sequence[Path], maps: Sequence[Path] = ()) -> RunResult:
    """The result of `run_job`, from the document that it has written."""
    run = record["run"]
    return RunResult(
        output=job.output,
        provenance=provenance_path(job.output),
        side_files=tuple(side_files),
        before=record["measures"]["before"] or {},
        after=record["measures"]["after"] or {},
        change=record["measures"]["change"] or {},
        steps=steps_of(record),
        warnings=tuple(record["warnings"]),
        seconds=run["seconds"],
        peak_memory=run["peak_memory_bytes"],
        breaches=tuple(record.get("guards", {}).get("breaches", ())),
        maps=tuple(maps),
        unit=record["measures"]["unit"],
    )


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
