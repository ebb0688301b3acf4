"""Relief made higher: what changes and what does not, in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.neighbours import touching_balls
from pymeshfair.filters.spectral import enhance, enhance_details
from pymeshfair.filters.spectral.detail_enhancement import SHORTEST, shortest_relief
from pymeshfair.filters.topology import border_vertices
from tests.meshes import Mesh, grid, icosphere, torus

Floats = NDArray[np.float64]


def waves(count: int, wavelength: float, height: float) -> Mesh:
    """A flat square of unit steps with waves along x."""
    vertices, faces = grid(count, count)
    vertices[:, :2] *= 1.0 / mean_step(vertices)
    vertices[:, 2] = height * np.cos(2.0 * np.pi * vertices[:, 0] / wavelength)
    return vertices, faces


def mean_step(vertices: Floats) -> float:
    """The distance of two columns of a grid."""
    return float(np.diff(np.unique(vertices[:, 0])).mean())


def test_waves_of_the_band_grow_by_the_response_and_the_border_stays() -> None:
    """In the middle of a flat sheet waves of height a become a (1 + (gain - 1) B (1 - K)), B and K the band and the low pass."""
    height, wavelength, detail, largest = 0.05, 12.0, 6.0, 24.0
    vertices, faces = waves(80, wavelength, height)
    found = enhance_details(vertices, faces, gain=3.0, detail_size=detail, largest_size=largest)
    assert np.array_equal(found.vertices[border_vertices(faces, len(vertices))], vertices[border_vertices(faces, len(vertices))])
    middle = (np.abs(vertices[:, :2] - vertices[:, :2].mean(axis=0)) < 12.0).all(axis=1)
    omega = np.array([2.0 * np.pi / wavelength])
    band = float(enhance(detail, largest)(omega)[0]) - 1.0
    slow = 2.0 ** -((wavelength / largest) ** -4)
    expected = 1.0 + 2.0 * band * (1.0 - slow)
    grown = (found.vertices[middle, 2] @ vertices[middle, 2]) / (vertices[middle, 2] @ vertices[middle, 2])
    # Twelve edges a wave: the operator's eigenvalue is (pi / 12)^2 / 3, 2.3 %, below the wave's; the border is not far.
    assert grown == pytest.approx(expected, rel=0.05)
    assert found.largest_displacement < 2.1 * height
    moved = np.linalg.norm(found.vertices - vertices, axis=1)
    assert found.largest_displacement == pytest.approx(moved.max(), rel=1e-12)
    # The relief has the share (expected - 1) / 2 of the waves, and they the root mean square height / sqrt(2).
    assert found.height == pytest.approx(height / np.sqrt(2.0) * (expected - 1.0) / 2.0, rel=0.05)
    # From the border at y = 0 on, which changes nothing of waves along x, the displacement rises by 3 d^2 - 2 d^3, d the distance
    # over the longest wave. Nearer to the border than a third of that, the base shape is drawn together.
    across = np.abs(vertices[:, 0] - vertices[:, 0].mean()) < 12.0
    rows = [across & (vertices[:, 1] == y) for y in range(8, 41)]
    risen = np.array([(found.vertices[row, 2] - vertices[row, 2]) @ vertices[row, 2] for row in rows])
    distance = np.minimum(np.arange(8, 41) / largest, 1.0)
    np.testing.assert_allclose(risen / risen[-1], 3.0 * distance**2 - 2.0 * distance**3, rtol=0, atol=0.005)


def test_a_sphere_stays_and_keeps_its_size() -> None:
    """A sphere is all shape: its heights over the smoothed one are the same everywhere, so that they are long waves."""
    vertices, faces = icosphere(4)
    edge = mean_edge_length(vertices, faces)
    found = enhance_details(vertices, faces, gain=5.0, detail_size=6 * edge, largest_size=24 * edge)
    radii = np.linalg.norm(found.vertices, axis=1)
    smoothed = 1.0 - 2.0 ** -((2.0 / (2 * np.pi / (24 * edge)) ** 2) ** 2)
    assert np.abs(radii - 1.0).max() < 0.05 * 4.0 * smoothed


def test_nothing_moves_by_more_than_the_share_of_the_thickness() -> None:
    """A torus with a tube of radius 0.3 under ten times its relief moves by a share of 0.6, and its roughness."""
    vertices, faces = torus(90, 36, minor=0.3)
    rng = np.random.default_rng(1)
    rough = vertices + 0.02 * rng.normal(size=vertices.shape)
    for most in (0.02, 0.1):
        found = enhance_details(rough, faces, gain=10.0, detail_size=0.1, largest_size=0.6, most=most)
        moved = np.linalg.norm(found.vertices - rough, axis=1).max()
        assert moved < most * 0.65
        assert moved > 0.3 * most * 0.6


@pytest.mark.parametrize(("shape", "largest"), [((1.0, 0.8, 0.6), 120), ((1.0, 0.8, 0.6), 60), ((10.0, 0.5, 0.5), 20)])
def test_a_body_that_is_thinner_than_the_waves_keeps_its_shape(shape: tuple[float, float, float], largest: float) -> None:
    """An egg and a rod far thinner than the longest wave move by less than a hundredth of an edge, turned inside out or not."""
    vertices, faces = icosphere(4)[0] * shape, icosphere(4)[1]
    edge = mean_edge_length(vertices, faces)
    for sides in (faces, faces[:, ::-1].copy()):
        found = enhance_details(vertices, sides, detail_size=5 * edge, largest_size=largest * edge)
        assert found.height > 0.1 * edge
        assert np.linalg.norm(found.vertices - vertices, axis=1).max() < 0.01 * edge


def test_a_surface_that_is_inside_out_gains_the_same_relief() -> None:
    """Thickness and gaps count alike, so that an egg of which every face is turned over moves to the same place."""
    vertices, faces = icosphere(4)[0] * (1.0, 0.8, 0.6), icosphere(4)[1]
    found, other = (enhance_details(vertices, sides, detail_size=0.3) for sides in (faces, faces[:, ::-1].copy()))
    assert found.largest_displacement > 1e-3
    np.testing.assert_allclose(other.vertices, found.vertices, atol=1e-9)


def test_only_movable_vertices_move() -> None:
    """The others keep every bit; those that move go where they would have gone."""
    vertices, faces = icosphere(3)[0] * (1.0, 0.8, 0.6), icosphere(3)[1]
    some = vertices[:, 2] > 0.2
    whole = enhance_details(vertices, faces, detail_size=0.6).vertices
    part = enhance_details(vertices, faces, detail_size=0.6, movable=some).vertices
    assert (whole != vertices).any(axis=1).all()
    np.testing.assert_array_equal(part, np.where(some[:, None], whole, vertices))


def test_gain_one_changes_no_bit_and_wrong_bands_are_refused() -> None:
    """The displacement has the factor gain - 1; a band needs two lengths in order."""
    vertices, faces = icosphere(2)
    assert np.array_equal(enhance_details(vertices, faces, gain=1.0, detail_size=0.5).vertices, vertices)
    with pytest.raises(FilterInputError, match=r"largest_size 0.5 is not above detail_size 0.5"):
        enhance_details(vertices, faces, detail_size=0.5, largest_size=0.5)
    with pytest.raises(FilterInputError, match="no triangles"):
        enhance_details(vertices, np.empty((0, 3), dtype=np.int32))


def test_balls_of_a_slab_have_half_its_thickness_and_those_of_a_sphere_its_radius() -> None:
    """Two planes at distance 1 have balls of radius 1/2 between, the largest outside; a sphere has its own ball inside."""
    x, y = np.meshgrid(np.linspace(-3.0, 3.0, 61), np.linspace(-3.0, 3.0, 61))
    flat = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    slab = np.concatenate([flat, flat + np.array([0.0, 0.0, 1.0])])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], len(flat), axis=0)
    most = np.full(len(slab), 2.0)
    np.testing.assert_allclose(touching_balls(slab, normals, largest=most), 0.5, rtol=1e-6)
    assert np.array_equal(touching_balls(slab, -normals, largest=most), most)
    vertices, _ = icosphere(3)
    inside = touching_balls(vertices, vertices, largest=np.full(len(vertices), 3.0))
    # The sphere has samples opposite each, or next to there: the ball through two points of a sphere with its centre on the
    # radius of one of them is the sphere's own.
    np.testing.assert_allclose(inside, 1.0, rtol=1e-6)


@pytest.mark.parametrize("degree", [14, 18, 22, 28])
def test_the_band_begins_a_third_of_an_octave_beyond_the_shortest_waves(degree: int) -> None:
    """Bumps of one degree l have omega^2 = l (l + 1); bands end at 2^(k / 3) in mean edges, and the middle of theirs counts."""
    vertices, faces = icosphere(5)
    edge = mean_edge_length(vertices, faces)
    bumps = 0.4 * np.polynomial.legendre.Legendre.basis(degree)(vertices[:, 2])
    noise = 0.05 * np.random.default_rng(0).normal(size=len(vertices))
    rough = vertices * (1.0 + edge * (bumps + noise))[:, None]
    band = np.floor(3.0 * np.log2(edge * np.sqrt(degree * (degree + 1))))
    shortest = 2.0 * np.pi / 2.0 ** ((band + 0.5) / 3.0) * 2.0 ** (1.0 / 3.0)
    assert shortest_relief(3.0 * rough, faces, 3.0 * edge) == pytest.approx(3.0 * edge * shortest, rel=1e-12)


def test_a_band_that_is_not_given_is_told_in_mesh_units() -> None:
    """It begins where the relief does and is two octaves wide; given, it does the same."""
    vertices, faces = icosphere(3)[0] * (10.0, 8.0, 6.0), icosphere(3)[1]
    found = enhance_details(vertices, faces)
    start = shortest_relief(vertices, faces, mean_edge_length(vertices, faces))
    assert (found.detail_size, found.largest_size) == pytest.approx((start, 4.0 * start), rel=1e-12)
    assert np.abs(found.vertices - vertices).max() > 1e-3
    given = enhance_details(vertices, faces, detail_size=start, largest_size=4.0 * start)
    np.testing.assert_allclose(given.vertices, found.vertices, rtol=0, atol=1e-9)


def test_the_band_begins_where_waves_rise_above_the_noise() -> None:
    """Noise of 0.01, 0.04 and 0.16 edges on a sphere with bumps of many sizes: the relief begins at longer waves each time."""
    vertices, faces = icosphere(5)
    edge = mean_edge_length(vertices, faces)
    rng = np.random.default_rng(3)
    directions = rng.normal(size=(40, 3)) * np.geomspace(2.0, 24.0, 40)[:, None]
    bumps = (np.cos(vertices @ directions.T) / np.linalg.norm(directions, axis=1) ** 2).sum(axis=1)
    shape = vertices * (1.0 + 0.2 * bumps)[:, None]
    starts = []
    for noise in (0.01, 0.04, 0.16):
        rough = shape + noise * edge * rng.normal(size=(len(shape), 1)) * vertices
        starts.append(shortest_relief(rough, faces, edge) / edge)
    assert SHORTEST <= starts[0] < starts[1] < starts[2]
