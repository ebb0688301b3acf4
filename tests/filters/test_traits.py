"""The traits of a scan, by which recipes are chosen: noise, sharp edges, and whether it is seen from one side."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising import Scan
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection import surface_measures
from pymeshfair.filters.traits import facing, measured_traits, sharpness
from tests.meshes import Mesh, cube, grid, icosphere, rotation, subdivided, torus, tube

#: a cube of 16 edges to a side
FINE_CUBE = subdivided(*subdivided(*subdivided(*subdivided(*cube()))))


def can(around: int, radius: float, height: float) -> Mesh:
    """A cylinder whose lids are rings, open in the middle."""
    vertices, faces = tube(around, 8)
    outline = [(0.5, 0.0), *((1.0, k / 6.0) for k in range(7)), (0.5, 1.0)]
    vertices[:, 2] = 1.0
    return vertices * [(r * radius, r * radius, z * height) for r, z in outline for _ in range(around)], faces


def along_normals(mesh: Mesh, level: float, seed: int = 3) -> Mesh:
    """A sphere around 0 with independent noise of that many mean edges along its normals."""
    vertices, faces = mesh
    heights = np.random.default_rng(seed).normal(scale=level * mean_edge_length(vertices, faces), size=(len(vertices), 1))
    return vertices + heights * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces


def test_facing_is_one_for_a_plane_a_half_for_half_a_ball_and_zero_for_what_is_closed() -> None:
    """|sum A n| / sum A: the shadow of a half ball is pi r^2, its area twice that; a closed surface has no sum."""
    assert facing(*grid()) == pytest.approx(1.0)
    assert facing(*icosphere(2)) == pytest.approx(0.0, abs=1e-12)
    vertices, faces = icosphere(5)
    half = faces[(vertices[faces].mean(axis=1)[:, 2] > 0)]
    assert facing(vertices, half) == pytest.approx(0.5, abs=0.01)  # the rim is a zigzag of edges of 0.04


def test_facing_of_no_area_is_zero() -> None:
    """Without faces, or with faces of no area, there is no side."""
    assert facing(np.zeros((3, 3)), np.array([[0, 1, 2]])) == 0.0
    assert facing(np.zeros((3, 3)), np.zeros((0, 3), dtype=np.int32)) == 0.0


def test_all_bending_of_a_cube_is_at_its_edges_and_none_of_a_ball() -> None:
    """Planes that meet at right angles bend nowhere else; a ball of edges of 4 degrees nowhere by 30."""
    assert sharpness(Scan.of(*FINE_CUBE), 0.0) == pytest.approx(1.0)
    assert sharpness(Scan.of(*icosphere(4)), 0.0) == 0.0
    assert sharpness(Scan.of(*grid()), 0.0) == 0.0


def test_a_cylinder_bends_at_its_rims_by_the_share_of_its_closed_form() -> None:
    """Two rims of pi / 2 along 2 pi r, and 2 pi around the height h: the share is pi r / (pi r + h)."""
    radius, height = 1.0, 2.0
    found = sharpness(Scan.of(*can(48, radius, height)), 0.0)
    # The mean over the neighbours turns the two triangles of a square at a rim, which have others around them, a little apart.
    assert found == pytest.approx(np.pi * radius / (np.pi * radius + height), rel=0.05)


@pytest.mark.parametrize("level", [0.1, 0.3])
def test_noise_does_not_hide_edges_and_makes_none(level: float) -> None:
    """A cube under noise still bends at its edges for the most part, a ball under the same noise hardly there."""
    vertices, faces = FINE_CUBE
    shifts = np.random.default_rng(4).normal(scale=level * mean_edge_length(vertices, faces), size=vertices.shape)
    assert sharpness(Scan.of(vertices + shifts, faces), level) > 0.7
    assert sharpness(Scan.of(*along_normals(icosphere(4), level)), level) < 0.2


@pytest.mark.parametrize("level", [0.1, 0.3])
def test_noise_of_a_ball_is_what_was_added(level: float) -> None:
    """Even noise along the normals is found to a fifth, of the calm part and of the whole alike."""
    assert Scan.of(*along_normals(icosphere(4), level)).surface_noise == pytest.approx(level, rel=0.2)


def test_noise_on_half_of_a_surface_is_that_of_the_calm_half() -> None:
    """Details on one half of a ball are no noise: the other half has a tenth of them, and that is what is found."""
    ball = icosphere(4)
    rough, calm = along_normals(ball, 0.3)[0], along_normals(ball, 0.03)[0]
    mixed = np.where(ball[0][:, 2:] > 0.0, rough, calm)
    assert Scan.of(mixed, ball[1]).surface_noise == pytest.approx(0.03, rel=0.3)


def test_planes_as_they_were_designed_have_no_noise() -> None:
    """A cube of twelve triangles has corners alone, which are not noise."""
    assert measured_traits(*subdivided(*cube()))["noise"] == 0.0


def test_traits_do_not_depend_on_place_size_and_turn() -> None:
    """Moved, turned and scaled, a noisy torus has the same traits but for rounding."""
    vertices, faces = torus(48, 24)
    vertices = vertices + np.random.default_rng(5).normal(scale=0.01, size=vertices.shape)
    first = measured_traits(vertices, faces)
    second = measured_traits(1e3 * vertices @ rotation().T + 5e4, faces)
    assert first.keys() == second.keys()
    for name, value in first.items():
        assert second[name] == pytest.approx(value, rel=1e-5, abs=1e-6), name


def test_a_mean_edge_that_is_known_changes_no_bit() -> None:
    """Of a mesh of 32,768 faces, which is sampled, and of its copy far away and larger, no trait changes."""
    vertices, faces = torus(128, 128)
    rng = np.random.default_rng(5)
    for points in (vertices + rng.normal(scale=1e-3, size=vertices.shape), 1e5 * vertices + 1e7):
        known = surface_measures(points, faces).mean_edge
        assert measured_traits(points, faces, mean_edge=known) == measured_traits(points, faces)


def test_only_what_is_wanted_is_measured_and_unknown_traits_are_refused() -> None:
    """One trait asked for is one trait given; a wrong name is an error."""
    assert list(measured_traits(*icosphere(2), ("facing",))) == ["facing"]
    assert list(measured_traits(*icosphere(2), ("noise",))) == ["noise"]
    with pytest.raises(FilterInputError, match="wanted"):
        measured_traits(*icosphere(2), ("weight",))


@pytest.mark.parametrize("faces", [np.zeros((0, 3), dtype=np.int32), np.array([[0, 1, 2]], dtype=np.int32)])
def test_tiny_meshes_have_traits_too(faces: np.ndarray) -> None:
    """No face, or one, is no noise, no edge and no camera."""
    found = measured_traits(np.eye(3), faces)
    assert (found["noise"], found["sharpness"], found["camera noise"]) == (0.0, 0.0, 0.0)
