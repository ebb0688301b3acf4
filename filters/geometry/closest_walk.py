"""Closest points of a surface, by a walk from triangle to triangle that starts near."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Floats, Ints, Longs
from ..topology import vertex_faces
from .measures import closest_weights

# The most steps of one walk; queries start at most a few faces away.
_LONGEST_WALK = 64


class WalkableSurface(NamedTuple):
    """A triangle mesh with the faces at every vertex, so that a walk can go from a face to its neighbours."""

    points: Floats  # (n, 3) coordinates
    faces: Ints  # (m, 3) triangles
    offsets: Longs  # (n + 1,)
    around: Ints  # the faces at vertex i are ``around[offsets[i]:offsets[i + 1]]``, ascending

    @classmethod
    def of(cls, points: Floats, faces: Ints) -> "WalkableSurface":
        """The surface of (n, 3) coordinates and (m, 3) triangles."""
        around = vertex_faces(faces, len(points))
        return cls(points, faces, around.offsets, np.ascontiguousarray(around.rows[:, 0]))

    def first_faces(self) -> Ints:
        """(n,) int32 the lowest face at every vertex, from which a walk from the vertex may start; 0 if there is none."""
        has_faces = np.diff(self.offsets) > 0
        first = np.zeros(len(self.points), dtype=np.int32)
        first[has_faces] = self.around[self.offsets[:-1][has_faces]]
        return first

    def closest(self, queries: Floats, start: Ints, enough: float = 0.0) -> tuple[Floats, Ints, Floats]:
        """The (q, 3) points nearest to the queries, (q,) their faces, and (q,) the distances.

        Each walk goes from its start to the nearest of the faces that share a vertex with it, until none is nearer. So it stays
        on one sheet of the surface, and the distance is at least that to the whole surface.

        Args:
            queries: (q, 3) points.
            start: (q,) the face where each walk starts.
            enough: a walk also ends where the distance is at most this, in the unit of the points.
        """
        nearest, faces = np.empty_like(queries), np.array(start, dtype=np.int32)
        distances = np.empty(len(queries))
        with threads_for(len(queries)):
            _walk(self, queries, enough * enough, nearest, faces, distances)
        return nearest, faces, distances


@compiled
def _closest_on_triangle(points: Floats, a: int, b: int, c: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The point of the triangle nearest to (x, y, z)."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    s, t = closest_weights(ux, uy, uz, vx, vy, vz, x - points[a, 0], y - points[a, 1], z - points[a, 2])
    return points[a, 0] + s * ux + t * vx, points[a, 1] + s * uy + t * vy, points[a, 2] + s * uz + t * vz


@compiled
def nearest_by_walk(
    surface: WalkableSurface, x: float, y: float, z: float, start: int, enough: float
) -> tuple[float, float, float, int, float]:
    """`WalkableSurface.closest` of one point, for kernels: the nearest point, its face and the square of the distance.

    `enough` is a squared distance, too.
    """
    points, faces, offsets, around = surface
    face = start
    nx, ny, nz = _closest_on_triangle(points, faces[face, 0], faces[face, 1], faces[face, 2], x, y, z)
    best = (nx - x) ** 2 + (ny - y) ** 2 + (nz - z) ** 2
    for _ in range(_LONGEST_WALK):
        if best <= enough:
            break
        here = face
        for k in range(3):
            vertex = faces[here, k]
            for m in range(offsets[vertex], offsets[vertex + 1]):
                g = around[m]
                cx, cy, cz = _closest_on_triangle(points, faces[g, 0], faces[g, 1], faces[g, 2], x, y, z)
                square = (cx - x) ** 2 + (cy - y) ** 2 + (cz - z) ** 2
                if square < best:
                    best, face, nx, ny, nz = square, g, cx, cy, cz
        if face == here:
            break
    return nx, ny, nz, face, best


@compiled(parallel=True)
def _walk(surface: WalkableSurface, queries: Floats, enough: float, nearest: Floats, at: Ints, distances: Floats) -> None:
    for q in prange(queries.shape[0]):
        nearest[q, 0], nearest[q, 1], nearest[q, 2], at[q], square = nearest_by_walk(
            surface, queries[q, 0], queries[q, 1], queries[q, 2], at[q], enough
        )
        distances[q] = np.sqrt(square)
