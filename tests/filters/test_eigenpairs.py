"""The eigensolver, against closed forms, dense matrices and itself."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest
from scipy import linalg
from threadpoolctl import threadpool_info, threadpool_limits

from pymeshfair.filters.checks import ConvergenceError, FilterInputError
from pymeshfair.filters.libraries import one_blas_thread
from pymeshfair.filters.linear_solvers import ShiftedFactors
from pymeshfair.filters.spectral import eigenpairs
from pymeshfair.filters.spectral.eigenpairs import lowest_eigenpairs
from pymeshfair.filters.spectral.problem import SpectralProblem, spectral_problem
from tests.meshes import Mesh, book, grid, icosphere, irregular_grid, noisy, renumbered, sample, torus, tube, two_spheres


def residual(problem: SpectralProblem, kappa: np.ndarray, modes: np.ndarray) -> float:
    """The largest |S v - kappa M v| in the norm of M^-1 as a share of kappa, of the least kappa above 0 for those that are 0."""
    rest = (problem.dirichlet @ modes - problem.mass[:, None] * modes * kappa) / np.sqrt(problem.mass)[:, None]
    least = kappa[kappa > 1e-9 * kappa[-1]].min()
    return float((np.linalg.norm(rest, axis=0) / np.maximum(kappa, least)).max())


def deviation(problem: SpectralProblem, modes: np.ndarray) -> float:
    """The largest entry of |V^T M V - I|."""
    return float(np.abs(modes.T @ (problem.mass[:, None] * modes) - np.eye(modes.shape[1])).max())


def dense(problem: SpectralProblem) -> np.ndarray:
    """All eigenvalues, by LAPACK."""
    root = 1.0 / np.sqrt(problem.mass)
    with threadpool_limits(limits=1):
        return np.asarray(linalg.eigvalsh(root[:, None] * problem.dirichlet.toarray() * root))


def test_sphere_eigenvalues_tend_to_the_closed_form_at_order_two() -> None:
    """On a sphere of radius r, l (l + 1) / r^2 comes 2 l + 1 times, up to l = 10, with an error that falls to a quarter."""
    radius = 1.7
    degree = np.repeat(np.arange(11), 2 * np.arange(11) + 1)
    exact = degree * (degree + 1) / radius**2
    errors = []
    for level in (3, 4, 5):
        kappa, _ = lowest_eigenpairs(spectral_problem(*icosphere(level, radius)), len(exact))
        errors.append(np.abs(kappa[1:] - exact[1:]) / exact[1:])
    # A mesh of edges h differs by c kappa h^2; h is 0.03 of the radius on the finest, kappa 110 / r^2.
    assert errors[2].max() < 0.015
    rate = np.log2([errors[k].reshape(-1)[m] / errors[k + 1][m] for k in (1,) for m in range(len(exact) - 1)])
    assert 1.8 < np.median(rate) < 2.2
    assert rate.min() > 1.5


@pytest.mark.parametrize("size", [(20, 30), (40, 50)])
def test_rectangle_has_the_modes_of_natural_borders(size: tuple[int, int]) -> None:
    """On a a x b rectangle pi^2 (i^2 / a^2 + j^2 / b^2): cosines, which the lumped five-point stencil gives in closed form."""
    rows, columns = size
    problem = spectral_problem(*grid(rows, columns))
    kappa, _ = lowest_eigenpairs(problem, 60)
    i, j = np.meshgrid(np.arange(rows + 1), np.arange(columns + 1), indexing="ij")
    stencil = np.sort((4 * np.sin(np.pi * i / (2 * rows)) ** 2 + 4 * np.sin(np.pi * j / (2 * columns)) ** 2).ravel())
    np.testing.assert_allclose(kappa, stencil[:60], rtol=1e-9, atol=1e-12)
    smooth = np.sort((np.pi**2 * ((i / rows) ** 2 + (j / columns) ** 2)).ravel())
    # sin(x)^2 = x^2 (1 - x^2 / 3 + ...): what the stencil is off by.
    np.testing.assert_allclose(kappa[1:], smooth[1:60], rtol=smooth[59] / 12)


def flat_torus(n: int) -> SpectralProblem:
    """A square of n x n vertices whose opposite sides are one: a surface that no coordinates embed, built by hand."""
    from scipy import sparse

    ring = sparse.diags_array([2.0, -1.0, -1.0, -1.0, -1.0], offsets=[0, 1, -1, n - 1, 1 - n], shape=(n, n))
    one = sparse.eye_array(n)
    stiffness = sparse.csr_matrix(sparse.kron(ring, one) + sparse.kron(one, ring))
    rows = np.arange(n * n, dtype=np.int32)
    return SpectralProblem(stiffness, np.ones(n * n), rows, np.zeros(n * n, dtype=np.int32), n * n)


@pytest.mark.parametrize("count", [1, 2, 5, 100, 333])
def test_multiple_eigenvalues_of_a_flat_torus_are_all_found(count: int) -> None:
    """A flat torus has eigenvalues of multiplicity 4, 8 and 12; as many as were asked for come, also from within a cluster."""
    problem = flat_torus(40)
    kappa, modes = lowest_eigenpairs(problem, count)
    wave = 4 * np.sin(np.pi * np.arange(40) / 40) ** 2
    np.testing.assert_allclose(kappa, np.sort(np.add.outer(wave, wave).ravel())[:count], rtol=1e-9, atol=1e-12)
    assert deviation(problem, modes) < 1e-9


MESHES: dict[str, Mesh] = {
    "noisy sphere": noisy(icosphere(3), 0.01),
    "torus": torus(36, 30),
    "long tube": tube(8, 110, 0.2, 30.0),
    "obtuse": irregular_grid(25, 35),
}


@pytest.mark.parametrize("name", MESHES)
def test_no_eigenvalue_is_left_out(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The eigenvalues are the lowest of LAPACK's, with the orthonormality and the residual promised, also in small bands."""
    monkeypatch.setattr(eigenpairs, "_BAND", 30)
    monkeypatch.setattr(eigenpairs, "_DENSE", 0)
    monkeypatch.setattr(eigenpairs, "_DENSE_LIMIT", 0)
    problem = spectral_problem(*MESHES[name])
    kappa, modes = lowest_eigenpairs(problem, 120)
    np.testing.assert_allclose(kappa, dense(problem)[:120], rtol=1e-8, atol=1e-9 * kappa[-1])
    assert deviation(problem, modes) < 1e-9
    assert residual(problem, kappa, modes) <= 1e-9


def test_a_search_that_misses_modes_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """When a band's search passes over an eigenvalue above its shift, the count of the next notices and it is searched for."""
    searched = eigenpairs.modes_near
    dropped: list[int] = []

    def careless(factors: ShiftedFactors, locked: np.ndarray, **rest: Any) -> tuple[np.ndarray, np.ndarray]:
        kappa, modes = searched(factors, locked, **rest)
        above = np.flatnonzero(kappa > factors.shift)
        if not dropped and len(above) > 3:
            dropped.append(int(above[2]))
            keep = np.arange(len(kappa)) != above[2]
            return kappa[keep], modes[:, keep]
        return kappa, modes

    monkeypatch.setattr(eigenpairs, "modes_near", careless)
    problem = spectral_problem(*noisy(icosphere(3), 0.01))
    kappa, modes = lowest_eigenpairs(problem, 60)
    assert dropped
    np.testing.assert_allclose(kappa[1:], dense(problem)[1:60], rtol=1e-8)
    assert deviation(problem, modes) < 1e-9


def test_multiplicity_above_the_block_takes_a_second_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """With blocks of two vectors the eightfold eigenvalues of a torus are complete nevertheless."""
    monkeypatch.setattr(eigenpairs, "BLOCK", 2)
    kappa, modes = lowest_eigenpairs(flat_torus(30), 60)
    wave = 4 * np.sin(np.pi * np.arange(30) / 30) ** 2
    np.testing.assert_allclose(kappa, np.sort(np.add.outer(wave, wave).ravel())[:60], rtol=1e-9, atol=1e-12)
    assert deviation(flat_torus(30), modes) < 1e-9


def test_components_are_solved_for_one_by_one_and_merged() -> None:
    """Two equal spheres have every eigenvalue twice, each mode on one of them alone; a third component counts by its own size."""
    problem = spectral_problem(*two_spheres())
    kappa, modes = lowest_eigenpairs(problem, 50)
    alone, _ = lowest_eigenpairs(spectral_problem(*icosphere(2)), 25)
    np.testing.assert_allclose(kappa, np.repeat(alone, 2), rtol=1e-9, atol=1e-9)
    half = np.abs(modes[problem.components == 0]).max(axis=0) > 0
    assert (half != (np.abs(modes[problem.components == 1]).max(axis=0) > 0)).all()
    small, large = icosphere(2, 0.1), icosphere(3)
    both = np.concatenate([small[0] + 3.0, large[0]]), np.concatenate([small[1], large[1] + np.int32(len(small[0]))])
    problem = spectral_problem(*both)
    kappa, modes = lowest_eigenpairs(problem, 200)
    np.testing.assert_allclose(kappa, dense(problem)[:200], rtol=1e-8, atol=1e-8)
    assert deviation(problem, modes) < 1e-9


def test_first_mode_is_constant_and_signs_survive_rounding() -> None:
    """The first mode is 1 / sqrt(area); a mesh moved by rounding errors has the same modes with the same signs."""
    vertices, faces = noisy(icosphere(4), 0.02)
    problem = spectral_problem(vertices, faces)
    kappa, modes = lowest_eigenpairs(problem, 80)
    assert kappa[0] == 0.0
    np.testing.assert_allclose(modes[:, 0], 1.0 / np.sqrt(problem.mass.sum()), rtol=1e-13)
    moved = vertices * (1.0 + 1e-13 * np.random.default_rng(1).normal(size=vertices.shape))
    _, again = lowest_eigenpairs(spectral_problem(moved, faces), 80)
    # The rotation of two modes is the change, 1e-13 times a kappa of up to 100, over their gap.
    assert np.abs(again - modes).max() < 1e-6


def test_numbering_and_size_do_not_matter() -> None:
    """Renumbered, a mesh has the same eigenvalues; made c times as large, they are divided by c squared, to 1e-100 and 1e100."""
    mesh = noisy(icosphere(4), 0.02)
    kappa, _ = lowest_eigenpairs(spectral_problem(*mesh), 40)
    vertices, faces, _ = renumbered(mesh)
    np.testing.assert_allclose(lowest_eigenpairs(spectral_problem(vertices, faces), 40)[0], kappa, rtol=1e-9, atol=1e-12)
    for scale in (1e-100, 1e100):
        other, _ = lowest_eigenpairs(spectral_problem(mesh[0] * scale, mesh[1]), 40)
        np.testing.assert_allclose(other * scale**2, kappa, rtol=1e-9, atol=1e-12)


def test_non_manifold_meshes_have_modes() -> None:
    """Pages that share an edge are one surface to the robust operator, with one constant mode and all of its others."""
    problem = spectral_problem(*book(5))
    kappa, modes = lowest_eigenpairs(problem, 10)
    assert len(kappa) == 7
    assert kappa[1] > 1e-3
    assert deviation(problem, modes) < 1e-9


def graded_disc(around: int, rings: int) -> Mesh:
    """A flat disc of rings that shrink towards the centre, all triangles of the same shape."""
    radius = np.exp(-2 * np.pi / around) ** np.arange(rings)
    turned = 0.5 * (np.arange(rings) % 2)
    angle = 2 * np.pi * (np.arange(around) + turned[:, None]) / around
    points = np.stack([radius[:, None] * np.cos(angle), radius[:, None] * np.sin(angle), 0 * angle], axis=-1).reshape(-1, 3)
    faces = []
    for ring in range(rings - 1):
        for k in range(around):
            here, right = ring * around + k, ring * around + (k + 1) % around
            inner, inner_right = here + around, right + around
            faces += [[here, right, inner], [right, inner_right, inner]] if ring % 2 == 0 else []
            faces += [[here, right, inner_right], [here, inner_right, inner]] if ring % 2 else []
    last = (rings - 1) * around
    faces += [[last + k, last + (k + 1) % around, len(points)] for k in range(around)]
    return np.vstack([points, np.zeros(3)]), np.array(faces, dtype=np.int32)


@pytest.mark.parametrize("rings", [20, 30, 45])
def test_triangles_of_all_sizes_do_not_drown_the_lowest_modes(rings: int) -> None:
    """Triangles that shrink to 6e-11 change the waves of a disc by no more than their share of its area."""
    coarse, _ = lowest_eigenpairs(spectral_problem(*graded_disc(12, 12)), 8)
    problem = spectral_problem(*graded_disc(12, rings))
    kappa, modes = lowest_eigenpairs(problem, 8)
    # Beyond ring 12 there are exp(-4 pi) of the area, 3.5e-6.
    np.testing.assert_allclose(kappa, coarse, rtol=1e-4, atol=1e-12)
    assert deviation(problem, modes) < 1e-9


def test_modes_that_rounding_drowns_are_refused() -> None:
    """All modes of a disc whose eigenvalues span 20 orders of magnitude: the message says why and what to do."""
    problem = spectral_problem(*graded_disc(12, 45))
    with pytest.raises(ConvergenceError, match="differ too much in size or shape; take fewer modes, filter without"):
        lowest_eigenpairs(problem, 541)


def test_constant_modes_may_be_left_out() -> None:
    """Without them the modes are the same, as many as were asked for, down to the last of all components."""
    problem = spectral_problem(*two_spheres())
    n = len(problem.mass)
    kappa, modes = lowest_eigenpairs(problem, 32)
    some, waves = lowest_eigenpairs(problem, 30, constants=False)
    np.testing.assert_allclose(some, kappa[2:], rtol=1e-9)
    np.testing.assert_allclose(np.abs(problem.mass @ waves), 0.0, atol=1e-9)
    assert deviation(problem, np.hstack([modes[:, :2], waves])) < 1e-9
    assert lowest_eigenpairs(problem, n, constants=False)[1].shape == (n, n - 2)


def test_counts_at_the_ends() -> None:
    """None is none, one is the constant, more than there are is all; a negative count is refused."""
    problem = spectral_problem(*icosphere(1))
    assert lowest_eigenpairs(problem, 0)[1].shape == (42, 0)
    assert lowest_eigenpairs(problem, 1)[0].tolist() == [0.0]
    assert lowest_eigenpairs(problem, 100)[1].shape == (42, 42)
    empty = spectral_problem(np.zeros((3, 3)), np.zeros((0, 3), dtype=np.int32))
    assert lowest_eigenpairs(empty, 5)[1].shape == (0, 0)
    with pytest.raises(FilterInputError, match="count is -1"):
        lowest_eigenpairs(problem, -1)


DIGEST = """
import hashlib, sys
from pymeshfair.filters.compilation import set_threads
from pymeshfair.filters.spectral.eigenpairs import lowest_eigenpairs
from pymeshfair.filters.spectral.problem import spectral_problem
from tests.meshes import icosphere, noisy
set_threads(int(sys.argv[1]))
kappa, modes = lowest_eigenpairs(spectral_problem(*noisy(icosphere(4), 0.01)), 130)
print(hashlib.sha256(kappa.tobytes() + modes.tobytes()).hexdigest())
"""


def test_bits_are_the_same_in_other_processes_and_with_other_threads() -> None:
    """Two further processes, one with a thread and one with two for BLAS and kernels, give the bits of this one."""
    kappa, modes = lowest_eigenpairs(spectral_problem(*noisy(icosphere(4), 0.01)), 130)
    ours = hashlib.sha256(kappa.tobytes() + modes.tobytes()).hexdigest()
    for threads in ("1", "2"):
        limits = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), threads)
        told = subprocess.run(
            [sys.executable, "-c", DIGEST, threads if (os.cpu_count() or 1) > 1 else "1"],
            env={**os.environ, **limits, "NUMBA_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        )
        assert told.stdout.strip() == ours


def test_blas_has_one_thread_until_the_last_context_is_left() -> None:
    """Where two threads need the limit, the first that leaves does not lift it for the other; the last gives back two threads."""

    def counts() -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    first, second = one_blas_thread(), one_blas_thread()
    with threadpool_limits(2, "blas"):
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        inside = counts()
        second.__exit__(None, None, None)
        assert (inside, counts()) == ({1}, {2})


def test_blas_has_one_thread_in_a_second_thread_of_a_program() -> None:
    """Whichever thread of a program has set limits before, in the context the libraries have one thread, and two afterwards."""

    def counts() -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    def in_context() -> None:
        with one_blas_thread():
            inside.append(counts())

    inside: list[set[int]] = []
    with threadpool_limits(2, "blas"):
        for _ in range(2):
            worker = threading.Thread(target=in_context)
            worker.start()
            worker.join()
            in_context()
        assert (inside, counts()) == ([{1}] * 4, {2})


@pytest.mark.slow
def test_an_interrupted_solve_stops_within_a_second_and_leaves_nothing() -> None:
    """Raised from `progress` at any time, the exception comes out within a second, and soon no thread of ours is left."""

    class StopItError(Exception):
        pass

    vertices, faces = sample("bunny.obj")
    problem = spectral_problem(vertices, faces)
    ring = spectral_problem(*torus(50, 30))
    before = threading.active_count()
    for patience, case, count in ((0.0, problem, 1000), (0.3, problem, 1000), (0.6, problem, 1000), (0.2, ring, 1500)):
        start = time.perf_counter()
        asked: list[float] = []

        def progress(done: float, start: float = start, patience: float = patience, asked: list[float] = asked) -> None:
            assert 0.0 <= done <= 1.0
            if time.perf_counter() - start >= patience:
                asked.append(time.perf_counter())
                raise StopItError

        with pytest.raises(StopItError):
            lowest_eigenpairs(case, count, progress=progress)
        assert asked[-1] - start < patience + 1.0
        assert time.perf_counter() - asked[-1] < 1.0
    end = time.perf_counter() + 30.0  # the dense matrix is given its time
    while threading.active_count() > before and time.perf_counter() < end:
        time.sleep(0.1)
    assert threading.active_count() <= before


def test_progress_grows_to_one() -> None:
    """What is told never falls and ends at 1."""
    told: list[float] = []
    lowest_eigenpairs(spectral_problem(*noisy(icosphere(4), 0.01)), 250, progress=told.append)
    assert told[-1] == 1.0
    assert (np.diff(told) >= 0.0).all()
    assert len(told) > 20
