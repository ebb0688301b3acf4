"""Polygons, strips and equal rows, against definitions written out in plain Python."""

from __future__ import annotations

import itertools
import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pymeshfair.files.errors import ContentsError
from pymeshfair.files.polygons import edges_of, numbered, outlines, triangles_of, triangulated

#: corners of up to six strips or lines, of vertices 0 to 5
LISTS = st.lists(st.lists(st.integers(0, 5), max_size=6), min_size=1, max_size=6)


def as_arrays(lists: list[list[int]]) -> tuple[Any, Any]:
    """The lists one after the other, and their lengths."""
    return np.array([v for each in lists for v in each], dtype=np.int64), np.array([len(each) for each in lists])


@given(LISTS)
def test_edges_of_polylines_are_their_pairs(lists: list[list[int]]) -> None:
    """Each corner with the next one of the same line."""
    found = edges_of(*as_arrays(lists))
    assert found.tolist() == [list(pair) for each in lists for pair in itertools.pairwise(each)]


@given(LISTS)
def test_triangles_of_strips_and_fans_are_those_of_the_definition(lists: list[list[int]]) -> None:
    """Three corners in turn, every second triple turned over, or the first corner and two in turn; none names a vertex twice."""
    corners, lengths = as_arrays(lists)
    strips, fans = [], []
    for each in lists:
        for k, (a, b, c) in enumerate(zip(each, each[1:], each[2:], strict=False)):
            strips.append([a, b, c] if k % 2 == 0 else [b, a, c])
            fans.append([each[0], b, c])
    for expected, is_fan in ((strips, False), (fans, True)):
        found = corners[triangles_of(corners, lengths, fans=is_fan)]
        rows = [list(np.roll(row, -row.argmin())) for row in found]  # a strip may begin a triangle at another corner
        wanted = [list(np.roll(row, -int(np.argmin(row)))) for row in expected if len(set(row)) == 3]
        assert rows == wanted


@given(st.lists(st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, np.nan])] * 2), max_size=12))
def test_equal_rows_are_numbered_in_their_order(rows: list[tuple[float, float]]) -> None:
    """By the first row that is equal, -0 to 0 too; a row with NaN equals none."""
    firsts, numbers = numbered(np.array(rows, dtype=np.float64).reshape(-1, 2))
    starts: list[int] = []
    for i, row in enumerate(rows):
        equal = [k for k, first in enumerate(starts) if rows[first] == row and not np.isnan(row).any()]
        if not equal:
            starts.append(i)
        assert numbers[i] == (equal[0] if equal else len(starts) - 1)
    assert firsts.tolist() == starts


def test_many_equal_rows_are_numbered_as_numpy_numbers_them() -> None:
    """Where thousands of rows share a table, the groups are those of `numpy.unique`."""
    rows = np.random.default_rng(0).integers(0, 20, (5000, 3)).astype(np.float64)
    firsts, numbers = numbered(rows)
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    np.testing.assert_array_equal(firsts, np.sort(first))
    np.testing.assert_array_equal(firsts[numbers], first[inverse.ravel()])


@given(st.integers(0, 10**6), st.lists(st.integers(3, 9), min_size=1, max_size=6))
def test_polygons_come_back_from_their_triangles(seed: int, lengths: list[int]) -> None:
    """Stars of any depth with vertices of their own, triangles in any order: the same corners, ordered by first triangle."""
    rng = np.random.default_rng(seed)
    points = []
    for length in lengths:
        angle = 2.0 * np.pi * np.arange(length) / length
        points.append(rng.uniform(0.2, 1.0, length)[:, None] * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle]))
    corners = rng.permutation(sum(lengths)).astype(np.int64)
    vertices = np.empty((len(corners), 3))
    vertices[corners] = np.concatenate(points)
    places, _, attributes = triangulated(vertices, corners, np.array(lengths))
    order = rng.permutation(len(places))
    faces = corners[places].astype(np.int32)[order]
    found = outlines(faces, attributes["polygon"][order] if attributes else None)
    assert found.notes == ()
    rims = np.split(faces.ravel()[found.places], np.cumsum(found.lengths)[:-1])
    expected = np.split(corners, np.cumsum(lengths)[:-1])
    assert {tuple(np.roll(rim, -rim.argmin())) for rim in rims} == {tuple(np.roll(rim, -rim.argmin())) for rim in expected}
    assert len(rims) == len(expected)
    firsts = [min(t for t, face in enumerate(faces.tolist()) if set(face) <= set(rim.tolist())) for rim in rims]
    assert firsts == sorted(firsts)
    assert [t // 3 for t in found.places[np.cumsum(found.lengths) - found.lengths]] == found.triangles.tolist()


def test_the_time_of_a_comb_is_quadratic() -> None:
    """At first most convex corners of a comb are no ears: with a full search for each ear, it takes over ten seconds."""
    teeth = np.column_stack([np.arange(2000), np.tile([0.0, 10.0], 1000), np.zeros(2000)])
    vertices, start = np.concatenate([teeth - [0, 1, 0], teeth[::-1]]), time.process_time()
    assert len(triangulated(vertices, np.arange(4000), np.array([4000]))[0]) == 3998
    assert time.process_time() - start < 5.0


def test_a_face_of_too_many_corners_is_refused() -> None:
    """The time of a face grows with the square of its corners; so all formats refuse those of more than 10,000 vertices."""
    vertices = np.zeros((10_001, 3))
    with pytest.raises(ContentsError, match="a face of more than 10,000 vertices"):
        triangulated(vertices, np.arange(10_004) % 10_001, np.array([3, 10_001]))
    assert len(triangulated(vertices, np.arange(10_003) % 10_001, np.array([3, 10_000]))[0]) == 9999


def test_a_polygon_whose_triangles_differ_is_triangles() -> None:
    """A polygon has one value for all its triangles; those that have several, NaN being one value, are not joined."""
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]], np.int32)
    polygon, values = np.array([0, 0, 1, 1]), np.array([np.nan, np.nan, 1.0, 2.0])
    found = outlines(faces, polygon, [values, np.zeros((4, 4))])
    assert found.lengths.tolist() == [4, 3, 3]
    assert found.notes == ("polygons whose triangles have different values are written as triangles (1)",)
