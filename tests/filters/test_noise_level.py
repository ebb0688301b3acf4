"""The noise of a mesh is measured from the mesh alone."""

from __future__ import annotations

import numpy as np
import pytest
from denoising_pairs import along_normals

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.noise_level import agreement, estimate_noise
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import edges
from tests.meshes import cube, grid, icosphere, noisy, renumbered, rotation, single_triangle, torus

SHAPES = {
    "sphere": icosphere(4),
    "torus": torus(80, 40),
    "cube": cube(5),
}


def _along_normals(name: str, level: float, share: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    return along_normals(level, share)(*SHAPES[name], np.random.default_rng(7)), SHAPES[name][1]


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("level", [0.1, 0.2, 0.4, 0.6])
def test_level_is_that_of_the_noise(name: str, level: float) -> None:
    """The level in mesh units is right within 15 % from weak to very strong noise, on smooth and on sharp shapes."""
    vertices, faces = SHAPES[name]
    found = estimate_noise(*_along_normals(name, level))
    assert found.length == pytest.approx(level * mean_edge_length(vertices, faces), rel=0.15)


def test_the_deviation_tells_impulsive_noise() -> None:
    """If a fifth of the vertices moves, the mean square is far above what the median says; of Gaussian noise they agree."""
    even, spiky = (estimate_noise(*_along_normals("sphere", level, share)) for level, share in ((0.3, 1.0), (0.5, 0.2)))
    assert even.deviation / even.level == pytest.approx(1.0, abs=0.06)
    assert spiky.deviation / spiky.level > 1.4


def test_a_plane_has_no_noise_but_may_be_sampled_unevenly() -> None:
    """Vertices shifted within a plane are no noise along the normal, and are seen along the tangents."""
    vertices, faces = grid(30, 30)
    shifts = np.random.default_rng(1).normal(0.0, 0.1, vertices.shape) * [1.0, 1.0, 0.0]
    found = estimate_noise(vertices + shifts, faces)
    assert found.deviation < 1e-12
    assert found.tangential == pytest.approx(0.1 / mean_edge_length(vertices + shifts, faces), rel=0.1)


def test_moved_turned_scaled_and_renumbered_meshes_have_the_same_noise() -> None:
    """Every number but the length is the same to 1e-9, and the length grows with the mesh."""
    vertices, faces = noisy(torus(40, 20), 0.03)
    first = estimate_noise(vertices, faces)
    turned = estimate_noise(100.0 * vertices @ rotation().T + [3.0, -4.0, 5.0], faces)
    shuffled = estimate_noise(*renumbered((vertices, faces))[:2])
    for other in (turned, shuffled):
        for name in ("level", "deviation", "tangential"):
            assert getattr(other, name) == pytest.approx(getattr(first, name), rel=1e-9, abs=1e-9)
    assert turned.length == pytest.approx(100.0 * first.length, rel=1e-9)


def test_without_inner_vertices_there_is_no_noise() -> None:
    """A triangle and a mesh without faces have the level 0, and residuals that agree in nothing."""
    for mesh in (single_triangle(), (np.zeros((3, 3)), np.empty((0, 3), dtype=np.int32))):
        assert estimate_noise(*mesh).level == 0.0
        assert agreement(*mesh) == (0.0, 0.0)


def test_what_is_no_mesh_is_refused() -> None:
    """Indices out of range are an error of the filters."""
    with pytest.raises(FilterInputError):
        estimate_noise(np.zeros((3, 3)), [[0, 1, 3]])


def test_noise_that_neighbours_share_is_told_from_independent_noise() -> None:
    """On a sphere independent noise gives 0 up to 0.01, half of which is the mean of the one-ring more than 0.03."""
    vertices, faces = icosphere(4)
    heights = np.random.default_rng(6).normal(size=len(vertices)) * 0.3 * mean_edge_length(vertices, faces)
    pairs = edges(faces)
    shared = heights.copy()
    np.add.at(shared, pairs[:, 0], heights[pairs[:, 1]] / 6.0)
    np.add.at(shared, pairs[:, 1], heights[pairs[:, 0]] / 6.0)
    assert abs(agreement(vertices * (1.0 + heights)[:, None], faces)[0]) < 0.01
    assert agreement(vertices * (1.0 + shared)[:, None], faces)[0] > 0.03


def test_where_it_is_calm_a_surface_agrees_and_the_noise_of_a_cube_does_not() -> None:
    """Noise of 0.03 edges on a cube: all of it agrees like a surface, the third without edges by less than 0.1.

    Vertices anywhere on a ball agree everywhere.
    """
    everywhere, calm = agreement(*_along_normals("cube", 0.03))
    assert everywhere > 0.1 > calm
    vertices, faces = noisy(icosphere(4), 0.01)
    assert agreement(vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces)[1] > 0.13
