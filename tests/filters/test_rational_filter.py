"""Spectral filters by solves with one real pole, against eigenvectors and the polynomial."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebval

from pymeshfair.filters.spectral.eigenvector_free import filter_without_eigenvectors, rational_series
from pymeshfair.filters.spectral.problem import Response, enhance, low_pass, spectral_problem
from tests.filters.test_polynomial_filter import (
    MESHES,
    RESPONSES,
    against_modes,
    all_modes,
    filtered_by_modes,
    limited_to,
    posed,
    root_mean_square,
)
from tests.meshes import icosphere, with_caps


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
@pytest.mark.parametrize("response", RESPONSES)
@pytest.mark.parametrize("mesh", MESHES)
def test_the_error_is_within_its_estimate(mesh: str, response: str, tolerance: float) -> None:
    """The distance to the filter by all eigenvectors is at most what is reported, and that near the tolerance."""
    difference, found = against_modes(mesh, response, tolerance, "rational")
    assert root_mean_square(posed(mesh)[0], difference) <= found.error + 1e-12
    assert found.share <= 2.0 * tolerance


@pytest.mark.parametrize("response", [low_pass(1.0), low_pass(1.0, order=1), low_pass(1.0, order=4), enhance(1.0, 20.0)])
def test_the_series_holds_for_all_frequencies(response: Response) -> None:
    """The scalar function is within the error of the response from 0 to far beyond any mesh."""
    series, pole = rational_series(response, tolerance=1e-6)
    omega = np.concatenate([np.linspace(0.0, 30.0, 4000), np.geomspace(30.0, 1e12, 1000)])
    difference = np.abs(chebval(2.0 * pole / (omega**2 + pole) - 1.0, series.coefficients) - response.profile(omega))
    assert difference.max() <= series.error <= 1e-6


def test_thin_triangles_take_the_rational_route() -> None:
    """Caps of a height of 1e-5 would take thousands of products; solves stay about 30, and are exact."""
    vertices, faces = with_caps(1e-5)
    problem = spectral_problem(vertices, faces, operator="cotangent")
    values, bound, _, route, degree = filter_without_eigenvectors(problem, vertices, low_pass(4.0))
    assert route == "rational"
    assert degree < 40
    assert bound < 2e-5
    exact = filtered_by_modes(problem, *all_modes(problem), vertices, low_pass(4.0))
    assert root_mean_square(problem, values - exact) <= bound


def test_good_triangles_take_the_polynomial() -> None:
    """For waves of a few edges on a good mesh few products are enough."""
    vertices, faces = icosphere(3)
    filtered = filter_without_eigenvectors(spectral_problem(vertices, faces), vertices, low_pass(0.5))
    assert filtered.route == "polynomial"
    assert filtered.degree < 1000


def test_both_routes_agree() -> None:
    """On 10,000 vertices of noise the two differ by no more than both errors."""
    vertices, faces = icosphere(5)
    noisy = vertices + np.random.default_rng(0).normal(0.0, 0.002, vertices.shape)
    problem = spectral_problem(noisy, faces)
    one = filter_without_eigenvectors(problem, noisy, low_pass(0.8))
    with limited_to("rational"):
        other = filter_without_eigenvectors(problem, noisy, low_pass(0.8))
    assert (one.route, other.route) == ("polynomial", "rational")
    assert root_mean_square(problem, one.values - other.values) <= one.error + other.error
