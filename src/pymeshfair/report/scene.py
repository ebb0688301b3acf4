"""Meshes for the viewer in the browser: decimated, quantised and compressed.

The viewer (``viewer.js``) reads this layout. A scene is a header in JSON and a body of bytes. Coordinates are integers of 16 bits
in a cube around the meshes, normals are two integers of 12 bits on an octahedron [meyer2010], scalars for colours are integers of
8 bits between the ends of their colour bar, and indices have 32 bits. The body holds differences of these numbers, see `_planes`.
"""

import base64
import json
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import Floats, Ints
from ..filters.geometry import cross_products, vector_lengths
from ..filters.inspection import Limits, mesh_normals
from ..filters.libraries import spatial
from ..filters.mesh import bounding_box, mask_of
from ..filters.topology import proper_faces
from ..looking.picture import COLORINGS, Coloring, in_unit
from ..mesh_data import MeshData

MOST_FACES = 120_000  # the largest number of faces of a mesh in a browser; larger meshes are decimated
MOST_POINTS = 200_000
_THINNED = 2  # before decimation, a mesh of over 4 `MOST_FACES` faces is thinned on a grid to about this many times `MOST_FACES`


@dataclass(frozen=True, eq=False)
class Shown:
    """A mesh for a browser: n vertices and k elements."""

    name: str  # such as "before"
    vertices: Floats  # (n, 3) coordinates
    elements: Ints  # (k, 3) triangles or (k, 2) edges; (0, 3) for a cloud
    normals: Floats  # (n, 3) unit normals; 0 where there is none
    scalars: Mapping[str, Floats]  # (n,) scalars by the name of their coloring
    of_vertices: int  # the number of vertices of the whole mesh
    of_faces: int  # the number of faces of the whole mesh
    kept: NDArray[np.integer]  # (n,) the vertex of the whole mesh that gives each vertex its normal and scalars

    @property
    def decimated(self) -> bool:
        return len(self.elements) < self.of_faces or (not len(self.elements) and len(self.vertices) < self.of_vertices)


def shown_mesh(name: str, mesh: MeshData, *, scalars: Mapping[str, Floats] | None = None, like: Shown | None = None) -> Shown:
    """A mesh for the viewer: its faces, at most `MOST_FACES`; or else its edges; or else its points, at most `MOST_POINTS`.

    A mesh with more faces is decimated by quadrics, and first thinned on a grid if it is much larger. Of a larger cloud, points
    at equal steps in its order are kept. Vertices that no face or edge uses are left out; each other one has the scalars and
    the normal of the nearest used vertex of the whole mesh. `like` is the `Shown` of this mesh before its vertices moved; the
    result has the elements of `like`.
    """
    vertices, faces = mesh.vertices, mesh.faces
    points, elements = None, faces if len(faces) else mesh.edges
    if like is not None:
        kept, elements = like.kept, like.elements
    elif len(elements):
        used = mask_of(elements, len(vertices))
        kept, elements = np.flatnonzero(used), (np.cumsum(used, dtype=np.int32) - 1)[elements]
        if len(faces) > MOST_FACES:
            points, elements, nearest = _simplified(vertices[kept], elements)
            kept = kept[nearest]
    else:
        elements = np.empty((0, 3), dtype=np.int32)
        kept = np.linspace(0, len(vertices) - 1, min(len(vertices), MOST_POINTS)).astype(np.int32)
    numbers = {key: np.asarray(values)[kept] for key, values in (scalars or {}).items()}
    file_normals = np.nan_to_num(mesh.vertex_attributes.get("normals", np.zeros((len(vertices), 3))), posinf=0.0, neginf=0.0)
    normals = (mesh_normals(vertices, faces) if len(faces) else file_normals)[kept]
    return Shown(name, vertices[kept] if points is None else points, elements, normals, numbers, len(vertices), len(faces), kept)


def _simplified(vertices: Floats, faces: Ints) -> tuple[Floats, Ints, Ints]:
    """The vertices and faces of a coarser mesh, and for each of its vertices the nearest vertex of the whole mesh."""
    from fast_simplification import simplify

    middle = vertices.mean(axis=0)
    local = vertices - middle  # near 0, because `simplify` computes in single precision
    thinned = _thinned(local, faces, _THINNED * MOST_FACES) if len(faces) > 2 * _THINNED * MOST_FACES else (local, faces)
    coarse, triangles = simplify(thinned[0].astype(np.float32), thinned[1].astype(np.int64), target_count=MOST_FACES)
    _, nearest = spatial.cKDTree(local).query(coarse)
    return coarse + middle, triangles.astype(np.int32), nearest.astype(np.int32)


def _thinned(local: Floats, faces: Ints, target: int) -> tuple[Floats, Ints]:
    """The mesh with the vertices of each grid cell merged at their mean; about `target` to 1.7 `target` faces remain.

    A grid needs little time and memory for each face; quadrics need much of both.
    """
    areas = vector_lengths(cross_products(local, faces))
    side = math.sqrt(float(areas.sum()) / target)  # `areas` are doubled: a cell of a flat part keeps two faces
    cell_of_vertex = np.zeros(len(local), np.int64) if side > 0.0 else np.arange(len(local))
    # Axis by axis: with a vertex far away, the number of cells of the whole grid would overflow.
    for along in np.floor(local / side).T if side > 0.0 else ():
        _, row = np.unique(along, return_inverse=True)
        _, cell_of_vertex = np.unique(cell_of_vertex * (row.max() + 1) + row, return_inverse=True)
    counts = np.bincount(cell_of_vertex)
    means = np.column_stack([np.bincount(cell_of_vertex, local[:, k]) / counts for k in range(3)])
    merged = cell_of_vertex.astype(np.int32)[faces]
    return means, merged[proper_faces(merged)]


#: the largest integer of a coordinate, of a component of a normal, and of a scalar
_PLACES, _DIRECTIONS, _LEVELS = 65535, 4095, 255


@dataclass(frozen=True)
class Marker:
    """A place that the viewer shows with a ring and a label."""

    place: tuple[float, float, float]  # (x, y, z)
    label: str
    mesh: int = 1  # the index of its mesh in the scene, from 0


@dataclass(frozen=True)
class Scene:
    """The data of the viewer."""

    header: dict[str, Any]  # a description of the body and of the view, as values for JSON
    body: bytes  # the arrays, compressed by zlib

    @property
    def text(self) -> str:
        return base64.b64encode(self.body).decode("ascii")

    @property
    def message(self) -> bytes:
        """Header and body as one message: the length of the header in four bytes (little-endian), the header, the body."""
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
    """Pack meshes for one camera; at least one mesh must have a vertex.

    `limits` are the ends of the colour bar of each coloring for which a mesh has scalars. If the `tolerance` is not 0, distances
    within it have one colour. `box` is the cube of the coordinates: its centre and half its side. Scenes that are shown
    together share a cube; points outside the cube are moved to its sides. The default is the bounding cube of all meshes.
    """
    centre, half = least_box(meshes) if box is None else box
    parts: list[bytes] = []
    bars = {name: _color_bar(COLORINGS[name], ends, tolerance if name == "distance" else 0.0) for name, ends in limits.items()}
    header = {
        "centre": centre.tolist(),
        "half": half,
        "fit": min(1.0, least_box(meshes)[1] / half),
        "up": up,
        "meshes": [_packed(mesh, centre, half, limits, parts) for mesh in meshes],
        "colorings": {name: {**bar, "label": in_unit(COLORINGS[name].label, unit)} for name, bar in bars.items()},
        "markers": [
            {"place": ((np.asarray(m.place) - centre) / half).tolist(), "label": m.label, "mesh": m.mesh} for m in markers
        ],
    }
    return Scene(header, zlib.compress(b"".join(parts), 7))


def least_box(meshes: Sequence[Shown]) -> tuple[Floats, float]:
    """The bounding cube of what is drawn: its centre and half its side."""
    low, high = bounding_box(np.concatenate([mesh.vertices for mesh in meshes]))
    return 0.5 * (low + high), 0.5 * float((high - low).max()) or 1.0


def _packed(mesh: Shown, centre: Floats, half: float, limits: Mapping[str, Limits], parts: list[bytes]) -> dict[str, Any]:
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
            {"name": name, "bits": 8 * array.itemsize, "rows": len(array), "columns": array.size // (len(array) or 1) or 1}
            for name, array in arrays
        ],
    }


def _planes(array: NDArray[Any]) -> bytes:
    """The differences of integers down each column, as bytes: the lowest bytes of all differences, then all second bytes, ..."""
    if not array.size:
        return b""
    table = array.reshape(len(array), -1)
    steps = np.diff(table, axis=0, prepend=np.zeros((1, table.shape[1]), dtype=table.dtype))
    if array.dtype == np.uint32:
        # The corners of a triangle have similar indices, so differences go from corner to corner; zigzag codes keep them small.
        flat = table.ravel()
        signed = np.diff(flat, prepend=np.uint32(0)).astype(np.int32)
        steps = ((signed << 1) ^ (signed >> 31)).astype(np.uint32)[:, None]
    flat = np.ascontiguousarray(steps.T).ravel()
    return flat.astype(flat.dtype.newbyteorder("<")).view(np.uint8).reshape(-1, array.itemsize).T.tobytes()


def _octahedral(normals: Floats) -> NDArray[np.uint16]:
    """(n, 2) integers from 0 to 4095 for unit normals, projected onto the octahedron |x| + |y| + |z| = 1 and unfolded."""
    sizes = np.abs(normals).sum(axis=1, keepdims=True)
    flat = np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0.0)
    x, y = flat[:, 0], flat[:, 1]
    folded = np.column_stack([(1.0 - np.abs(y)) * np.where(x < 0.0, -1.0, 1.0), (1.0 - np.abs(x)) * np.where(y < 0.0, -1.0, 1.0)])
    unfolded = np.where(flat[:, 2:] < 0.0, folded, flat[:, :2])
    return np.asarray(np.rint((0.5 + 0.5 * unfolded) * _DIRECTIONS), dtype=np.uint16)


def _levels(values: Floats, limits: Limits) -> NDArray[np.uint8]:
    """(n,) integers from 0 to 255 for values between the limits; the middle level for NaN, or if the limits are equal."""
    low, high = limits
    shares = np.full(len(values), 0.5)
    if high > low:
        shares = np.clip((0.5 * values - 0.5 * low) / (0.5 * high - 0.5 * low), 0.0, 1.0)
        shares[np.isnan(values)] = 0.5
    return np.asarray(np.rint(shares * _LEVELS), dtype=np.uint8)


def _color_bar(coloring: Coloring, limits: Limits, tolerance: float) -> dict[str, Any]:
    limits = Limits(limits.low, max(limits))
    values = np.linspace(limits.low, limits.high, _LEVELS + 1)
    colors = np.rint(255.0 * coloring.colors(values, limits, tolerance)).astype(int)
    return {"low": limits.low, "high": limits.high, "colors": colors.ravel().tolist()}
