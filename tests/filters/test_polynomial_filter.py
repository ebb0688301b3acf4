"""Spectral filters by polynomials of the operator, against eigenvectors and closed forms."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
import scipy.linalg
from numpy.polynomial.chebyshev import chebval

from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.spectral import eigenvector_free
from pymeshfair.filters.spectral.eigenpairs import lowest_eigenpairs
from pymeshfair.filters.spectral.eigenvector_free import (
    Filtered,
    RouteName,
    chebyshev_series,
    filter_without_eigenvectors,
    gershgorin_bound,
    lanczos_bound,
    polynomial_filter,
    polynomial_series,
    symmetric_form,
)
from pymeshfair.filters.spectral.problem import Response, SpectralProblem, band_pass, enhance, low_pass, spectral_problem
from tests.meshes import Floats, Mesh, book, grid, icosphere, irregular_grid, torus, two_spheres, with_caps

MESHES = {
    "sphere": icosphere(2),
    "torus": torus(),
    "irregular": irregular_grid(),
    "two spheres": two_spheres(),
    "book": book(5),
    "caps": with_caps(1e-2),
}
RESPONSES = {
    "low pass": low_pass(1.5),
    "steep": low_pass(3.0, order=4),
    "band": band_pass(0.7, 2.0),
    "enhance": enhance(0.8, 3.0, gain=3.0),
}


@functools.cache
def posed(mesh: str) -> tuple[SpectralProblem, Floats, Floats]:
    """The problem of one of the meshes, its frequencies and modes, dense."""
    problem = spectral_problem(*MESHES[mesh])
    return problem, *all_modes(problem)


def all_modes(problem: SpectralProblem) -> tuple[Floats, Floats]:
    """(n,) frequencies and (n, n) modes by a dense solver."""
    root = np.sqrt(problem.mass)
    dense = problem.dirichlet.toarray() / np.outer(root, root)
    kappa, vectors = scipy.linalg.eigh((dense + dense.T) / 2.0)
    kappa[: problem.n_components] = 0.0
    return np.sqrt(kappa), vectors / root[:, None]


def filtered_by_modes(problem: SpectralProblem, omega: Floats, modes: Floats, values: Floats, response: Response) -> Floats:
    """Every mode times the response at its frequency."""
    result: Floats = modes @ (response(omega)[:, None] * (modes.T @ (problem.mass[:, None] * values)))
    return result


def root_mean_square(problem: SpectralProblem, values: Floats) -> float:
    """Over the surface."""
    return math.sqrt(float(problem.mass @ (values * values).sum(axis=1)) / float(problem.mass.sum()))


@contextmanager
def limited_to(route: RouteName) -> Iterator[None]:
    """A context in which a polynomial of any degree is taken, or none."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(eigenvector_free, "MOST_PRODUCTS", eigenvector_free.LARGEST_DEGREE if route == "polynomial" else 0)
        yield


def against_modes(mesh: str, response: str, tolerance: float, route: RouteName) -> tuple[Floats, Filtered]:
    """The difference from the filter by all eigenvectors, and the result."""
    vertices, _ = MESHES[mesh]
    problem, omega, modes = posed(mesh)
    with limited_to(route):
        found = filter_without_eigenvectors(problem, vertices, RESPONSES[response], tolerance=tolerance)
    return found.values - filtered_by_modes(problem, omega, modes, vertices, RESPONSES[response]), found


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize("response", RESPONSES)
@pytest.mark.parametrize("mesh", MESHES)
def test_the_error_is_within_its_bound(mesh: str, response: str, tolerance: float) -> None:
    """The distance to the filter by all eigenvectors is at most the bound, and the bound at most the tolerance."""
    difference, found = against_modes(mesh, response, tolerance, "polynomial")
    assert root_mean_square(posed(mesh)[0], difference) <= found.error + 1e-12
    assert found.share <= 1.01 * tolerance + 1e-11


def test_series_error_is_a_bound() -> None:
    """A Chebyshev series of a smooth function is within its error everywhere, and no shorter one promises the tolerance."""
    t = np.linspace(-1.0, 1.0, 20_001)

    def peak(x: Floats) -> Floats:
        return 1.0 / (1.0 + 400.0 * (x - 0.3) ** 2)

    for tolerance in (1e-2, 1e-5, 1e-9):
        series = chebyshev_series(peak, tolerance=tolerance, width=0.05, largest_degree=2000)
        error = np.abs(chebval(t, series.coefficients) - peak(t)).max()
        assert error <= series.error <= tolerance
        assert abs(series.coefficients[-1]) > 0.0


def test_narrow_features_are_not_missed() -> None:
    """A response at the far end of a huge spectrum is resolved, or the error is infinite, never small by oversight."""
    response = low_pass(2.0 * math.pi)
    series = polynomial_series(response, 1e6, tolerance=1e-6)
    assert series.degree == pytest.approx(8.7e3, rel=0.1)
    assert polynomial_series(response, 1e30, tolerance=1e-6).error == math.inf


@pytest.mark.parametrize("mesh", MESHES)
def test_bounds_of_the_spectrum_hold(mesh: str) -> None:
    """Both bounds are at least the largest eigenvalue; Lanczos's, where there is one, is the closer, within 10 %."""
    problem = spectral_problem(*MESHES[mesh])
    symmetric = symmetric_form(problem.dirichlet, problem.mass)
    largest = np.linalg.eigvalsh(symmetric.toarray())[-1]
    assert gershgorin_bound(symmetric, problem.mass) >= largest * (1.0 - 1e-12)
    closer = lanczos_bound(symmetric)
    assert largest <= closer
    assert closer <= 1.1 * largest or (closer == math.inf and len(problem.mass) < 100)


def test_too_low_a_bound_is_noticed() -> None:
    """Modes above the bound make the recurrence grow, and the result is refused."""
    vertices, faces = icosphere(2)
    problem = spectral_problem(vertices, faces)
    symmetric = symmetric_form(problem.dirichlet, problem.mass)
    bound = 0.3 * gershgorin_bound(symmetric, problem.mass)
    noise = np.random.default_rng(0).normal(size=(len(vertices), 1))
    series = polynomial_series(low_pass(1.0), bound, tolerance=1e-9)
    assert polynomial_filter(symmetric, problem.mass, noise, series, bound) is None


def test_recurrence_is_the_series() -> None:
    """On a diagonal operator the filter is the scalar series at each eigenvalue."""
    vertices, faces = grid(3, 3)
    problem = spectral_problem(vertices, faces)
    dense = symmetric_form(problem.dirichlet, problem.mass)
    kappa, vectors = np.linalg.eigh(dense.toarray())
    bound = 1.1 * float(kappa[-1])
    series = polynomial_series(low_pass(3.0), bound, tolerance=1e-3)
    done = polynomial_filter(dense, problem.mass, vectors / np.sqrt(problem.mass)[:, None], series, bound)
    assert done is not None
    expected = vectors * chebval(1.0 - 2.0 * kappa / bound, series.coefficients) / np.sqrt(problem.mass)[:, None]
    np.testing.assert_allclose(done, expected, atol=1e-13)


def test_a_wave_of_the_cutoff_comes_out_halved() -> None:
    """A cosine of the detail size along a flat rectangle, a mode of natural borders, keeps half its amplitude, to (h / l)^2."""
    vertices, faces = grid(10, 96, spacing=1.0 / 96.0)
    detail_size = 0.25
    wave = np.cos(2.0 * math.pi * vertices[:, 0] / detail_size)
    problem = spectral_problem(vertices, faces)
    values = filter_without_eigenvectors(problem, wave, low_pass(detail_size)).values
    ratio = float((problem.mass * values) @ wave) / float((problem.mass * wave) @ wave)
    # kappa is low by (omega h)^2 / 12, and F' = -2 ln 2 F per relative change of kappa.
    slack = 2.0 * math.log(2.0) * 0.5 * (2.0 * math.pi / detail_size / 96.0) ** 2 / 12.0
    assert 0.5 < ratio < 0.5 + 1.2 * slack
    np.testing.assert_allclose(values, ratio * wave, atol=0.01)


def moved(mesh: Mesh, by: float) -> Floats:
    """The vertices, by that far along each axis."""
    return mesh[0] + by


@pytest.mark.parametrize("response", RESPONSES)
def test_centroids_stay(response: str) -> None:
    """Each component keeps its centroid, weighted by area, and constants come out as they went in."""
    vertices, faces = two_spheres()
    problem = spectral_problem(vertices, faces)
    values = filter_without_eigenvectors(problem, vertices, RESPONSES[response]).values
    for label in range(2):
        part = problem.components == label
        weights = problem.mass[part] / problem.mass[part].sum()
        np.testing.assert_allclose(weights @ values[part], weights @ vertices[part], atol=1e-9)
    constant, bound, *_ = filter_without_eigenvectors(problem, np.full(len(vertices), 7.0), RESPONSES[response])
    np.testing.assert_allclose(constant, 7.0, atol=1e-13)
    assert bound <= 1e-13


def test_place_and_columns_do_not_matter() -> None:
    """Moved vertices come out moved as far, and columns filtered alone as together."""
    mesh = torus()
    problem = spectral_problem(*mesh)
    response = low_pass(1.5)
    together = filter_without_eigenvectors(problem, mesh[0], response).values
    away = filter_without_eigenvectors(problem, moved(mesh, 100.0), response).values
    np.testing.assert_allclose(away - 100.0, together, atol=1e-11)
    four = np.column_stack([mesh[0], mesh[0][:, 0]])
    wide = filter_without_eigenvectors(problem, four, response, tolerance=1e-9).values
    alone = filter_without_eigenvectors(problem, mesh[0][:, 0], response, tolerance=1e-9).values
    assert alone.shape == (len(four),)
    np.testing.assert_allclose(wide[:, 3], alone, atol=1e-8)
    np.testing.assert_array_equal(wide[:, 3], wide[:, 0])


def test_threads_and_runs_do_not_matter() -> None:
    """The same bits from one thread, from all threads, and again."""
    vertices, faces = icosphere(4)
    problem = spectral_problem(vertices, faces)
    allowed = allowed_threads()
    results = []
    try:
        for threads in (1, allowed, allowed):
            set_threads(threads)
            results.append(filter_without_eigenvectors(problem, vertices, low_pass(0.5)).values.tobytes())
    finally:
        set_threads(allowed)
    assert len(set(results)) == 1


def test_it_can_be_stopped() -> None:
    """An exception of `progress` ends the work between two products."""
    vertices, faces = icosphere(3)
    problem = spectral_problem(vertices, faces)
    told: list[float] = []

    def stop(done: float) -> None:
        told.append(done)
        if len(told) == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        filter_without_eigenvectors(problem, vertices, low_pass(1.0), progress=stop)
    assert told == sorted(told)
    assert told[-1] < 1.0


@pytest.mark.slow
def test_eigenvectors_and_polynomial_agree_on_a_scan() -> None:
    """Both give the same bunny to 1e-4 of its diagonal, for a response that has ended, but for 1e-6, at mode 100."""
    path = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "bunny.obj"
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    vertices, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    problem = spectral_problem(vertices, faces)
    kappa, modes = lowest_eigenpairs(problem, 100)
    omega = np.sqrt(kappa)
    omega[: problem.n_components] = 0.0
    detail_size = 2.0 * math.pi * low_pass(2.0 * math.pi).last_frequency(1e-6) / float(omega[-1])
    response = low_pass(detail_size)
    points = vertices[problem.vertices]
    by_modes = filtered_by_modes(problem, omega, modes, points, response)
    with limited_to("polynomial"):
        values, bound, *_ = filter_without_eigenvectors(problem, points, response)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    assert np.linalg.norm(values - by_modes, axis=1).max() <= 1e-4 * diagonal
    assert bound <= 1e-4 * diagonal
    assert np.linalg.norm(values - points, axis=1).max() >= 1e-2 * diagonal


def test_nothing_to_filter() -> None:
    """No vertices, or none that differ, give back what came in without an error."""
    nothing = spectral_problem(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))
    filtered = filter_without_eigenvectors(nothing, np.empty((0, 3)), low_pass(1.0))
    assert filtered.values.shape == (0, 3)
    assert (filtered.error, filtered.degree) == (0.0, 0)
