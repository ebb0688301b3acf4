"""Outliers that are off along the surface as well."""

from __future__ import annotations

import numpy as np

from pymeshfair.filters.denoising.slid import evened, folding, have_slid
from pymeshfair.filters.evidence import far_from_border
from pymeshfair.filters.geometry import mean_edge_length
from tests.meshes import irregular_grid

SHEET, FACES = irregular_grid(30, 34)
POINTS = SHEET / mean_edge_length(SHEET, FACES)
UP = np.tile([0.0, 0.0, 1.0], (len(POINTS), 1))
OUTLYING = np.zeros(len(POINTS), dtype=np.bool_)
OUTLYING[np.flatnonzero(far_from_border(FACES, len(POINTS)))[::23]] = True


def _off(along: float, up: float) -> np.ndarray:
    points = POINTS.copy()
    points[OUTLYING] += (along, 0.0, up)
    return points


def test_spikes_along_normals_have_not_slid() -> None:
    """Heights alone, however large, and ways along a sheet that fold nothing say nothing; an edge and a half does."""
    assert not have_slid(_off(0.0, 3.0), FACES, UP, OUTLYING)
    assert not have_slid(_off(0.1, 3.0), FACES, UP, OUTLYING)
    assert have_slid(_off(1.5, 0.0), FACES, UP, OUTLYING)
    assert not have_slid(POINTS, FACES, UP, np.zeros_like(OUTLYING))


def test_what_folds_is_found_and_put_back() -> None:
    """Vertices an edge and a half off fold faces, known or not; put back they are among their neighbours, and the others stay."""
    points = _off(1.5, 0.0)
    nobody = np.zeros_like(OUTLYING)
    assert folding(points, FACES, UP, nobody)[OUTLYING].all()
    assert not folding(points, FACES, UP, nobody, ~OUTLYING)[OUTLYING].any()
    assert not folding(POINTS, FACES, UP, nobody).any()
    back = evened(points, FACES, UP, OUTLYING)
    assert np.array_equal(back[~OUTLYING], points[~OUTLYING])
    assert np.linalg.norm(back - POINTS, axis=1)[OUTLYING].max() < 0.5
