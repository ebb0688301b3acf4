"""``pymeshfair doctor``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from .json_document import print_document
from .options import Debug, Json

if TYPE_CHECKING:
    from .findings import Finding


def doctor(json: Json = False, debug: Debug = False) -> None:
    """Look for what keeps pymeshfair from working here."""
    from .findings import look_around

    findings = []
    for finding in look_around():
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


def _show(finding: Finding) -> None:
    mark = typer.style("ok   ", fg="green") if finding.ok else typer.style("WRONG", fg="red")
    typer.echo(f"{mark}  {finding.name:<12}  {finding.detail}")
    if finding.advice:
        typer.echo(f"{'':21}{finding.advice}")
