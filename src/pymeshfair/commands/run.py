"""``pymeshfair run RECIPE INPUT -o OUTPUT``."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import options
from .streams import Talk, complain, counted, print_document, print_lines, printable, say, talk, warn

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..running.job import Event, Job, RunResult


@options.with_groups
def run(
    recipe: options.Recipe,
    input: Annotated[Path, typer.Argument(metavar="INPUT", help="The mesh file to clean.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The mesh file to write; its extension is the format.")],
    chosen: options.RunOptions,
    cluster: options.SchedulerOptions,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace OUTPUT, even if it is the input, and the files of --map and --report.")
    ] = False,
    map: Annotated[
        Path | None,
        typer.Option(metavar="MAP.ply", help="Write the intervention map there: what was kept, moved and added, and how far."),
    ] = None,
    map_tolerance: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="What moved by no more counts as kept in MAP.ply: 0.05, 0.1%, 0.5edge, 0.05mm."),
    ] = None,
    tiles: Annotated[
        bool, typer.Option("--tiles", help="Work by tiles, for clouds and meshes larger than memory; see docs/scale.md.")
    ] = False,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="With --tiles: go on with a run that was killed, and let this one be gone on with."),
    ] = False,
    report: options.Report = None,
    up: options.Up = "y",
    json: options.Json = False,
) -> None:
    """Clean a mesh file with a recipe.

    Beside OUTPUT, OUTPUT.provenance.json says how it came about. Both appear whole or not at all, and MAP.ply and OUT.html with
    them. If OUTPUT exists, it is replaced only if it is, to the byte, what this very run wrote there before: from the same INPUT,
    with the same recipe and settings. Anything else is kept, and the run refused, unless --overwrite is given.
    """
    from ..running.supervise import workers_of_runs

    if report is not None:
        options.check_report(report, up, overwrite=overwrite)
        options.check_measured(no_measures=chosen.no_measures)
    with workers_of_runs() as workers:
        if not tiles:
            workers.prepare()
        from ..scripts.warnings import traps

        tolerance = options.map_tolerance(map_tolerance, map)
        job = chosen.job(recipe, input, output, overwrite=overwrite, map=map, map_tolerance=tolerance)
        changes = (str(change) for change in job.recipe.changes if not change.same_meaning)
        job = replace(job, warnings=(*changes, *traps(job.recipe.script)))
        scheduler = cluster.chosen()
        if tiles or scheduler is not None or resume:
            if not tiles or report is not None:
                raise typer.BadParameter(
                    "it needs --tiles" if not tiles else "--tiles makes no report, which shows the whole mesh"
                )
            from ..tiles.course import run_by_tiles

            carry_out(job, lambda show: run_by_tiles(job, show, scheduler=scheduler, resume=resume), json=json)
            return
        from ..running.supervise import run_job

        if report is None:
            carry_out(job, lambda show: run_job(job, show, workers=workers), json=json)
            return
        from .reports import reporting

        with reporting(job, report, up) as page:
            carry_out(job, lambda show: run_job(job, show, workers=workers, also=page), json=json, report=report)


def carry_out(job: Job, carry: Callable[[Callable[[Event], None]], RunResult], *, json: bool, report: Path | None = None) -> None:
    """Run the job with its progress on stderr, then print what came of it on stdout.

    `carry` runs it, and is given what shows the events; `report` is the page that it makes.
    """
    from ..looking import words  # noqa: F401  # for `_show`, while the worker still loads MeshLab
    from . import tables  # noqa: F401
    from .progress import progress

    with progress() as show:
        result = carry(show)
    warn(*result.warnings)
    if report is not None:
        say(f"Report: {report}", err=True)
    if json:
        print_document(_document(job, result))
    elif talk() > Talk.LITTLE:
        _show(result)
    for breach in result.breaches:
        complain(f"{breach['guard']}: {breach['message']}")
    if result.breaches:
        raise typer.Exit(1)


def _document(job: Job, result: RunResult) -> dict[str, object]:
    unmeasured = {name: None for name in ("before", "after", "change") if not getattr(result, name)}
    return {"recipe": job.recipe.name, "input": job.input, **vars(result), **unmeasured}


def _show(result: RunResult) -> None:
    from ..looking.words import change_lines
    from .tables import console, measures_table

    if result.before:
        console().print(measures_table({"before": result.before, "after": result.after}, result.unit))
        print_lines((*change_lines(result.change, result.unit), ""))
    typer.echo(f"{counted(len(result.steps), 'step')} in {result.seconds:.1f} s. Written:")
    for path in (result.output, *result.side_files, result.provenance, *result.maps):
        typer.echo(f"  {printable(_near(path))}")


def _near(path: Path) -> Path:
    """The path from the working folder, where that is shorter."""
    with contextlib.suppress(OSError, ValueError):  # the working folder is gone, or another one
        return path.relative_to(Path.cwd())
    return path
