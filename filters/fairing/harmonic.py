"""Harmonic functions on the graph of a mesh: values interpolated from fixed vertices."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..libraries import sparse
from ..linear_solvers import Cholesky
from ..mesh import Floats, check_vertex_mask, mask_of
from ..topology import edges


def harmonic_values(faces: ArrayLike, values: ArrayLike, fixed: ArrayLike) -> Floats:
    """Gives every vertex that is not fixed the mean of its neighbours: sum_j (x_j - x_i) = 0 [pinkall1993].

    By the maximum principle no value lies beyond the fixed ones of its component, so colours stay colours.

    Args:
        faces: (m, 3) triangles; vertices are neighbours if an edge joins them.
        values: (n, k) the values; those that are not fixed count only in components without a fixed vertex.
        fixed: (n,) bool, the vertices that keep their values.

    Returns:
        (n, k) float64. Fixed values, and those of components without a fixed vertex, keep every bit.

    Raises:
        FilterInputError: the arrays do not fit.
    """
    result = np.array(values, dtype=np.float64)
    triangles = np.asarray(faces)
    if result.ndim != 2 or (len(triangles) and triangles.max() >= len(result)):
        raise FilterInputError(f"values of shape {result.shape} do not fit: there must be a row for every vertex of the faces")
    is_fixed = check_vertex_mask("fixed", fixed, len(result))
    ends = edges(np.ascontiguousarray(triangles, dtype=np.int32))
    n = len(result)
    graph = sparse.csr_array((np.ones(2 * len(ends)), (ends.T.ravel(), ends[:, ::-1].T.ravel())), shape=(n, n))
    count, label = sparse.csgraph.connected_components(graph, directed=False)
    free = ~is_fixed & mask_of(label[is_fixed], count)[label]
    if not free.any():
        return result
    degrees = np.asarray(graph.sum(axis=1)).ravel()
    system = sparse.diags_array(degrees[free]) - graph[free][:, free]
    result[free] = Cholesky(sparse.csr_matrix(system)).solve(graph[free][:, is_fixed] @ result[is_fixed])
    return result
