"""``pymeshfair run RECIPE INPUT -o OUTPUT``; ``demo``, a run on pymeshlab's sample scan; and ``verify``, which repeats a run."""

from __future__ import annotations

import contextlib
import importlib.util
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Argument, Option

from ..looking.words import change_lines
from ..places import counted
from . import options
from .streams import Verbosity, complain, print_document, print_lines, say, show, verbosity, warn

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..files.writing import StagedFile
    from ..running.job import Event, Job, RunResult


#: the recipe and the scan of the demo
_RECIPE, _SCAN = "clean_range_map", Path("tests/sample_meshes/rangemaps/face000.ply")

EXIT_CODES = {
    "identical": 0,
    "within tolerance": 0,
    "not repeated": 1,
    "output changed": 3,
    "input changed": 4,
    "recipe changed": 5,
    "other versions": 6,
}


@options.with_run_options
def run(
    recipe: options.Recipe,
    input: Annotated[Path, Argument(metavar="INPUT", help="The mesh file to clean.")],
    output: Annotated[Path, Option("--output", "-o", help="The mesh file to write; its extension is the format.")],
    chosen: options.RunOptions,
    overwrite: Annotated[bool, Option("--overwrite", help="Replace OUTPUT (even if it is INPUT), map and report.")] = False,
    map: Annotated[Path | None, Option(metavar="MAP.ply", help="Write a map of kept, moved and added surface.")] = None,
    map_tolerance: Annotated[str | None, Option(metavar="LENGTH", help="In the map, smaller moves count as kept.")] = None,
    tiles: Annotated[bool, Option("--tiles", help="Work in tiles, for scans larger than the memory; see docs/scale.md.")] = False,
    resume: Annotated[bool, Option("--resume", help="With --tiles: continue a killed run.")] = False,
    report: options.Report = None,
    up: options.Up = None,
    json: options.Json = False,
) -> None:
    """Clean a mesh file with a recipe.

    OUTPUT.provenance.json, beside OUTPUT, records how OUTPUT was made. All files, MAP.ply and OUT.html too, are written
    completely or not at all. An existing OUTPUT is replaced only if the same run wrote it (same INPUT, recipe and settings) and
    no byte of it has changed since. Otherwise the run is refused, unless --overwrite is given.
    """
    from ..running.supervise import run_job, workers_of_runs

    options.check_report(report, overwrite=overwrite, up=up)
    with workers_of_runs() as workers:
        if not tiles:
            workers.prepare()
        from ..declaration import Length

        tolerance = None if map_tolerance is None else Length.parse(map_tolerance, "--map-tolerance")
        if tolerance is not None and (map is None or tolerance.amount < 0.0):
            wrong = "it is about the map: give --map, too" if map is None else f"{map_tolerance} is below 0"
            raise typer.BadParameter(wrong, param_hint="--map-tolerance")
        job = chosen.job(recipe, input, output, report=report, overwrite=overwrite, map=map, map_tolerance=tolerance)
        scheduler = chosen.chosen_scheduler()
        if not tiles and (scheduler is not None or resume):
            raise typer.BadParameter("--resume and the options of a scheduler need --tiles")
        if tiles:
            if report is not None:
                raise typer.BadParameter("--tiles makes no report, because a report shows the whole mesh")
            from ..tiles.course import run_by_tiles

            carry_out(job, lambda show: run_by_tiles(job, show, scheduler=scheduler, resume=resume), json=json)
        else:
            page = None if report is None else partial(_staged_report, job, report, up or "y")
            carry_out(job, lambda show: run_job(job, show, workers=workers, also=page), json=json, report=report)


def _staged_report(job: Job, path: Path, up: str, result: RunResult) -> list[StagedFile]:
    from json import loads

    from ..files.writing import stage_file
    from ..report.comparison_page import run_page
    from ..running.read import read_mesh

    before = read_mesh(job.input, self_intersections=None, allow_outside=job.allow_outside, unchecked=job.unchecked)
    after = read_mesh(result.output, self_intersections=None)
    page = run_page(loads(result.provenance.read_text("utf-8", "surrogateescape")), before, after, up=up)
    options.check_report(path, overwrite=job.overwrite)
    return [stage_file(result.output.with_name("report.html"), path.absolute(), page)]


def carry_out(job: Job, carry: Callable[[Callable[[Event], None]], RunResult], *, json: bool, report: Path | None = None) -> None:
    """Run the job by `carry` with its progress on stderr, then print its result on stdout."""
    from ..errors import GuardBroken
    from .display import progress

    with progress() as show:
        try:
            result = carry(show)
        except GuardBroken as error:
            where = "" if error.maps else "; --map OUT.ply shows where"
            error.args = (f"{error}{where}; --keep-broken writes it all the same",)
            raise
    warn(*result.warnings)
    if report is not None:
        say(f"Report: {report}", err=True)
    if json:
        unmeasured = {name: None for name in ("before", "after", "change") if not getattr(result, name)}
        print_document({"recipe": job.recipe.name, "input": job.input, **vars(result), **unmeasured})
    elif verbosity() > Verbosity.QUIET:
        _show(result)
    for breach in result.breaches:
        complain(f"{breach['guard']}: {breach['message']}")
    if result.breaches:
        raise typer.Exit(1)


def _show(result: RunResult) -> None:
    from .display import show_measures

    if result.before:
        show_measures({"before": result.before, "after": result.after}, result.unit)
        print_lines((*change_lines(result.change, result.unit), ""))
    typer.echo(f"{counted(len(result.steps), 'step')} in {result.seconds:.1f} s. Written:")
    for path in (result.output, *result.side_files, result.provenance, *result.maps):
        shown = path
        with contextlib.suppress(OSError, ValueError):  # if the file is outside the working folder, or the folder is gone
            shown = path.relative_to(Path.cwd())
        print_lines([f"  {shown}"])


def demo(
    folder: Annotated[Path, typer.Option("--output", "-o", metavar="FOLDER", help="Where to write.")] = Path("pymeshfair_demo"),
    json: options.Json = False,
) -> None:
    """Clean a real range map, and show what to try next.

    The range map, a sample in the pymeshlab wheel, shows a man's face in 85,849 vertices, from a laser scanner. The scan is
    copied to face.ply in FOLDER. The result is face_clean.ply; face_clean.ply of an earlier demo is replaced.
    """
    from shlex import quote

    from ..running.supervise import run_job, workers_of_runs

    with workers_of_runs() as workers:
        workers.prepare()
        from ..files.errors import OutputError
        from ..files.writing import write_file
        from ..recipe import load_recipe
        from ..running.job import Job

        scan = sample_scan()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(folder, error.strerror or str(error)) from error
        if not (folder / "face.ply").is_file():
            write_file(folder / "face.ply", scan.read_bytes(), overwrite=False)
        elif (folder / "face.ply").read_bytes() != scan.read_bytes():
            raise OutputError(folder / "face.ply", "another file has this name; name another folder with --output")
        say(f"cleaning {scan} with the recipe {_RECIPE}", err=True)
        job = Job(load_recipe(_RECIPE), scan, folder / "face_clean.ply", command=tuple(sys.argv))
        carry_out(job, lambda show: run_job(job, show, workers=workers), json=json)
    copy, again, page = (quote(str(folder / name)) for name in ("face.ply", "again.ply", "again.html"))
    say(
        f"\nTry next:\n  pymeshfair info {_RECIPE}\n"
        f"  pymeshfair run {_RECIPE} {copy} -o {again} --report {page}\n"
        f"  pymeshfair list recipes",
        err=True,
    )


def sample_scan() -> Path:
    """The path of the sample range map in pymeshlab's folder, found without importing pymeshlab."""
    from ..files.errors import InputError

    spec = importlib.util.find_spec("pymeshlab")
    scan = Path(spec.origin).parent / _SCAN if spec and spec.origin else _SCAN
    if not scan.is_file():
        words = "this pymeshlab came without its samples; the wheels of pymeshlab 2025.7 and later on PyPI have them"
        raise InputError(scan, words)
    return scan


def verify(
    output: Annotated[Path, Argument(metavar="OUTPUT", help="A mesh file that a run wrote, with its provenance beside it.")],
    recorded: Annotated[bool, Option("--recorded", help="Use the recipe in the provenance, not the recipe's file.")] = False,
    timeout: options.Timeout = None,
    allow_outside: options.AllowOutside = False,
    unchecked: options.Unchecked = False,
    memory: options.Memory = None,
    json: options.Json = False,
) -> None:
    """Repeat the run that made a file, from its provenance, and compare the results.

    The recipe in the provenance is compared with the recipe that pymeshfair ships, or with the recipe's file. --allow-outside and
    --unchecked must be given again if the run had them.

    Exit codes: 0: the same bytes (of random filters without a seed: equal counts of elements, and small distances);
    1: other bytes, or the run failed; 3: the output has changed; 4: the input has changed; 5: the recipe has changed; 6: other
    bytes, and versions of software or the system have changed, too.
    """
    from ..running.verify import verify_output
    from ..tiles.course import run_by_tiles
    from .display import progress

    with progress() as on_event:
        verified = verify_output(
            output,
            recorded=recorded,
            allow_outside=allow_outside,
            unchecked=unchecked,
            timeout=timeout,
            memory_limit=options.memory_limit(memory),
            on_event=on_event,
            by_tiles=run_by_tiles,
        )
    document = {"output": output, "verdict": verified.verdict, "findings": verified.findings, "notes": verified.notes}
    show(document, [f"{output}: {verified.verdict}", *(f"  {t}" for t in (*verified.findings, *verified.notes))], json=json)
    raise typer.Exit(EXIT_CODES[verified.verdict])
