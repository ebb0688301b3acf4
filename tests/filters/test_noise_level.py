"""The noise of a mesh is measured from the mesh alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.correlated_noise import shared_noise
from pymeshfair.filters.denoising.noise_level import estimate_noise, residual_correlation, smooth_normals
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import edges
from tests.meshes import (
    cube,
    grid,
    icosphere,
    irregular_grid,
    noisy,
    renumbered,
    rotation,
    single_triangle,
    subdivided,
    torus,
)

SHAPES = {
    "sphere": icosphere(4),
    "torus": torus(80, 40),
    "cube": subdivided(*subdivided(*subdivided(*subdivided(*subdivided(*cube()))))),
}


def _along_normals(name: str, level: float, share: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = SHAPES[name]
    rng = np.random.default_rng(7)
    moved = rng.random(len(vertices)) < share
    heights = rng.normal(size=len(vertices)) * level * mean_edge_length(vertices, faces) * moved
    return vertices + heights[:, None] * smooth_normals(vertices, faces), faces


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("level", [0.1, 0.2, 0.4, 0.6])
def test_level_is_that_of_the_noise(name: str, level: float) -> None:
    """The level in mesh units is right within 15 % from weak to very strong noise, on smooth and on sharp shapes."""
    vertices, faces = SHAPES[name]
    found = estimate_noise(*_along_normals(name, level))
    assert found.length == pytest.approx(level * mean_edge_length(vertices, faces), rel=0.15)


def test_tails_tell_impulsive_noise() -> None:
    """If a fifth of the vertices moves, the mean square is far above what the median says; of Gaussian noise they agree."""
    assert estimate_noise(*_along_normals("sphere", 0.3)).tails == pytest.approx(1.0, abs=0.06)
    assert estimate_noise(*_along_normals("sphere", 0.5, share=0.2)).tails > 1.4


def test_a_plane_has_no_noise_but_may_be_sampled_unevenly() -> None:
    """Vertices shifted within a plane are no noise along the normal, and are seen along the tangents."""
    vertices, faces = grid(30, 30)
    shifts = np.random.default_rng(1).normal(0.0, 0.1, vertices.shape) * [1.0, 1.0, 0.0]
    found = estimate_noise(vertices + shifts, faces)
    assert found.deviation < 1e-12
    assert found.tangential == pytest.approx(0.1 / mean_edge_length(vertices + shifts, faces), rel=0.1)


def test_noise_along_a_view_direction_stands_out() -> None:
    """On a plane all residuals are parallel; on a sphere they look everywhere."""
    vertices, faces = grid(20, 20)
    heights = np.random.default_rng(2).normal(0.0, 0.02, len(vertices))
    found = estimate_noise(vertices + heights[:, None] * [0.0, 0.0, 1.0], faces)
    assert found.anisotropy > 0.95
    assert abs(found.direction[2]) > 0.99
    assert estimate_noise(*_along_normals("sphere", 0.2)).anisotropy < 0.1


def test_moved_turned_scaled_and_renumbered_meshes_have_the_same_noise() -> None:
    """Every number but the length is the same to 1e-9, and the length grows with the mesh."""
    vertices, faces = noisy(torus(40, 20), 0.03)
    first = estimate_noise(vertices, faces)
    turned = estimate_noise(100.0 * vertices @ rotation().T + [3.0, -4.0, 5.0], faces)
    shuffled = estimate_noise(*renumbered((vertices, faces))[:2])
    for other in (turned, shuffled):
        for name in ("level", "deviation", "tails", "tangential", "anisotropy"):
            assert getattr(other, name) == pytest.approx(getattr(first, name), rel=1e-9, abs=1e-9)
    assert turned.length == pytest.approx(100.0 * first.length, rel=1e-9)


def test_without_inner_vertices_there_is_no_noise() -> None:
    """A triangle and a mesh without faces have the level 0."""
    assert estimate_noise(*single_triangle()).level == 0.0
    assert estimate_noise(np.zeros((3, 3)), np.empty((0, 3), dtype=np.int32)).level == 0.0


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
    assert abs(residual_correlation(vertices * (1.0 + heights)[:, None], faces)) < 0.01
    assert residual_correlation(vertices * (1.0 + shared)[:, None], faces) > 0.03


def test_the_edges_of_a_cube_agree_and_its_calmest_third_does_not() -> None:
    """Noise of 0.03 edges on a cube: all of it agrees like a surface, the third without edges by less than 0.1."""
    vertices, faces = _along_normals("cube", 0.03)
    assert residual_correlation(vertices, faces) > 0.1
    assert residual_correlation(vertices, faces, calmest=1.0 / 3.0) < 0.1


def test_the_calmest_third_of_a_surface_agrees() -> None:
    """Vertices anywhere on a ball agree everywhere."""
    vertices, faces = noisy(icosphere(4), 0.01)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    assert residual_correlation(vertices, faces, calmest=1.0 / 3.0) > 0.13


def test_a_depth_camera_is_told_from_rough_land_and_from_a_closed_shape() -> None:
    """Steps and blurred noise along the view are a camera's; waves of all sizes with independent noise, and a ball, are not."""
    rng = np.random.default_rng(1)
    vertices, faces = grid(100, 100)
    x, y = vertices[:, 0], vertices[:, 1]
    blurred = gaussian_filter(rng.normal(size=(101, 101)), 1.5).ravel()
    camera = vertices.copy()
    camera[:, 2] = 2.0 * np.round(2.0 * np.sin(x / 9.0) * np.cos(y / 11.0) + 0.6 * blurred / blurred.std())
    land, land_faces = irregular_grid(70, 70)
    x, y = land[:, 0], land[:, 1]
    waves = [
        8.0 * 0.45**k * np.sin(0.06 * 2**k * (a * x + b * y) + c) for k in range(1, 5) for a, b, c in rng.normal(size=(4, 3))
    ]
    land = np.column_stack([x, y, np.sum(waves, axis=0) + 0.2 * rng.normal(size=len(land))])
    for points, triangles, expected in (
        (camera, faces, True),
        (land, land_faces, False),
        (*_along_normals("sphere", 0.2), False),
    ):
        assert (shared_noise(points, triangles, estimate_noise(points, triangles)) > 0.0) is expected


def test_a_mesh_without_inner_vertices_agrees_in_nothing() -> None:
    """A triangle has no residuals."""
    assert residual_correlation(*single_triangle()) == 0.0
