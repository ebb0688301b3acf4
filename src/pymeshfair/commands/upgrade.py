"""``pymeshfair upgrade OLD.mlx -o NEW.mlx``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import Json, Overwrite
from .streams import STANDARD, check_text, counted, print_document, read_script_bytes, save_text, say

if TYPE_CHECKING:
    from ..scripts import Upgrade


def upgrade(
    script: Annotated[Path, typer.Argument(metavar="OLD.mlx", help="A script of any MeshLab since 2010; - is standard input.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="NEW.mlx", help="The script to write; - is standard output.")],
    accept: Annotated[bool, typer.Option("--accept", help="Write it even if its meaning changes.")] = False,
    mend: Annotated[bool, typer.Option("--mend", help="Set values that lack a type, which MeshLab drops.")] = False,
    relative_to: Annotated[
        Path | None,
        typer.Option("--relative-to", metavar="MESH", help="Lengths were meant for that mesh; make them relative to its size."),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Bring a script of an older MeshLab up to date.

    Every change is listed, and whether the script still means the same. Nothing is written if a meaning changes, unless accepted.
    """
    from ..files.errors import InputError
    from ..scripts import format_script
    from ..scripts.upgrade import relative_script, upgrade_script
    from ..scripts.write import NOMINAL_DIAGONAL

    check_text(output, ("mlx",), overwrite=overwrite, json=json)
    name = "<stdin>" if script == STANDARD else str(script)
    upgraded = upgrade_script(read_script_bytes(script), name, path=None if script == STANDARD else script, mend=mend)
    result, diagonal = upgraded.script, NOMINAL_DIAGONAL
    if relative_to is not None:
        from ..running.read import read_mesh

        diagonal = read_mesh(relative_to).measured.diagonal
        if not diagonal > 0:
            raise InputError(relative_to, "its points are all in one place, so that no length can be relative to its size")
        result = relative_script(result, diagonal=diagonal)
    written = accept or not upgraded.warnings
    if written:
        save_text(format_script(result, known_mesh=False, diagonal=diagonal), output, overwrite=overwrite)
    if json:
        print_document(_document(script, output if written else None, upgraded))
    else:
        say(*upgraded.changes, err=output == STANDARD)
        if written:
            changes = counted(len(upgraded.changes), "change") if upgraded.changes else "no changes"
            say(f"{output}: {changes}", err=output == STANDARD)
        else:
            typer.echo(_refusal(upgraded), err=True)
    if not written:
        raise typer.Exit(2)


def _document(script: Path, output: Path | None, upgraded: Upgrade) -> dict[str, object]:
    changes = [{**vars(change), "same_meaning": change.same_meaning} for change in upgraded.changes]
    document: dict[str, object] = {"script": script, "output": output, "changes": changes}
    if output is None:
        document["error"] = {"kind": "MeaningChanges", "message": _refusal(upgraded), "changes": list(upgraded.warnings)}
    return document


def _refusal(upgraded: Upgrade) -> str:
    count, total = len(upgraded.warnings), len(upgraded.changes)
    return f"nothing is written: {count} of {total} changes alter the meaning; --accept writes the script all the same"
