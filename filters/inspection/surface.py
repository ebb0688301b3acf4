"""Exact nearest places on a surface or in a cloud for many points, and the side of the surface on which each point lies."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..compilation import compiled
from ..execution import blocks, over_range
from ..geometry import closest_weights, face_normals
from ..libraries import spatial
from ..mesh import Floats, Ints, Longs, NormalisedMesh, check_mesh, normalised_mesh
from ..neighbours import gap_to, split_nodes
from ..topology import faces_across, proper_faces
from .curvature import at_vertices, normals_by_completed_angle

#: Triangles in a leaf, a constant of the kernels: 2 and 8 are not faster.
_LEAF = 4
#: The size of the search stack, enough for a tree of 2^31 triangles.
_STACK = 64
#: The search skips boxes with a squared distance above this times that of the nearest triangle so far, plus `rounding`.
_SLACK = 1.0 + 1e-9
#: Differences of squared distances below this share of the squared size of the coordinates are rounding errors.
_ROUNDING = (8.0 * np.finfo(np.float64).eps) ** 2


class TriangleTree(NamedTuple):
    """A bounding volume tree: node i splits its triangles into nodes 2 i and 2 i + 1, at the median along the widest axis."""

    triangles: Floats  # (m, 9) the first corner, the vector to the second corner, the vector to the third
    indices: Ints  # (m,) the face of each triangle
    boxes: Floats  # (nodes, 2, 3) the lowest and the highest coordinates of the triangles of each node
    leaves: int
    rounding: float  # smaller differences of squared distances are rounding errors

    @classmethod
    def of(cls, points: Floats, faces: Ints) -> "TriangleTree":
        """Builds the tree of (m, 3) triangles, m at least 1, with corners at (n, 3) points near the origin."""
        leaves = -(-len(faces) // _LEAF)
        rows = np.empty((len(faces), 4))
        _middles(points, faces, rows)
        boxes = np.empty((2 << (leaves - 1).bit_length(), 2, 3))
        split_nodes(rows, _LEAF, boxes, np.empty(len(boxes), np.int64), 1, 0, leaves)
        indices, triangles = rows[:, 3].astype(np.int32), np.empty((len(faces), 9))
        _enclose(points, faces, indices, leaves, triangles, boxes)
        return cls(triangles, indices, boxes, leaves, _ROUNDING * float(np.abs(boxes[1]).max()) ** 2)

    def nearest(self, queries: Floats) -> tuple[Longs, Floats, Floats]:
        """(q,) the faces nearest to (q, 3) points (lowest of ties), (q, 2) weights of the last two corners, (q,) distances."""
        faces, weights, distances = np.empty(len(queries), np.int64), np.empty((len(queries), 2)), np.empty(len(queries))
        over_range(_search, len(queries), self, np.ascontiguousarray(queries), faces, weights, distances)
        return faces, weights, distances


@compiled(nogil=True)
def _middles(points: Floats, faces: Ints, rows: Floats) -> None:
    for f in range(faces.shape[0]):
        for d in range(3):
            x, y, z = points[faces[f, 0], d], points[faces[f, 1], d], points[faces[f, 2], d]
            rows[f, d] = 0.5 * (min(x, y, z) + max(x, y, z))
        rows[f, 3] = f


@compiled(nogil=True)
def _enclose(points: Floats, faces: Ints, indices: Ints, leaves: int, triangles: Floats, boxes: Floats) -> None:
    """Writes the triangles in the order of the tree, and replaces the boxes of their centres by the boxes of the triangles."""
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for leaf in range(leaves):
        node, first, last = 1, 0, leaves
        while last - first > 1:
            middle = (first + last) // 2
            if leaf < middle:
                node, last = 2 * node, middle
            else:
                node, first = 2 * node + 1, middle
        for r in range(leaf * _LEAF, min((leaf + 1) * _LEAF, indices.shape[0])):
            f = indices[r]
            for d in range(3):
                a, b, c = points[faces[f, 0], d], points[faces[f, 1], d], points[faces[f, 2], d]
                triangles[r, d], triangles[r, 3 + d], triangles[r, 6 + d] = a, b - a, c - a
                boxes[node, 0, d], boxes[node, 1, d] = min(boxes[node, 0, d], a, b, c), max(boxes[node, 1, d], a, b, c)
    for node in range(boxes.shape[0] // 2 - 1, 0, -1):
        for d in range(3):
            boxes[node, 0, d] = min(boxes[node, 0, d], boxes[2 * node, 0, d], boxes[2 * node + 1, 0, d])
            boxes[node, 1, d] = max(boxes[node, 1, d], boxes[2 * node, 1, d], boxes[2 * node + 1, 1, d])


@compiled(nogil=True)
def _search(tree: TriangleTree, queries: Floats, faces: Longs, weights: Floats, distances: Floats, first: int, last: int) -> None:
    """Writes the nearest place for the queries from `first` to before `last`; visits the nearer child of a node first."""
    triangles, indices, boxes, leaves, rounding = tree
    stack = np.empty((_STACK, 3), np.int64)
    gaps = np.empty(_STACK)
    row = 0
    for q in range(first, last):
        x, y, z = queries[q, 0], queries[q, 1], queries[q, 2]
        # The nearest triangle of the previous query is a good first guess.
        s, t, best = _measure(triangles, row, x, y, z)
        stack[0, 0], stack[0, 1], stack[0, 2], gaps[0] = 1, 0, leaves, 0.0
        top = 1
        while top > 0:
            top -= 1
            node, a, b, gap = stack[top, 0], stack[top, 1], stack[top, 2], gaps[top]
            bound = best * _SLACK + rounding
            if gap > bound:
                continue
            while b - a > 1:
                middle = (a + b) // 2
                left, right = gap_to(boxes, 2 * node, x, y, z), gap_to(boxes, 2 * node + 1, x, y, z)
                if left <= right:
                    other, c, d, further = 2 * node + 1, middle, b, right
                    node, b, gap = 2 * node, middle, left
                else:
                    other, c, d, further = 2 * node, a, middle, left
                    node, a, gap = 2 * node + 1, middle, right
                if further <= bound:
                    stack[top, 0], stack[top, 1], stack[top, 2], gaps[top] = other, c, d, further
                    top += 1
                if gap > bound:
                    break
            if gap <= bound:
                for r in range(a * _LEAF, min(b * _LEAF, triangles.shape[0])):
                    s1, t1, square = _measure(triangles, r, x, y, z)
                    if square < best or (square == best and indices[r] < indices[row]):
                        s, t, best, row = s1, t1, square, r
        faces[q], weights[q, 0], weights[q, 1], distances[q] = indices[row], s, t, math.sqrt(best)


@compiled(nogil=True)
def _measure(triangles: Floats, r: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The weights s, t of the place on triangle r nearest to (x, y, z), and its squared distance."""
    px, py, pz = x - triangles[r, 0], y - triangles[r, 1], z - triangles[r, 2]
    ux, uy, uz = triangles[r, 3], triangles[r, 4], triangles[r, 5]
    vx, vy, vz = triangles[r, 6], triangles[r, 7], triangles[r, 8]
    s, t = closest_weights(ux, uy, uz, vx, vy, vz, px, py, pz)
    px, py, pz = px - s * ux - t * vx, py - s * uy - t * vy, pz - s * uz - t * vz
    return s, t, px * px + py * py + pz * pz


@compiled(nogil=True)
def _bound(triangles: Floats, corners: Floats, distances: Floats, beside: Longs, bounds: Floats, first: int, last: int) -> None:
    for c in range(first, last):
        longest = 0.0
        for k in range(3):
            square = 0.0
            for d in range(3):
                square += (corners[c, k, d] - corners[c, k - 1, d]) ** 2
            longest = max(longest, square)
        bounds[c] = max(distances[c, 0], distances[c, 1], distances[c, 2]) + math.sqrt(longest / 3.0)
        for row in beside[c]:
            furthest = 0.0
            for k in range(3):
                furthest = max(furthest, _measure(triangles, row, corners[c, k, 0], corners[c, k, 1], corners[c, k, 2])[2])
            bounds[c] = min(bounds[c], math.sqrt(furthest))


class NearestPlaces(NamedTuple):
    """The places of a surface nearest to q points."""

    signed: Floats  # (q,) the distances of the points from the places, negative behind the faces
    elements: Ints  # (q,) the face of each place; in a cloud, the index of the nearest point
    vectors: Floats  # (q, 3) from the places to the points, in mesh units; (0, 3) if not requested

    @property
    def distances(self) -> Floats:
        return np.abs(self.signed)


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh or cloud to which distances are measured; exact also far from the origin: differences are taken before squares."""

    mesh: NormalisedMesh
    faces: Longs  # (m,) the index in the original mesh of each triangle of `mesh`

    @classmethod
    def of(cls, vertices: ArrayLike, faces: ArrayLike) -> "Surface":
        """The surface of (n, 3) vertices and (m, 3) triangles; their cloud if no triangle has three distinct vertices."""
        points, triangles = check_mesh(vertices, faces)
        if len(points) == 0:
            raise FilterInputError("the reference has no vertices: there is nothing to measure from")
        proper = np.flatnonzero(proper_faces(triangles))
        return cls(normalised_mesh(points, triangles[proper]), proper)

    def nearest(self, queries: Floats, *, vectors: bool = False) -> NearestPlaces:
        """Returns the exact nearest place to each of (q, 3) points; of equally near places, the one on the face of lowest index.

        The sign is negative behind the face. At an edge, the sum of the adjacent normals decides; at a vertex, their sum weighted
        by angle. So the sign is right for every point around a closed surface [baerentzen2005].
        """
        count = len(queries)
        places = NearestPlaces(np.empty(count), np.empty(count, np.int32), np.empty((count * vectors, 3)))
        for part in blocks(count):  # the intermediate arrays need five times the memory of the result
            places.signed[part], places.elements[part], offsets = self._nearest(queries[part])
            if vectors:
                places.vectors[part] = offsets / self.mesh.scale
        return places

    def _nearest(self, queries: Floats) -> tuple[Floats, Longs, Floats]:
        mesh = self.mesh
        local = self.local(queries)
        if not len(mesh.cells):
            distances, points = self._points.query(local)
            return distances / mesh.scale, mesh.used[points], local - mesh.points[points]
        cells, weights, distances = self._tree.nearest(local)
        corners = mesh.points[mesh.cells[cells]]
        s, t = weights[:, :1], weights[:, 1:]
        vectors = local - corners[:, 0] - s * (corners[:, 1] - corners[:, 0]) - t * (corners[:, 2] - corners[:, 0])
        outwards = np.einsum("ij,ij->i", vectors, self._normals_at(cells, weights))
        return np.where(outwards < 0.0, -1.0, 1.0) * distances / mesh.scale, self.faces[cells], vectors

    def local(self, places: Floats) -> Floats:
        """Converts places to the local coordinates of `mesh`."""
        return np.ascontiguousarray((places - self.mesh.middle) * self.mesh.scale)

    def search(self, local: Floats) -> tuple[Longs, Floats]:
        """Returns the nearest triangle of `mesh` to each of (q, 3) local places, and the (q,) local distances."""
        cells, _, distances = self._tree.nearest(local)
        return cells, distances

    def largest_distances(self, corners: Floats, distances: Floats, beside: Longs) -> Floats:
        """Returns (t,) upper bounds of local distances of points in t triangles, given those of their (t, 3, 3) corners.

        Each point is at most L / sqrt(3) from a corner, L the longest side (Jung's theorem), so its distance exceeds the corner's
        by at most L / sqrt(3). The distance to each triangle of `mesh` in (t, k) `beside` is convex, so largest at a corner.
        """
        bounds, rows = np.empty(len(corners)), self._row_of[beside]
        over_range(_bound, len(corners), self._tree.triangles, np.ascontiguousarray(corners), distances, rows, bounds)
        return bounds

    def cells_of(self, faces: Ints) -> Longs:
        """Returns the triangles of `mesh` for faces of the original mesh."""
        return np.searchsorted(self.faces, faces)

    def normals_of(self, faces: Ints) -> Floats:
        """(q, 3) the unit normals of faces of the original mesh with three distinct vertices; 0 for a face without area."""
        return np.asarray(self._normals[self.cells_of(faces)])

    def normals_at_vertices(self) -> Floats:
        """(n, 3) the unit normals of all vertices of the original mesh; 0 if undefined."""
        return at_vertices(self.mesh, self._vertex_normals)

    def _normals_at(self, cells: Longs, weights: Floats) -> Floats:
        normals = self._normals[cells]
        s, t = weights.T
        # Edge k goes from corner k to the next; a place on two edges is their common corner.
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
    def _row_of(self) -> Longs:
        return np.argsort(self._tree.indices)

    @cached_property
    def _points(self) -> "spatial.cKDTree":
        return spatial.cKDTree(self.mesh.points)

    @cached_property
    def _normals(self) -> Floats:
        return face_normals(self.mesh.points, self.mesh.cells)

    @cached_property
    def _vertex_normals(self) -> Floats:
        return normals_by_completed_angle(self.mesh.points, self.mesh.cells)

    @cached_property
    def _across(self) -> Ints:
        return faces_across(self.mesh.cells)
