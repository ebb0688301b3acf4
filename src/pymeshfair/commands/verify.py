"""``pymeshfair verify OUTPUT``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import AllowOutside, Json, Memory, Timeout, Unchecked, memory_limit
from .streams import print_document, printable

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..running.job import Event, Job

#: exit code by verdict
EXIT_CODES = {
    "identical": 0,
    "within tolerance": 0,
    "not repeated": 1,
    "output changed": 3,
    "input changed": 4,
    "recipe changed": 5,
    "other versions": 6,
}


def verify(
    output: Annotated[Path, typer.Argument(metavar="OUTPUT", help="A mesh file that a run wrote, its provenance beside it.")],
    recorded: Annotated[
        bool,
        typer.Option(
            "--recorded", help="Use the recipe in the provenance, even if the recipe's file has changed since, or there was none."
        ),
    ] = False,
    timeout: Timeout = None,
    allow_outside: AllowOutside = False,
    unchecked: Unchecked = False,
    memory: Memory = None,
    json: Json = False,
) -> None:
    """Make a file again from its provenance, and compare.

    The recipe in the provenance is compared with the one that pymeshfair ships, or with its file. --allow-outside and --unchecked
    must be given as they were to the run.

    Exit codes: 0 the same bytes (or, for random filters without a seed, equal counts of elements and small distances), 1 other
    bytes, or the run failed, 3 the output has changed since, 4 the input has, 5 the recipe has, 6 other bytes with other
    versions.
    """
    from ..running.verify import verify_output
    from .progress import progress

    with progress() as show:
        verified = verify_output(
            output,
            recorded=recorded,
            allow_outside=allow_outside,
            unchecked=unchecked,
            timeout=timeout,
            memory_limit=memory_limit(memory),
            on_event=show,
            by_tiles=_by_tiles,
        )
    if json:
        print_document({"output": output, "verdict": verified.verdict, "findings": verified.findings, "notes": verified.notes})
    else:
        typer.echo(f"{printable(output)}: {verified.verdict}")
        for text in (*verified.findings, *verified.notes):
            typer.echo(f"  {printable(text)}")
    raise typer.Exit(EXIT_CODES[verified.verdict])


def _by_tiles(job: Job, on_event: Callable[[Event], None]) -> None:
    from ..tiles.course import run_by_tiles

    run_by_tiles(job, on_event)
