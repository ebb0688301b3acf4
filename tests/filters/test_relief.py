"""The loss of relief: what is taken of heights that are no noise."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion import explicit_smoothing, relief_lost
from pymeshfair.filters.geometry import mean_edge_length
from tests.meshes import Mesh, icosphere, noisy


def _bumpy() -> tuple[Mesh, np.ndarray]:
    """A ball with bumps, and the ball without them."""
    vertices, faces = icosphere(4)
    x, y, z = 12.0 * vertices.T
    return (vertices * (1.0 + 0.03 * np.sin(x) * np.sin(y) * np.cos(z))[:, None], faces), vertices


def _share(before: np.ndarray, after: np.ndarray, faces: np.ndarray) -> float:
    lost = relief_lost(before, after, faces)
    assert lost is not None
    assert lost.shortest == 0.0
    return lost.share


def test_nothing_is_lost_where_nothing_moves_and_all_where_bumps_go() -> None:
    """0 for the same surface; bumps at half their height are half lost, those that are gone are lost."""
    (bumps, faces), ball = _bumpy()
    assert _share(bumps, bumps, faces) == pytest.approx(0.0, abs=1e-12)
    assert _share(bumps, 0.5 * (bumps + ball), faces) == pytest.approx(0.5, abs=0.03)
    assert _share(bumps, ball, faces) == pytest.approx(1.0, abs=0.06)


def test_noise_that_goes_is_no_loss() -> None:
    """Bumps with noise of 0.05 edges: the bumps without it lost less than 5 %; noise alone is no relief."""
    (bumps, faces), ball = _bumpy()
    edge = mean_edge_length(ball, faces)
    noise = np.random.default_rng(4).normal(scale=0.05 * edge, size=(len(ball), 1)) * ball
    lost = relief_lost(bumps + noise, bumps, faces, noise=0.05)
    assert lost is not None
    assert lost.share < 0.05
    assert relief_lost(ball + 6.0 * noise, ball, faces, noise=0.3) is None


def test_noise_hides_short_relief_alone() -> None:
    """Bumps of nine edges with noise of 0.3 edges: what counts are waves from 6 edges on, and half of them is lost."""
    ball, faces = icosphere(5)
    x, y, z = 12.0 * ball.T
    bumps = ball * (1.0 + 0.06 * np.sin(x) * np.sin(y) * np.cos(z))[:, None]
    noise = np.random.default_rng(4).normal(scale=0.3 * mean_edge_length(ball, faces), size=(len(ball), 1)) * ball
    lost = relief_lost(bumps + noise, 0.5 * (bumps + ball), faces, noise=0.3)
    assert lost is not None
    assert lost.shortest == 6.0
    assert lost.share == pytest.approx(0.5, abs=0.1)


def test_another_number_of_vertices_is_refused() -> None:
    """The heights of vertices are compared one by one."""
    vertices, faces = icosphere(1)
    with pytest.raises(FilterInputError, match="the 42 vertices of before, got 43"):
        relief_lost(vertices, np.append(vertices, [[0, 0, 0]], axis=0), faces)


def test_collapsed_triangles_are_not_measured() -> None:
    """Triangles with vertices of their own, each smoothed to nearly a point, have no loss: their smoothing has no solution."""
    vertices, faces = noisy(icosphere(3), 0.01)
    soup, own = vertices[faces].reshape(-1, 3), np.arange(faces.size, dtype=np.int32).reshape(-1, 3)
    assert relief_lost(soup, explicit_smoothing(soup, own), own) is None
