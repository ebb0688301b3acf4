"""Stray points of clouds: single ones, hazes and clumps."""

from __future__ import annotations

import numpy as np
import pytest
from cloud_strays import shares, terrain  # benchmarks/cloud_strays.py
from numpy.typing import NDArray

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.outliers import stray_points

Points = NDArray[np.float64]


def sphere(count: int) -> Points:
    """A spiral of points evenly around the unit sphere."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angles = np.arange(count) * np.pi * (1.0 + 5.0**0.5)
    around = np.sqrt(1.0 - z**2)
    return np.column_stack([around * np.cos(angles), around * np.sin(angles), z])


def littered(seed: int, count: int = 4000) -> tuple[Points, NDArray[np.bool_]]:
    """The sphere, a haze of 200 points in a box of ten times its size and a clump of 40; which of them are stray."""
    rng = np.random.default_rng(seed)
    haze = rng.uniform(-10.0, 10.0, (200, 3))
    haze = haze[np.abs(np.linalg.norm(haze, axis=1) - 1.0) > 0.5]
    clump = rng.normal(loc=3.0, scale=0.05, size=(40, 3))
    return np.concatenate([sphere(count), haze, clump]), np.arange(count + len(haze) + 40) >= count


@pytest.mark.parametrize("seed", range(3))
def test_haze_and_clump_are_stray_and_the_surface_is_not(seed: int) -> None:
    """All of the litter is found, and not one point of the sphere."""
    points, stray = littered(seed)
    assert np.array_equal(stray_points(points), stray)


@pytest.mark.parametrize("count", [20_000, 60_000, 200_000])
def test_flyers_over_terrain_are_stray_whatever_the_density(count: int) -> None:
    """Of 0.1 % of flyers over terrain with buildings at least 95 % beyond 5 m are found; at most 0.1 % of the good points go."""
    good, flyers = terrain(count, side=100.0)
    bands, lost = shares(stray_points(np.concatenate([good, flyers])), good, flyers)
    assert bands[2] >= 0.95
    assert lost <= 1e-3


def test_a_clean_surface_has_no_stray_points() -> None:
    """No two points of an even sphere differ in spacing by a factor of two."""
    assert not stray_points(sphere(1000)).any()


def test_parts_of_different_density_stay() -> None:
    """A sphere with a sixteenth of the density, four times the spacing, is no haze."""
    points = np.concatenate([sphere(8000), sphere(500) + np.array([4.0, 0.0, 0.0])])
    assert not stray_points(points).any()


def test_the_smallest_part_decides_about_islands() -> None:
    """An island of 150 points is stray from 151 on."""
    points = np.concatenate([sphere(4000), 0.2 * sphere(150) + np.array([4.0, 0.0, 0.0])])
    assert not stray_points(points, smallest_part=150).any()
    assert np.array_equal(stray_points(points, smallest_part=151), np.arange(4150) >= 4000)


def test_points_without_a_measurement_at_the_origin_do_not_hide_the_haze() -> None:
    """Of a haze of 1,000 points as many are found where more than half of the points are at one place; the sphere stays."""
    points = np.concatenate([sphere(8000), np.random.default_rng(0).uniform(2.0, 8.0, (1000, 3))])
    stray = stray_points(np.concatenate([points, np.zeros((9001, 3))]))
    assert np.array_equal(stray[:9000], stray_points(points))
    assert stray[8000:9000].mean() > 0.9


def test_place_size_and_order_make_no_difference() -> None:
    """The same points are stray when the cloud is moved, turned, scaled by 2^40 and shuffled."""
    points, stray = littered(5)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    order = np.random.default_rng(2).permutation(len(points))
    there = (points @ turn + [3.0, -2.0, 5.0]) * 2.0**40
    assert np.array_equal(stray_points(there[order]), stray[order])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"sparseness": 0.5}, "sparseness is 0.5: it must be finite and at least 1"),
        ({"smallest_part": 0}, "smallest_part is 0: it must be a whole number of at least 1"),
        ({"neighbors": 4000}, "need a cloud of at least 4001 points"),
    ],
)
def test_parameters_that_are_refused(options: dict[str, float], words: str) -> None:
    """What is out of its bounds is named with them."""
    with pytest.raises(FilterInputError, match=words):
        stray_points(sphere(500), **options)  # type: ignore[arg-type]
