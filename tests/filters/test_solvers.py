"""The sparse solvers against dense and direct ones, and what they do where there is no solution."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from pymeshfair.filters.checks import ConvergenceError, FilterInputError
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.linear_solvers import SpdSolver, conjugate_gradients
from pymeshfair.filters.linear_solvers.conjugate_gradients import SmoothedAggregation
from pymeshfair.filters.linear_solvers.spd_solver import Solution
from pymeshfair.filters.operators import laplace_beltrami
from tests.meshes import Floats, Mesh, icosphere, irregular_grid, noisy


@pytest.fixture(autouse=True)
def _as_if_large(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Small systems are solved as large ones are, without factors, but in tests about sizes."""
    if "sizes" not in request.node.name:
        monkeypatch.setattr("pymeshfair.filters.linear_solvers.spd_solver._FACTORS_FOR_ONE", 0)
        monkeypatch.setattr("pymeshfair.filters.linear_solvers.spd_solver._FACTORS_FOR_MORE", 100_000)


def system(mesh: Mesh, edges: float) -> tuple[sparse.csr_matrix, Floats]:
    """M - t C with t = (edges mean edges)^2, divided by 1 + t, and three right-hand sides in its range."""
    vertices, faces = mesh
    laplacian = laplace_beltrami(vertices, faces)
    t = (edges * mean_edge_length(vertices, faces)) ** 2
    matrix = sparse.csr_matrix((sparse.diags_array(laplacian.mass) - t * laplacian.stiffness) / (1.0 + t))
    return matrix, t / (1.0 + t) * (laplacian.stiffness @ vertices)


def solved(matrix: sparse.csr_matrix, b: Floats, **options: Any) -> Solution:
    """The solution of one system."""
    return SpdSolver(matrix).solve(b, **options)


def energy(matrix: sparse.csr_matrix, x: Floats) -> float:
    """sqrt(x^T A x), over all columns."""
    return float(np.sqrt((x * (matrix @ x)).sum()))


def rough_sphere(subdivisions: int = 4) -> Mesh:
    """A sphere with noise of 0.15 edges, so that some weights are negative."""
    vertices, faces = icosphere(subdivisions)
    return noisy((vertices, faces), 0.15 * mean_edge_length(vertices, faces))


def rough_sheet() -> Mesh:
    """The mesh of the thread test: a sheet of several blocks of rows, with noise of an edge."""
    vertices, faces = irregular_grid(150, 150)
    vertices[:, 2] = np.random.default_rng(0).normal(size=len(vertices))
    return vertices, faces


@pytest.mark.parametrize(("edges", "method"), [(1.0, "jacobi"), (30.0, "multigrid"), (1e4, "multigrid")])
def test_agrees_with_a_direct_solver(edges: float, method: str) -> None:
    """Either way of conjugate gradients ends within its tolerance, in the energy norm, of what SuperLU gives."""
    matrix, b = system(rough_sphere(), edges)
    solution = solved(matrix, b, tolerance=1e-10)
    expected = spsolve(matrix.tocsc(), b)
    assert solution.method == method
    # The tolerance holds for an estimate of the error that the spread of the preconditioned spectrum blurs.
    assert energy(matrix, solution.values - expected) <= 10 * 1e-10 * energy(matrix, expected)


@pytest.mark.parametrize("edges", [1.0, 30.0])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_the_estimated_error_is_the_error(edges: float, tolerance: float) -> None:
    """The error that a solution reports is its true one in the energy norm, within a factor of five, and below the tolerance."""
    matrix, b = system(rough_sphere(), edges)
    expected = SpdSolver(matrix).by_factors(b).values
    solution = solved(matrix, b, tolerance=tolerance, reference=energy(matrix, expected))
    true = energy(matrix, solution.values - expected)
    assert true / 5 <= solution.error <= 5 * true
    assert solution.error <= 2 * tolerance * energy(matrix, expected)


def test_factors_solve_to_rounding() -> None:
    """A factorisation reports, and has, the backward error of a backward stable method."""
    matrix, b = system(rough_sphere(), 30.0)
    solution = SpdSolver(matrix).by_factors(b)
    scale = 1 / np.sqrt(matrix.diagonal())[:, None]
    scaled = sparse.diags_array(scale.ravel()) @ matrix @ sparse.diags_array(scale.ravel())
    residual = scale * (b - matrix @ solution.values)
    size = np.abs(scaled).sum(axis=1).max() * np.linalg.norm(solution.values / scale) + np.linalg.norm(scale * b)
    assert solution.backward_error < 8 * np.finfo(float).eps
    assert solution.backward_error == pytest.approx(np.linalg.norm(residual) / size, rel=1e-6)


def test_factors_pay_for_many_solves() -> None:
    """Told of many solves with a small matrix the solver factorises for the second, and gives the same solution."""
    matrix, b = system(rough_sphere(3), 1.0)
    solver = SpdSolver(matrix, solves=10)
    assert solver.solve(b).method == "jacobi"
    many = solver.solve(b)
    assert many.method == "cholesky"
    assert np.abs(many.values - solved(matrix, b, tolerance=1e-12).values).max() < 1e-10 * np.abs(many.values).max()


@pytest.mark.parametrize(("edges", "method"), [(0.1, "jacobi"), (10.0, "cholesky"), (1e4, "cholesky")])
def test_factors_solve_systems_of_small_sizes(edges: float, method: str) -> None:
    """Where the diagonal is no good preconditioner, a small system is solved by factors at once, as SuperLU solves it."""
    matrix, b = system(rough_sphere(), edges)
    solution = solved(matrix, b, tolerance=1e-10)
    assert solution.method == method
    expected = spsolve(matrix.tocsc(), b)
    assert energy(matrix, solution.values - expected) <= 1e-9 * energy(matrix, expected)


@pytest.mark.parametrize("edges", [10.0, 1e3, 1e6])
def test_multigrid_steps_do_not_grow(edges: float) -> None:
    """The steps of multigrid are few for any step length and grow by less than half from 642 times 4 to 642 times 16 unknowns."""
    steps = [solved(*system(icosphere(level), edges), tolerance=1e-8).iterations for level in (4, 5)]
    assert steps[0] <= 20
    assert steps[1] <= 1.5 * steps[0]


def test_multigrid_is_symmetric_and_positive() -> None:
    """One cycle of multigrid is a symmetric positive definite operator, as conjugate gradients need."""
    matrix, _ = system(rough_sphere(), 30.0)
    cycle = SmoothedAggregation(matrix)
    assert len(cycle._levels) >= 1
    r, s = np.random.default_rng(0).normal(size=(2, matrix.shape[0], 3))
    through_r, through_s = cycle(r).copy(), cycle(s).copy()
    assert np.allclose((s * through_r).sum(axis=0), (r * through_s).sum(axis=0), rtol=1e-10)
    assert ((r * through_r).sum(axis=0) > 0).all()


def test_multigrid_of_a_diagonal_matrix_is_exact() -> None:
    """On a diagonal matrix, where there is nothing to aggregate, one cycle is exact."""
    diagonal = np.random.default_rng(0).uniform(1, 2, 3000)
    cycle = SmoothedAggregation(sparse.csr_matrix(sparse.diags_array(diagonal)))
    b = np.random.default_rng(1).normal(size=(3000, 3))
    assert np.allclose(cycle(b), b / diagonal[:, None], rtol=1e-15)


@pytest.mark.parametrize("columns", [0, 1, 2, 3, 5])
def test_any_number_of_right_hand_sides(columns: int) -> None:
    """Right-hand sides are solved for in threes, and the answer has their shape and order."""
    matrix, _ = system(icosphere(2), 1.0)
    b = np.random.default_rng(0).normal(size=(matrix.shape[0], columns))
    solution = solved(matrix, b, tolerance=1e-12)
    expected = np.linalg.solve(matrix.toarray(), b)
    assert solution.values.shape == b.shape
    assert np.abs(solution.values - expected).max(initial=0.0) < 1e-9 * np.abs(expected).max(initial=1.0)
    assert columns == 0 or solved(matrix, b[:, 0]).values.shape == (matrix.shape[0],)


def test_nothing_to_solve() -> None:
    """A right-hand side of zeros has the solution 0, without a step; so does a system without equations."""
    matrix, b = system(icosphere(2), 1.0)
    solution = solved(matrix, 0 * b)
    assert solution.iterations == 0
    assert (solution.values == 0).all()
    assert solved(sparse.csr_matrix((0, 0)), np.empty((0, 3))).values.shape == (0, 3)
    assert SpdSolver(sparse.csr_matrix((0, 0))).by_factors(np.empty((0, 3))).values.shape == (0, 3)
    assert SpdSolver(matrix).by_factors(b[:, :0]).values.shape == (len(b), 0)


def test_a_good_guess_saves_the_work() -> None:
    """Started from its own answer the solver takes no step and changes nothing."""
    matrix, b = system(rough_sphere(3), 1.0)
    first = solved(matrix, b, tolerance=1e-8)
    second = solved(matrix, b, tolerance=1e-8, start=first.values)
    assert second.iterations <= 1
    assert np.abs(second.values - first.values).max() <= 1e-8 * np.abs(first.values).max()


def test_the_scale_of_the_unknowns_makes_no_difference() -> None:
    """Unknowns measured in other units, powers of two from 2^-30 to 2^30, give the same solution bit by bit."""
    matrix, b = system(rough_sphere(), 1.0)
    units = 2.0 ** np.random.default_rng(0).integers(-30, 31, matrix.shape[0])
    scaled = sparse.csr_matrix(sparse.diags_array(units) @ matrix @ sparse.diags_array(units))
    x = conjugate_gradients(matrix, b, target=0.0, max_iterations=40).values
    in_units = conjugate_gradients(scaled, units[:, None] * b, target=0.0, max_iterations=40).values
    assert np.array_equal(units[:, None] * in_units, x)


def test_singular_but_consistent() -> None:
    """A Laplace operator alone, singular, is solved up to a constant where the right-hand side sums to 0."""
    vertices, faces = rough_sphere()
    stiffness = -laplace_beltrami(vertices, faces).stiffness
    b = stiffness @ vertices
    b -= b.mean(axis=0)
    x = solved(sparse.csr_matrix(stiffness), b, tolerance=1e-10).values
    difference = (x - x.mean(axis=0)) - (vertices - vertices.mean(axis=0))
    assert np.abs(difference).max() < 1e-8


def test_singular_systems_have_no_factors_however_many_are_solved() -> None:
    """Solved many times, a Laplace operator alone gives the same bits each time: its factors do not exist."""
    stiffness = sparse.csr_matrix(-laplace_beltrami(*rough_sphere()).stiffness)
    right_side = stiffness @ rough_sphere()[0]
    solver = SpdSolver(stiffness, solves=8)
    assert len({solver.solve(right_side).values.tobytes() for _ in range(3)}) == 1


def test_callers_arrays_are_left_alone() -> None:
    """Neither the matrix, though its arrays are views into others, nor the right-hand side is written to."""
    matrix, b = system(icosphere(3), 30.0)
    whole = [np.concatenate([[0], array, [0]]) for array in (matrix.data, matrix.indices, matrix.indptr)]
    kept = [array.copy() for array in whole]
    view = sparse.csr_matrix(tuple(array[1:-1] for array in whole), shape=matrix.shape)
    b.flags.writeable = False
    expected = spsolve(matrix.tocsc(), b)
    for solution in (solved(view, b), SpdSolver(view).by_factors(b)):
        assert np.abs(solution.values - expected).max() < 1e-8 * np.abs(expected).max()
    assert all(np.array_equal(array, before) for array, before in zip(whole, kept, strict=True))


def test_progress_is_told_and_may_stop_the_work() -> None:
    """Progress never goes back, stays in [0, 1], is told every few steps, and an exception of it comes through at once."""
    matrix, b = system(rough_sphere(5), 1.0)
    told: list[float] = []
    solution = solved(matrix, b, progress=told.append)
    assert told == sorted(told)
    assert 0.0 <= min(told) <= max(told) <= 1.0
    assert len(told) >= solution.iterations // 5

    calls = []

    def stop(done: float) -> None:
        calls.append(done)
        if len(calls) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solved(matrix, b, progress=stop)
    assert len(calls) == 3


def test_an_indefinite_matrix_is_an_error() -> None:
    """Where no method can succeed the error names the size and the residual that was reached."""
    matrix, b = system(icosphere(3), 1.0)
    indefinite = sparse.csr_matrix(matrix - 0.999 * sparse.diags_array(matrix.diagonal()))
    with pytest.raises(ConvergenceError, match=r"backward error of .* 642 equations.*not positive definite"):
        solved(indefinite, b)
    with pytest.raises(ConvergenceError, match="not positive definite"):
        SpdSolver(indefinite).by_factors(b)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.ones((2, 3)), "square"),
        (np.diag([1.0, 0.0]), r"diagonal entry 1 is 0\.0"),
        (np.diag([1.0, -2.0]), r"diagonal entry 1 is -2\.0"),
        (np.diag([1.0, np.nan]), "diagonal entry 1 is nan"),
        (np.array([[1.0, np.inf], [np.inf, 1.0]]), "not finite"),
    ],
)
def test_matrices_that_are_refused(matrix: NDArray[np.float64], message: str) -> None:
    """A matrix that no system can have is refused with the reason."""
    with pytest.raises(FilterInputError, match=message):
        solved(sparse.csr_matrix(matrix), np.ones(matrix.shape[0]))


@pytest.mark.parametrize("b", [np.ones(3), np.ones((3, 3)), np.array([1.0, np.nan])])
def test_right_hand_sides_that_are_refused(b: NDArray[np.float64]) -> None:
    """A right-hand side of another length, or one that is not finite, is refused."""
    with pytest.raises(FilterInputError, match="right-hand side of 2 rows"):
        solved(sparse.csr_matrix(np.eye(2)), b)


_DIGEST = """
import hashlib
from pymeshfair.filters.compilation import allowed_threads
from pymeshfair.filters import execution
from pymeshfair.filters.diffusion.implicit import implicit_fairing
from pymeshfair.filters.linear_solvers import spd_solver
from tests.filters.test_solvers import rough_sheet

execution.SERIAL_BELOW = spd_solver._FACTORS_FOR_ONE = 0
vertices, faces = rough_sheet()
print(allowed_threads())
for time_step in (0.5, 100.0):
    print(hashlib.sha256(implicit_fairing(vertices, faces, time_step=time_step).tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_same_bits_for_any_number_of_threads() -> None:
    """A mesh of several blocks of rows comes out the same to the bit on one thread and on two, by both preconditioners."""
    digests = []
    for threads in ("1", "2"):
        environment = {**os.environ, "NUMBA_NUM_THREADS": threads}
        run = subprocess.run([sys.executable, "-c", _DIGEST], env=environment, capture_output=True, text=True, check=True)
        used, *found = run.stdout.split()
        assert used == threads
        digests.append(found)
    assert len(set(digests[0])) == 2
    assert digests[0] == digests[1]


def test_the_mesh_of_the_thread_test_uses_both_preconditioners() -> None:
    """A time step of half a squared edge is solved with the diagonal, one of a hundred with multigrid."""
    vertices, faces = rough_sheet()
    methods = []
    for t in (0.5, 100.0):
        laplacian = laplace_beltrami(vertices, faces)
        matrix = sparse.csr_matrix(sparse.diags_array(laplacian.mass) - t * laplacian.stiffness)
        methods.append(solved(matrix, laplacian.stiffness @ vertices, tolerance=1e-8).method)
    assert methods == ["jacobi", "multigrid"]
