"""``pymeshfair check``, ``upgrade`` and ``export``: commands on scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Argument, Option

from ..places import counted
from .group import Failure
from .options import Json, Overwrite, Recipe, recipe_names
from .streams import STANDARD, check_text, open_recipe, print_document, print_lines, read_script_bytes, save_text, say


def check(
    recipes: Annotated[
        list[str], Argument(metavar="RECIPE...", help="Shipped names, .mlx files, or - for stdin.", autocompletion=recipe_names)
    ],
    mesh: Annotated[Path | None, Option("--mesh", metavar="SCAN", help="Check also whether lengths suit this mesh.")] = None,
    json: Json = False,
) -> None:
    """Check recipes and list all their problems.

    Steps that run, but probably do not do what was meant, get a warning. No mesh is opened, except SCAN.
    """
    diagonal, checked, problems = None, [], []
    if mesh is not None:
        from ..running.read import read_mesh

        diagonal = read_mesh(mesh).measured.diagonal
    for name in recipes:
        verdict, text = _verdict(name, diagonal)
        checked.append(verdict)
        problems += verdict.get("problems", [])
        if verdict["ok"] and not verdict["warnings"]:
            say(text, err=json)
        else:
            print_lines([text], err=json)
    invalid = sum(not verdict["ok"] for verdict in checked)
    if json:
        message = f"{invalid} of {counted(len(checked), 'recipe')} not valid"
        error = {"error": {"kind": "ScriptError", "message": message, "problems": problems}} if invalid else {}
        print_document({"recipes": checked, **error})
    if invalid:
        raise typer.Exit(2)


def _verdict(name: str, diagonal: float | None) -> tuple[dict[str, Any], str]:
    from ..errors import PymeshfairError
    from ..scripts.warnings import script_warnings

    try:
        script = open_recipe(name).script
    except PymeshfairError as error:
        failure = Failure.of(error)
        problems = failure.details.get("problems", [{"file": name, "message": failure.message}])
        return {"recipe": name, "ok": False, "problems": problems}, failure.message
    steps = len(script.steps)
    warnings = script_warnings(script, diagonal=diagonal)
    lines = [f"{name}: ok, {counted(steps, 'step')}", *(f"  warning: {text}" for text in warnings)]
    return {"recipe": name, "ok": True, "steps": steps, "warnings": warnings}, "\n".join(lines)


def upgrade(
    script: Annotated[Path, Argument(metavar="OLD.mlx", help="A script of any MeshLab since 2010; - is standard input.")],
    output: Annotated[Path, Option("--output", "-o", metavar="NEW.mlx", help="The script to write; - is standard output.")],
    accept: Annotated[bool, Option("--accept", help="Write the script even if its meaning changes.")] = False,
    relative_to: Annotated[Path | None, Option("--relative-to", metavar="MESH", help="Lengths in % of MESH's diagonal.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Bring a script of an older MeshLab up to date.

    List all changes, and say which of them alter the meaning. If any does, nothing is written without --accept.
    """
    from ..scripts import format_script
    from ..scripts.upgrade import relative_script, upgrade_script

    check_text(output, ("mlx",), overwrite=overwrite, json=json)
    path, name = (None, "<stdin>") if script == STANDARD else (script, str(script))
    upgraded = upgrade_script(read_script_bytes(script), name, path=path)
    if relative_to is not None:
        from ..running.read import diagonals_on_mesh

        upgraded = relative_script(upgraded, diagonals_on_mesh(upgraded.script, relative_to))
    written = accept or not upgraded.warnings
    if written:
        save_text(format_script(upgraded.script, known_mesh=False), output, overwrite=overwrite)
    altering, total = len(upgraded.warnings), len(upgraded.changes)
    refusal = f"nothing is written: {altering} of {total} changes alter the meaning; --accept writes the script anyway"
    if json:
        changes = [{**vars(change), "same_meaning": change.same_meaning} for change in upgraded.changes]
        error = {"error": {"kind": "MeaningChanges", "message": refusal, "changes": list(upgraded.warnings)}}
        document = {"script": script, "output": output if written else None, "changes": changes}
        print_document({**document, **({} if written else error)})
    else:
        say(*upgraded.changes, err=output == STANDARD)
        if written:
            say(f"{output}: {counted(total, 'change') if total else 'no changes'}", err=output == STANDARD)
        else:
            typer.echo(refusal, err=True)
    if not written:
        raise typer.Exit(2)


def export(
    recipe: Recipe,
    output: Annotated[Path, Option("--output", "-o", metavar="PLAIN.mlx", help="The script to write; - is standard output.")],
    mesh: Annotated[Path | None, Option("--for", metavar="MESH", help="The mesh for which lengths are computed.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a recipe as a script for MeshLab's desktop application and plain pymeshlab.

    Parameters are written in MeshLab's order, with lengths in mesh units. A filter that MeshLab lacks is replaced by an
    equivalent filter of MeshLab; if there is none, the recipe is refused.
    """
    from ..scripts.write import MeshFacts, export_script

    check_text(output, ("mlx",), overwrite=overwrite, json=json)
    script = open_recipe(recipe).script
    facts, lengths = None, []
    if mesh is not None:
        from ..running.read import lengths_on_mesh, read_mesh

        read = read_mesh(mesh)
        facts = MeshFacts(read.measured.diagonal, read.measured.resolution(), closed=read.measures["closed"])
        lengths = lengths_on_mesh(script, mesh)
    exported, replaced = export_script(script, mesh=facts, lengths=lengths)
    save_text(exported, output, overwrite=overwrite)
    if json:
        print_document({"recipe": recipe, "output": output, "steps": len(script.steps), "replaced": replaced})
    else:
        say(*replaced, f"{output}: {counted(len(script.steps), 'step')}", err=output == STANDARD)
