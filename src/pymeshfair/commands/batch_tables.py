"""The tables of a batch: its results, or with --dry-run its plan."""

from collections.abc import Sequence
from typing import Any

import typer

from ..batch.journal import Outcome
from ..batch.numbers import area_change, displacement_in_edges, largest_in_edges, worst_first
from ..batch.summary import Summary
from ..batch.work import Prospect, Task
from .batch_progress import counted_warnings
from .streams import Talk, complain, talk
from .tables import console, table

#: of more scans only these many are listed, the worst
_LISTED = 40


def show_summary(summary: Summary, task: Task) -> None:
    """Print a row a scan, the worst first if there are many, then the counts and where everything is; then what failed."""
    if talk() > Talk.LITTLE:
        _show_rows(summary, task)
    for outcome in summary.outcomes:
        if outcome.error is not None:
            where = "" if outcome.input in outcome.error["message"] else f"{outcome.input}: "
            complain(f"{where}{outcome.error['message']}")
        for breach in outcome.breaches if outcome.error is None else ():
            complain(f"{outcome.input}: {breach['guard']}: {breach['message']}")


def _show_rows(summary: Summary, task: Task) -> None:
    told = {outcome.output: (name, far) for outcome, name, far in summary.rows}
    shown = list(summary.outcomes) if len(summary.outcomes) <= _LISTED else worst_first(summary.outcomes)[:_LISTED]
    headers = ["scan", "", "vertices", "moved (edges)", "at most", "area %", "seconds", ""]
    rows = [_row(outcome, *told[outcome.output]) for outcome in shown]
    console().print(table(headers, rows, numbers=range(2, 7)))
    if len(shown) < len(summary.outcomes):
        typer.echo(f"  and {len(summary.outcomes) - len(shown):,} that went better; batch.csv has them all")
    counts = summary.counts
    words = [f"{counts['done']:,} of {counts['scans']:,} scans done"]
    words += [f"{counts['resumed']:,} of them before"] if counts["resumed"] else []
    words += [f"{counts['broken']:,} written beyond a limit"] if counts["broken"] else []
    words += [f"{counts['failed']:,} failed"] if counts["failed"] else []
    words += [f"{counts['left']:,} left"] if counts["left"] else []
    typer.echo(f"\n{', '.join(words)}, in {summary.seconds:.1f} s. Written:")
    for path in task.written:
        typer.echo(f"  {path}")
    if counts["left"]:
        typer.echo("The same command with --resume does what is left.")


def _row(outcome: Outcome, label: str, far: Sequence[str]) -> list[str]:
    vertices = None if outcome.after is None else outcome.after["vertices"]
    remarks = [f"far from the others in {' and '.join(far)}"] if far else []
    remarks += [outcome.former] if outcome.former else []
    remarks += [counted_warnings(outcome)] if outcome.warnings else []
    numbers = (displacement_in_edges(outcome), largest_in_edges(outcome), area_change(outcome))
    return [
        label,
        outcome.status + (" before" if outcome.resumed else ""),
        "-" if vertices is None else f"{vertices:,}",
        *("-" if number is None else f"{number:.3g}" for number in numbers),
        f"{outcome.seconds:.2f}",
        ", ".join(remarks),
    ]


def show_prospect(task: Task, prospect: Prospect) -> None:
    """Print what would be done, and every problem."""
    recipe = task.template.recipe
    typer.echo(f"{recipe.title} ({recipe.name}):")
    for number, step in enumerate(recipe.script.steps, 1):
        typer.echo(f"  {number}  {step.filter.name}")
    typer.echo("")
    rows = [[str(scan.input), str(scan.output), prospect.states[scan.number]] for scan in task.scans]
    console().print(table(["input", "output", ""], rows))
    todo = sum(state == "to do" for state in prospect.states.values())
    free = "" if prospect.bytes_free is None else f", {prospect.bytes_free / 1e9:.3g} GB free in {task.folder}"
    typer.echo(
        f"\n{todo:,} of {len(task.scans):,} scans to do, {prospect.bytes_in / 1e9:.3g} GB to read{free}. Nothing was done."
    )
    for number, problem in prospect.problems.items():
        complain(f"scan {number}: {problem}")
    if prospect.lacks_room:
        complain("the outputs may need twice the size of the inputs")


def prospect_document(task: Task, prospect: Prospect) -> dict[str, Any]:
    """The same as a document."""
    return {
        "recipe": task.template.recipe.name,
        "steps": [step.filter.name for step in task.template.recipe.script.steps],
        "scans": [
            {
                "input": scan.input,
                "output": scan.output,
                "overrides": scan.overrides,
                "state": prospect.states[scan.number],
                "problem": prospect.problems.get(scan.number),
            }
            for scan in task.scans
        ],
        "bytes_in": prospect.bytes_in,
        "bytes_free": prospect.bytes_free,
        "lacks_room": prospect.lacks_room,
    }
