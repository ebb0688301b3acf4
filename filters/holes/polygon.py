"""The polygon that is triangulated to close a hole: its rim, with the islands in it joined to it by cuts."""

from typing import NamedTuple

import numpy as np

from ..execution import Progress
from ..geometry import side_lengths
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import BoundaryLoop, OneRings
from .triangulation import triangulate_rim

_MOST_TRIES = 20


class Polygon(NamedTuple):
    """A closed walk along border edges, and to an island and back along a cut.

    Attributes:
        vertices: (k,) int32 of the mesh, one a corner of the polygon. A vertex is several corners where a cut begins or ends, and
            where parts of the surface are attached by it alone.
        opposite: (k,) int32 the third vertex of the face of the mesh at the edge from each to the next, -1 at cuts.
    """

    vertices: Ints
    opposite: Ints


def polygon(rim: BoundaryLoop, islands: list[BoundaryLoop], points: Floats) -> Polygon:
    """The rim with each island joined by the shortest cut to what is joined already, the nearest island first.

    It begins after the longest edge of the rim: the triangulation depends slightly on its first corner, which must not depend on
    the numbers of the vertices.
    """
    first = int(side_lengths(points[rim.vertices]).argmax()) + 1
    vertices, opposite = np.roll(rim.vertices, -first), np.roll(rim.opposite, -first)
    rest = list(islands)
    while rest:
        best = (np.inf, 0, 0, 0)
        for which, island in enumerate(rest):
            apart = np.linalg.norm(points[vertices][:, None] - points[island.vertices], axis=2)
            nearest = int(apart.argmin())
            best = min(best, (float(apart.flat[nearest]), which, *divmod(nearest, apart.shape[1])))
        i, j = best[2:]
        island = rest.pop(best[1])
        around, beyond = np.roll(island.vertices, -j), np.roll(island.opposite, -j)
        # To the island, once round it, back, and on along the rim.
        cut = np.array([-1], dtype=np.int32)
        vertices = np.concatenate([vertices[: i + 1], around, around[:1], vertices[i:]])
        opposite = np.concatenate([opposite[:i], cut, beyond, cut, opposite[i:]])
    return Polygon(vertices, opposite)


def triangulate_polygon(outline: Polygon, points: Floats, joined: Bools, progress: Progress) -> Ints | None:
    """(b, 3) the vertices of triangles that close the polygon; None if there are none that leave a manifold.

    Args:
        outline: the polygon.
        points: (n, 3) the vertices of the mesh.
        joined: (k, k) which of its corners are joined by an edge already.
        progress: as for `triangulate_rim`.
    """
    corners = outline.vertices
    opposite = np.where(outline.opposite[:, None] < 0, np.nan, points[outline.opposite])
    forbidden = joined | (corners[:, None] == corners)
    for _ in range(_MOST_TRIES):
        triangles = triangulate_rim(points[corners], opposite, forbidden, progress=progress)
        if triangles is None:
            return None
        doubled = _doubled_diagonals(corners, triangles)
        if len(doubled) == 0:
            return np.asarray(corners[triangles])
        # Two corners at one vertex have got diagonals to the same vertex: forbid the second.
        forbidden[doubled[:, 0], doubled[:, 1]] = forbidden[doubled[:, 1], doubled[:, 0]] = True
    return None


def _doubled_diagonals(corners: Ints, triangles: Ints) -> Longs:
    """(d, 2) the corners of the diagonals that join the same two vertices as another diagonal before them."""
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    ends, uses = np.unique(ends, axis=0, return_counts=True)
    diagonals = ends[uses == 2]
    _, first = np.unique(np.sort(corners[diagonals], axis=1), axis=0, return_index=True)
    return np.asarray(np.delete(diagonals, first, axis=0), dtype=np.int64)


def joined_corners(corners: Ints, rings: OneRings, place: Ints, more: dict[int, set[int]]) -> Bools:
    """(k, k) which corners of a polygon are joined by an edge that is no side of it.

    Args:
        corners: (k,) the vertices of the polygon.
        rings: the neighbours of every vertex of the mesh.
        place: (n,) of -1, working memory that is left as it was.
        more: further neighbours of vertices, by edges of the patches made before.
    """
    k = len(corners)
    own, index = np.unique(corners, return_inverse=True)
    place[own] = np.arange(len(own), dtype=np.int32)
    linked = np.zeros((len(own), len(own)), dtype=np.bool_)
    for i, v in enumerate(own.tolist()):
        others = place[rings.neighbours[rings.offsets[v] : rings.offsets[v + 1]]]
        linked[i, others[others >= 0]] = True
        for w in more.get(v, ()):
            if place[w] >= 0:
                linked[i, place[w]] = True
    place[own] = -1
    joined = linked[np.ix_(index, index)]
    side = np.arange(k)
    joined[side, (side + 1) % k] = joined[(side + 1) % k, side] = False
    return joined
