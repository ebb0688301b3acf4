"""``pymeshfair check RECIPE...``."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from .failure import Failure
from .json_document import print_document
from .options import Debug, Json


def check(
    recipes: Annotated[list[str], typer.Argument(metavar="RECIPE", help="Shipped names or paths of .mlx files.")],
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Check recipes and name every problem in them.

    No mesh is opened.
    """
    checked = []
    for name in recipes:
        verdict = _verdict(name)
        checked.append(verdict)
        typer.echo(verdict.pop("said"), err=json)
    bad = [verdict for verdict in checked if "problems" in verdict]
    document: dict[str, Any] = {"recipes": checked}
    if bad:
        message = f"{len(bad)} of {len(checked)} {'recipe' if len(checked) == 1 else 'recipes'} not valid"
        document["error"] = {"kind": "ScriptError", "message": message, "problems": [p for v in bad for p in v["problems"]]}
    if json:
        print_document(document)
    if bad:
        raise typer.Exit(2)


def _verdict(name: str) -> dict[str, Any]:
    """What a check finds, in terms of JSON, with the words for people under ``"said"``."""
    from ..errors import PymeshfairError
    from ..recipe import load_recipe

    try:
        steps = len(load_recipe(name).script.steps)
    except PymeshfairError as error:
        failure = Failure.of(error)
        problems = failure.details.get("problems", [{"file": name, "message": failure.message}])
        return {"recipe": name, "ok": False, "problems": problems, "said": failure.message}
    return {"recipe": name, "ok": True, "steps": steps, "said": f"{name}: ok, {steps} {'step' if steps == 1 else 'steps'}"}
