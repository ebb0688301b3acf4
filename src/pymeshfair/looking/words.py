"""Measures and comparisons in words: the rows of tables and the lines below them, for the terminal and for pages alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .comparison import Comparison, LengthIn

#: measure, its words in the table, and whether it is shown even where it is 0 or unknown
_MEASURES = (
    ("vertices", "vertices", True),
    ("faces", "faces", True),
    ("border_edges", "border edges", True),
    ("components", "components", True),
    ("area", "area", True),
    ("volume", "volume", False),
    ("mean_edge", "mean edge", True),
    ("mean_spacing", "mean spacing", False),
    ("roughness", "roughness (degrees between neighbouring faces)", True),
    ("degenerate_faces", "degenerate faces", False),
    ("folded_faces", "folded faces", False),
    ("unreferenced_vertices", "unreferenced vertices", False),
    ("non_manifold_edges", "non-manifold edges", False),
    ("non_manifold_vertices", "non-manifold vertices", False),
    ("border_loops", "border loops", False),
    ("holes", "holes", False),
    ("genus", "genus", False),
    ("triangle_quality", "triangle quality (1: equilateral)", False),
    ("self_intersecting_faces", "self-intersecting faces", False),
    ("noise", "noise along the normals", False),
    ("sharp_edge_length", "length of sharp edges", False),
)
#: above the columns of `displacement_rows`
DISPLACEMENT_HEADERS = ("", "mesh units", "mean edges", "% of diagonal")


def measure_rows(columns: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """What it is and its value for each mesh; rare measures that are 0 or unknown in all of them are left out.

    Args:
        columns: measures by name, by the header of each mesh.
    """
    surfaces = [measures for measures in columns.values() if measures.get("faces") or measures.get("edges")]
    return [
        [words, *(_shown(measures.get(name)) for measures in columns.values())]
        for name, words, always in _MEASURES
        # The points of a cloud wait for no face.
        if always or any(measures.get(name) for measures in (surfaces if name == "unreferenced_vertices" else columns.values()))
    ]


def change_lines(change: Mapping[str, Any]) -> list[str]:
    """What a run did to the shape, `pymeshfair.running.shape_change.ShapeChange` by name, as lines below the table."""
    shares = [*zip(("x", "y", "z"), change["sides"], strict=True), ("area", change["area"]), ("volume", change["volume"])]
    why = "" if change["moved"] else ", as vertices or faces were added or removed"
    lines = [f"changed{why}: " + ", ".join(f"{name} {share:+.2%}" for name, share in shares if share is not None)]
    if aside := change.get("sides_without_noise"):
        shown = ", ".join(f"{name} {share:+.2%}" for name, share in zip("xyz", aside, strict=True) if share is not None)
        lines.append(f"noise at the ends aside: {shown}")
    moved = change["moved"]
    if moved and not moved["largest"]:
        lines.append("moved: no vertex")
    elif moved:
        x, y, z = moved["place"]
        edges = f" ({moved['edges']:.2g} mean edges)" if moved["edges"] is not None else ""
        lines.append(
            f"moved: mean {moved['mean']:.3g}, 99 % below {moved['most']:.3g}, at most {moved['largest']:.3g}{edges}, vertex "
            f"{moved['vertex']} at {x:.6g}, {y:.6g}, {z:.6g}"
        )
    if change["turned"]:
        lines.append(f"turned over: {change['turned']:,} {'face' if change['turned'] == 1 else 'faces'}")
    return lines


def displacement_rows(found: Comparison) -> list[list[str]]:
    """How far what lies from what, in three units; see `DISPLACEMENT_HEADERS`."""
    moved = found.displacement
    how = "vertex by vertex" if moved.by_vertex else "to the nearest place"
    x, y, z = moved.place
    return [
        _length(f"displacement, mean ({how})", moved.mean),
        _length("displacement, root mean square", moved.rms),
        _length("displacement that 95 % keep below", moved.most),
        _length(f"largest displacement, vertex {moved.vertex} at {x:.6g}, {y:.6g}, {z:.6g}", moved.largest),
        _length("farthest vertex of AFTER from BEFORE", found.after_from_before),
        _length("farthest vertex of BEFORE from AFTER", found.before_from_after),
        _length("Hausdorff distance", found.hausdorff),
    ]


def comparison_lines(found: Comparison) -> list[str]:
    """What else changed, one line each."""
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


def _length(words: str, length: LengthIn) -> list[str]:
    values = (length.mesh_units, length.mean_edges, length.percent_of_diagonal)
    return [words, *("-" if value is None else f"{value:.4g}" for value in values)]


def _shown(value: float | str | None) -> str:
    if value is None or isinstance(value, str):  # a text stands for a number beyond the largest
        return value or "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:,.6g}"
