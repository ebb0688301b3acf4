"""Nearest neighbours of whole clouds: exact, ties by index, the same for any number of threads."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pymeshfair.filters import execution as threads
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import ignore_progress
from pymeshfair.filters.neighbours import LEAF, build_tree, nearest_neighbours

Floats = NDArray[np.float64]


def brute_force(points: Floats, k: int) -> tuple[Floats, NDArray[np.int64]]:
    """All distances of all points, sorted by distance and then by index, with the same rounding as the search."""
    x, y, z = points.T
    dx, dy, dz = (c[:, None] - c[None, :] for c in (x, y, z))
    squared = dx * dx + dy * dy + dz * dz
    np.fill_diagonal(squared, np.inf)
    order = np.argsort(squared, axis=1, kind="stable")[:, :k]
    return np.sqrt(np.take_along_axis(squared, order, axis=1)), order


def assert_exact(points: Floats, k: int) -> None:
    """The search finds what brute force finds, bit by bit."""
    distances, indices = nearest_neighbours(points, k)
    expected_distances, expected_indices = brute_force(points, k)
    np.testing.assert_array_equal(indices, expected_indices)
    np.testing.assert_array_equal(distances, expected_distances)


def clouds() -> dict[str, Floats]:
    """Clouds that a search can stumble on, about 1,500 points each."""
    random = np.random.default_rng(7)
    normal = random.normal(size=(1500, 3))
    cube = random.random((1500, 3))
    grid = np.stack(np.meshgrid(*[np.arange(12.0)] * 3), axis=-1).reshape(-1, 3)
    line = np.outer(random.random(1500), [1.0, 2.0, -3.0])
    heap = np.concatenate([cube[:500], np.zeros((600, 3)), np.full((400, 3), 0.5)])
    return {
        "normal": normal,
        "sphere": normal / np.linalg.norm(normal, axis=1, keepdims=True),
        "plane": cube * [1.0, 1.0, 0.0],
        "line": line,
        "even line": np.outer(np.arange(1500.0), [0.0, 1.0, 0.0]),
        "grid": grid,
        "doubled grid": np.concatenate([grid[:700], grid[:700]]),
        "clusters": np.concatenate([normal[:700] * 1e-9, normal[700:1400] * 1e-3 + 1.0, normal[1400:] * 1e3]),
        "two heaps": random.permutation(heap),
        "one heap": np.full((1500, 3), 0.1),
        "signed zeros": np.copysign(0.0, normal),
        "there and back": np.stack([np.minimum(np.arange(1500.0), np.arange(1500.0)[::-1])] * 3, axis=1),
    }


@pytest.mark.parametrize("k", [1, 8, 20, 75])
@pytest.mark.parametrize("name", clouds())
def test_equals_brute_force(name: str, k: int) -> None:
    """Neighbours and distances equal those of brute force to the bit, ties resolved by index, whatever the shape of the cloud."""
    assert_exact(clouds()[name], k)


@pytest.mark.parametrize("n", [2, 3, 15, 16, 17, 31, 32, 33, 48, 49, 64, 65])
def test_small_clouds(n: int) -> None:
    """Clouds of about a leaf or two work for the fewest and for the most neighbours that there can be."""
    points = np.random.default_rng(n).random((n, 3))
    assert_exact(points, 1)
    assert_exact(points, n - 1)


@settings(deadline=None, max_examples=150)
@given(
    arrays(np.float64, st.tuples(st.integers(2, 90), st.just(3)), elements=st.integers(-2, 2).map(float)),
    st.integers(1, 40),
)
def test_ties_and_coincident_points(points: Floats, k: int) -> None:
    """On lattices of 125 places, where nearly every distance is a tie and points coincide, the answer is still exact."""
    assert_exact(points, min(k, len(points) - 1))


@settings(deadline=None, max_examples=100)
@given(
    arrays(
        np.float64,
        st.tuples(st.integers(2, 60), st.just(3)),
        elements=st.floats(-1e3, 1e3, allow_subnormal=False).map(lambda x: x if abs(x) > 1e-100 else 0.0),
    ),
    st.integers(1, 30),
)
def test_any_points(points: Floats, k: int) -> None:
    """The answer is exact for any coordinates whose squared distances a float64 holds."""
    assert_exact(points, min(k, len(points) - 1))


def test_agrees_with_scipy_on_several_subtrees() -> None:
    """On a cloud so large that several threads build the tree, the distances are those of scipy's tree but for rounding."""
    random = np.random.default_rng(3)
    points = random.random((150_000, 3)) ** 3
    distances, indices = nearest_neighbours(points, 6)
    expected, _ = cKDTree(points).query(points, 7, workers=-1)
    np.testing.assert_allclose(distances, expected[:, 1:], rtol=1e-14, atol=0.0)
    np.testing.assert_allclose(np.linalg.norm(points[indices] - points[:, None], axis=2), distances, rtol=1e-14, atol=0.0)


def test_a_heap_of_coincident_points_costs_no_more_than_others() -> None:
    """A sensor's invalid points all lie at the origin: each gets those of lowest index, without looking at the whole heap.

    Looking at all of them would be 4e10 comparisons.
    """
    distances, indices = nearest_neighbours(np.zeros((200_000, 3)), 4)
    assert not distances.any()
    np.testing.assert_array_equal(indices[4:], np.tile([0, 1, 2, 3], (199_996, 1)))
    np.testing.assert_array_equal(indices[:4], [[1, 2, 3, 4], [0, 2, 3, 4], [0, 1, 3, 4], [0, 1, 2, 4]])


def test_coincident_points_lie_in_the_tree_in_the_order_of_their_indices() -> None:
    """Each leaf of a heap holds a run of indices, so that the first leaves of the walk hold the answer."""
    tree = build_tree(np.ones((1000, 3)), ignore_progress)
    np.testing.assert_array_equal(np.sort(tree.indices.reshape(-1, LEAF), axis=1), np.arange(1008).reshape(-1, LEAF))


@pytest.mark.parametrize("exponent", [-1060, -100, 100, 1020])
def test_any_magnitude(exponent: int) -> None:
    """A change of unit by a power of two changes the distances by it, exactly, even where squares would leave a float64."""
    points = np.random.default_rng(1).integers(-1000, 1000, (300, 3)) / 1024
    distances, indices = nearest_neighbours(points, 9)
    scaled_distances, scaled_indices = nearest_neighbours(np.ldexp(points, exponent), 9)
    np.testing.assert_array_equal(scaled_indices, indices)
    np.testing.assert_allclose(scaled_distances, np.ldexp(distances, exponent), rtol=1e-15, atol=1e-320)


def test_far_from_the_origin() -> None:
    """At the offset of map coordinates the answer is that of brute force there: nothing is lost beyond the input's rounding."""
    assert_exact(np.random.default_rng(2).random((500, 3)) + np.array([448_262.0, 5_411_932.0, 121.0]), 12)


def test_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread and three threads give the same bits."""
    points = np.random.default_rng(4).normal(size=(100_000, 3))
    monkeypatch.setattr(threads, "allowed_threads", lambda: 3)
    several = nearest_neighbours(points, 5)
    monkeypatch.setattr(threads, "allowed_threads", lambda: 1)
    one = nearest_neighbours(points, 5)
    np.testing.assert_array_equal(several[0], one[0])
    np.testing.assert_array_equal(several[1], one[1])


def test_two_callers_at_once() -> None:
    """Two threads of a program may search at the same time."""
    clouds = [np.random.default_rng(seed).random((30_000, 3)) for seed in (0, 1)]
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda points: nearest_neighbours(points, 4)[1], clouds))
    for indices, points in zip(found, clouds, strict=True):
        np.testing.assert_array_equal(indices, nearest_neighbours(points, 4)[1])


def test_order_of_the_points() -> None:
    """Points in another order have the same neighbours."""
    random = np.random.default_rng(5)
    points = random.random((2000, 3))
    order = random.permutation(2000)
    _, indices = nearest_neighbours(points, 10)
    _, shuffled = nearest_neighbours(points[order], 10)
    np.testing.assert_array_equal(order[shuffled], indices[order])


def test_takes_any_array_and_leaves_it_alone() -> None:
    """Single precision, integers, lists and views are converted; the input is not written to."""
    points = np.random.default_rng(6).integers(0, 50, (100, 3))
    expected = brute_force(points.astype(float), 3)[1]
    strided = np.asfortranarray(np.repeat(points, 2, axis=0).astype(np.float32))[::2]
    strided.flags.writeable = False
    for given_points in (points, points.tolist(), strided):
        np.testing.assert_array_equal(nearest_neighbours(given_points, 3)[1], expected)


@pytest.mark.parametrize(
    ("k", "message"),
    [(0, "k is 0: it must be a whole number of at least 1"), (2.0, "written 2"), (10, "at least 11 points, got 10")],
)
def test_impossible_numbers_of_neighbours(k: int, message: str) -> None:
    """Too few or too many neighbours are refused with the number and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        nearest_neighbours(np.random.default_rng(0).random((10, 3)), k)


def test_points_that_are_none() -> None:
    """NaN and infinity are refused with their number and the first index; so are arrays of another shape and empty ones."""
    points = np.random.default_rng(0).random((50, 3))
    points[[7, 9, 30], [0, 1, 2]] = np.nan, np.inf, -np.inf
    with pytest.raises(FilterInputError, match=r"vertex 7 is \[nan, .*: 3 of 50 vertices"):
        nearest_neighbours(points, 3)
    with pytest.raises(FilterInputError, match=r"\(n, 3\) array of real numbers, got shape \(50, 2\)"):
        nearest_neighbours(points[:, :2], 3)
    with pytest.raises(FilterInputError, match="at least 2 points, got 0"):
        nearest_neighbours(np.empty((0, 3)), 1)


def test_progress_rises_to_one() -> None:
    """The progress never falls, ends at 1, and comes often."""
    shares: list[float] = []
    nearest_neighbours(np.random.default_rng(0).random((100_000, 3)), 10, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    assert len(shares) >= 8


def test_progress_can_stop_the_work() -> None:
    """What the progress raises comes out, and nothing more is reported."""
    shares: list[float] = []

    def stop(share: float) -> None:
        shares.append(share)
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nearest_neighbours(np.random.default_rng(0).random((100_000, 3)), 10, progress=stop)
    assert shares[-1] < 0.9


def test_progress_is_said_again_during_a_long_task() -> None:
    """However long a single task takes, the progress is heard of, so that a caller can interrupt."""
    shares: list[float] = []
    threads.in_parallel(time.sleep, [(0.7,), (0.0,)], shares.append)
    assert shares.count(0.0) >= 2
    assert shares[-2:] == [0.5, 1.0]


def test_an_error_in_a_task_comes_out() -> None:
    """What a task raises is raised to the caller."""
    with pytest.raises(ValueError, match="non-negative"):
        threads.in_parallel(time.sleep, [(0.0,), (-1.0,)], lambda share: None)
