"""The provenance document and the result of a run, from what supervisor and worker know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from ..files.provenance import SCHEMA, described_file, provenance_path
from .environment import worker_environment
from .job import Job, RunResult, StepReport
from .versions import thread_settings, versions


def record_of(
    job: Job,
    report: Mapping[str, Any],
    said: Mapping[int, Sequence[str]],
    warned: Mapping[int, Sequence[str]],
    *,
    started: datetime,
    seconds: float,
) -> dict[str, Any]:
    """The provenance document of a finished run.

    Args:
        job: what was asked for.
        report: what the worker reported.
        said: what filters said, by the number of the step.
        warned: what MeshLab called warnings, by the number of the step, 0 for reading and writing.
        started: when.
        seconds: how long it took.
    """
    script = job.recipe.script
    warnings = [*job.warnings, *report["warnings"]]
    # Where the format declares its counts the worker reports what reading left out; elsewhere MeshLab's warnings have to do.
    warnings += [f"MeshLab says: {text}" for text in warned.get(0, ()) if not report["counted"]]
    warnings += [f"step {n}: {text}" for n in sorted(warned) if n for text in warned[n]]
    return {
        "schema": SCHEMA,
        "recipe": {
            "name": job.recipe.name,
            "file": None if script.path is None else str(script.path.absolute()),
            "overrides": list(job.overrides),
            "sha256": job.recipe.digest,
            "text": job.recipe.text,
        },
        **_options(job, report["output"]["side_files"]),
        "input": report["input"],
        "output": report["output"],
        "steps": [
            {
                "number": number,
                "filter": step.filter.name,
                "python_name": step.filter.python_name,
                "origin": step.filter.origin,
                "parameters": done["parameters"],
                "values": done["values"],
                "messages": [*said.get(number, ()), *done["notes"]],
            }
            for number, (step, done) in enumerate(zip(script.steps, report["steps"], strict=True), 1)
        ],
        "measures": {name: report[name] for name in ("before", "after", "change", "traits")},
        "warnings": warnings,
        **_guarded(job, report),
        "versions": versions(),
        "threads": thread_settings(worker_environment(job.threads)),
        "run": {
            "started": started.isoformat(timespec="seconds").replace("+00:00", "Z"),
            "seconds": round(seconds, 3),
            "step_seconds": [round(done["seconds"], 3) for done in report["steps"]],
            "peak_memory_bytes": report["peak_memory"],
            "command": list(job.command),
        },
    }


def _options(job: Job, side_files: Sequence[Any]) -> dict[str, Any]:
    """The entry about what the input was allowed, its unit, measures and names of textures, where that was not as usual."""
    given: dict[str, Any] = {name: True for name in ("allow_outside", "unchecked", "keep_all") if getattr(job, name)}
    given |= {} if job.measures else {"no_measures": True}
    given |= {} if job.unit is None else {"unit": job.unit}
    given |= {"own_texture_names": True} if job.own_texture_names and side_files else {}
    return {"options": given} if given else {}


def _guarded(job: Job, report: Mapping[str, Any]) -> dict[str, Any]:
    """The entry about guards and the intervention map, of a run that had any."""
    if "breaches" not in report:
        return {}
    maps = [described_file(Path(f["staged"]), named=Path(f["target"])) for f in report["maps"]]
    return {"guards": {"limits": job.all_guards.texts(), "breaches": report["breaches"], "maps": maps}}


def result_of(job: Job, record: Mapping[str, Any], side_files: Sequence[Path], maps: Sequence[Path] = ()) -> RunResult:
    """What `run_job` gives back, from the document that it has written."""
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
    )


def steps_of(record: Mapping[str, Any]) -> tuple[StepReport, ...]:
    """What every step did, from a provenance document."""
    return tuple(
        StepReport(
            step["number"],
            step["filter"],
            step["python_name"],
            seconds,
            parameters=step["parameters"],
            values=step["values"],
            messages=tuple(step["messages"]),
        )
        for step, seconds in zip(record["steps"], record["run"]["step_seconds"], strict=True)
    )
