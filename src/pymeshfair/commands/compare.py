"""``pymeshfair compare BEFORE AFTER``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .json_document import print_document
from .options import Debug, Json
from .streams import warn

if TYPE_CHECKING:
    from ..looking.comparison import Comparison, LengthIn


def compare(
    before: Annotated[Path, typer.Argument(metavar="BEFORE", help="The mesh file that comparison starts from.")],
    after: Annotated[Path, typer.Argument(metavar="AFTER", help="The mesh file that is compared with it.")],
    self_intersections: Annotated[
        bool, typer.Option("--self-intersections/--no-self-intersections", help="Whether to look for faces that cut others.")
    ] = True,
    timeout: Annotated[float | None, typer.Option(metavar="SECONDS", help="Stop after that time a mesh.", min=0.001)] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Tell what lies between two meshes or clouds: what moved and how far, what was kept, lost, added and removed.

    They may have different vertices and faces.
    """
    from ..looking.comparison import compare as compare_states
    from ..looking.mesh_state import state_of
    from ..running.read import read_mesh

    meshes = [read_mesh(path, self_intersections=self_intersections, timeout=timeout) for path in (before, after)]
    warnings = list(dict.fromkeys(w for mesh in meshes for w in mesh.warnings))
    for warning in warnings:
        warn(warning)
    found, _ = compare_states(*(state_of(mesh) for mesh in meshes))
    if json:
        print_document({"files": {"before": before, "after": after}, "comparison": found, "warnings": warnings})
    else:
        _show(found)


def _show(found: Comparison) -> None:
    from .measures_table import measures_table
    from .tables import console, table

    console().print(measures_table({"before": found.before, "after": found.after}))
    moved = found.displacement
    how = "vertex by vertex" if moved.by_vertex else "to the nearest place"
    x, y, z = moved.place
    rows = [
        _length(f"displacement, mean ({how})", moved.mean),
        _length("displacement, root mean square", moved.rms),
        _length("displacement that 95 % keep below", moved.most),
        _length(f"largest displacement, vertex {moved.vertex} at {x:.6g}, {y:.6g}, {z:.6g}", moved.largest),
        _length("farthest vertex of AFTER from BEFORE", found.after_from_before),
        _length("farthest vertex of BEFORE from AFTER", found.before_from_after),
        _length("Hausdorff distance", found.hausdorff),
    ]
    typer.echo("")
    console().print(table(["", "mesh units", "mean edges", "% of diagonal"], rows, numbers=(1, 2, 3)))
    typer.echo("")
    for line in _lines(found):
        typer.echo(line)


def _length(words: str, length: LengthIn) -> list[str]:
    values = (length.mesh_units, length.mean_edges, length.percent_of_diagonal)
    return [words, *("-" if value is None else f"{value:.4g}" for value in values)]


def _lines(found: Comparison) -> list[str]:
    lines = []
    for words, value in (("area", found.area_change), ("volume", found.volume_change)):
        if value is not None:
            lines.append(f"{words}: {value:+.4g} %")
    if found.normal_deviation is not None:
        lines.append(
            f"normals: {found.normal_deviation:.3g} degrees apart on average, {found.largest_normal_deviation:.3g} at most; "
            f"{found.flipped_faces:,} faces flipped"
        )
    if found.sharp_edges_kept is not None:
        lines.append(
            f"sharp edges (from {found.sharp_angle:g} degrees): {100 * found.sharp_edges_kept:.1f} % of their length kept"
        )
    if found.added_area is not None:
        lines.append(f"more than a mean edge away: {found.added_area:.6g} of area added, {found.removed_area:.6g} removed")
    for words, names in (("kept", found.attributes_kept), ("lost", found.attributes_lost), ("gained", found.attributes_gained)):
        if names:
            lines.append(f"{words}: {', '.join(names)}")
    return lines
