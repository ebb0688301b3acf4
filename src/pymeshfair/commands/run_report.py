"""The report of a run: changes of the mesh, and limits kept or broken."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..files.writing import StagedFile, stage_file, write_file
from ..looking.mesh_state import MeshState, state_of
from ..report.comparison_page import Verdict, comparison_page, verdict_of
from ..report.scene import Marker
from ..running.errors import GuardBroken
from ..running.read import read_mesh
from ..running.supervise import run_job
from .report_file import check_report, compared_files, page_numbers
from .streams import say

if TYPE_CHECKING:
    from ..looking.comparison import Comparison
    from ..running.job import Job, RunResult


@contextlib.contextmanager
def reporting(job: Job, path: Path, up: str) -> Iterator[Callable[[RunResult], Sequence[StagedFile]]]:
    """Makes the report of a run, to appear with its output.

    A run without output, because it broke a limit, is reported, too: it is repeated into a temporary folder to show its result.
    """
    before = state_of(read_mesh(job.input, self_intersections=None, allow_outside=job.allow_outside, unchecked=job.unchecked))
    target = path.absolute()

    def staged(result: RunResult) -> Sequence[StagedFile]:
        page = _page(job, result, before, up, kept=True)
        check_report(path, up, overwrite=job.overwrite)
        return [stage_file(result.output.with_name("report.html"), target, page)]

    try:
        yield staged
    except GuardBroken:
        say("repeating the run for its report", err=True)
        with tempfile.TemporaryDirectory() as folder:
            again = replace(job, output=Path(folder) / "result.ply", keep_broken=True, map=None, overwrite=False)
            page = _page(job, run_job(again), before, up, kept=False)
        write_file(target, page, overwrite=job.overwrite)
        say(f"Report: {path}", err=True)
        raise


def _page(job: Job, result: RunResult, before: MeshState, up: str, *, kept: bool) -> bytes:
    compared, left_out = compared_files(before, state_of(read_mesh(result.output, self_intersections=None)))
    # How far vertices moved is what the run said, before the file rounded their coordinates.
    compared = replace(compared, comparison=replace(compared.comparison, displacement=None))
    places = [(breach["place"], f"{breach['guard']}, vertex {breach['vertex']}") for breach in result.breaches if breach["place"]]
    record = result.provenance.read_text("utf-8")
    written = f"written to {job.output.name}" if kept else "no output was written"
    return comparison_page(
        compared,
        title=f"{job.input.name}: {job.recipe.title}",
        subtitle=f"The recipe {job.recipe.name} on {job.input.name}, {written}.",
        numbers=page_numbers(
            {
                "files": {"before": job.input, "after": job.output if kept else None},
                "change": result.change,
                "comparison": compared.comparison,
            }
        ),
        up=up,
        unit=result.unit,
        warnings=result.warnings,
        left_out=left_out,
        verdict=_verdict(job, result, compared.comparison, kept=kept),
        markers=[Marker(place, words) for place, words in places],
        run=json.loads(record),
        provenance=_without_folders(record, job) if kept else "A run without output leaves no provenance.",
    )


def _without_folders(text: str, job: Job) -> str:
    """The record without the folders of this machine, which say nothing to those who get the page."""
    for folder in (job.input.absolute().parent, job.output.absolute().parent, Path.cwd()):
        text = text.replace(f"{json.dumps(str(folder))[1:-1]}/", "")
    return text


def _verdict(job: Job, result: RunResult, found: Comparison, *, kept: bool) -> Verdict:
    moved = verdict_of(found, result.change, result.unit)
    steps = f"{len(result.steps)} {'step' if len(result.steps) == 1 else 'steps'} in {result.seconds:.1f} s."
    if result.breaches:
        lines = [f"{breach['guard']}: {breach['message']}." for breach in result.breaches]
        count = "a limit" if len(lines) == 1 else f"{len(lines)} limits"
        what = "the output was written all the same" if kept else "no output was written"
        return Verdict("bad", f"The run went beyond {count}; {what}.", (*lines, moved.text, *moved.lines, steps))
    limits = job.all_guards.texts()
    if limits:
        told = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in limits.items())
        return Verdict("good", f"Done, and every limit was kept: {told}.", (moved.text, *moved.lines, steps))
    return Verdict(moved.kind, moved.text, (*moved.lines, f"{steps} No limits were set."))
