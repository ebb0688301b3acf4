"""``pymeshfair export RECIPE -o PLAIN.mlx``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .json_document import print_document
from .options import Debug, Json


def export(
    recipe: Annotated[str, typer.Argument(metavar="RECIPE", help="A shipped name or the path of an .mlx file.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="PLAIN.mlx", help="The script to write.")],
    mesh: Annotated[
        Path | None, typer.Option("--for", metavar="MESH", help="The mesh whose size makes relative lengths mesh units.")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write a recipe as a script for MeshLab's desktop and plain pymeshlab.

    Every parameter is written, in MeshLab's order, with lengths in mesh units. Filters that MeshLab lacks are refused.
    """
    from ..recipe import load_recipe
    from ..scripts.export import export_script

    script = load_recipe(recipe).script
    size = None
    if mesh is not None:
        from ..running.inspect import inspect_mesh

        measures = inspect_mesh(mesh)
        size = (measures["diagonal"], measures["mean_edge"] or measures["mean_spacing"] or 0.0)
    export_script(script, output, size=size)
    if json:
        print_document({"recipe": recipe, "output": output, "steps": len(script.steps)})
    else:
        typer.echo(f"{output}: {len(script.steps)} {'step' if len(script.steps) == 1 else 'steps'}")
