"""``pymeshfair compare BEFORE AFTER``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import options
from .streams import STANDARD, check_text, print_document, print_lines, save_text, say, warn

if TYPE_CHECKING:
    from ..looking.comparison import Comparison
    from ..running.read import ReadMesh

#: areas out of tolerance that the text lists
_AREAS = 20


def compare(
    before: Annotated[Path, typer.Argument(metavar="BEFORE", help="The mesh file that comparison starts from.")],
    after: Annotated[Path, typer.Argument(metavar="AFTER", help="The mesh file that is compared with it.")],
    self_intersections: Annotated[
        bool | None,
        typer.Option(
            "--self-intersections/--no-self-intersections",
            help="Whether to look for faces that cut others; by default in meshes of at most 200,000 vertices.",
        ),
    ] = None,
    tolerance: options.Tolerance = None,
    limits: options.Limits = None,
    unit: options.Unit = None,
    align: Annotated[
        bool, typer.Option("--align", help="Turn and move AFTER onto BEFORE first, for scans of one object taken twice.")
    ] = False,
    deviations: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.csv|OUT.ply",
            help="Write how far outwards each vertex of AFTER lies; in PLY it is the scalar. - prints the table.",
        ),
    ] = None,
    section: Annotated[
        list[str] | None,
        typer.Option(metavar="AXIS=VALUE", help="Show both outlines in that plane in the report: z=12.5. May be repeated."),
    ] = None,
    report: options.Report = None,
    up: options.Up = "y",
    allow_outside: options.AllowOutside = False,
    unchecked: options.Unchecked = False,
    overwrite: options.Overwrite = False,
    json: options.Json = False,
) -> None:
    """Tell what lies between two meshes or clouds: how far apart they are, what was kept, lost, added and removed.

    They may have different vertices and faces. With --tolerance the exit code is 1 if a place of one lies further from the other.
    """
    from ..declaration.units import unit_of_scan
    from ..files.formats import extension
    from ..files.writing import write_file
    from ..looking.comparison import FORMATS, deviations_file
    from ..looking.comparison import compare as compare_states
    from ..looking.mesh_state import state_of
    from ..running.read import read_mesh

    planes = []
    if section:
        from ..report.charts import Plane  # which loads a library of pictures

        planes = [Plane.parse(text) for text in section]
    if planes and report is None:
        raise typer.BadParameter("sections are shown in the report: give --report, too", param_hint="--section")
    if report is not None:
        options.check_report(report, up, overwrite=overwrite)
    if deviations is not None:
        check_text(deviations, FORMATS, overwrite=overwrite, json=json)
    meshes = [
        read_mesh(path, self_intersections=self_intersections, allow_outside=allow_outside, unchecked=unchecked)
        for path in (before, after)
    ]
    alignment = None
    if align:
        meshes[1], alignment = _aligned(*meshes)
    of_files = [mesh.mesh.unit for mesh in meshes]
    unit = unit_of_scan(unit, of_files[0])
    warnings = list(dict.fromkeys(w for mesh in meshes for w in mesh.warnings))
    if all(of_files) and of_files[0] != of_files[1]:
        warnings.append(f"BEFORE is in {of_files[0]} and AFTER in {of_files[1]}: coordinates are compared as the files have them")
    warn(*warnings)
    first, second = (state_of(mesh) for mesh in meshes)
    allowed = options.tolerance_in_mesh_units(tolerance, unit, first.diagonal, first.mean_edge)
    ends = options.limits_in_mesh_units(limits, unit, first.diagonal, first.mean_edge)
    if report is None:
        comparison, distances = compare_states(first, second, tolerance=allowed)
    else:
        from .reports import compared_files, page_numbers

        compared, left_out = compared_files(first, second, tolerance=allowed)
        comparison, distances = compared.comparison, compared.distances
    if deviations is not None:
        kind = "csv" if deviations == STANDARD else extension(deviations)
        content = deviations_file(second.mesh, distances.after.at_vertices, kind)
        if deviations == STANDARD:
            save_text(content.decode("utf-8"), deviations, overwrite=overwrite)
        else:
            write_file(deviations, content, overwrite=overwrite)
    numbers = {
        "files": {"before": before, "after": after},
        "unit": unit,
        "alignment": alignment,
        "comparison": comparison,
        "warnings": warnings,
    }
    if report is not None:
        from ..report.comparison_page import comparison_page

        page = comparison_page(
            compared,
            title=f"{before.name} and {after.name}",
            subtitle="What lies between two meshes.",
            numbers=page_numbers(numbers),
            up=up,
            warnings=warnings,
            left_out=left_out,
            limits=ends,
            planes=planes,
            unit=unit,
        )
        write_file(report, page, overwrite=overwrite)
        say(f"Report: {report}", err=True)
    if json:
        print_document(numbers)
    elif deviations != STANDARD:
        _show(comparison, alignment, unit)
    if comparison.passed is False:
        raise typer.Exit(1)


def _aligned(before: ReadMesh, after: ReadMesh) -> tuple[ReadMesh, dict[str, Any]]:
    """The second mesh, turned and moved onto the first, and what that took."""
    from dataclasses import asdict, replace

    from ..errors import MeshError
    from ..filters.inspection import Surface, align
    from ..filters.mesh import bounding_box
    from ..mesh_data import moved

    if not len(before.mesh.faces):
        raise MeshError(f"{before.path.name} has no faces onto which something could be aligned")
    (low, high), (least, most) = (bounding_box(read.mesh.vertices) for read in (before, after))
    if (most < low).any() or (least > high).any():
        raise MeshError(
            f"the boxes of {before.path.name} and {after.path.name} do not overlap, so that --align cannot begin: bring them "
            "near each other first, by a tool with a view (in MeshLab: Align), and make sure that both are in one unit"
        )
    alignment = align(after.mesh.vertices, after.mesh.faces, Surface.of(before.mesh.vertices, before.mesh.faces))
    numbers = {name: value for name, value in asdict(alignment).items() if name != "vertices"}
    warnings = after.warnings
    if not alignment.converged:
        warnings = (*warnings, f"the alignment did not settle in {alignment.iterations} iterations: look whether it is right")
    return replace(after, mesh=moved(after.mesh, alignment.vertices), warnings=warnings), numbers


def _show(comparison: Comparison, alignment: dict[str, Any] | None, unit: str | None) -> None:
    from ..looking.words import area_headers, area_rows, comparison_lines, distance_headers, distance_rows, verdict_text
    from .tables import console, measures_table, table

    console().print(measures_table({"before": comparison.before, "after": comparison.after}, unit))
    typer.echo("")
    console().print(table(distance_headers(unit), distance_rows(comparison), numbers=(1, 2, 3)))
    typer.echo("")
    if comparison.out_of_tolerance:
        console().print(table(area_headers(unit), area_rows(comparison, _AREAS), numbers=(2, 3, 4)))
        typer.echo("")
    print_lines((*comparison_lines(comparison, unit), verdict_text(comparison, unit)))
    if alignment is not None:
        spoken = f" {unit}" if unit else ""
        typer.echo(
            f"Aligned first: turned by {alignment['degrees']:.4g} degrees, moved by {alignment['shift']:.4g}{spoken}; 80 % "
            f"of AFTER then lie {alignment['residual']:.4g}{spoken} from BEFORE (root mean square)"
        )
