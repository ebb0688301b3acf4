"""Meshes that were read from a text, written as binary files: MeshLab reads these several times as fast, and alike.

Only what both of its readers understand alike is handed over so: triangles without a vertex twice between finite points.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .ply import PlyHeader
from .ply_given import given_header
from .ply_rows import KINDS, AllRows, Rows


def are_plain_triangles(points: NDArray[np.float64], faces: NDArray[np.int64]) -> bool:
    """Whether MeshLab keeps all of (n, 3) points and (m, 3) indices of them."""
    a, b, c = faces.T
    return bool(len(faces) and np.isfinite(points).all() and ((a != b) & (b != c) & (c != a)).all())


def mesh_as_ply(points: NDArray[np.float64], faces: NDArray[np.int64], colours: NDArray[np.uint8] | None = None) -> list[bytes]:
    """A mesh as the parts of a binary PLY file.

    Args:
        points: (n, 3).
        faces: (m, 3) indices of them.
        colours: (n, 3) of the vertices, from 0 to 255, or None.
    """
    kinds: list[Any] = [("points", "<f8", 3)] + ([] if colours is None else [("colours", "u1", 3)])
    vertices = np.empty(len(points), dtype=kinds)
    vertices["points"] = points
    if colours is not None:
        vertices["colours"] = colours
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    channels = () if colours is None else ("red", "green", "blue")
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", *(f"property double {c}" for c in "xyz")]
    lines += [f"property uchar {c}" for c in channels]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    return ["\n".join(lines).encode("ascii"), vertices.tobytes(), rows.tobytes()]


def facets_as_stl(corners: NDArray[np.float64]) -> list[bytes] | None:
    """(m, 3, 3) corners of triangles as the parts of a binary STL file; None if they are beyond its numbers."""
    if np.abs(corners).max(initial=0.0) > np.finfo(np.float32).max:
        return None
    rows = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = corners
    return [b"facets of a text".ljust(80), np.uint32(len(rows)).tobytes(), rows.tobytes()]


def text_as_binary(header: PlyHeader, rows: AllRows) -> list[bytes] | None:
    """A PLY file that is a text as the parts of a binary one; None if its numbers would be others, or MeshLab left some out."""
    if not rows.exact or {e.name for e in header.elements} != {"vertex", "face"}:
        return None
    parts = []
    for element in header.elements:
        own = rows[element.name]
        lists = [own.lengths(p.name) for p in element.properties if p.count_type]
        if not all(len(lengths) and lengths[0] and (lengths == lengths[0]).all() for lengths in lists):
            return None
        if not all(np.isfinite(own.values[p.name]).all() for p in element.properties):
            return None
        parts.append(_as_rows(own))
    corners = next((p.name for p in header.element("face").properties if p.name in ("vertex_indices", "vertex_index")), None)
    if corners is None or (rows["face"].lengths(corners) != 3).any():
        return None
    faces = rows["face"].values[corners].reshape(-1, 3).astype(np.int64)
    places = rows["vertex"].values
    if not {"x", "y", "z"} <= places.keys() or not are_plain_triangles(np.stack([places[c] for c in "xyz"], axis=1), faces):
        return None
    return [given_header(replace(header, format="binary_little_endian"), ()), *parts]


def _as_rows(own: Rows) -> bytes:
    kinds: list[Any] = []
    for p in own.element.properties:
        if p.count_type:
            kinds.append((f"{p.name} count", f"<{KINDS[p.count_type]}"))
        shape = (int(own.lengths(p.name)[0]),) if p.count_type else ()
        kinds.append((p.name, f"<{KINDS[p.type]}", shape))
    table = np.empty(own.element.count, dtype=kinds)
    for p in own.element.properties:
        if p.count_type:
            table[f"{p.name} count"] = own.lengths(p.name)
        table[p.name] = own.values[p.name].reshape(table[p.name].shape)
    return table.tobytes()
