"""Bilateral projection of points against a loop over them, on a plane, a sphere and two sides of a cube."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.spatial
from numpy.typing import NDArray

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.clouds import bilateral_projection, normals_of
from pymeshfair.filters.neighbours import nearest_neighbours
from pymeshfair.filters.robust import KERNEL_NAMES, KernelName, weight
from tests.meshes import AWKWARD, icosphere, rotation, spiral

Floats = NDArray[np.float64]


def flat(n: int = 2000, seed: int = 0) -> Floats:
    """Points strewn over the unit square."""
    return np.column_stack([np.random.default_rng(seed).random((n, 2)), np.zeros(n)])


def roof(n: int = 4000) -> Floats:
    """Two sides of a cube with the edge x = 0, z = 0 between them: the squares z = 0 and x = 0."""
    points = flat(n)
    points[::2] = points[::2][:, [2, 1, 0]] * [1, 1, -1]
    return points


def shaken(points: Floats, amount: float) -> Floats:
    """The points, each coordinate shifted by a normal deviate."""
    return points + np.random.default_rng(9).normal(0.0, amount, points.shape)


@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_a_loop_over_points_gives_the_same(name: KernelName) -> None:
    """One iteration is its equation over the nearest neighbours, normals included, to 1e-10."""
    points = shaken(spiral(300), 0.02)
    _, indices = scipy.spatial.cKDTree(points).query(points, k=13)
    expected = points.copy()
    for i, p in enumerate(points):
        normal = np.linalg.eigh(np.cov(points[indices[i]].T))[1][:, 0]
        arms = points[indices[i, 1:]] - p
        weights = weight(name, np.linalg.norm(arms, axis=1), 0.3)
        weights = weights * weight(name, arms @ normal, 0.05)
        if weights.sum() > 0:
            expected[i] = p + normal * (weights @ (arms @ normal)) / weights.sum()
    found = bilateral_projection(
        points, neighbors=12, space_kernel=name, range_kernel=name, space_sigma=0.3, range_sigma=0.05, iterations=1
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_a_noisy_plane_gets_flat() -> None:
    """A plane is a fixed point, and the noise of one, a third of the points' spacing, falls to less than half."""
    points = flat() @ rotation(2).T
    np.testing.assert_allclose(bilateral_projection(points), points, rtol=0, atol=1e-12)
    noisy = shaken(flat(), 0.007)
    assert bilateral_projection(noisy)[:, 2].std() < 0.5 * noisy[:, 2].std()


def test_a_noisy_sphere_gets_round() -> None:
    """The mean distance to the sphere falls to less than half, with estimated normals and with true ones of any length."""
    truth = spiral(10_000)
    noisy = shaken(truth, 0.01)

    def error(points: Floats) -> float:
        return float(np.abs(np.linalg.norm(points, axis=1) - 1).mean())

    assert error(bilateral_projection(noisy)) < 0.5 * error(noisy)
    found = bilateral_projection(noisy, normals=truth)
    assert error(found) < 0.5 * error(noisy)
    signs = np.where(np.arange(len(truth)) % 2, -3.0, 1e-200)[:, None]
    np.testing.assert_allclose(bilateral_projection(noisy, normals=truth * signs), found, rtol=0, atol=1e-12)


def test_an_edge_survives() -> None:
    """Along true normals, points near the edge of a cube come nearer to its sides with "tukey", and sink with "l2"."""
    truth = roof()
    noisy = shaken(truth, 0.004)
    normals = np.where((np.arange(len(truth)) % 2 == 0)[:, None], [1.0, 0, 0], [0, 0, 1.0])
    near = (np.abs(truth).max(axis=1) > 0) & (np.linalg.norm(truth[:, [0, 2]], axis=1) < 0.03)

    def error(points: Floats) -> float:
        return float(np.abs(((points - truth) * normals).sum(axis=1))[near].mean())

    assert error(bilateral_projection(noisy, normals=normals, range_kernel="tukey", range_sigma=0.02)) < error(noisy)
    assert error(bilateral_projection(noisy, normals=normals, range_kernel="l2")) > error(noisy)


def bowl(n: int = 2000) -> Floats:
    """Points strewn over a quadric above the square (-0.5, 0.5)^2."""
    points = flat(n) - [0.5, 0.5, 0.0]
    x, y = points[:, 0], points[:, 1]
    points[:, 2] = 0.5 * x**2 - 0.3 * x * y + 0.2 * y**2
    return points


def test_quadrics_stay() -> None:
    """With the degree 2 a quadric along its axis stays but for its corners, and a plane; with the degree 1 a quadric shrinks."""
    up, points = np.tile([0.0, 0.0, 1.0], (2000, 1)), bowl()
    inner = np.abs(points[:, :2]).max(axis=1) < 0.4
    arguments: dict[str, Any] = {"normals": up, "neighbors": 30, "range_kernel": "l2", "iterations": 1}
    moved = [np.abs(bilateral_projection(points, **arguments, degree=degree) - points)[inner].max() for degree in (1, 2)]
    assert moved[0] > 1e-3
    assert moved[1] < 1e-12
    found = bilateral_projection(flat(), **arguments, degree=2)
    np.testing.assert_allclose(found, flat(), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["gaussian", "tukey", "l1"])
def test_a_loop_over_quadrics_gives_the_same(name: KernelName) -> None:
    """One iteration with the degree 2 is numpy's weighted least squares over the nearest neighbours, to 1e-9."""
    points = shaken(spiral(300), 0.02)
    _, indices = scipy.spatial.cKDTree(points).query(points, k=41)
    expected = points.copy()
    for i, p in enumerate(points):
        normal, *tangents = np.linalg.eigh(np.cov(points[indices[i]].T))[1].T
        arms = points[indices[i, 1:]] - p
        (u, v), h = np.array(tangents) @ arms.T, arms @ normal
        roots = np.sqrt(weight(name, np.linalg.norm(arms, axis=1), 0.6) * weight(name, h, 0.2))
        terms = np.column_stack([np.ones(40), u, v, u * u, u * v, v * v])
        expected[i] = p + normal * np.linalg.lstsq(terms * roots[:, None], h * roots, rcond=None)[0][0]
    kernels: dict[str, Any] = {"space_kernel": name, "range_kernel": name, "space_sigma": 0.6, "range_sigma": 0.2}
    found = bilateral_projection(points, neighbors=40, iterations=1, degree=2, **kernels)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_quadrics_turn_and_scale_with_the_cloud() -> None:
    """Moved, turned and scaled points give the results moved, turned and scaled."""
    points, turn = shaken(bowl(), 0.005), rotation(3)
    found = bilateral_projection(7.0 * points @ turn.T + [5.0, -3.0, 2.0], neighbors=40, degree=2)
    expected = 7.0 * bilateral_projection(points, neighbors=40, degree=2) @ turn.T + [5.0, -3.0, 2.0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("neighbors", [3, 7, 8, 12])
def test_few_neighbours_pass_on_no_more_noise_than_there_is(neighbors: int) -> None:
    """Quadrics through few neighbours, most of all near a border, are replaced by planes and means."""
    points = shaken(flat(), 0.005)
    assert bilateral_projection(points, neighbors=neighbors, degree=2)[:, 2].std() < 1.1 * points[:, 2].std()


def test_quadrics_of_weights_near_the_smallest_number() -> None:
    """Range sigmas far below the heights leave weights that are hardly above 0, or none: no point becomes NaN or flies away."""
    points = shaken(spiral(500), 0.02)
    for sigma in (1e-3, 5e-4, 1e-4, 1e-8):
        found = bilateral_projection(points, neighbors=40, range_sigma=sigma, degree=2)
        assert np.abs(found - points).max() < 0.2


def test_normals_of_a_sphere_point_outwards_or_inwards() -> None:
    """Estimated normals are those of the sphere up to their sign, to the curvature over the neighbourhood; their length is 1."""
    points = spiral(3000)
    normals = normals_of(points, nearest_neighbours(points, 18)[1])
    assert np.abs((normals * points).sum(axis=1)).min() > math.cos(math.radians(2))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-12)


def test_points_that_may_not_move_keep_every_bit() -> None:
    """Not movable ones, those whose normal is 0, and all of them if there are no iterations."""
    points = shaken(spiral(500), 0.02)
    movable = np.arange(500) % 2 == 0
    found = bilateral_projection(points, movable=movable)
    assert found[~movable].tobytes() == points[~movable].tobytes()
    assert (found[movable] != points[movable]).any(axis=1).all()
    found = bilateral_projection(points, normals=points * movable[:, None])
    assert found[~movable].tobytes() == points[~movable].tobytes()
    assert bilateral_projection(points, iterations=0).tobytes() == points.tobytes()


@pytest.mark.parametrize("name", [k for k, make in AWKWARD.items() if len(make()[0]) > 18])
def test_awkward_clouds_stay_finite(name: str) -> None:
    """Coincident points, points on a line, huge and tiny ones: nothing becomes NaN."""
    points, _ = AWKWARD[name]()
    for kernel in ("gaussian", "l1", "tukey"):
        for degree in (1, 2):
            found = bilateral_projection(points, range_kernel=kernel, space_kernel=kernel, degree=degree)
            assert np.isfinite(found).all()


def test_wrong_input_is_refused() -> None:
    """Too few points, normals of another number or not finite, and wrong parameters are errors that say so."""
    points, _ = icosphere(1)
    with pytest.raises(FilterInputError, match="60 neighbours need a cloud of at least 61 points, got 42"):
        bilateral_projection(points, neighbors=60)
    with pytest.raises(FilterInputError, match=r"normals must have the shape \(42, 3\), one per point, got \(40, 3\)"):
        bilateral_projection(points, normals=points[:40])
    with pytest.raises(
        FilterInputError, match=r"^normal 3 is \[nan, 0\.0, 1\.0\]: 1 of 42 normals .*; a point whose normal is 0 stays$"
    ):
        bilateral_projection(points, normals=np.where(np.arange(42)[:, None] == 3, [np.nan, 0.0, 1.0], points))
    with pytest.raises(FilterInputError, match=r"range_sigma is 0\.0: it must be finite and above 0"):
        bilateral_projection(points, range_sigma=0.0)
    with pytest.raises(FilterInputError, match="degree is 3: it must be a whole number from 1 to 2"):
        bilateral_projection(points, degree=3)
    with pytest.raises(FilterInputError, match="kernel 'box' is not one of"):
        bilateral_projection(points, space_kernel="box")  # type: ignore[arg-type]
