"""Values carried on from where they are known into the rest of a mesh: harmonic functions on its graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..libraries import sparse
from ..linear_solvers import Cholesky
from ..mesh import Floats, check_vertex_mask
from ..topology import edges


def harmonic_values(faces: ArrayLike, values: ArrayLike, known: ArrayLike) -> Floats:
    """Gives every vertex without a known value the mean of those of its neighbours: sum_j (x_j - x_i) = 0 [pinkall1993].

    By the maximum principle no value is beyond the known ones that it is connected with, so colours stay colours.

    Args:
        faces: (m, 3) triangles; vertices are neighbours if an edge joins them.
        values: (n, k) the values; those that are not known do not matter, unless no known vertex is connected with them.
        known: (n,) bool, which are known.

    Returns:
        (n, k) float64. Known values, and those of vertices that are connected with no known one, keep every bit.

    Raises:
        FilterInputError: the arrays do not fit.
    """
    found = np.array(values, dtype=np.float64)
    triangles = np.asarray(faces)
    if found.ndim != 2 or (len(triangles) and triangles.max() >= len(found)):
        raise FilterInputError(f"values of shape {found.shape} do not fit: there must be a row for every vertex of the faces")
    given = check_vertex_mask("known", known, len(found))
    ends = edges(np.ascontiguousarray(triangles, dtype=np.int32))
    n = len(found)
    graph = sparse.csr_array((np.ones(2 * len(ends)), (ends.T.ravel(), ends[:, ::-1].T.ravel())), shape=(n, n))
    _, label = sparse.csgraph.connected_components(graph, directed=False)
    reached = np.zeros(n, dtype=np.bool_)
    reached[label[given]] = True
    free = ~given & reached[label]
    if not free.any():
        return found
    degrees = np.asarray(graph.sum(axis=1)).ravel()
    system = sparse.diags_array(degrees[free]) - graph[free][:, free]
    found[free] = Cholesky(sparse.csr_matrix(system)).solve(graph[free][:, given] @ found[given])
    return found
