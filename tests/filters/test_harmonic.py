"""Harmonic values on the graph of a mesh."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion import harmonic_values
from pymeshfair.filters.topology import edges
from tests.meshes import grid, icosphere


def test_linear_values_come_back_on_a_regular_grid() -> None:
    """Every inner vertex of a regular grid is the mean of its six neighbours, so linear functions are harmonic on it."""
    vertices, faces = grid(9)
    rim = (vertices[:, :2] == vertices[:, :2].min()).any(axis=1) | (vertices[:, :2] == vertices[:, :2].max()).any(axis=1)
    linear = vertices[:, :2] @ np.array([[1.0, 2.0], [3.0, -1.0]])
    found = harmonic_values(faces, np.where(rim[:, None], linear, 99.0), rim)
    np.testing.assert_allclose(found, linear, atol=1e-12 * np.abs(linear).max())
    assert np.array_equal(found[rim], linear[rim])


def test_every_value_is_the_mean_of_its_neighbours_and_none_is_beyond_the_known() -> None:
    """On a sphere with three known vertices: the definition, and the maximum principle."""
    _, faces = icosphere(2)
    count = int(faces.max()) + 1
    known = np.isin(np.arange(count), [0, 50, 100])
    values = np.full((count, 1), np.nan)
    values[known, 0] = [0.0, 1.0, 0.4]
    found = harmonic_values(faces, values, known)[:, 0]
    sums, number = np.zeros(count), np.zeros(count)
    for a, b in edges(faces):
        sums[a] += found[b]
        sums[b] += found[a]
        number[[a, b]] += 1
    np.testing.assert_allclose((sums / number)[~known], found[~known], atol=1e-13)
    assert found[~known].min() > 0.0
    assert found[~known].max() < 1.0


def test_values_of_second_order_bend_least() -> None:
    """A quadratic function has a constant mean of differences on a regular grid and comes back; elsewhere least squares agree."""
    vertices, faces = grid(13)
    fixed = np.abs(vertices[:, :2] - vertices[:, :2].mean(axis=0)).max(axis=1) > 0.3 * np.ptp(vertices[:, 0])
    quadratic = (vertices[:, :2] @ np.array([[1.0, 2.0], [3.0, -1.0]])) ** 2
    found = harmonic_values(faces, np.where(fixed[:, None], quadratic, 99.0), fixed, order=2)
    np.testing.assert_allclose(found, quadratic, atol=1e-11 * np.abs(quadratic).max())
    _, faces = icosphere(2)
    count = int(faces.max()) + 1
    laplacian = np.eye(count)
    for a in range(count):
        near = np.unique(edges(faces)[(edges(faces) == a).any(axis=1)])
        laplacian[a, near[near != a]] = -1.0 / (len(near) - 1)
    known = np.arange(count) % 3 == 0
    values = np.random.default_rng(0).normal(size=(count, 2))
    expected = np.linalg.lstsq(laplacian[:, ~known], -laplacian[:, known] @ values[known], rcond=None)[0]
    np.testing.assert_allclose(harmonic_values(faces, values, known, order=2)[~known], expected, atol=1e-12)


def test_what_no_known_value_reaches_stays() -> None:
    """Of two triangles apart one has a known corner, which spreads; the other keeps what it has."""
    values = np.arange(6.0)[:, None]
    found = harmonic_values([[0, 1, 2], [3, 4, 5]], values, np.arange(6) == 2)
    np.testing.assert_allclose(found[:, 0], [2.0, 2.0, 2.0, 3.0, 4.0, 5.0], atol=1e-15)
    with pytest.raises(FilterInputError, match="there must be a row for every vertex"):
        harmonic_values([[0, 1, 6]], values, np.arange(6) == 2)
    for faces in ([[0, 1, -1]], [[0, 1, 2, 3]], [[0.4, 1.0, 2.0]]):
        with pytest.raises(FilterInputError, match=r"^face"):
            harmonic_values(faces, values, np.arange(6) == 2)
    assert np.array_equal(harmonic_values([], values, np.arange(6) == 2), values)
    with pytest.raises(FilterInputError, match="order is 3: it must be 1 or 2"):
        harmonic_values([[0, 1, 2]], values, np.arange(6) == 2, order=3)  # type: ignore[arg-type]
