"""Polygons to triangulate: the rim of a hole, joined by cuts with the islands in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..execution import Progress
from ..geometry import side_lengths
from ..libraries import sparse, spatial
from ..mesh import Floats, Ints, Longs
from ..topology import BoundaryLoop, OneRings
from .triangulation import triangulate_rim
from .vertex_pairs import VertexPairs, vertex_pairs

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
    """The rim with each island joined by the shortest cut to the polygon so far, the nearest island first.

    It begins after the longest edge of the rim: the triangulation depends slightly on its first corner, which must not depend on
    the numbers of the vertices.
    """
    first = int(side_lengths(points[rim.vertices]).argmax()) + 1
    vertices, opposite = np.roll(rim.vertices, -first), np.roll(rim.opposite, -first)
    rest = list(islands)
    while rest:
        best = (np.inf, 0, 0, 0)
        places, same_as = np.unique(points[vertices], axis=0, return_index=True)
        tree = spatial.cKDTree(places)
        for number, island in enumerate(rest):
            apart, nearest = tree.query(points[island.vertices])
            j = int(apart.argmin())
            best = min(best, (float(apart[j]), number, int(same_as[nearest[j]]), j))
        i, j = best[2:]
        island = rest.pop(best[1])
        around, beyond = np.roll(island.vertices, -j), np.roll(island.opposite, -j)
        # To the island, once round it, back, and on along the rim.
        cut = np.array([-1], dtype=np.int32)
        vertices = np.concatenate([vertices[: i + 1], around, around[:1], vertices[i:]])
        opposite = np.concatenate([opposite[:i], cut, beyond, cut, opposite[i:]])
    return Polygon(vertices, opposite)


def triangulate_polygon(outline: Polygon, points: Floats, joined: VertexPairs, progress: Progress) -> Ints | None:
    """(b, 3) the vertices of triangles that close the polygon; None if none of them is a manifold.

    Args:
        outline: the polygon.
        points: (n, 3) the vertices of the mesh.
        joined: which of its corners are joined by an edge already.
        progress: as for `triangulate_rim`.
    """
    corners = outline.vertices
    opposite = np.where(outline.opposite[:, None] < 0, np.nan, points[outline.opposite])
    forbidden = joined.with_pairs(*_corners_at_one_vertex(corners))
    for _ in range(_MOST_TRIES):
        triangles = triangulate_rim(points[corners], opposite, forbidden, progress=progress)
        if triangles is None:
            return None
        doubled = _doubled_diagonals(corners, triangles)
        if len(doubled) == 0:
            return np.asarray(corners[triangles])
        # Two corners at one vertex have got diagonals to the same vertex: forbid the second.
        forbidden = forbidden.with_pairs(doubled[:, 0], doubled[:, 1])
    return None


def _corners_at_one_vertex(corners: Ints) -> tuple[Longs, Longs]:
    """Every two corners of a polygon that are the same vertex."""
    order = np.argsort(corners, kind="stable")
    first, second = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    step = 1
    while (same := corners[order[step:]] == corners[order[:-step]]).any():
        first.append(order[:-step][same])
        second.append(order[step:][same])
        step += 1
    return np.concatenate(first), np.concatenate(second)


def _doubled_diagonals(corners: Ints, triangles: Ints) -> Longs:
    """(d, 2) the corners of the diagonals that join the same two vertices as another diagonal before them."""
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    ends, uses = np.unique(ends, axis=0, return_counts=True)
    diagonals = ends[uses == 2]
    _, first = np.unique(np.sort(corners[diagonals], axis=1), axis=0, return_index=True)
    return np.asarray(np.delete(diagonals, first, axis=0), dtype=np.int64)


def joined_corners(corners: Ints, rings: OneRings, place: Ints, more: dict[int, set[int]]) -> VertexPairs:
    """Which corners of a polygon are joined by an edge that is no side of it.

    Args:
        corners: (k,) the vertices of the polygon.
        rings: the neighbours of every vertex of the mesh.
        place: (n,) of -1, working memory that is left as it was.
        more: further neighbours of vertices, by edges of the patches made before.
    """
    k = len(corners)
    own, index = np.unique(corners, return_inverse=True)
    place[own] = np.arange(len(own), dtype=np.int32)
    ends: tuple[list[int], list[int]] = ([], [])
    for i, v in enumerate(own.tolist()):
        others = place[rings.neighbours[rings.offsets[v] : rings.offsets[v + 1]]]
        linked_to = others[others >= 0].tolist() + [int(place[w]) for w in more.get(v, ()) if place[w] >= 0]
        ends[0].extend([i] * len(linked_to))
        ends[1].extend(linked_to)
    place[own] = -1
    linked = sparse.csr_array((np.ones(len(ends[0])), ends), shape=(len(own), len(own)))
    at = sparse.csr_array((np.ones(k), (np.arange(k), index)), shape=(k, len(own)))
    first, second = (at @ linked @ at.T).nonzero()
    side = (np.abs(first - second) == 1) | (np.abs(first - second) == k - 1)
    return vertex_pairs(k, first[~side], second[~side])
