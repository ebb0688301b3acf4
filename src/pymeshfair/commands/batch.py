"""``pymeshfair batch RECIPE INPUT... -o FOLDER``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import options
from .options import Json
from .streams import print_document, warn

if TYPE_CHECKING:
    from ..batch.work import Task

#: so many of the outputs that are left out are named
_NAMED = 10


@options.with_groups
def batch(
    recipe: options.Recipe,
    inputs: Annotated[
        list[str],
        typer.Argument(
            metavar="INPUT...",
            help="Mesh files, folders with all below them, patterns ('scans/*/*.ply'), lists (@LIST.txt), tables (TABLE.csv); "
            "@- is a list on standard input, - a table.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FOLDER", help="Where everything is written; made if need be.")
    ],
    chosen: options.RunOptions,
    cluster: options.SchedulerOptions,
    name: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="The names of outputs, such as '{stem}_clean.ply', with {stem}, {name}, {extension}, {folder}, {parent} and "
            "{number}; by default inputs keep their names, and those of a folder their folders below it.",
        ),
    ] = "",
    jobs: Annotated[int | None, typer.Option(metavar="N", help="Scans at a time; by default one a processor.", min=1)] = None,
    stop: Annotated[bool, typer.Option("--stop/--keep-going", help="Whether to stop at the first scan that fails.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Skip scans that are done already, compared by content.")] = False,
    sample: Annotated[
        int | None, typer.Option(metavar="N", help="Clean only N scans, spread over sizes and noise levels.", min=1)
    ] = None,
    report: Annotated[
        bool, typer.Option("--report", help="Write batch.html, a page with a row a scan, and a page of each scan that is done.")
    ] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check everything, and show what would be done.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace outputs that no run has written.")] = False,
    json: Json = False,
) -> None:
    """Clean many mesh files with a recipe.

    Each file is cleaned in a process of its own; a failure stops only that file. FOLDER also gets batch.csv and batch.json with a
    row for each file, and batch.jsonl, the journal from which --resume continues.
    """
    from ..batch.plan import expand, plan_scans, without_outputs
    from ..batch.work import Task
    from ..operating_system import this_system

    scheduler = cluster.chosen()
    if scheduler is not None and jobs is not None:
        raise typer.BadParameter("not with a scheduler: its workers determine how many scans run at a time", param_hint="--jobs")
    if report:
        options.check_measured(no_measures=chosen.no_measures)
    template = chosen.job(recipe, Path(), Path(), overwrite=overwrite)  # input and output are set for each scan
    folder, settings = output.absolute(), [setting.name for setting in template.recipe.script.settings]
    selected, outputs = without_outputs(expand(inputs, settings), folder)
    warn(*(f"left out: {path}, which is the output of a run" for path in outputs[:_NAMED]))
    if len(outputs) > _NAMED:
        warn(f"left out: {len(outputs) - _NAMED:,} further outputs of runs")
    scans = plan_scans(selected, template.recipe, folder, name)
    slots = jobs or this_system().processors()
    task = Task(scans, template, folder, scheduler, slots, resume=resume, stop=stop, sample=sample, report=report)
    if dry_run:
        _look_ahead(task, json=json)
    else:
        _carry_out(task, json=json)


def _look_ahead(task: Task, *, json: bool) -> None:
    from .batch_progress import prospect_document, show_prospect

    prospect = task.look_ahead()
    if json:
        print_document(prospect_document(task, prospect))
    else:
        show_prospect(task, prospect)
    if prospect.problems or prospect.lacks_room:
        raise typer.Exit(1)


def _carry_out(task: Task, *, json: bool) -> None:
    from .batch_progress import batch_progress, show_summary

    with task.processes() as pool, batch_progress() as show:
        summary = task.carry_out(show, pool)
    if json:
        print_document(summary.document())
    else:
        show_summary(summary, task)
    if summary.counts["failed"] or summary.counts["broken"]:
        raise typer.Exit(1)
