"""Factors by fronts: they solve what SuperLU solves, whatever the graph, and refuse what is not positive definite."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse.linalg import splu

from pymeshfair.filters.checks import ConvergenceError
from pymeshfair.filters.compilation import single_thread
from pymeshfair.filters.linear_solvers import Cholesky, Fronts, ShiftedFactors
from pymeshfair.filters.operators import uniform_laplacian
from tests.meshes import icosphere


def of_graph(n: int, ends: np.ndarray) -> sparse.csr_matrix:
    """A positive definite matrix with an entry for each pair of ends."""
    weights = np.random.default_rng(0).uniform(0.1, 1.0, ends.shape[1])
    graph = sparse.csr_matrix((weights, (ends[0], ends[1])), shape=(n, n))
    graph = sparse.csr_matrix(graph + graph.T)
    return sparse.csr_matrix(sparse.diags_array(np.asarray(graph.sum(axis=1)).ravel() + 1.0) - graph)


def assert_solves(matrix: sparse.csr_matrix) -> None:
    """The solution of five right-hand sides is SuperLU's."""
    b = np.random.default_rng(1).normal(size=(matrix.shape[0], 5))
    assert np.allclose(Cholesky(matrix).solve(b), splu(sparse.csc_matrix(matrix)).solve(b), rtol=1e-10, atol=1e-12)


@given(st.integers(1, 400), st.integers(0, 900), st.integers(0, 2**32 - 1))
def test_every_graph_is_solved_as_by_superlu(n: int, edges: int, seed: int) -> None:
    """Also graphs in many pieces, without edges, or so dense that nothing separates them."""
    assert_solves(of_graph(n, np.random.default_rng(seed).integers(0, n, size=(2, edges))))


def test_hubs_that_touch_all_others_take_no_dense_matrix() -> None:
    """A double cone over a circle of 40,000, whose only level between its two tips is the circle, is solved as by SuperLU."""
    n = 40_000
    circle = np.arange(n)
    ends = np.array([[*circle, *circle, *circle], [*np.roll(circle, 1), *np.full(n, n), *np.full(n, n + 1)]])
    assert_solves(of_graph(n + 2, ends))


def test_a_hundred_thousand_pieces_take_no_quadratic_time() -> None:
    """A diagonal matrix is solved at once."""
    matrix = sparse.csr_matrix(sparse.diags_array(np.arange(1.0, 100_001.0)))
    assert np.allclose(Cholesky(matrix).solve(np.ones((100_000, 1)))[:, 0], 1.0 / np.arange(1.0, 100_001.0))


@pytest.mark.parametrize("pieces", [1, 3, 30])
def test_threads_change_no_bit(pieces: int) -> None:
    """Factors and solutions of large graphs, which threads share in parts, are those of one thread, and right."""
    side = int(np.sqrt(25_000 / pieces))
    numbers = np.arange(pieces * side * side).reshape(pieces, side, side)
    across, along = (numbers[:, :, :-1], numbers[:, :, 1:]), (numbers[:, :-1], numbers[:, 1:])
    matrix = of_graph(
        numbers.size, np.array([np.concatenate([a.ravel(), b.ravel()]) for a, b in zip(across, along, strict=True)])
    )
    right = np.random.default_rng(1).normal(size=(numbers.size, 5))
    fronts = Fronts.of(matrix)
    values, pivots = fronts.factors(matrix)
    x = fronts.solve(values, right)
    assert len(fronts.parts) >= min(pieces, 8)
    assert np.allclose(matrix @ x, right, rtol=0.0, atol=1e-12)
    with single_thread():
        alone = Fronts.of(matrix)
        for one, two in zip((*alone, *alone.factors(matrix)), (*fronts, values, pivots), strict=True):
            np.testing.assert_array_equal(one, two)
        np.testing.assert_array_equal(alone.solve(values, right), x)


def test_an_indefinite_matrix_is_refused() -> None:
    """Both where its diagonal shows it and where only its pivots do."""
    with pytest.raises(ConvergenceError, match="diagonal"):
        Cholesky(sparse.csr_matrix(np.diag([1.0, -1.0])))
    with pytest.raises(ConvergenceError, match="not positive definite to rounding"):
        Cholesky(sparse.csr_matrix(np.array([[1.0, 2.0], [2.0, 1.0]])))


def test_pivots_count_eigenvalues_below_a_shift() -> None:
    """As many as numpy finds."""
    matrix = sparse.csc_matrix(-uniform_laplacian(icosphere(3)[1], 642).stiffness)
    values = np.linalg.eigvalsh(matrix.toarray())
    for shift in (0.5, 3.3, 6.1):
        factors = ShiftedFactors(matrix, Fronts.of(matrix), shift, lambda done: None, 0.0)
        assert factors.below == int((values < factors.shift).sum())
