"""The command ``pymeshfair``: one module a command, each importing what is heavy only when it runs, so that help is instant.

Exit codes: 0 done, 1 the run failed, 2 wrong usage or an invalid recipe, 130 interrupted; `verify` has more.
"""

from __future__ import annotations

import os
from typing import Annotated

import typer

from ..processes.environment import ONE_BLAS_THREAD
from . import batch, check, compare, demo, doctor, export, info, list, picture, run, spectrum, suggest, tune, upgrade, verify
from .failure import check_working_folder
from .group import CommandGroup

app = typer.Typer(
    name="pymeshfair",
    cls=CommandGroup,
    invoke_without_command=True,
    rich_markup_mode=None,  # plain help: rich's would double the time until the first letter
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
app.command()(demo.demo)
app.command()(run.run)
app.command()(batch.batch)
app.command()(verify.verify)
app.command()(check.check)
app.command()(upgrade.upgrade)
app.command()(export.export)
app.add_typer(list.app, name="list")
app.command()(info.info)
app.command()(suggest.suggest)
app.command()(spectrum.spectrum)
app.command()(compare.compare)
app.command()(picture.picture)
app.command()(tune.tune)
app.command()(doctor.doctor)


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
