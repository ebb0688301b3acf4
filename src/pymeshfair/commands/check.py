"""``pymeshfair check RECIPE...``."""

from pathlib import Path
from typing import Annotated, Any

import typer

from .group import Failure
from .options import Json
from .streams import Talk, counted, open_recipe, print_document, talk


def check(
    recipes: Annotated[
        list[str], typer.Argument(metavar="RECIPE", help="Shipped names, paths of .mlx files, or - for standard input.")
    ],
    mesh: Annotated[
        Path | None, typer.Option("--mesh", metavar="SCAN", help="Look whether the lengths suit that mesh as well.")
    ] = None,
    json: Json = False,
) -> None:
    """Check recipes and name every problem in them.

    What runs but hardly does what was meant is a warning. No mesh is opened, but for SCAN.
    """
    diagonal = None
    if mesh is not None:
        from ..running.read import read_mesh

        diagonal = read_mesh(mesh).measured.diagonal
    checked = []
    for name in recipes:
        verdict = _verdict(name, diagonal)
        checked.append(verdict)
        text = verdict.pop("said")
        if not verdict["ok"] or verdict["warnings"] or talk() > Talk.LITTLE:
            typer.echo(text, err=json)
    bad = [verdict for verdict in checked if "problems" in verdict]
    document: dict[str, Any] = {"recipes": checked}
    if bad:
        message = f"{len(bad)} of {counted(len(checked), 'recipe')} not valid"
        document["error"] = {"kind": "ScriptError", "message": message, "problems": [p for v in bad for p in v["problems"]]}
    if json:
        print_document(document)
    if bad:
        raise typer.Exit(2)


def _verdict(name: str, diagonal: float | None) -> dict[str, Any]:
    """The verdict on a recipe in terms of JSON; ``"said"`` is the text to print."""
    from ..errors import PymeshfairError
    from ..scripts.warnings import script_warnings

    try:
        script = open_recipe(name).script
    except PymeshfairError as error:
        failure = Failure.of(error)
        problems = failure.details.get("problems", [{"file": name, "message": failure.message}])
        return {"recipe": name, "ok": False, "problems": problems, "said": failure.message}
    steps = len(script.steps)
    warnings = script_warnings(script, diagonal=diagonal)
    lines = [f"{name}: ok, {counted(steps, 'step')}", *(f"  warning: {text}" for text in warnings)]
    return {"recipe": name, "ok": True, "steps": steps, "warnings": warnings, "said": "\n".join(lines)}
