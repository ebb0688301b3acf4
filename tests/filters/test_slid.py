"""Outliers that are off along the surface as well."""

from __future__ import annotations

import numpy as np

from pymeshfair.filters.denoising.slid import WaysBack
from pymeshfair.filters.evidence import far_from_border
from pymeshfair.filters.geometry import mean_edge_length
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
    assert not WaysBack.of(_off(0.0, 3.0), FACES, UP, OUTLYING).slid
    assert not WaysBack.of(_off(0.1, 3.0), FACES, UP, OUTLYING).slid
    assert WaysBack.of(_off(1.5, 0.0), FACES, UP, OUTLYING).slid
    assert not WaysBack.of(POINTS, FACES, UP, NOBODY).slid


def test_what_folds_is_found_and_put_back() -> None:
    """Vertices an edge and a half off fold faces, known or not; put back they are among their neighbours, and the others stay."""
    points = _off(1.5, 0.0)
    unknown = WaysBack.of(points, FACES, UP, NOBODY)
    assert unknown.folding()[OUTLYING].all()
    assert not unknown.folding(~OUTLYING)[OUTLYING].any()
    assert not WaysBack.of(POINTS, FACES, UP, NOBODY).folding().any()
    back = WaysBack.of(points, FACES, UP, OUTLYING).evened()
    assert np.array_equal(back[~OUTLYING], points[~OUTLYING])
    assert np.linalg.norm(back - POINTS, axis=1)[OUTLYING].max() < 0.5
