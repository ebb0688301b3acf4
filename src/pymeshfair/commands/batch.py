"""``pymeshfair batch RECIPE INPUT... -o FOLDER``: the command, its progress on stderr, and the tables of its plan and results."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Argument, Option

from ..places import counted
from . import options
from .options import Json
from .streams import Verbosity, complain, print_document, print_lines, printable, say, verbosity, warn

if TYPE_CHECKING:
    from ..batch.outcomes import Outcome, Summary
    from ..batch.plan import Scan
    from ..batch.work import Prospect, Task

_NAMED = 10  # the largest number of left-out files that are named
_LISTED = 40  # the most scans in the table; of more scans, the worst are listed


@options.with_run_options
def batch(
    recipe: options.Recipe,
    inputs: Annotated[
        list[str],
        Argument(
            metavar="INPUT...",
            help="Mesh files, folders with their subfolders, patterns ('scans/*/*.ply'), lists (@LIST.txt), tables (TABLE.csv); "
            "@- reads a list from standard input, - a table.",
        ),
    ],
    output: Annotated[Path, Option("--output", "-o", metavar="FOLDER", help="The folder to write; made if it is missing.")],
    chosen: options.RunOptions,
    name: Annotated[
        str,
        Option(
            metavar="NAME",
            help="The names of outputs, such as '{stem}_clean.ply', with {stem}, {name}, {extension}, {folder}, {parent} and "
            "{number}. By default outputs have the names and subfolders of inputs; .ply replaces formats that cannot be written.",
        ),
    ] = "",
    jobs: Annotated[int | None, Option(metavar="N", help="Scans at a time; by default one per processor.", min=1)] = None,
    stop: Annotated[bool, Option("--stop/--keep-going", help="Stop at the first scan that fails or breaks a limit.")] = False,
    resume: Annotated[bool, Option("--resume", help="Skip scans done with equal input, recipe, options and versions.")] = False,
    sample: Annotated[int | None, Option(metavar="N", help="Clean only N scans of different file sizes.", min=1)] = None,
    report: Annotated[bool, Option("--report", help="Write batch.html, with a row for each scan, and a page of each.")] = False,
    dry_run: Annotated[bool, Option("--dry-run", help="Check everything, and show what would be done.")] = False,
    overwrite: Annotated[bool, Option("--overwrite", help="Replace existing files even if no run has written them.")] = False,
    json: Json = False,
) -> None:
    """Clean many mesh files with a recipe.

    Worker processes clean the files; without --stop, a file that fails stops no other. FOLDER also gets batch.csv and batch.json
    with a row for each file, and batch.jsonl, the journal.
    """
    from ..batch.plan import expand, plan_scans, without_outputs
    from ..batch.work import Task
    from ..operating_system import this_system

    scheduler = chosen.chosen_scheduler()
    if scheduler is not None and jobs is not None:
        raise typer.BadParameter("not with a scheduler: its workers determine how many scans run at a time", param_hint="--jobs")
    template = chosen.job(recipe, Path(), Path(), report=report, overwrite=overwrite)  # input and output are set for each scan
    # Symbolic links in the path stay, as other machines may know only them; a path with ".." is resolved.
    folder = output.resolve() if ".." in output.parts else output.absolute()
    selected, dropped = without_outputs(expand(inputs, [setting.name for setting in template.recipe.script.settings]), folder)
    warn(*(f"left out: {text}" for text in dropped[:_NAMED]))
    if len(dropped) > _NAMED:
        warn(f"left out: {len(dropped) - _NAMED:,} further files")
    scans = plan_scans(selected, template.recipe, folder, name)
    slots = jobs or this_system().processors()
    task = Task(scans, template, folder, scheduler, slots, resume=resume, stop=stop, sample=sample, report=report)
    if dry_run:
        prospect = task.look_ahead()
        _show_prospect(task, prospect, json=json)
        failed = bool(prospect.problems or prospect.lacks_room)
    else:
        show = BatchBar() if sys.stderr.isatty() and verbosity() == Verbosity.NORMAL else BatchLines()
        with task.processes() as pool, show:
            summary = task.carry_out(show, pool)
        _show_summary(summary, task, json=json)
        failed = bool(summary.counts["failed"] or summary.counts["broken"])
    if failed:
        raise typer.Exit(1)


class BatchLines(ExitStack):
    """A `pymeshfair.batch.work.Listener` that prints a line per finished scan; a context manager, since `BatchBar` is one."""

    def __init__(self) -> None:
        super().__init__()
        self._total = self._ended = 0

    def begin(self, total: int) -> None:
        self._total = total

    def note(self, text: str) -> None:
        say(text, err=True)

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        self._ended += 1
        self.note(f"[{self._ended:>{len(str(self._total))}}/{self._total}] {_line(scan, outcome)}")

    def page(self, scan: Scan, problem: str) -> None:
        if problem:
            self.note(f"{scan.label}: no page: {problem}")


class BatchBar(BatchLines):
    """A progress bar over all scans with the time left; scans that failed or broke a limit are listed above it."""

    def __init__(self) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        from .display import progress_bar

        super().__init__()
        columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
        self._bar = self.enter_context(progress_bar(*columns))
        self._task = self._bar.add_task("preparing", total=None)
        self._failed = 0

    def begin(self, total: int) -> None:
        self._bar.update(self._task, total=total, description="starting")

    def note(self, text: str) -> None:
        self._bar.console.print(printable(text), markup=False)

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        if outcome.status != "done":
            self._failed += 1
            self.note(_line(scan, outcome))
        self._bar.update(self._task, advance=1, description=f"{self._failed} failed or broken")


def _line(scan: Scan, outcome: Outcome) -> str:
    from ..batch.outcomes import displacement_in_edges

    if outcome.error is not None:
        return f"{scan.label}: failed: {outcome.error['message']}" + (f"; {outcome.former}" if outcome.former else "")
    broken = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in outcome.breaches)
    moved = displacement_in_edges(outcome)
    words = [f"{outcome.seconds:.2f} s"]
    words += [] if moved is None else [f"moved by {moved:.2g} edges"]
    words += [counted(len(outcome.warnings), "warning")] if outcome.warnings else []
    return f"{scan.label}: {', '.join(words)}" + (f", written although it broke a limit: {broken}" if broken else "")


def _show_summary(summary: Summary, task: Task, *, json: bool) -> None:
    if json:
        print_document(summary.document())
    elif verbosity() > Verbosity.QUIET:
        _show_rows(summary, task)
    for outcome in summary.outcomes:
        if outcome.error is not None:
            where = "" if outcome.input in outcome.error["message"] else f"{outcome.input}: "
            complain(f"{where}{outcome.error['message']}")
        for breach in outcome.breaches if outcome.error is None else ():
            complain(f"{outcome.input}: {breach['guard']}: {breach['message']}")


def _show_rows(summary: Summary, task: Task) -> None:
    from .display import show_table

    shown = summary.rows if len(summary.rows) <= _LISTED else summary.worst_first[:_LISTED]
    headers = ["scan", "", "vertices", "moved (edges)", "at most", "area %", "seconds", ""]
    show_table(headers, *(_row(*row) for row in shown), numbers=range(2, 7))
    if len(shown) < len(summary.rows):
        typer.echo(f"  and {len(summary.rows) - len(shown):,} with better results; batch.csv lists all")
    counts = summary.counts
    others = {
        "broken": "written although they broke a limit",
        "resumed": "cleaned by an earlier batch",
        "failed": "failed",
        "left": "left",
    }
    words = [f"{counts['done']:,} of {counts['scans']:,} scans done"]
    words += [f"{counts[name]:,} {text}" for name, text in others.items() if counts[name]]
    typer.echo(f"\n{', '.join(words)}, in {summary.seconds:.1f} s. Written:")
    print_lines(f"  {path}" for path in task.written)
    if any(outcome.breaches and outcome.error for outcome in summary.outcomes):
        typer.echo("--keep-broken also writes scans that break a limit; pymeshfair run --map OUT.ply shows where.")
    if counts["left"]:
        without = [f" and without {option}" for option, given in (("--sample", task.sample), ("--stop", task.stop)) if given]
        typer.echo(f"The same command with --resume{''.join(without)} cleans those that are left.")


def _row(outcome: Outcome, label: str, far: Sequence[str]) -> list[str]:
    from ..batch.outcomes import area_change, displacement_in_edges

    remarks = [f"far from the others in {' and '.join(far)}"] if far else []
    remarks += [outcome.former] if outcome.former else []
    remarks += [counted(len(outcome.warnings), "warning")] if outcome.warnings else []
    numbers = (displacement_in_edges(outcome), displacement_in_edges(outcome, "largest"), area_change(outcome))
    return [
        label,
        outcome.status + (" before" if outcome.resumed else ""),
        "-" if outcome.after is None else f"{outcome.after['vertices']:,}",
        *("-" if number is None else f"{number:.3g}" for number in numbers),
        f"{outcome.seconds:.2f}",
        ", ".join(remarks),
    ]


def _show_prospect(task: Task, prospect: Prospect, *, json: bool) -> None:
    from .display import show_table

    recipe, states = task.template.recipe, prospect.states
    steps = [step.filter.name for step in recipe.script.steps]
    if json:
        scans = [
            {name: getattr(scan, name) for name in ("input", "output", "overrides")}
            | {"state": states[scan.number], "problem": prospect.problems.get(scan.number)}
            for scan in task.scans
        ]
        sizes = {name: getattr(prospect, name) for name in ("bytes_in", "bytes_free", "lacks_room")}
        print_document({"recipe": recipe.name, "steps": steps, "scans": scans, **sizes})
    else:
        print_lines([f"{recipe.title} ({recipe.name}):", *(f"  {number}  {step}" for number, step in enumerate(steps, 1)), ""])
        show_table(["input", "output", ""], *([str(scan.input), str(scan.output), states[scan.number]] for scan in task.scans))
        todo = sum(state == "to do" for state in states.values())
        free = "" if prospect.bytes_free is None else f", {prospect.bytes_free / 1e9:.3g} GB free in {task.folder}"
        typer.echo(
            f"\n{todo:,} of {len(task.scans):,} scans to do, {prospect.bytes_in / 1e9:.3g} GB to read{free}. Nothing was done."
        )
    for number, problem in prospect.problems.items():
        complain(f"scan {number}: {problem}")
    if prospect.lacks_room:
        complain("the disk may be too small: outputs may need twice the size of the inputs")
