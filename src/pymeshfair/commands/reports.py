"""The report of a run: one HTML file about both meshes, and about the run between them, with its changes and limits."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files.writing import StagedFile, check_target, stage_file
from ..looking.comparison import Comparison, compare, state_of
from ..looking.words import counted
from ..report.comparison_page import Compared, Verdict, comparison_page, verdict_of
from ..report.scene import Marker
from ..running.read import read_mesh
from .options import PAGES
from .streams import plain

if TYPE_CHECKING:
    from ..running.job import Job, RunResult


def page_numbers(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """The document of a command in terms of JSON, with names of files alone, as a page has it."""
    return dict(plain({**numbers, "files": {key: path.name for key, path in numbers["files"].items()}}))


def staged_report(job: Job, path: Path, up: str, result: RunResult) -> Sequence[StagedFile]:
    """The report of a run whose result is staged, to appear with its output."""
    before = read_mesh(job.input, self_intersections=None, allow_outside=job.allow_outside, unchecked=job.unchecked)
    states = [state_of(before), state_of(read_mesh(result.output, self_intersections=None))]
    comparison, distances = compare(*states)
    # How far vertices moved is what the run said, before the file rounded their coordinates.
    compared = Compared(*states, replace(comparison, displacement=None), distances)
    record = provenance = result.provenance.read_text("utf-8")
    for folder in (job.input.absolute().parent, job.output.absolute().parent, Path.cwd()):
        # The folders of this machine say nothing to those who get the page.
        provenance = provenance.replace(f"{json.dumps(str(folder))[1:-1]}/", "")
    files = {"before": job.input, "after": job.output}
    page = comparison_page(
        compared,
        title=f"{job.input.name}: {job.recipe.title}",
        subtitle=f"The recipe {job.recipe.name} on {job.input.name}, written to {job.output.name}.",
        numbers=page_numbers({"files": files, "change": result.change, "comparison": compared.comparison}),
        up=up,
        unit=result.unit,
        warnings=result.warnings,
        verdict=_verdict(job, result, compared.comparison),
        markers=[Marker(b["place"], f"{b['guard']}, vertex {b['vertex']}") for b in result.breaches if b["place"]],
        run=json.loads(record),
        provenance=provenance,
    )
    check_target(path, PAGES, overwrite=job.overwrite)
    return [stage_file(result.output.with_name("report.html"), path.absolute(), page)]


def _verdict(job: Job, result: RunResult, comparison: Comparison) -> Verdict:
    moved = verdict_of(comparison, result.change, result.unit)
    steps = f"{counted(len(result.steps), 'step')} in {result.seconds:.1f} s."
    if result.breaches:
        lines = [f"{breach['guard']}: {breach['message']}." for breach in result.breaches]
        count = "a limit" if len(lines) == 1 else f"{len(lines)} limits"
        return Verdict(
            "bad", f"The run went beyond {count}; the output was written all the same.", (*lines, moved.text, *moved.lines, steps)
        )
    if limits := job.all_guards.texts():
        kept_limits = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in limits.items())
        return Verdict("good", f"Done, and every limit was kept: {kept_limits}.", (moved.text, *moved.lines, steps))
    return Verdict(moved.kind, moved.text, (*moved.lines, f"{steps} No limits were set."))
