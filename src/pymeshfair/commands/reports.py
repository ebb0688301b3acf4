"""Reports: one HTML file about two meshes, and about the run between them, with its changes and limits."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import GuardBroken, PymeshfairError
from ..files.writing import StagedFile, check_target, stage_file, write_file
from ..looking.comparison import Comparison, Distances, MeshState, compare, state_of
from ..looking.words import counted
from ..report.comparison_page import Compared, Verdict, comparison_page, verdict_of
from ..report.scene import Marker
from ..running.read import read_mesh, reported_values
from ..running.supervise import run_job
from .options import PAGES
from .streams import plain, say

if TYPE_CHECKING:
    from ..running.job import Job, RunResult


#: vertices of a mesh beyond which its spectrum takes longer than all the rest of a report
MOST_OF_SPECTRUM = 200_000


def with_spectra(before: MeshState, after: MeshState, comparison: Comparison, distances: Distances) -> tuple[Compared, list[str]]:
    """The comparison of two meshes that were read from files, with their spectra, and what a page leaves out, with the reason."""
    spectra: dict[str, Any] = {}
    left_out = []
    if before.self_intersecting is None and after.self_intersecting is None:
        left_out.append("Faces that cut others were not looked for: `compare --self-intersections` does, in large meshes, too.")
    if max(len(before.mesh.vertices), len(after.mesh.vertices)) > MOST_OF_SPECTRUM:
        left_out.append(f"No spectrum: a mesh has more than {MOST_OF_SPECTRUM:,} vertices. `pymeshfair spectrum` takes its time.")
    else:
        try:
            for name, state in (("before", before), ("after", after)):
                spectra[name] = reported_values(state.path, "get_surface_spectrum", {"modes": 0})
        except PymeshfairError as error:
            spectra.clear()
            left_out.append(f"No spectrum: {error}")
    return Compared(before, after, comparison, distances, spectra), left_out


def page_numbers(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """The document of a command in terms of JSON, with names of files alone, as a page has it."""
    return dict(plain({**numbers, "files": {key: path and path.name for key, path in numbers["files"].items()}}))


@contextlib.contextmanager
def reporting(job: Job, path: Path, up: str) -> Iterator[Callable[[RunResult], Sequence[StagedFile]]]:
    """Makes the report of a run, to appear with its output.

    A run without output, because it broke a limit, is reported, too: it is repeated into a temporary folder to show its result.
    """
    before = state_of(read_mesh(job.input, self_intersections=None, allow_outside=job.allow_outside, unchecked=job.unchecked))
    target = path.absolute()

    def staged(result: RunResult) -> Sequence[StagedFile]:
        page = _page(job, result, before, up, kept=True)
        check_target(path, PAGES, overwrite=job.overwrite)
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
    after = state_of(read_mesh(result.output, self_intersections=None))
    comparison, distances = compare(before, after)
    # How far vertices moved is what the run said, before the file rounded their coordinates.
    compared, left_out = with_spectra(before, after, replace(comparison, displacement=None), distances)
    files = {"before": job.input, "after": job.output if kept else None}
    record = result.provenance.read_text("utf-8")
    provenance = "A run without output leaves no provenance."
    if kept:
        provenance = record
        for folder in (job.input.absolute().parent, job.output.absolute().parent, Path.cwd()):
            # The folders of this machine say nothing to those who get the page.
            provenance = provenance.replace(f"{json.dumps(str(folder))[1:-1]}/", "")
    written = f"written to {job.output.name}" if kept else "no output was written"
    return comparison_page(
        compared,
        title=f"{job.input.name}: {job.recipe.title}",
        subtitle=f"The recipe {job.recipe.name} on {job.input.name}, {written}.",
        numbers=page_numbers({"files": files, "change": result.change, "comparison": compared.comparison}),
        up=up,
        unit=result.unit,
        warnings=result.warnings,
        left_out=left_out,
        verdict=_verdict(job, result, compared.comparison, kept=kept),
        markers=[Marker(b["place"], f"{b['guard']}, vertex {b['vertex']}") for b in result.breaches if b["place"]],
        run=json.loads(record),
        provenance=provenance,
    )


def _verdict(job: Job, result: RunResult, comparison: Comparison, *, kept: bool) -> Verdict:
    moved = verdict_of(comparison, result.change, result.unit)
    steps = f"{counted(len(result.steps), 'step')} in {result.seconds:.1f} s."
    if result.breaches:
        lines = [f"{breach['guard']}: {breach['message']}." for breach in result.breaches]
        count = "a limit" if len(lines) == 1 else f"{len(lines)} limits"
        what = "the output was written all the same" if kept else "no output was written"
        return Verdict("bad", f"The run went beyond {count}; {what}.", (*lines, moved.text, *moved.lines, steps))
    if limits := job.all_guards.texts():
        kept_limits = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in limits.items())
        return Verdict("good", f"Done, and every limit was kept: {kept_limits}.", (moved.text, *moved.lines, steps))
    return Verdict(moved.kind, moved.text, (*moved.lines, f"{steps} No limits were set."))
