"""The option ``-o`` of the commands that write a script: an .mlx file, or ``-`` for standard output."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import typer

STDOUT = Path("-")


def check_script(output: Path, *, overwrite: bool, json: bool) -> None:
    """Refuse a script that could not be written, before anything is done."""
    from ..files.writing import check_target

    if output != STDOUT:
        check_target(output, ("mlx",), overwrite=overwrite)
    elif json:
        raise typer.BadParameter("the script and the document of --json cannot both go to standard output", param_hint="-o")


def save_script(text: str, output: Path, *, overwrite: bool) -> None:
    """Write the script."""
    from ..files.writing import write_file

    if output == STDOUT:
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(encoding="utf-8")  # as the file would be
        sys.stdout.write(text)
    else:
        write_file(output, text.encode("utf-8"), overwrite=overwrite)
