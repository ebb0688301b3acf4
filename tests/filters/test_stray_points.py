"""Stray points of clouds: single ones, hazes and clumps."""

from __future__ import annotations

import numpy as np
import pytest
from cloud_strays import shares, terrain  # benchmarks/cloud_strays.py
from numpy.typing import NDArray
from scipy import sparse, spatial

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.outliers import NO_LINK, cut_links, stray_points, thicknesses
from tests.meshes import spiral

Points = NDArray[np.float64]


def littered(seed: int, count: int = 4000) -> tuple[Points, NDArray[np.bool_]]:
    """The sphere, a haze of 200 points in a box of ten times its size and a clump of 40; which of them are stray."""
    rng = np.random.default_rng(seed)
    haze = rng.uniform(-10.0, 10.0, (200, 3))
    haze = haze[np.abs(np.linalg.norm(haze, axis=1) - 1.0) > 0.5]
    clump = rng.normal(loc=3.0, scale=0.05, size=(40, 3))
    return np.concatenate([spiral(count), haze, clump]), np.arange(count + len(haze) + 40) >= count


def by_the_definition(points: Points, k: int, sparseness: float, smallest: int) -> NDArray[np.bool_]:
    """The three steps, with all distances and links in matrices."""
    squared = spatial.distance.cdist(points, points, "sqeuclidean")
    np.fill_diagonal(squared, np.inf)
    nearest = np.argsort(squared, axis=1)[:, :k]
    spacing = np.sqrt(np.take_along_axis(squared, nearest, axis=1).mean(axis=1))
    around = points[np.column_stack([np.arange(len(points)), nearest])]
    around -= around.mean(axis=1, keepdims=True)
    variances = np.linalg.eigvalsh(around.transpose(0, 2, 1) @ around)
    thickness = variances[:, 0] / variances.sum(axis=1)
    links = np.zeros(squared.shape, dtype=np.bool_)
    np.put_along_axis(links, nearest, True, axis=1)
    links &= links.T
    limit = sparseness * np.median(spacing)
    joined = links.sum(axis=1) >= k / 4
    kept = (spacing <= limit) | (joined & ((spacing <= 2 * limit) | (thickness <= 0.06)))
    for _ in range(2):
        kept |= (links & kept).sum(axis=1) >= k / 4
    _, parts = sparse.csgraph.connected_components(sparse.csr_array(links & kept & kept[:, None]), directed=False)
    sizes = np.bincount(parts)
    fills_space = np.bincount(parts, thickness) / sizes > 0.14
    return np.asarray(~kept | (sizes < np.where(fills_space, 3 * smallest, smallest))[parts])


def parts_of_all_kinds(seed: int) -> Points:
    """Spheres, boxes and balls that fill space, rough sheets, one with ever wider rows, a haze; an odd number of points."""
    rng = np.random.default_rng(seed)
    rows, columns = (axis.ravel().astype(float) for axis in np.indices((13, 13)))
    wide = np.column_stack([rows, columns, np.zeros(169)]) + 0.4 * rng.normal(size=(169, 3))
    parts = [
        spiral(300),
        spiral(150) * (0.55 + 0.02 * rng.normal(size=(150, 1))),
        rng.uniform(-0.25, 0.25, (280, 3)),
        rng.uniform(-0.3, 0.3, (330, 3)),
        0.15 * wide + 0.14 * rng.normal(size=(169, 3)),
        0.8 * wide,
        wide * np.column_stack([0.15 * 1.15**rows] * 3),
    ]
    places = 12.0 * np.stack(np.unravel_index(np.arange(len(parts)), (2, 2, 2)), axis=1)
    return np.concatenate([*(part + place for part, place in zip(parts, places, strict=True)), rng.uniform(-2.0, 5.0, (101, 3))])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("k", "sparseness", "smallest"), [(16, 1.5, 100), (8, 1.0, 60), (27, 2.5, 95)])
def test_is_the_definition(k: int, sparseness: float, smallest: int, seed: int) -> None:
    """Of parts of all kinds the points are stray that are so by the three steps, written down with matrices."""
    points = parts_of_all_kinds(seed)
    found = stray_points(points, neighbors=k, sparseness=sparseness, smallest_part=smallest)
    np.testing.assert_array_equal(found, by_the_definition(points, k, sparseness, smallest))


def test_a_thickness_is_an_eigenvalue() -> None:
    """It is the least eigenvalue of the covariance over the trace, 1/3 where all are equal, 0 on planes, lines and in one place.

    A root of the cubic formula has half the digits where two eigenvalues coincide, as on a line: 1e-7 of the trace.
    """
    rng = np.random.default_rng(3)
    clouds = rng.normal(size=(200, 9, 3)) * rng.uniform(0.0, 1.0, (200, 1, 3)) @ np.linalg.qr(rng.normal(size=(200, 3, 3)))[0]
    axes = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3), 2.0 * np.eye(3)[:1], -2.0 * np.eye(3)[:1]])
    known = np.stack([axes[[0, 1, 2, 3, 4, 5, 6, 0, 0]], axes * [1.0, 1.0, 0.0], axes * [1.0, 0.0, 0.0], 0.0 * axes])
    clouds = np.concatenate([clouds, known]) + 3.0
    places, m = np.concatenate(clouds.transpose(1, 0, 2)), len(clouds)
    neighbours = (np.arange(m)[:, None] + m * np.arange(1, 9)).astype(np.int32)
    found = thicknesses(places, np.arange(9 * m), neighbours)
    centred = clouds - clouds.mean(axis=1, keepdims=True)
    variances = np.linalg.eigvalsh(centred.transpose(0, 2, 1) @ centred)
    expected = variances[:, 0] / np.maximum(variances.sum(axis=1), 1e-300)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(found[:200], expected[:200], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found[200:], [1 / 3, 0.0, 0.0, 0.0], rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("noise", [0.0, 0.3], ids=["lattice", "cloud"])
def test_neighbours_are_sorted_and_links_are_mutual(noise: float) -> None:
    """Where distances are equal the lower number comes first; a link stays if each end is among the k nearest of the other."""
    rng = np.random.default_rng(4)
    points = rng.permutation(np.indices((5, 5, 5)).reshape(3, -1).T + noise * rng.normal(size=(125, 3)))
    numbers = rng.permutation(125).astype(np.int64)
    squared = ((points[:, None] - points) ** 2).sum(axis=2)
    np.fill_diagonal(squared, np.inf)
    nearest = np.array([np.lexsort((numbers, row))[:10] for row in squared], dtype=np.int32)
    links = rng.permuted(nearest, axis=1)
    thicknesses(points, numbers, links)
    np.testing.assert_array_equal(links, nearest)
    cut_links(points, numbers, links, np.take_along_axis(squared, nearest, axis=1).max(axis=1), numbers[nearest[:, -1]])
    mutual = (nearest[nearest] == np.arange(125)[:, None, None]).any(axis=2)
    assert not mutual.all()
    np.testing.assert_array_equal(links, np.where(mutual, nearest, NO_LINK))


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
    assert not stray_points(spiral(1000)).any()


def test_parts_of_different_density_stay() -> None:
    """A sphere with a sixteenth of the density, four times the spacing, is no haze."""
    points = np.concatenate([spiral(8000), spiral(500) + np.array([4.0, 0.0, 0.0])])
    assert not stray_points(points).any()


def test_the_smallest_part_decides_about_islands() -> None:
    """An island of 150 points is stray from 151 on."""
    points = np.concatenate([spiral(4000), 0.2 * spiral(150) + np.array([4.0, 0.0, 0.0])])
    assert not stray_points(points, smallest_part=150).any()
    assert np.array_equal(stray_points(points, smallest_part=151), np.arange(4150) >= 4000)


def test_points_without_a_measurement_at_the_origin_do_not_hide_the_haze() -> None:
    """Of a haze of 1,000 points as many are found where more than half of the points are at one place; the sphere stays."""
    points = np.concatenate([spiral(8000), np.random.default_rng(0).uniform(2.0, 8.0, (1000, 3))])
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
        stray_points(spiral(500), **options)  # type: ignore[arg-type]
