"""Reads what follows the header of a PLY file, held against it to the last byte, before MeshLab does.

MeshLab trusts lengths of lists and indices of edges, takes a face without vertices for the one before it, and writes lists that
are longer than its own store behind that store.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .announced import unended
from .as_binary import text_as_binary
from .ply import PlyElement, PlyError, PlyHeader
from .ply_rows import Rows, binary_rows
from .ply_text_rows import text_rows

#: the longest lists that MeshLab has room for
_LONGEST = {"vertex_indices": 512, "vertex_index": 512, "texcoord": 32, "color": 32}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class PlyBody:
    """What is in a PLY file.

    Attributes:
        points: (n, 3) its vertices, or None if they have no places.
        triangles: how many triangles its faces make, a polygon of k corners k - 2.
        binary: the parts of a binary file that MeshLab reads alike and sooner, of a text; None if there is none.
        columns: (element, property) -> the values, one for each vertex or face, of those asked for that have one.
        doubts: what makes one doubt that it is whole.
    """

    points: NDArray[np.float64] | None
    triangles: int
    columns: Mapping[tuple[str, str], NDArray[np.float64]] = field(default_factory=dict)
    binary: list[bytes] | None = None
    doubts: tuple[str, ...] = ()


def read_body(path: Path, header: PlyHeader, wanted: frozenset[tuple[str, str]]) -> PlyBody:
    """Read and check the rows of every element.

    Raises:
        PlyError: they are not what the header declares, or name what is not there.
        OSError: the file cannot be read.
    """
    names = [e.name for e in header.elements]
    if "vertex" not in names:
        raise PlyError("it has no element 'vertex'")
    if len(set(names)) != len(names):
        raise PlyError("it declares an element twice")
    for element in header.elements:
        properties = [p.name for p in element.properties]
        if len(set(properties)) != len(properties):
            raise PlyError(f"its element {element.name!r} has a property twice")
    data = np.memmap(path, dtype=np.uint8, mode="r")
    rows = (text_rows if header.format == "ascii" else binary_rows)(data, header)
    points: NDArray[np.float64] | None = None
    triangles = 0
    columns: dict[tuple[str, str], NDArray[np.float64]] = {}
    n = header.element("vertex").count
    for element in header.elements:
        own = rows[element.name]
        if header.format != "ascii":
            _check_empty_lists(element, own)
        if element.name in ("face", "tristrips", "range_grid", "edge") and "vertex" not in rows.done:
            raise PlyError(f"its element {element.name!r} comes before the vertices")
        rows.done.append(element.name)
        if element.name == "vertex" and {"x", "y", "z"} <= {p.name for p in element.properties}:
            points = np.stack([own.column(c) for c in "xyz"], axis=1) if n else np.empty((0, 3))
        if element.name == "face":
            triangles = _check_faces(element, own, n, len(header.textures))
        elif element.name == "edge":
            _check_edges(element, own, n)
        elif element.name in ("tristrips", "range_grid"):
            _check_lists(element, own, n, header)
        columns |= {
            (element.name, name): own.exact_column(name) for e, name in wanted if e == element.name and own.has_column(name)
        }
    if header.format != "ascii":
        return PlyBody(points, triangles, columns)
    return PlyBody(points, triangles, columns, text_as_binary(header, rows), unended(data[-1:].tobytes()))


def _check_empty_lists(element: PlyElement, rows: Rows) -> None:
    """Refuse what MeshLab's reader takes for the end of a binary file; it drops all lists but those of faces."""
    for p in element.properties:
        if p.count_type and element.count and not (lengths := rows.lengths(p.name)).all() and p.name not in _CORNERS:
            raise PlyError(
                f"the list {p.name!r} of number {int(np.argmin(lengths)) + 1:,} of its {element.name!r} is empty, at which "
                "MeshLab's reader fails; save it without that list, or as a text"
            )


def _check_faces(element: PlyElement, rows: Rows, n: int, textures: int) -> int:
    for p in element.properties:
        lengths = rows.lengths(p.name) if p.count_type else None
        if lengths is not None and len(lengths) and lengths.max() > _LONGEST.get(p.name, 1 << 62):
            k = int(np.argmax(lengths))
            raise PlyError(
                f"the list {p.name!r} of its face {k + 1:,} has {lengths[k]:,} values; {_LONGEST[p.name]} are the most"
            )
    named = [p.name for p in element.properties if p.name in _CORNERS and p.count_type]
    if len(named) > 1:
        raise PlyError(f"its faces have their corners twice, as {' and as '.join(map(repr, named))}")
    if not named or not element.count:
        return 0
    corners = named[0]
    lengths = rows.lengths(corners)
    if lengths.min() < 3:
        k = int(np.argmin(lengths))
        raise PlyError(f"its face {k + 1:,} has {lengths[k]} vertices")
    rows.check_range(corners, 0, n, "face")
    _check_textures(element, rows, lengths, textures)
    return int((lengths - 2).sum())


def _check_textures(element: PlyElement, rows: Rows, corners: NDArray[np.int64], textures: int) -> None:
    """Refuse faces without two texture coordinates a corner, as MeshLab takes others, or of a texture that is not there."""
    for p in element.properties:
        if p.name == "texcoord" and p.count_type and (wrong := rows.lengths(p.name) != 2 * corners).any():
            k = int(np.argmax(wrong))
            raise PlyError(
                f"the list 'texcoord' of its face {k + 1:,} has {rows.lengths(p.name)[k]} values for {corners[k]} corners"
            )
        if p.name == "texnumber" and rows.has_column(p.name):
            numbers = rows.column(p.name)
            if (wrong := ~((numbers >= -1) & (numbers < max(textures, 1)))).any():
                k = int(np.argmax(wrong))
                raise PlyError(f"its face {k + 1:,} has the texture {numbers[k]:.0f}, counted from 0, of {textures}")


def _check_edges(element: PlyElement, rows: Rows, n: int) -> None:
    for name in ("vertex1", "vertex2"):
        if element.count and rows.has_column(name):
            values = rows.column(name)
            wrong = ~((values >= 0) & (values < n))
            if wrong.any():
                raise PlyError(f"its edge {int(np.argmax(wrong)) + 1:,} ends at a vertex that is none of its {n:,}")


def _check_lists(element: PlyElement, rows: Rows, n: int, header: PlyHeader) -> None:
    if not element.count:
        return
    for p in element.properties:
        if p.name == "vertex_indices" and p.count_type:
            rows.check_range(p.name, -1, n, element.name)
    if element.name == "range_grid":
        said = [c.split() for c in header.comments]
        sizes = {w[0]: int(w[1]) for w in said if len(w) == 2 and w[0] in ("num_cols", "num_rows") and w[1].isdigit()}
        if sizes.get("num_cols", 0) * sizes.get("num_rows", 0) != element.count:
            raise PlyError(f"it has a grid of {element.count:,} places, but num_cols and num_rows say otherwise")
