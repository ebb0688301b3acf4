"""Outliers that are off along the surface as well."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.denoising.tangential_shift import TangentialShift
from pymeshfair.filters.evidence import far_from_border
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import border_vertices
from tests.meshes import irregular_grid

SHEET, FACES = irregular_grid(30, 34)
POINTS = SHEET / mean_edge_length(SHEET, FACES)
UP = np.tile([0.0, 0.0, 1.0], (len(POINTS), 1))
OUTLYING = np.zeros(len(POINTS), dtype=np.bool_)
OUTLYING[np.flatnonzero(far_from_border(FACES, len(POINTS)))[::23]] = True
NOBODY = np.zeros_like(OUTLYING)


def _off(along: float, up: float) -> np.ndarray:
    points = POINTS.copy()
    points[OUTLYING] += (along, 0.0, up)
    return points


def test_spikes_along_normals_have_not_slid() -> None:
    """Heights alone, however large, and ways along a sheet that fold nothing say nothing; an edge and a half does."""
    assert not TangentialShift.of(_off(0.0, 3.0), FACES, UP, OUTLYING).outliers_fold
    assert not TangentialShift.of(_off(0.1, 3.0), FACES, UP, OUTLYING).outliers_fold
    assert TangentialShift.of(_off(1.5, 0.0), FACES, UP, OUTLYING).outliers_fold
    assert not TangentialShift.of(POINTS, FACES, UP, NOBODY).outliers_fold


def test_what_folds_is_found_and_put_back() -> None:
    """Vertices an edge and a half off fold faces, known or not; put back they are among their neighbours, and the others stay."""
    points = _off(1.5, 0.0)
    unknown = TangentialShift.of(points, FACES, UP, NOBODY)
    assert unknown.folding()[OUTLYING].all()
    assert not unknown.folding(~OUTLYING)[OUTLYING].any()
    assert not TangentialShift.of(POINTS, FACES, UP, NOBODY).folding().any()
    back = TangentialShift.of(points, FACES, UP, OUTLYING).evened()
    assert np.array_equal(back[~OUTLYING], points[~OUTLYING])
    assert np.linalg.norm(back - POINTS, axis=1)[OUTLYING].max() < 0.5


def test_heights_move_nothing_along_the_surface() -> None:
    """Spikes along the normals keep their place in the sheet to the bit."""
    spikes = _off(0.0, 3.0)
    assert np.array_equal(TangentialShift.of(spikes, FACES, UP, OUTLYING).evened(), spikes)


def test_a_border_goes_back_to_its_outline() -> None:
    """The sides of the sheet are straight: what slid off one comes back to it, and is not drawn inwards."""
    sides = border_vertices(FACES, len(POINTS)) & (POINTS[:, 1] == POINTS[:, 1].min())
    outlying = np.zeros_like(sides)
    outlying[np.flatnonzero(sides)[3:-3:4]] = True
    points = POINTS.copy()
    points[outlying, 1] -= 1.0
    ways = TangentialShift.of(points, FACES, UP, outlying).ways[outlying]
    np.testing.assert_allclose(ways[:, 1], 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("level", [0.2, 0.4, 0.8])
def test_of_all_shares_of_the_ways_the_one_taken_is_nearly_the_best(level: float) -> None:
    """Normally distributed slides: of 101 shares none has a squared error less by more than a tenth; none and all have more."""
    random = np.random.default_rng(4)
    inner = np.flatnonzero(far_from_border(FACES, len(POINTS)))
    outlying = np.isin(np.arange(len(POINTS)), inner[random.random(len(inner)) < 0.2])
    points = POINTS.copy()
    points[outlying, :2] += level * random.normal(size=(np.count_nonzero(outlying), 2))
    ways = TangentialShift.of(points, FACES, UP, outlying)

    def error(share: float) -> float:
        return float((((points + share * ways.ways - POINTS)[outlying]) ** 2).sum())

    taken = float(((ways.evened() - POINTS)[outlying] ** 2).sum())
    assert taken == pytest.approx(error(ways.share))
    assert taken < 1.1 * min(map(error, np.linspace(0.0, 1.0, 101)))
    assert taken < min(error(0.0), error(1.0))


@pytest.mark.parametrize("exponent", [-800, -3, 400])
def test_the_share_is_that_of_the_mesh_in_other_units(exponent: int) -> None:
    """Powers of two change no digit, also where squares of lengths are too small or too large for a number."""
    points = _off(0.4, 0.0)
    assert (
        TangentialShift.of(np.ldexp(points, exponent), FACES, UP, OUTLYING).share
        == TangentialShift.of(points, FACES, UP, OUTLYING).share
        > 0.0
    )


def test_what_nothing_is_known_of_has_not_slid() -> None:
    """Without outliers, without anybody else, on a single point: the share is 0."""
    for points, outlying in ((POINTS, NOBODY), (_off(0.4, 0.0), ~NOBODY), (np.zeros_like(POINTS), OUTLYING)):
        assert TangentialShift.of(points, FACES, UP, outlying).share == 0.0
