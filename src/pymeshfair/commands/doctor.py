"""``pymeshfair doctor``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .json_document import print_document
from .options import Debug, Json
from .streams import warn

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
    debug: Debug = False,
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
    typer.echo(message, err=True)
    if wrong:
        raise typer.Exit(1)


def _compile_all() -> None:
    """Compile what no installation and no run has compiled yet."""
    from rich.console import Console
    from rich.progress import Progress

    from ..filters.compilation import compile_ahead, listed_signatures

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("compiling filters for this machine", total=1.0)
        failures = compile_ahead(listed_signatures(), progress=lambda share: bar.update(task, completed=share))
    for failure in failures:
        warn(f"not compiled: {failure}")


def _show(finding: Finding) -> None:
    mark = typer.style("ok   ", fg="green") if finding.ok else typer.style("WRONG", fg="red")
    typer.echo(f"{mark}  {finding.name:<12}  {finding.detail}")
    if finding.advice:
        typer.echo(f"{'':21}{finding.advice}")
