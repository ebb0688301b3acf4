"""``pymeshfair doctor``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import Json
from .streams import print_document, say, warn

if TYPE_CHECKING:
    from .findings import Finding


def doctor(
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="A folder of outputs: name the files that killed runs left there.")
    ] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Remove these files.")] = False,
    warm: Annotated[
        bool, typer.Option("--warm", help="First compile all filters for this machine, such as in the image of a container.")
    ] = False,
    json: Json = False,
) -> None:
    """Look for what keeps pymeshfair from working here."""
    from .findings import look_around, look_at_left_files

    if warm:
        _compile_all()

    if remove and folder is None:
        raise typer.BadParameter("it needs the FOLDER of the files", param_hint="--remove")
    findings = []
    for finding in (*look_around(), *(look_at_left_files(folder, remove=remove) if folder else ())):
        findings.append(finding)
        if not json:
            _show(finding)
    wrong = [f.name for f in findings if not f.ok]
    message = f"something is wrong with {', '.join(wrong)}" if wrong else "all is well"
    if json:
        print_document({"findings": findings} | ({"error": {"kind": "Unwell", "message": message}} if wrong else {}))
    say(message, err=True)
    if wrong:
        raise typer.Exit(1)


def _compile_all() -> None:
    """Compile what no installation and no run has compiled yet."""
    from rich.progress import BarColumn, TaskProgressColumn, TimeRemainingColumn

    from ..filters.compilation import compile_ahead, listed_signatures
    from .progress import progress_bar

    with progress_bar(BarColumn(), TaskProgressColumn(), TimeRemainingColumn()) as bar:
        task = bar.add_task("compiling filters for this machine", total=1.0)
        failures = compile_ahead(listed_signatures(), progress=lambda share: bar.update(task, completed=share))
    warn(*(f"not compiled: {failure}" for failure in (*failures, *_compile_others())))


def _compile_others() -> list[str]:
    """Run the filters of other packages on a small mesh, which compiles what they use; what went wrong."""
    from ..meshset import MeshSet
    from ..registry import custom_filters

    failures = []
    for declared in custom_filters():
        if declared.origin == "pymeshfair":
            continue
        meshes = MeshSet()
        meshes.create_octahedron()
        meshes.compute_scalar_by_function_per_vertex(q="z")
        meshes.compute_color_by_function_per_vertex(x="x", y="y", z="z")
        try:
            meshes.apply_filter(declared.python_name)
        except Exception as error:  # the filter may need another mesh
            failures.append(f"{declared.python_name}, of {declared.origin}: {type(error).__name__}: {error}")
    return failures


def _show(finding: Finding) -> None:
    mark = typer.style("ok   ", fg="green") if finding.ok else typer.style("WRONG", fg="red")
    typer.echo(f"{mark}  {finding.name:<12}  {finding.detail}")
    if finding.advice:
        typer.echo(f"{'':21}{finding.advice}")
