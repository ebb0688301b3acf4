"""Packs meshes for the viewer in the browser: whole numbers of few bits, their differences by byte, compressed.

The viewer (``viewer.js``) reads the same layout back. A scene is a header in JSON and a body of bytes. Coordinates are whole
numbers of 16 bits over the box of all meshes, normals two numbers of 12 bits on an octahedron [meyer2010], numbers for colours 8
bits between their limits.
"""

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import Floats
from ..filters.inspection import Limits
from ..looking.coloring import COLORINGS, Coloring, in_unit
from .display import Shown

#: the highest level of a coordinate, of a part of a normal, and of a number
_PLACES, _DIRECTIONS, _LEVELS = 65535, 4095, 255


@dataclass(frozen=True)
class Marker:
    """A place that the viewer shows with a ring and some words."""

    place: tuple[float, float, float]  # (x, y, z)
    label: str  # the words
    mesh: int = 1  # the number of the mesh that it belongs to


@dataclass(frozen=True)
class Scene:
    """The data of the viewer."""

    header: dict[str, Any]  # the contents of the body and their places, in terms of JSON
    body: bytes  # the bytes, compressed by zlib

    @property
    def text(self) -> str:
        """The body in letters, for a page that holds everything."""
        return base64.b64encode(self.body).decode("ascii")

    @property
    def message(self) -> bytes:
        """Header and body as one message: the length of the header in four bytes, little end first, the header, the body."""
        import json

        head = json.dumps(self.header).encode("utf-8")
        return len(head).to_bytes(4, "little") + head + self.body


def pack_scene(
    meshes: Sequence[Shown],
    limits: Mapping[str, Limits],
    *,
    up: str = "y",
    markers: Sequence[Marker] = (),
    box: tuple[Floats, float] | None = None,
    tolerance: float = 0.0,
    unit: str | None = None,
) -> Scene:
    """Pack meshes that are seen from one camera.

    Args:
        meshes: at least one with a vertex.
        limits: the ends of the colour bar, by coloring, for every coloring that a mesh has numbers of.
        up: the upright axis, "y" or "z".
        markers: places to show.
        box: the middle and half the side of the cube in which coordinates are kept, for scenes that are to be shown together;
            what lies outside is moved to its sides. The least that holds all meshes if it is None.
        tolerance: of distances, whose colours have a band of that size.
        unit: of the scan, if it is known.
    """
    centre, half = _least_box(meshes) if box is None else box
    parts: list[bytes] = []
    described = [_packed(mesh, centre, half, limits, parts) for mesh in meshes]
    header = {
        "centre": centre.tolist(),
        "half": half,
        "fit": min(1.0, _least_box(meshes)[1] / half),
        "up": up,
        "meshes": described,
        "colorings": {
            name: _coloring(COLORINGS[name], ends, tolerance if name == "distance" else 0.0)
            | {"label": in_unit(COLORINGS[name].label, unit)}
            for name, ends in limits.items()
        },
        "markers": [
            {"place": ((np.asarray(m.place) - centre) / half).tolist(), "label": m.label, "mesh": m.mesh} for m in markers
        ],
    }
    return Scene(header, zlib.compress(b"".join(parts), 7))


def _least_box(meshes: Sequence[Shown]) -> tuple[Floats, float]:
    low = np.min([mesh.vertices.min(axis=0) for mesh in meshes if len(mesh.vertices)], axis=0)
    high = np.max([mesh.vertices.max(axis=0) for mesh in meshes if len(mesh.vertices)], axis=0)
    return 0.5 * (low + high), 0.5 * float((high - low).max()) or 1.0


def _packed(mesh: Shown, centre: Floats, half: float, limits: Mapping[str, Limits], parts: list[bytes]) -> dict[str, Any]:
    """Add the arrays of a mesh to the parts; their description."""
    places = np.rint(((mesh.vertices - centre) / half * 0.5 + 0.5) * _PLACES).clip(0, _PLACES).astype(np.uint16)
    arrays: list[tuple[str, NDArray[Any]]] = [
        ("positions", places),
        ("normals", _octahedral(mesh.normals)),
        ("elements", mesh.elements.astype(np.uint32)),
        *(("scalar:" + name, _levels(values, limits[name])) for name, values in mesh.scalars.items()),
    ]
    parts += [_planes(array) for _, array in arrays]
    return {
        "name": mesh.name,
        "vertices": len(mesh.vertices),
        "of_vertices": mesh.of_vertices,
        "of_faces": mesh.of_faces,
        "lit": bool(mesh.normals.any()),
        "limits": {name: list(limits[name]) for name in mesh.scalars},
        "arrays": [
            {
                "name": name,
                "bits": 8 * array.itemsize,
                "rows": len(array),
                "columns": array.size // len(array) if len(array) else 1,
            }
            for name, array in arrays
        ],
    }


def _planes(array: NDArray[Any]) -> bytes:
    """The differences of whole numbers from row to row, first all the lowest bytes, then all the next ones."""
    if not array.size:
        return b""
    table = array.reshape(len(array), -1)
    steps = np.diff(table, axis=0, prepend=np.zeros((1, table.shape[1]), dtype=table.dtype))
    if array.dtype == np.uint32:
        # Corners of one triangle are near each other, so they follow each other; small steps back become small numbers.
        flat = table.ravel()
        signed = np.diff(flat, prepend=np.uint32(0)).astype(np.int32)
        steps = ((signed << 1) ^ (signed >> 31)).astype(np.uint32)[:, None]
    flat = np.ascontiguousarray(steps.T).ravel()
    return flat.astype(flat.dtype.newbyteorder("<")).view(np.uint8).reshape(-1, array.itemsize).T.tobytes()


def _octahedral(normals: Floats) -> NDArray[np.uint16]:
    """(n, 2) unit normals on the unfolded octahedron |x| + |y| + |z| = 1."""
    sizes = np.abs(normals).sum(axis=1, keepdims=True)
    flat = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0.0)
    x, y = flat[:, 0], flat[:, 1]
    below = flat[:, 2] < 0.0
    folded = np.column_stack([(1.0 - np.abs(y)) * np.where(x < 0.0, -1.0, 1.0), (1.0 - np.abs(x)) * np.where(y < 0.0, -1.0, 1.0)])
    unfolded = np.where(below[:, None], folded, flat[:, :2])
    return np.asarray(np.rint((0.5 + 0.5 * unfolded) * _DIRECTIONS), dtype=np.uint16)


def _levels(values: Floats, limits: Limits) -> NDArray[np.uint8]:
    """(n,) the place of each number between the limits, in 255 steps; the middle where there is no number."""
    low, high = limits
    shares = np.full(len(values), 0.5)
    if high > low:
        shares = np.clip((0.5 * values - 0.5 * low) / (0.5 * high - 0.5 * low), 0.0, 1.0)
        shares[np.isnan(values)] = 0.5
    return np.asarray(np.rint(shares * _LEVELS), dtype=np.uint8)


def _coloring(coloring: Coloring, limits: Limits, tolerance: float) -> dict[str, Any]:
    """The ends and 256 colours of a coloring."""
    values = np.linspace(limits.low, limits.high, _LEVELS + 1)
    if not limits.high > limits.low:
        limits, values = Limits(limits.low, limits.low), np.full(_LEVELS + 1, limits.low)
    colors = np.rint(255.0 * coloring.colors(values, limits, tolerance)).astype(int)
    return {"low": limits.low, "high": limits.high, "colors": colors.ravel().tolist()}
