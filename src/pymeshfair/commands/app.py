"""The command ``pymeshfair``. Its commands import large libraries only when they run, so that help is instant.

Exit codes and JSON documents: docs/command_line.md.
"""

import os
import sys
from typing import Annotated

import typer

from ..processes.environment import ONE_BLAS_THREAD
from . import batch, compare, doctor, info, picture, run, scripts, spectrum, suggest, tune
from .group import Command, CommandGroup

app = typer.Typer(
    name="pymeshfair",
    cls=CommandGroup,
    invoke_without_command=True,
    rich_markup_mode=None,  # plain help, as rich takes twice as long to show it
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
command = app.command(cls=Command)  # a command has the name of its function
for function in (run.demo, run.run, batch.batch, run.verify, scripts.check, scripts.upgrade, scripts.export):
    command(function)
app.add_typer(info.listing, name="list")
for other in (info.info, suggest.suggest, spectrum.spectrum, compare.compare, picture.picture, tune.tune, doctor.doctor):
    command(other)


@app.callback()
def pymeshfair(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", "-V", help="Show the version.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Reproducible clean-up of 3D scans, with MeshLab's filters and others that MeshLab lacks.

    Try `pymeshfair demo`, then `pymeshfair list recipes` and `pymeshfair run RECIPE INPUT -o OUTPUT`.
    """
    try:
        os.getcwd()  # noqa: PTH109 - pathlib would load more
    except OSError:
        from ..errors import RunError

        raise RunError("the working folder does not exist any more; change to another one, and give the command again") from None
    if version:
        import importlib.metadata

        typer.echo(f"pymeshfair {importlib.metadata.version('pymeshfair')}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help(), err=True)
        raise typer.Exit(2)


def main() -> None:
    """The entry point of the console script."""
    if os.name == "posix" and sys.getfilesystemencoding() != "utf-8" and os.environ.get("PYTHONUTF8") != "1":
        # MeshLab and the records need file names in UTF-8 in every locale. The output keeps the encoding of the locale.
        changes = {"PYTHONUTF8": "1", "PYTHONIOENCODING": getattr(sys.stdout or sys.stderr, "encoding", "utf-8")}
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], {**os.environ, **changes})
    os.environ.update(ONE_BLAS_THREAD)  # only a process with a single thread can make workers as copies of itself
    app()
