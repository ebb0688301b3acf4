"""The measures of one or more meshes side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from .tables import table

#: measure, its words in the table, and whether it is shown even where it is 0 or unknown
_ROWS = (
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


def measures_table(columns: Mapping[str, Mapping[str, Any]]) -> Table:
    """One column for each mesh, by its header; rare measures that are 0 or unknown in all of them are left out."""
    rows = [
        [words, *(_shown(measures.get(name)) for measures in columns.values())]
        for name, words, always in _ROWS
        if always or any(measures.get(name) for measures in columns.values())
    ]
    return table(["", *columns], rows, numbers=range(1, len(columns) + 1))


def _shown(value: float | str | None) -> str:
    if value is None or isinstance(value, str):  # a text stands for a number beyond the largest
        return value or "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:,.6g}"
