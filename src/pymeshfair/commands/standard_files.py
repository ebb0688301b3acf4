"""``-`` in the place of a file: standard input for a script, standard output for a script or a table."""

from __future__ import annotations

import io
import sys
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from ..recipe import Recipe

STANDARD = Path("-")


def open_recipe(name: str, *, upgrade: bool = False) -> Recipe:
    """A shipped recipe, the script in a file, or that on standard input; see `pymeshfair.recipe.load_recipe`."""
    from ..recipe import load_recipe, parse_recipe

    if name != str(STANDARD):
        return load_recipe(name, upgrade=upgrade)
    return parse_recipe(read_script_bytes(STANDARD), "<stdin>", upgrade=upgrade)


def read_script_bytes(path: Path) -> bytes:
    """The bytes of a script's file or of standard input, at most one more than a script may have."""
    from ..scripts.read import MOST_BYTES, read_bytes

    return sys.stdin.buffer.read(MOST_BYTES + 1) if path == STANDARD else read_bytes(path)


def check_text(output: Path, kinds: Collection[str], *, overwrite: bool, json: bool) -> None:
    """Refuse an output that could not be written, before anything is done."""
    from ..files.writing import check_target

    if output != STANDARD:
        check_target(output, kinds, overwrite=overwrite)
    elif json:
        raise typer.BadParameter("the document of --json and another one cannot both go to standard output", param_hint="-")


def save_text(text: str, output: Path, *, overwrite: bool) -> None:
    """Write the file, or print its text."""
    from ..files.writing import write_file

    if output == STANDARD:
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(encoding="utf-8")  # as the file would be
        sys.stdout.write(text)
    else:
        write_file(output, text.encode("utf-8"), overwrite=overwrite)
