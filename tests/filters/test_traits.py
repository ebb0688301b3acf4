"""The traits of a scan, by which recipes are chosen: noise, sharp edges, and whether it is seen from one side."""

from __future__ import annotations

import numpy as np
import pytest
from denoising_pairs import along_normals

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising import Scan
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection import surface_measures
from pymeshfair.filters.traits import measured_traits, sharpness
from tests.meshes import Floats, Ints, Mesh, cube, grid, icosphere, noisy, rotation, torus, tube

#: a cube of 16 edges to a side
FINE_CUBE = cube(4)


def can(around: int) -> Mesh:
    """A cylinder of radius 1 and height 2 whose lids are rings, open in the middle."""
    vertices, faces = tube(around, 8)
    outline = [(0.5, 0.0), *((1.0, k / 3.0) for k in range(7)), (0.5, 2.0)]
    vertices[:, 2] = 1.0
    return vertices * [(r, r, z) for r, z in outline for _ in range(around)], faces


def rough_ball(level: float) -> Mesh:
    """A ball with independent noise of that many mean edges along its normals."""
    ball = icosphere(4)
    return along_normals(level)(*ball, np.random.default_rng(3)), ball[1]


def test_facing_is_one_for_a_plane_a_half_for_half_a_ball_and_zero_for_what_is_closed() -> None:
    """|sum A n| / sum A: the shadow of a half ball is pi r^2, its area twice that; a closed one has no sum, nor has no area."""

    def facing(vertices: Floats, faces: Ints) -> float:
        return measured_traits(vertices, faces, ["facing"])["facing"]

    assert facing(*grid()) == pytest.approx(1.0)
    assert facing(*icosphere(2)) == pytest.approx(0.0, abs=1e-12)
    vertices, faces = icosphere(5)
    half = faces[(vertices[faces].mean(axis=1)[:, 2] > 0)]
    assert facing(vertices, half) == pytest.approx(0.5, abs=0.01)  # the rim is a zigzag of edges of 0.04
    assert facing(np.zeros((3, 3)), np.array([[0, 1, 2]], dtype=np.int32)) == 0.0
    assert facing(np.zeros((3, 3)), np.zeros((0, 3), dtype=np.int32)) == 0.0


def test_all_bending_of_a_cube_is_at_its_edges_and_none_of_a_ball() -> None:
    """Planes that meet at right angles bend nowhere else; a ball of edges of 4 degrees nowhere by 30."""
    assert sharpness(Scan.of(*FINE_CUBE), 0.0) == pytest.approx(1.0)
    assert sharpness(Scan.of(*icosphere(4)), 0.0) == 0.0
    assert sharpness(Scan.of(*grid()), 0.0) == 0.0


def test_a_cylinder_bends_at_its_rims_by_the_share_of_its_closed_form() -> None:
    """Two rims of pi / 2 along 2 pi r, and 2 pi around the height h: the share is pi r / (pi r + h)."""
    # The mean over the neighbours turns the two triangles of a square at a rim, which have others around them, a little apart:
    # by half as much on the finer cylinder.
    for around, apart in ((48, 0.06), (96, 0.03)):
        assert sharpness(Scan.of(*can(around)), 0.0) == pytest.approx(np.pi / (np.pi + 2.0), rel=apart)


@pytest.mark.parametrize("level", [0.1, 0.3])
def test_noise_does_not_hide_edges_and_makes_none(level: float) -> None:
    """A cube under noise still bends at its edges for the most part, a ball under the same noise hardly there."""
    assert sharpness(Scan.of(*noisy(FINE_CUBE, level * mean_edge_length(*FINE_CUBE), seed=4)), level) > 0.7
    assert sharpness(Scan.of(*rough_ball(level)), level) < 0.2


@pytest.mark.parametrize(("below", "above"), [(0.1, 0.1), (0.3, 0.3), (0.03, 0.3)])
def test_noise_of_a_ball_is_that_of_its_calmer_half(below: float, above: float) -> None:
    """Even noise along the normals is found to a fifth; more of it on one half counts as details."""
    ball = icosphere(4)
    mixed = np.where(ball[0][:, 2:] > 0.0, rough_ball(above)[0], rough_ball(below)[0])
    assert Scan.of(mixed, ball[1]).surface_noise == pytest.approx(below, rel=0.2 if below == above else 0.3)


def test_planes_as_they_were_designed_have_no_noise() -> None:
    """A cube of twelve triangles has corners alone, which are not noise."""
    assert measured_traits(*cube(1))["noise"] == 0.0


def test_traits_do_not_depend_on_place_size_and_turn() -> None:
    """Moved, turned and scaled, a noisy torus has the same traits but for rounding."""
    vertices, faces = noisy(torus(48, 24), 0.01, seed=5)
    first = measured_traits(vertices, faces)
    second = measured_traits(1e3 * vertices @ rotation().T + 5e4, faces)
    assert first.keys() == second.keys()
    for name, value in first.items():
        assert second[name] == pytest.approx(value, rel=1e-5, abs=1e-6), name


def test_a_mean_edge_that_is_known_changes_no_bit() -> None:
    """Of a mesh of 32,768 faces, which is sampled, and of its copy far away and larger, no trait changes."""
    vertices, faces = torus(128, 128)
    for points in (noisy((vertices, faces), 1e-3)[0], 1e5 * vertices + 1e7):
        known = surface_measures(points, faces).mean_edge
        assert measured_traits(points, faces, mean_edge=known) == measured_traits(points, faces)


def test_only_what_is_wanted_is_measured_and_unknown_traits_are_refused() -> None:
    """One trait asked for is one trait given; a wrong name is an error."""
    for name in ("facing", "noise"):
        assert list(measured_traits(*icosphere(2), (name,))) == [name]
    with pytest.raises(FilterInputError, match="wanted"):
        measured_traits(*icosphere(2), ("weight",))


@pytest.mark.parametrize("faces", [np.zeros((0, 3), dtype=np.int32), np.array([[0, 1, 2]], dtype=np.int32)])
def test_tiny_meshes_have_traits_too(faces: np.ndarray) -> None:
    """No face, or one, is no noise, no edge and no camera."""
    found = measured_traits(np.eye(3), faces)
    assert (found["noise"], found["sharpness"], found["camera noise"]) == (0.0, 0.0, 0.0)
