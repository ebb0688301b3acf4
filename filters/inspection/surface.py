"""The nearest place on a surface, or in a cloud, to each of many points, and on which side of it they lie."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..geometry import face_normals
from ..libraries import spatial
from ..mesh import Floats, Ints, Longs, NormalisedMesh, check_mesh, normalised_mesh
from ..topology import faces_across, proper_faces
from .corner_angles import vertex_normals
from .triangle_tree import TriangleTree, largest_distances

#: points that are looked up at a time
_BLOCK = 1 << 16


class NearestPlaces(NamedTuple):
    """The places of a surface nearest to q points.

    Attributes:
        vectors: (q, 3) from the places to the points, in mesh units.
        distances: (q,) their lengths.
        elements: (q,) the face on which each place lies; in a cloud the point that it is.
        sides: (q,) 1 on the side to which the faces look, and where that tells nothing; -1 on the other.
    """

    vectors: Floats
    distances: Floats
    elements: Longs
    sides: Floats

    @property
    def signed(self) -> Floats:
        """(q,) the distances, negative on the inner side."""
        return self.sides * self.distances


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh, or a cloud, to which distances are measured; exact far from the origin, too, as differences come before squares.

    Attributes:
        mesh: normalised; what searches need is made of it when it is first used, and kept.
        faces: (m,) the number of each of its triangles in the mesh that it was made of.
        vertex_count: of that mesh.
    """

    mesh: NormalisedMesh
    faces: Longs
    vertex_count: int

    @classmethod
    def of(cls, vertices: ArrayLike, faces: ArrayLike) -> Surface:
        """The surface of (n, 3) vertices and (m, 3) triangles; without any the cloud of the vertices.

        Raises:
            FilterInputError: not a mesh, or no vertices.
        """
        points, triangles = check_mesh(vertices, faces)
        if len(points) == 0:
            raise FilterInputError("the reference has no vertices: there is nothing to measure from")
        proper = np.flatnonzero(proper_faces(triangles))
        return cls(normalised_mesh(points, triangles[proper]), proper, len(points))

    def nearest(self, queries: Floats) -> NearestPlaces:
        """The nearest place to each of (q, 3) points: exact, and of places as near as each other that of the lowest face.

        The side is that of the face, and at an edge or a vertex that of the sum of its faces' normals, weighted with the angle
        at a vertex: then it is right for every point around a closed surface [baerentzen2005].
        """
        count = len(queries)
        found = NearestPlaces(np.empty((count, 3)), np.empty(count), np.empty(count, np.int64), np.ones(count))
        # By blocks, as what is computed on the way takes five times the memory of what is found.
        for start in range(0, count, _BLOCK):
            part = slice(start, start + _BLOCK)
            for whole, values in zip(found, self._nearest(queries[part]), strict=True):
                whole[part] = values
        return found

    def _nearest(self, queries: Floats) -> tuple[Floats, Floats, Longs, Floats | float]:
        mesh = self.mesh
        local = self.local(queries)
        if not len(mesh.cells):
            distances, points = self._points.query(local)
            return (local - mesh.points[points]) / mesh.scale, distances / mesh.scale, mesh.used[points], 1.0
        cells, weights, distances = self._tree.nearest(local)
        corners = mesh.points[mesh.cells[cells]]
        s, t = weights[:, :1], weights[:, 1:]
        vectors = local - corners[:, 0] - s * (corners[:, 1] - corners[:, 0]) - t * (corners[:, 2] - corners[:, 0])
        outwards = np.einsum("ij,ij->i", vectors, self._normals_at(cells, weights))
        return vectors / mesh.scale, distances / mesh.scale, self.faces[cells], np.where(outwards < 0.0, -1.0, 1.0)

    def local(self, places: Floats) -> Floats:
        """Places about the middle of the surface and of its scale, in which `search` and `largest_distances` work."""
        return np.ascontiguousarray((places - self.mesh.middle) * self.mesh.scale)

    def search(self, local: Floats) -> tuple[Longs, Floats]:
        """The nearest triangles, by their number in `mesh`, to (q, 3) local places, and their (q,) local distances."""
        cells, _, distances = self._tree.nearest(local)
        return cells, distances

    def largest_distances(self, corners: Floats, distances: Floats, beside: Longs) -> Floats:
        """See `pymeshfair.filters.inspection.triangle_tree.largest_distances`; all is local."""
        return largest_distances(self.mesh.points, self.mesh.cells, corners, distances, beside)

    def cells_of(self, faces: Longs) -> Longs:
        """The triangles of `mesh` by their number in the mesh that it was made of."""
        return faces if self.faces[-1] == len(self.faces) - 1 else np.searchsorted(self.faces, faces)

    def normals_of(self, faces: Longs) -> Floats:
        """(q, 3) the unit normals of triangles by their number in the mesh; 0 of those without area."""
        return np.asarray(self._normals[self.cells_of(faces)])

    def normals_at_vertices(self) -> Floats:
        """(n, 3) the unit normals of all vertices; 0 where there are none."""
        normals = np.zeros((self.vertex_count, 3))
        normals[self.mesh.used] = self._vertex_normals
        return normals

    def _normals_at(self, cells: Longs, weights: Floats) -> Floats:
        """(q, 3) a direction to the outer side at places of triangles."""
        normals = self._normals[cells]
        s, t = weights.T
        # Edge k goes from corner k to the next; a place on two of them is their common corner.
        on = np.column_stack([t == 0.0, s + t == 1.0, s == 0.0])
        at_corner = on.sum(axis=1) > 1
        for k in range(3):
            edge = np.flatnonzero(on[:, k] & ~at_corner)
            across = self._across[cells[edge], k]
            normals[edge[across >= 0]] += self._normals[across[across >= 0]]
        corner, at = np.nonzero(on & np.roll(on, 1, axis=1))
        if len(corner):
            normals[corner] = self._vertex_normals[self.mesh.cells[cells[corner], at]]
        return normals

    @cached_property
    def _tree(self) -> TriangleTree:
        return TriangleTree.of(self.mesh.points, self.mesh.cells)

    @cached_property
    def _points(self) -> spatial.cKDTree:
        return spatial.cKDTree(self.mesh.points)

    @cached_property
    def _normals(self) -> Floats:
        return face_normals(self.mesh.points, self.mesh.cells)

    @cached_property
    def _vertex_normals(self) -> Floats:
        return vertex_normals(self.mesh.points, self.mesh.cells)

    @cached_property
    def _across(self) -> Ints:
        return faces_across(self.mesh.cells)
