"""``pymeshfair export RECIPE -o PLAIN.mlx``."""

from pathlib import Path
from typing import Annotated

import typer

from .options import Json, Overwrite, Recipe
from .streams import STANDARD, check_text, counted, open_recipe, print_document, save_text, say


def export(
    recipe: Recipe,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="PLAIN.mlx", help="The script to write; - is standard output.")
    ],
    mesh: Annotated[
        Path | None, typer.Option("--for", metavar="MESH", help="The mesh whose size makes relative lengths mesh units.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a recipe as a script for MeshLab's desktop and plain pymeshlab.

    Every parameter is written, in MeshLab's order, with lengths in mesh units. A filter that MeshLab lacks is replaced by one
    that does the same, or refused.
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
