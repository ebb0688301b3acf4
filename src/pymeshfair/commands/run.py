"""``pymeshfair run RECIPE INPUT -o OUTPUT``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .json_document import print_document
from .options import Debug, Json
from .report_file import Report, Up, check_report
from .streams import printable, warn

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..running.job import Job, RunResult


def run(
    recipe: Annotated[str, typer.Argument(metavar="RECIPE", help="A shipped name or the path of an .mlx file.")],
    input: Annotated[Path, typer.Argument(metavar="INPUT", help="The mesh file to clean.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The mesh file to write; its extension is the format.")],
    set: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Another value for a setting of the recipe, or STEP.PARAM=VALUE for a parameter of a step, whose STEP is "
            "a number, a tag or a part of the filter's name. May be repeated.",
        ),
    ] = None,
    others: Annotated[
        list[Path] | None,
        typer.Option("--with", metavar="MESH", help="The file of a further layer that the recipe names. May be repeated."),
    ] = None,
    upgrade: Annotated[bool, typer.Option("--upgrade", help="Bring a script of an older MeshLab up to date first.")] = False,
    timeout: Annotated[float | None, typer.Option(metavar="SECONDS", help="Stop the run after that time.", min=0.001)] = None,
    memory: Annotated[
        str | None,
        typer.Option(metavar="SIZE", help="Memory that the run may take, such as 4GB; by default 80 % of the machine's."),
    ] = None,
    allow_outside: Annotated[
        bool, typer.Option("--allow-outside", help="Let INPUT name textures, materials and buffers outside its folder.")
    ] = False,
    unchecked: Annotated[
        bool, typer.Option("--unchecked", help="Let MeshLab read formats that are not checked before (.3ds, .ctm, .e57 ...).")
    ] = False,
    keep_all: Annotated[
        bool, typer.Option("--keep-all", help="Fail if anything of INPUT or of the result would not be in OUTPUT.")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUTPUT, even if it is the input.")] = False,
    max_displacement: Annotated[
        str, typer.Option(metavar="LENGTH", help="Fail if a vertex moves further: 0.05 (or 0.05mm), 0.1% or 0.5edge.")
    ] = "",
    max_volume_change: Annotated[str, typer.Option(metavar="PERCENT", help="Fail if the volume changes by more: 1%.")] = "",
    require: Annotated[
        str,
        typer.Option(
            metavar="WHAT,...",
            help="Fail if the result is not so: watertight, manifold, oriented, components=N, genus=N.",
        ),
    ] = "",
    keep_sharp: Annotated[
        str, typer.Option(metavar="PERCENT", help="Fail if less of the length of the sharp edges is kept: 95%.")
    ] = "",
    keep_broken: Annotated[
        bool, typer.Option("--keep-broken", help="Write OUTPUT even if it goes beyond a limit; the exit code is 1 all the same.")
    ] = False,
    map: Annotated[
        Path | None,
        typer.Option(metavar="MAP.ply", help="Write the intervention map there: what was kept, moved and added, and how far."),
    ] = None,
    report: Report = None,
    up: Up = "y",
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Clean a mesh file with a recipe.

    Beside OUTPUT, OUTPUT.provenance.json says how it came about. OUTPUT appears whole or not at all.
    """
    from ..recipe import load_recipe
    from ..running.job import Job
    from ..running.memory import parse_memory
    from ..scripts.guards import Guards
    from ..scripts.traps import traps

    if report is not None:
        check_report(report, up)
    overrides = tuple(set or ())
    found = load_recipe(recipe, upgrade=upgrade).override(overrides)
    try:
        limit = None if memory is None else parse_memory(memory)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--memory") from None
    limits = {
        "max_displacement": max_displacement,
        "max_volume_change": max_volume_change,
        "require": require,
        "keep_sharp": keep_sharp,
    }
    job = Job(
        recipe=found,
        input=input,
        output=output,
        others=tuple(others or ()),
        warnings=(*(str(change) for change in found.changes if not change.same_meaning), *traps(found.script)),
        overwrite=overwrite,
        timeout=timeout,
        memory_limit=limit,
        allow_outside=allow_outside,
        unchecked=unchecked,
        keep_all=keep_all,
        overrides=overrides,
        command=tuple(sys.argv),
        guards=Guards.parse({name: text for name, text in limits.items() if text}),
        keep_broken=keep_broken,
        map=map,
    )
    if report is None:
        carry_out(job, json=json)
        return
    from .run_report import reporting

    with reporting(job, report, up) as write:
        carry_out(job, json=json, finished=write)


def carry_out(job: Job, *, json: bool, finished: Callable[[RunResult], None] = lambda result: None) -> None:
    """Run the job with its progress on stderr, then print what came of it on stdout; `finished` is called in between."""
    from ..running.supervise import run_job
    from .progress import progress

    with progress() as show:
        result = run_job(job, show)
    for warning in result.warnings:
        warn(warning)
    finished(result)
    if json:
        print_document(_document(job, result))
    else:
        _show(result)
    if result.breaches:
        for breach in result.breaches:
            typer.echo(
                f"{typer.style('error:', fg='red')} {printable(breach['guard'])}: {printable(breach['message'])}", err=True
            )
        raise typer.Exit(1)


def _document(job: Job, result: RunResult) -> dict[str, object]:
    return {
        "recipe": job.recipe.name,
        "input": job.input,
        "output": result.output,
        "provenance": result.provenance,
        "side_files": result.side_files,
        "seconds": result.seconds,
        "peak_memory": result.peak_memory,
        "steps": result.steps,
        "before": result.before,
        "after": result.after,
        "warnings": result.warnings,
        "breaches": result.breaches,
        "maps": result.maps,
    }


def _show(result: RunResult) -> None:
    from .measures_table import measures_table
    from .tables import console

    console().print(measures_table({"before": result.before, "after": result.after}))
    typer.echo(f"\n{len(result.steps)} {'step' if len(result.steps) == 1 else 'steps'} in {result.seconds:.1f} s. Written:")
    for path in (result.output, *result.side_files, result.provenance, *result.maps):
        typer.echo(f"  {printable(_near(path))}")


def _near(path: Path) -> Path:
    """The path from the working folder, where that is shorter."""
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
