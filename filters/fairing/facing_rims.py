"""The two rims of a mesh that face each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..libraries import spatial
from ..mesh import Ints, check_mesh, check_movable
from ..topology import boundary_loops, connected_components


def facing_rims(
    vertices: ArrayLike, faces: ArrayLike, *, among: ArrayLike | None = None, progress: Progress = ignore_progress
) -> tuple[Ints, Ints]:
    """The two rims that are nearest to each other, each in the direction of the faces that would close it.

    A rim is one of the `boundary_loops` that meets no vertex twice. The distance of two rims is the mean, over the vertices of
    both, of the distance to the nearest vertex of the other; each rim has the same weight.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        among: (n,) bool: only rims all of whose vertices are true, which may be of one component. None: all rims, but the two are
            of different components.
        progress: called with the share that is done; may raise to stop.

    Raises:
        FilterInputError: there are no two such rims.
    """
    points, triangles = check_mesh(vertices, faces)
    rims = [
        loop.vertices for loop in boundary_loops(points, triangles).loops if len(np.unique(loop.vertices)) == len(loop.vertices)
    ]
    component = connected_components(triangles, len(points))[0]
    if among is not None:
        chosen = check_movable(among, len(points))
        rims = [rim for rim in rims if chosen[rim].all()]
    second, first = np.tril_indices(len(rims), -1)
    if among is None:
        part = np.array([component[rim[0]] for rim in rims], dtype=np.int64)
        first, second = (ends[part[first] != part[second]] for ends in (first, second))
    if len(first) == 0:
        where = "of different components" if among is None else "all of whose vertices are selected"
        raise FilterInputError(
            f"there are no two rims {where} to join: {len(rims)} found; put both parts into one layer (merge the visible layers) "
            "and open each where they are to meet"
        )
    low, high = (np.array([bound(points[rim], axis=0) for rim in rims]) for bound in (np.min, np.max))
    gaps = np.linalg.norm(np.maximum(0.0, np.maximum(low[first] - high[second], low[second] - high[first])), axis=1)
    trees: dict[int, spatial.cKDTree] = {}
    nearest, found = np.inf, 0
    for step, k in enumerate(np.argsort(gaps, kind="stable")):
        if gaps[k] >= nearest:  # rims are at least as far apart as their boxes, and so are all pairs to come
            break
        progress(step / len(gaps))
        a, b = int(first[k]), int(second[k])
        for end in (a, b):
            if end not in trees:
                trees[end] = spatial.cKDTree(points[rims[end]])
        distance = (trees[a].query(trees[b].data)[0].mean() + trees[b].query(trees[a].data)[0].mean()) / 2
        if distance < nearest:
            nearest, found = distance, int(k)
    return rims[first[found]], rims[second[found]]
