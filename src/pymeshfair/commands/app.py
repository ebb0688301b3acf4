"""The command ``pymeshfair``: one module a command, each importing what is heavy only when it runs, so that help is instant.

Exit codes and JSON documents: docs/command_line.md.
"""

import os
from typing import Annotated

import typer

from ..processes.environment import ONE_BLAS_THREAD
from . import batch, check, compare, demo, doctor, export, info, list, picture, run, spectrum, suggest, tune, upgrade, verify
from .group import Command, CommandGroup, check_working_folder

app = typer.Typer(
    name="pymeshfair",
    cls=CommandGroup,
    invoke_without_command=True,
    rich_markup_mode=None,  # plain help: rich's would double the time until the first letter
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
command = app.command(cls=Command)  # the name of each is that of its function
for function in (demo.demo, run.run, batch.batch, verify.verify, check.check, upgrade.upgrade, export.export):
    command(function)
app.add_typer(list.app, name="list")
for other in (info.info, suggest.suggest, spectrum.spectrum, compare.compare, picture.picture, tune.tune, doctor.doctor):
    command(other)


@app.callback()
def pymeshfair(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", "-V", help="Show the version.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Reproducible clean-up of 3D scans with MeshLab's filters and those that it lacks.

    Try `pymeshfair demo`, then `pymeshfair list recipes` and `pymeshfair run RECIPE INPUT -o OUTPUT`.
    """
    check_working_folder()
    if version:
        import importlib.metadata

        typer.echo(f"pymeshfair {importlib.metadata.version('pymeshfair')}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help(), err=True)
        raise typer.Exit(2)


def main() -> None:
    """The entry point of the console script."""
    os.environ.update(ONE_BLAS_THREAD)  # more threads would keep workers from being copies of this process
    app()
