"""Meshes as a browser shows them: with no more triangles than it can turn, and with the numbers that become colours."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..declaration import Floats, Ints
from ..filters.geometry import cross_products, vector_lengths
from ..filters.inspection import mesh_normals
from ..filters.libraries import spatial
from ..filters.topology import proper_faces
from ..mesh_data import MeshData

#: faces of a mesh that a browser is given; more are decimated
MOST_FACES = 120_000
#: points of a cloud that a browser is given
MOST_POINTS = 200_000
#: times the faces that are to remain: so many a grid leaves for the decimation
_THINNED = 2


@dataclass(frozen=True, eq=False)
class Shown:
    """A mesh for a browser: n vertices and k elements."""

    name: str  # such as "before"
    vertices: Floats  # (n, 3) coordinates
    elements: Ints  # (k, 3) triangles or (k, 2) edges; (0, 3) of a cloud
    normals: Floats  # (n, 3) unit normals; 0 where there is none
    scalars: Mapping[str, Floats]  # (n,) numbers by the name of their coloring
    of_vertices: int  # how many vertices the mesh has
    of_faces: int  # how many faces the mesh has
    kept: Ints  # (n,) the vertex of the mesh whose normal and numbers each vertex has

    @property
    def decimated(self) -> bool:
        """Whether it has fewer elements than the mesh."""
        return len(self.vertices) < self.of_vertices


def shown_mesh(
    name: str,
    mesh: MeshData,
    *,
    scalars: Mapping[str, Floats] | None = None,
    like: Shown | None = None,
    most_faces: int = MOST_FACES,
    most_points: int = MOST_POINTS,
) -> Shown:
    """A mesh with at most so many elements.

    Numbers and normals are those of the whole mesh: a vertex that remains has those of the nearest vertex of the whole.

    Args:
        name: see `Shown`.
        mesh: its edges are shown where there are no faces, its own normals where it is a cloud.
        scalars: (n,) each.
        like: another mesh of the same vertices and faces, moved; what remains of it is what remains here.
        most_faces: a mesh with more is decimated by quadrics; one with many more is thinned on a grid first.
        most_points: of a cloud with more, evenly chosen ones are left out.
    """
    vertices, faces, edges = mesh.vertices, mesh.faces, mesh.edges
    points, elements = vertices, faces if len(faces) else edges if len(edges) else np.empty((0, 3), dtype=np.int32)
    if like is not None:
        kept, elements = like.kept, like.elements
        points = vertices[kept]
    elif len(faces) > most_faces:
        points, elements, kept = _simplified(vertices, faces, most_faces)
    elif not len(elements) and len(vertices) > most_points:
        kept = np.linspace(0, len(vertices) - 1, most_points).astype(np.int32)
        points = vertices[kept]
    else:
        kept = np.arange(len(vertices), dtype=np.int32)
    of = {key: np.asarray(values)[kept] for key, values in (scalars or {}).items()}
    own = mesh.vertex_attributes.get("normals", np.zeros((len(vertices), 3)))
    normals = mesh_normals(vertices, faces) if len(faces) else own
    return Shown(name, points, elements, normals[kept], of, len(vertices), len(faces), kept)


def _simplified(vertices: Floats, faces: Ints, most: int) -> tuple[Floats, Ints, Ints]:
    """Vertices and faces of a coarser mesh, and the nearest vertex of the whole to each of its own."""
    from fast_simplification import simplify

    middle = vertices.mean(axis=0)
    local = vertices - middle  # it computes in single precision
    thinned = _thinned(local, faces, _THINNED * most) if len(faces) > 2 * _THINNED * most else (local, faces)
    coarse, triangles = simplify(thinned[0].astype(np.float32), thinned[1].astype(np.int64), target_count=most)
    _, nearest = spatial.cKDTree(local).query(coarse)
    return coarse + middle, triangles.astype(np.int32), nearest.astype(np.int32)


def _thinned(local: Floats, faces: Ints, about: int) -> tuple[Floats, Ints]:
    """The mesh with the vertices of each cell of a grid as one, at their mean; about so many faces remain.

    Quadrics take time and keep memory by the face, a grid takes neither.
    """
    areas = vector_lengths(cross_products(local, faces))
    side = math.sqrt(float(areas.sum()) / about)  # two faces for a cell, each half a square
    cells = np.floor(local / side).astype(np.int64) if side > 0.0 else np.arange(len(local))[:, None]
    cells -= cells.min(axis=0)
    key = np.ravel_multi_index(cells.T, cells.max(axis=0) + 1)
    _, of = np.unique(key, return_inverse=True)
    counts = np.bincount(of)
    means = np.column_stack([np.bincount(of, local[:, k]) / counts for k in range(3)])
    merged = of.astype(np.int32)[faces]
    return means, merged[proper_faces(merged)]
