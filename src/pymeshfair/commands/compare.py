"""``pymeshfair compare BEFORE AFTER``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .json_document import print_document
from .options import AllowOutside, Debug, Json, Overwrite, Unchecked
from .report_file import Report, Up, check_report, compared_files, report_page, say_report
from .streams import warn

if TYPE_CHECKING:
    from ..looking.comparison import Comparison


def compare(
    before: Annotated[Path, typer.Argument(metavar="BEFORE", help="The mesh file that comparison starts from.")],
    after: Annotated[Path, typer.Argument(metavar="AFTER", help="The mesh file that is compared with it.")],
    self_intersections: Annotated[
        bool, typer.Option("--self-intersections/--no-self-intersections", help="Whether to look for faces that cut others.")
    ] = True,
    report: Report = None,
    up: Up = "y",
    timeout: Annotated[float | None, typer.Option(metavar="SECONDS", help="Stop after that time a mesh.", min=0.001)] = None,
    allow_outside: AllowOutside = False,
    unchecked: Unchecked = False,
    overwrite: Overwrite = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Tell what lies between two meshes or clouds: what moved and how far, what was kept, lost, added and removed.

    They may have different vertices and faces.
    """
    from ..files.writing import write_file
    from ..looking.comparison import compare as compare_states
    from ..looking.mesh_state import state_of
    from ..running.read import read_mesh

    if report is not None:
        check_report(report, up, overwrite=overwrite)
    read = partial(read_mesh, timeout=timeout, allow_outside=allow_outside, unchecked=unchecked)
    meshes = [read(path, self_intersections=self_intersections) for path in (before, after)]
    warnings = list(dict.fromkeys(w for mesh in meshes for w in mesh.warnings))
    for warning in warnings:
        warn(warning)
    first, second = (state_of(mesh) for mesh in meshes)
    if report is None:
        found, _ = compare_states(first, second)
    else:
        compared, left_out = compared_files(first, second, timeout)
        found = compared.found
    numbers = {"files": {"before": before, "after": after}, "comparison": found, "warnings": warnings}
    if report is not None:
        page = report_page(
            compared,
            title=f"{before.name} and {after.name}",
            subtitle="What lies between two meshes.",
            numbers=numbers,
            up=up,
            warnings=warnings,
            left_out=left_out,
        )
        write_file(report, page, overwrite=overwrite)
        say_report(report)
    if json:
        print_document(numbers)
    else:
        _show(found)


def _show(found: Comparison) -> None:
    from ..looking.words import DISPLACEMENT_HEADERS, comparison_lines, displacement_rows
    from .measures_table import measures_table
    from .tables import console, table

    console().print(measures_table({"before": found.before, "after": found.after}))
    typer.echo("")
    console().print(table(DISPLACEMENT_HEADERS, displacement_rows(found), numbers=(1, 2, 3)))
    typer.echo("")
    for line in comparison_lines(found):
        typer.echo(line)
