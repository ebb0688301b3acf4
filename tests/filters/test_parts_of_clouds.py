"""What parts of a cloud and of a mesh give together: neighbours beyond a tile, sums in any order, exact means."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.filters.denoising import distances_of_part
from pymeshfair.filters.denoising.face_neighbourhoods import face_neighbourhoods, mean_centre_distance
from pymeshfair.filters.geometry import measure_faces
from pymeshfair.filters.neighbours import CellTree, Nearest, cells_within, offer_cells, reaching_out
from pymeshfair.filters.outliers import SPREAD_BLOCK, spread_of, standard_distances
from pymeshfair.filters.topology import vertex_faces
from tests.meshes import icosphere

Floats = NDArray[np.float64]


@given(st.lists(st.floats(0, 1e150), min_size=1, max_size=60), st.integers(0, 1000))
def test_a_sum_does_not_depend_on_its_order(values: list[float], seed: int) -> None:
    """The root of the mean of a row has the same bits for every order, and differs from the exact one by rounding alone."""
    row = np.array(values)
    mixed = np.random.default_rng(seed).permutation(row)
    found = standard_distances(row[None])[0]
    assert standard_distances(mixed[None])[0] == found
    assert found == pytest.approx(math.sqrt(math.fsum(values) / len(values)), rel=1e-15)


@pytest.mark.parametrize("row", [[0.0, 0.0], [5e-324, 0.0], [1e-300, 1e-310], [np.inf, 1.0]])
def test_sums_at_the_ends_of_the_range_of_numbers(row: list[float]) -> None:
    """Zeros, the smallest numbers and infinity come out as they are."""
    assert standard_distances(np.array([row]))[0] == pytest.approx(math.sqrt(sum(row) / 2), rel=1e-12)


def test_the_spread_is_the_root_mean_square_of_what_is_finite() -> None:
    """Over several blocks, of numbers whose squares overflow, and without the infinite ones."""
    factors = np.random.default_rng(0).normal(size=2 * SPREAD_BLOCK + 77) * 1e200
    factors[5] = np.inf
    finite = factors[np.isfinite(factors)] / 1e200
    found = spread_of(lambda: (factors[at : at + SPREAD_BLOCK] for at in range(0, len(factors), SPREAD_BLOCK)), 3.0)
    assert found / 1e200 == pytest.approx(3.0 * math.sqrt(np.mean(finite**2)), rel=1e-13)
    assert spread_of(lambda: [np.array([np.inf])], 3.0) == 0.0


@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 30))
def test_cells_give_the_neighbours_of_a_table_of_distances(seed: int, k: int, size: int) -> None:
    """Among cells of any size, ties and coincident points included, the nearest are those of the full table of distances."""
    random = np.random.default_rng(seed)
    points = random.integers(0, 6, (90, 3)) / 8.0
    points = points[np.lexsort(points.T)]
    numbers = random.permutation(len(points))
    starts = np.arange(0, len(points), size)
    boxes = np.stack([np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)], axis=1)
    counts = np.diff(np.append(starts, len(points)))
    cells = CellTree.over(boxes, counts)
    bounds = np.full(len(points), np.inf)
    assert reaching_out(points, bounds, cells, 0, 0).all()
    asked = cells_within(points, bounds, cells, 0, 0, k)
    shape = len(points), k
    nearest = Nearest(np.full(shape, np.inf), np.full(shape, 10**9), np.full(shape, -1))
    rows = np.stack([starts, starts + counts], axis=1)
    offer_cells(points, numbers, nearest, asked, cells, rows, (points, numbers, np.arange(len(points))))
    table = ((points[:, None] - points) ** 2).sum(axis=2)
    for p in range(len(points)):
        order = [q for q in np.lexsort((numbers, table[p])) if q != p][:k]
        np.testing.assert_array_equal(nearest.numbers[p], numbers[order])
        np.testing.assert_array_equal(nearest.slots[p], order)
        np.testing.assert_array_equal(nearest.squared[p], table[p, order])


@given(st.integers(0, 10**6), st.integers(1, 200))
def test_cells_are_listed_in_groups_as_they_are_at_once(seed: int, most: int) -> None:
    """Groups of points whose cells fit into a list of a given length have the cells that they have in one list."""
    random = np.random.default_rng(seed)
    points, corners = random.random((40, 3)), np.sort(random.random((30, 2, 3)), axis=1)
    cells, bounds = CellTree.over(corners, random.integers(1, 9, 30)), random.random(40)
    offsets, found = cells_within(points, bounds.copy(), cells, 3, 7, 5)
    at = 0
    while at < len(points):
        part, cells_of = cells_within(points[at:], bounds[at:].copy(), cells, 3, 7, 5, most=most)
        listed = len(part) - 1
        assert listed == 1 or (listed > 1 and part[-1] <= most)
        assert at + listed == len(points) or offsets[at + listed + 1] - offsets[at] > most
        np.testing.assert_array_equal(part, offsets[at : at + listed + 1] - offsets[at])
        np.testing.assert_array_equal(cells_of, found[offsets[at] : offsets[at + listed]])
        at += listed


def test_parts_give_the_mean_distance_of_the_whole() -> None:
    """The sums of halves, in one exact sum, are the mean over all faces to the bit."""
    vertices, faces = icosphere(3)
    points = 0.2 * (vertices + np.random.default_rng(1).normal(scale=0.01, size=vertices.shape))
    edge = face_neighbourhoods(faces, vertex_faces(faces, len(points)), "edge")
    whole = mean_centre_distance(measure_faces(points, faces), edge)
    own = np.random.default_rng(2).random(len(faces)) < 0.4
    (one, n), (other, m) = distances_of_part(points, faces, own), distances_of_part(points, faces, ~own)
    assert math.fsum([*one, *other]) / (n + m) == whole
