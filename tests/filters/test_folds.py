"""Faces that results leave folded over."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pymeshfair.filters.evidence import choose, far_from_border, folded_share, folds_cost_more, upright
from pymeshfair.filters.geometry import mean_edge_length
from tests.meshes import Floats, Ints, irregular_grid, renumbered, rotation

SHEET, FACES = irregular_grid(40, 40)
POINTS = SHEET / mean_edge_length(SHEET, FACES)
UP = np.tile([0.0, 0.0, 1.0], (len(POINTS), 1))
EVERY = np.ones(len(POINTS), dtype=np.bool_)


def _slid(every: int, by: float) -> Floats:
    """The sheet, one of so many inner vertices moved along it by so many edges."""
    points = POINTS.copy()
    points[np.flatnonzero(far_from_border(FACES, len(POINTS)))[::every], 0] += by
    return points


def _turned_over(points: Floats) -> float:
    """The share of the triangles of a flat sheet that run clockwise, seen from above."""
    a, b, c = (points[FACES[:, k], :2] for k in range(3))
    (x, y), (u, v) = (b - a).T, (c - a).T
    return float(np.mean(x * v - y * u < 0.0))


@pytest.mark.parametrize("by", [0.0, 0.5, 1.5])
def test_faces_of_a_sheet_are_folded_over_if_they_run_clockwise(by: float) -> None:
    """The share is that of the negative areas in the plan, the same for the sheet turned and renumbered."""
    points = _slid(11, by)
    expected = _turned_over(points)
    assert (expected > 0.01) is (by > 1.0)
    assert folded_share(points, FACES, UP) == expected
    turn = rotation()
    assert folded_share(points @ turn.T, FACES, UP @ turn.T) == expected
    shuffled, faces, _ = renumbered((points, FACES))
    assert folded_share(shuffled, faces, UP) == expected


def test_of_many_folds_twice_the_least_are_allowed_and_a_few_always() -> None:
    """With a hundredth allowed 0.007 and 0 are alike; above it more than twice the least is too much."""
    assert upright([0.0, 0.007, 0.02], 0.01).tolist() == [True, True, False]
    assert upright([0.05, 0.09, 0.11], 0.01).tolist() == [True, True, False]


@pytest.mark.parametrize(("share", "expected"), [(0.02, True), (0.002, False), (-0.02, False)])
def test_folds_cost_more_than_a_tilt(share: float, expected: bool) -> None:
    """A fiftieth of the faces folded over outweighs a repetition that takes 5 degrees, a five-hundredth does not."""
    assert folds_cost_more(share, _tilted(5.0), _tilted(10.0), FACES) is expected


def _tilted(degrees: float) -> Floats:
    """The sheet, turned about an axis in it, or nearly: its normals are off by so many degrees."""
    points = POINTS.copy()
    points[:, 2] = np.tan(np.radians(degrees)) * POINTS[:, 0]
    return points


def test_folds_lose_though_heights_do_not_tell() -> None:
    """A flat result wins over one with ripples, but not if it leaves faces folded over."""
    noise = 0.1 * np.random.default_rng(0).normal(size=len(POINTS))
    scan = POINTS + noise[:, None] * UP
    ripples = 0.01 * np.random.default_rng(1).normal(size=len(POINTS))[:, None] * UP

    for flat, expected in ((POINTS, "flat"), (_slid(11, 1.5), "ripples")):

        def candidates(start: Floats, held: Ints, flat: Floats = flat) -> list[Iterator[Floats]]:
            return [iter([start]), iter([flat]), iter([POINTS + ripples])]

        found = choose(scan, FACES, candidates, [["nothing"], ["flat"], ["ripples"]], normals=UP, scored=EVERY)
        assert found is not None
        assert found.chosen.label == expected
