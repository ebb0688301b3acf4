"""``pymeshfair compare BEFORE AFTER``: the distance and the differences of two meshes, as text, document, table or report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument, Option

from ..looking.words import area_table, comparison_lines, distance_table, verdict_text
from ..places import point_text
from . import options
from .streams import STANDARD, check_text, plain, print_document, print_lines, save_text, say, warn

if TYPE_CHECKING:
    from ..looking.comparison import Comparison
    from ..running.read import ReadMesh


def compare(
    before: Annotated[Path, Argument(metavar="BEFORE", help="The first mesh file, the reference.")],
    after: Annotated[Path, Argument(metavar="AFTER", help="The mesh file to compare with BEFORE.")],
    self_intersections: Annotated[
        bool | None, Option(help="Search for faces that cut others; by default in meshes of up to 200,000 vertices.")
    ] = None,
    tolerance: options.Tolerance = None,
    limits: options.Limits = None,
    unit: options.Unit = None,
    align: Annotated[bool, Option("--align", help="First turn and move AFTER onto BEFORE.")] = False,
    deviations: Annotated[
        Path | None,
        Option(metavar="OUT.csv|OUT.ply", help="Write how far outwards from BEFORE each vertex of AFTER is; - prints the table."),
    ] = None,
    section: Annotated[
        list[str] | None, Option(metavar="AXIS=VALUE", help="A section for the report: z=12.5. Repeatable.")
    ] = None,
    report: options.Report = None,
    up: options.Up = None,
    allow_outside: options.AllowOutside = False,
    unchecked: options.Unchecked = False,
    overwrite: options.Overwrite = False,
    json: options.Json = False,
) -> None:
    """Compare two meshes or clouds: their distance, added and removed area, and kept and lost attributes.

    The meshes may have different vertices and faces. With --tolerance the exit code is 1 if a distance exceeds the tolerance.
    """
    from ..declaration.parameters import doubts_of_typed_unit
    from ..files.errors import OutputError
    from ..files.formats import extension
    from ..files.outputs import same_file
    from ..files.writing import write_file
    from ..filters.mesh import bounding_box
    from ..looking.comparison import FORMATS, deviations_file, state_of
    from ..looking.comparison import compare as compare_states
    from ..running.read import read_mesh

    options.check_report(report, overwrite=overwrite, section=section, limits=limits, up=up)
    planes = []
    if section:
        from ..report.page import Plane, section_chart  # imported here, as it loads Pillow

        planes = [Plane.parse(text) for text in section]
    if deviations is not None:
        check_text(deviations, FORMATS, overwrite=overwrite, json=json)
        if same_file(deviations, before) or same_file(deviations, after):
            raise OutputError(deviations, "it is BEFORE or AFTER; name another file for the deviations")
    reading: dict[str, Any] = {"self_intersections": self_intersections, "allow_outside": allow_outside, "unchecked": unchecked}
    meshes = [read_mesh(path, **reading) for path in (before, after)]
    meshes[1], alignment = _aligned(*meshes) if align else (meshes[1], None)
    units = [mesh.mesh.unit for mesh in meshes]
    warnings = [*dict.fromkeys(w for mesh in meshes for w in mesh.warnings), *doubts_of_typed_unit(unit, units[0])]
    unit, assumed = options.assumed_unit(unit, dict(zip(("BEFORE", "AFTER"), units, strict=True)))
    warnings += assumed
    if unit and units[1] not in (None, unit):
        warnings.append(f"BEFORE is in {unit} and AFTER in {units[1]}: coordinates are compared as the files have them")
    for read in meshes:
        if len(read.mesh.edges) and not len(read.mesh.faces):
            what = "it has edges and no faces: its vertices are compared, not its edges, so equal curves may have a distance"
            warnings.append(f"{read.path.name}: {what}")
    charts = [(plane, section_chart([read.mesh for read in meshes], plane, unit)) for plane in planes]
    for plane in [plane for plane, chart in charts if chart is None]:
        along = [corner[plane.axis] for read in meshes for corner in bounding_box(read.mesh.vertices)]
        reach = f"{point_text([min(along)])} to {point_text([max(along)])} along {'xyz'[plane.axis]}"
        warnings.append(f"the report has no section {plane}, which cuts no face: BEFORE and AFTER reach from {reach}")
    warn(*warnings)
    first, second = (state_of(mesh) for mesh in meshes)
    allowed, ends = options.lengths_in_mesh_units(tolerance, limits, unit, first.diagonal, first.mean_edge)
    compared = compare_states(first, second, tolerance=allowed)
    comparison = compared.comparison
    files = {"before": before, "after": after}
    numbers = {"files": files, "unit": unit, "alignment": alignment, "comparison": comparison, "warnings": warnings}
    if deviations is not None:
        content = deviations_file(second.mesh, compared.after_distance.at_vertices, extension(deviations) or "csv")
        if deviations == STANDARD:
            save_text(content.decode("utf-8"), deviations, overwrite=overwrite)
        else:
            write_file(deviations, content, overwrite=overwrite)
    if report is not None:
        from ..report.comparison_page import comparison_page

        page = comparison_page(
            compared,
            title=f"{before.name} and {after.name}",
            subtitle="Comparison of two meshes.",
            numbers=plain({**numbers, "files": {key: path.name for key, path in files.items()}}),
            up=up or "y",
            warnings=warnings,
            limits=ends,
            sections=[chart for _, chart in charts if chart is not None],
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
    from dataclasses import replace

    from ..errors import MeshError
    from ..filters.inspection import Surface, align
    from ..filters.mesh import bounding_box
    from ..looking.comparison import check_size
    from ..mesh_data import moved

    for read in (before, after):
        check_size(read)
    if not before.measures["area"]:
        raise MeshError(f"{before.path.name} has no faces with an area, which --align needs")
    (low, high), (least, most) = (bounding_box(read.mesh.vertices) for read in (before, after))
    if (most < low).any() or (least > high).any():
        raise MeshError(
            f"the boxes of {before.path.name} and {after.path.name} do not overlap, so that --align cannot begin: bring them "
            "near each other first, by a tool with a view (in MeshLab: Align), and make sure that both are in one unit"
        )
    alignment = align(after.mesh.vertices, after.mesh.faces, Surface.of(before.mesh.vertices, before.mesh.faces))
    warnings = after.warnings
    if not alignment.converged:
        warnings = (*warnings, f"the alignment did not converge in {alignment.iterations} iterations: check that it is right")
    # The other 20 % of AFTER are farther away than the residual. `compare` counts area beyond a mean edge from BEFORE as added.
    if 0.0 < (edge := before.measures["mean_edge"]) < alignment.residual:
        what = f"the nearest 80 % of AFTER stay {alignment.residual / edge:.3g} mean edges from BEFORE (root mean square)"
        warnings = (*warnings, f"{what}: --align may have ended at a wrong place, as it needs 80 % of AFTER to lie on BEFORE")
    numbers = {name: value for name, value in vars(alignment).items() if name != "vertices"}
    return replace(after, mesh=moved(after.mesh, alignment.vertices), warnings=warnings), numbers


def _show(comparison: Comparison, alignment: dict[str, Any] | None, unit: str | None) -> None:
    from .display import show_measures, show_table

    show_measures({"before": comparison.before, "after": comparison.after}, unit)
    typer.echo("")
    show_table(*distance_table(comparison, unit), numbers=(1, 2, 3))
    typer.echo("")
    if comparison.out_of_tolerance:
        show_table(*area_table(comparison, unit), numbers=(2, 3, 4))
        typer.echo("")
    print_lines((*comparison_lines(comparison, unit), verdict_text(comparison, unit)))
    if alignment is not None:
        suffix = f" {unit}" if unit else ""
        typer.echo(
            f"Aligned first: turned by {alignment['degrees']:.4g} degrees, moved by {alignment['shift']:.4g}{suffix}; "
            f"the nearest 80 % of AFTER are then {alignment['residual']:.4g}{suffix} from BEFORE (root mean square)"
        )
