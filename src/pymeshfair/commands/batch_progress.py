"""The progress of a batch on stderr, a bar on a terminal and else a line a scan; and the tables of its results or plan."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from ..batch.outcomes import Outcome, Summary, area_change, displacement_in_edges, largest_in_edges
from ..batch.plan import Scan
from ..batch.work import Prospect, Task
from .progress import progress_bar
from .streams import Talk, complain, counted, printable, say, talk
from .tables import console, table


class BatchLines(ExitStack):
    """A line for each scan that ends. A context manager, which ends the bar of `BatchBar`."""

    def __init__(self) -> None:
        super().__init__()
        self._total = 0
        self._ended = 0

    def begin(self, total: int) -> None:
        """So many scans are to do."""
        self._total = total

    def note(self, text: str) -> None:
        """Say something about the batch as a whole."""
        say(text, err=True)

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended."""
        self._ended += 1
        self.note(f"[{self._ended:>{len(str(self._total))}}/{self._total}] {outcome_line(scan, outcome)}")

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        """A page was made."""
        if "problem" in made:
            self.note(f"{scan.label}: no page: {made['problem']}")


class BatchBar(BatchLines):
    """A bar over all scans with their rate, the time left and the worst so far; those that fail stay above it."""

    def __init__(self) -> None:
        super().__init__()
        columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
        self._bar = self.enter_context(progress_bar(*columns))
        self._task = self._bar.add_task("preparing", total=None)
        self._started = time.monotonic()
        self._failed = 0
        self._worst: tuple[float, str] | None = None

    def begin(self, total: int) -> None:
        self._started = time.monotonic()
        self._bar.update(self._task, total=total, description="starting")

    def note(self, text: str) -> None:
        self._bar.console.print(printable(text), markup=False)

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        self._ended += 1
        self._failed += outcome.status != "done"
        moved = displacement_in_edges(outcome)
        if moved is not None and (self._worst is None or moved > self._worst[0]):
            self._worst = moved, scan.label
        if outcome.status != "done":
            self.note(outcome_line(scan, outcome))
        rate = 60.0 * self._ended / max(1e-9, time.monotonic() - self._started)
        words = [f"{rate:.3g} a minute", f"{self._failed} failed"]
        if self._worst is not None:
            words.append(f"moved most: {self._worst[1]}, {self._worst[0]:.2g} edges")
        self._bar.update(self._task, completed=self._ended, description=escape(printable(", ".join(words))))

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        super().page(scan, made)
        self._bar.update(self._task, description=escape(printable(f"page of {scan.label}")))


def outcome_line(scan: Scan, outcome: Outcome) -> str:
    """One line about a scan that has ended."""
    if outcome.error is not None:
        return f"{scan.label}: failed: {outcome.error['message']}" + (f"; {outcome.former}" if outcome.former else "")
    broken = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in outcome.breaches)
    moved = displacement_in_edges(outcome)
    words = [f"{outcome.seconds:.2f} s"]
    if moved is not None:
        words.append(f"moved by {moved:.2g} edges")
    if outcome.warnings:
        words.append(counted(len(outcome.warnings), "warning"))
    return f"{scan.label}: {', '.join(words)}" + (f", written although {broken}" if broken else "")


def batch_progress() -> BatchLines:
    """A bar if stderr is a terminal, else lines, which `say` prints."""
    return BatchBar() if sys.stderr.isatty() and talk() == Talk.USUAL else BatchLines()


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
    shown = summary.rows if len(summary.rows) <= _LISTED else summary.worst_first[:_LISTED]
    headers = ["scan", "", "vertices", "moved (edges)", "at most", "area %", "seconds", ""]
    console().print(table(headers, [_row(*row) for row in shown], numbers=range(2, 7)))
    if len(shown) < len(summary.rows):
        typer.echo(f"  and {len(summary.rows) - len(shown):,} that went better; batch.csv has them all")
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
    remarks += [counted(len(outcome.warnings), "warning")] if outcome.warnings else []
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
