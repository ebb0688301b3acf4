"""Folded faces taken back."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pymeshfair.filters.denoising import HALF_WAY, Outliers, denoised, unfolded
from pymeshfair.filters.inspection import folded_faces
from tests.meshes import grid, icosphere, irregular_grid, noisy

MESHES = {"ball": icosphere(2), "sheet": grid(8, 7), "irregular": irregular_grid(9, 10)}


@given(
    name=st.sampled_from(sorted(MESHES)),
    before=st.floats(0.0, 0.4),
    after=st.floats(0.0, 0.8),
    moved=st.floats(0.0, 1.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_more_faces_are_folded_than_before(name: str, before: float, after: float, moved: float, seed: int) -> None:
    """Wherever vertices have gone, they go back until no more faces are folded; what folds no face stays, to the bit."""
    (vertices, faces), rng = MESHES[name], np.random.default_rng(seed)
    start = vertices + before * rng.normal(size=vertices.shape)
    end = start + after * rng.normal(size=start.shape) * (rng.random((len(start), 1)) < moved)
    found = unfolded(start, end, faces)
    most, then = folded_faces(start, faces).sum(), folded_faces(end, faces).sum()
    assert folded_faces(found, faces).sum() <= most
    places = (start, start + HALF_WAY * (end - start), end)
    assert np.any([(found == place).all(axis=1) for place in places], axis=0).all()
    assert np.array_equal(found, end) == (then <= most)


def test_corners_go_back_half_of_their_way_where_that_is_enough() -> None:
    """A vertex of a flat sheet is pulled over its neighbour, and all heights change: the rest stays where it went."""
    start, faces = grid(6, 6)
    end = start + np.random.default_rng(1).normal(size=start.shape) * [0.0, 0.0, 0.01]
    end[len(start) // 2, 0] += 1.8
    corners = np.isin(np.arange(len(start)), faces[folded_faces(end, faces)])
    assert corners.any()
    np.testing.assert_array_equal(unfolded(start, end, faces), np.where(corners[:, None], start + HALF_WAY * (end - start), end))


@settings(max_examples=15, deadline=None)
@given(
    name=st.sampled_from(sorted(MESHES)),
    noise=st.floats(0.0, 0.3),
    relaxation=st.integers(0, 20),
    rounds=st.integers(0, 20),
    outliers=st.sampled_from(["keep", "replace", "only"]),
    seed=st.integers(0, 1000),
)
def test_denoising_folds_no_more_faces(
    name: str, noise: float, relaxation: int, rounds: int, outliers: Outliers, seed: int
) -> None:
    """Whatever the noise and the setting."""
    vertices, faces = noisy(MESHES[name], noise, seed=seed)
    filtering = {"outer_iterations": rounds, "method": "averaged", "neighborhood": "two_ring", "range_sigma": 0.5}
    result = denoised(vertices, faces, outliers=outliers, relaxation=relaxation, filtering=filtering)
    assert folded_faces(result, faces).sum() <= folded_faces(vertices, faces).sum()
