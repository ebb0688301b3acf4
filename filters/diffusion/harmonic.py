"""Continues values over a part of a mesh: harmonic and biharmonic functions of the uniform Laplacian."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..libraries import sparse
from ..linear_solvers import Cholesky
from ..mesh import Bools, Floats, Ints, check_mesh, check_vertex_mask, mask_of
from ..topology import edges


def harmonic_values(faces: ArrayLike, values: ArrayLike, fixed: ArrayLike, *, order: Literal[1, 2] = 1) -> Floats:
    """Continues fixed values smoothly over the other vertices [pinkall1993].

    With order 1 every other vertex has the mean of its neighbours: K x = 0, (K x)_i = sum_j (x_i - x_j). By the maximum principle
    all values stay in the range of the fixed values of their component, so colours stay valid. With order 2 the values bend
    least: they minimise |D^-1 K x|^2, where D has the numbers of neighbours on its diagonal. Then slopes continue, too.

    Args:
        faces: (m, 3) triangles; vertices are neighbours if an edge joins them.
        values: (n, k) the values. Components without a fixed vertex keep them; elsewhere only fixed values are used.
        fixed: (n,) bool, the vertices that keep their values.
        order: 1 or 2.

    Returns:
        (n, k) float64. Fixed values, and those of components without a fixed vertex, keep every bit.

    Raises:
        FilterInputError: the arrays do not fit, `faces` are not (m, 3) vertex numbers, or another order.
        ConvergenceError: with order 2, rounding errors are too large, as on a strip of 50,000 edges with one fixed vertex.
    """
    if order not in (1, 2):
        raise FilterInputError(f"order is {order!r}: it must be 1 or 2")
    given = np.asarray(values, dtype=np.float64)
    if given.ndim != 2 or np.max(faces, initial=-1) >= len(given):
        raise FilterInputError(f"values of shape {given.shape} do not fit: there must be a row for every vertex of the faces")
    triangles = check_mesh(np.zeros((len(given), 3)), faces)[1]
    return harmonic_continuation(triangles, check_vertex_mask("fixed", fixed, len(given)), order=order)(given)


def harmonic_continuation(faces: Ints, fixed: Bools, *, order: Literal[1, 2]) -> Callable[[Floats], Floats]:
    """Returns `harmonic_values` as a function of the (n, k) values; its matrix is factorised only once."""
    ends, n = edges(np.ascontiguousarray(faces, dtype=np.int32)), len(fixed)
    graph = sparse.csr_array((np.ones(2 * len(ends)), (ends.T.ravel(), ends[:, ::-1].T.ravel())), shape=(n, n))
    count, label = sparse.csgraph.connected_components(graph, directed=False)
    free = ~fixed & mask_of(label[fixed], count)[label]
    if not free.any():
        return np.copy
    degrees = np.asarray(graph.sum(axis=1)).ravel()
    system = sparse.csr_matrix(sparse.diags_array(degrees) - graph)
    if order == 2:
        system = (system @ sparse.diags_array(1.0 / np.maximum(degrees, 1.0) ** 2) @ system).tocsr()
    rows = system[free]
    factors, from_fixed = Cholesky(rows[:, free]), -rows[:, fixed]

    def continued(values: Floats) -> Floats:
        result = values.copy()
        result[free] = factors.solve(from_fixed @ values[fixed])
        return result

    return continued
