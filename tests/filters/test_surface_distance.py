"""Distances between surfaces: twenty pairs whose distance is known, and MeshLab's filter."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pymeshlab
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.inspection import Surface, SurfaceDistance, surface_distance
from pymeshfair.filters.inspection.surface import TriangleTree
from tests.meshes import Mesh, cube, grid, icosphere, irregular_grid, noisy, renumbered, rotation, sample, subdivided, torus

UTM = np.array([5e5, 5.5e6, 300.0])
#: mean, mean size, root mean square, and largest of the signed distances of the first mesh from the second
Known = tuple[float, float, float, float]


def measured(mesh: Mesh, other: Mesh) -> SurfaceDistance:
    """The distances of a mesh from another one."""
    return surface_distance(*mesh, Surface.of(*other))


def spheres(radius: float, other: float) -> tuple[Mesh, Mesh]:
    """Two concentric spheres of 5,120 faces."""
    vertices, faces = icosphere(4)
    return (radius * vertices, faces), (other * vertices, faces)


def moved(mesh: Mesh, offset: np.ndarray) -> Mesh:
    """The mesh somewhere else."""
    return mesh[0] + offset, mesh[1]


def wave(height: float, columns: int = 200) -> Mesh:
    """Two periods of a sine over the square from 0 to 1."""
    vertices, faces = grid(columns, columns, 1.0 / columns)
    return vertices + np.column_stack([0 * vertices[:, :2], height * np.sin(4 * math.pi * vertices[:, 0])]), faces


def flat(columns: int = 7, size: float = 1.0, middle: float = 0.5) -> Mesh:
    """A square round the middle of that from 0 to 1, of other triangles than `wave`."""
    vertices, faces = irregular_grid(columns, columns)
    vertices = vertices - vertices.min(axis=0)
    return (vertices / vertices.max() - [0.5, 0.5, 0.0]) * size + [middle, middle, 0.0], faces


def turned_cubes(degrees: float) -> tuple[Mesh, Mesh]:
    """A cube of side 1 turned about the axis z through its middle, and the cube."""
    vertices, faces = cube()
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return ((vertices - 0.5) @ turn.T + 0.5, faces), (vertices, faces)


def of_turned_cube(degrees: float) -> Known:
    """The same by quadrature: at height z of a side the distance depends on where along the side a point lies."""
    t = (np.arange(100_000) + 0.5) / 100_000 - 0.5
    a = math.radians(degrees)
    x, y = math.cos(a) * t + math.sin(a) * 0.5, math.sin(a) * t - math.cos(a) * 0.5
    outside = np.hypot(np.maximum(np.abs(x) - 0.5, 0), np.maximum(np.abs(y) - 0.5, 0))
    # Points inside are nearest to a side, and at the ends of the cube to its top or bottom: z is uniform from 0 to 1/2 away.
    depth = np.minimum(0.5 - np.abs(x), 0.5 - np.abs(y))
    inside = outside == 0.0
    d1 = np.where(inside, 2 * (depth * 0.5 - depth**2 / 2), outside)
    d2 = np.where(inside, 2 * (depth**2 * 0.5 - depth**3 * 2 / 3), outside**2)
    signed = np.where(inside, -d1, d1)
    # Four of six sides; top and bottom: what lies over the other's is at 0, the rest as far outside as in the plane.
    n = 1000
    u, v = np.meshgrid((np.arange(n) + 0.5) / n - 0.5, (np.arange(n) + 0.5) / n - 0.5)
    xx, yy = math.cos(a) * u - math.sin(a) * v, math.sin(a) * u + math.cos(a) * v
    lid = np.hypot(np.maximum(np.abs(xx) - 0.5, 0), np.maximum(np.abs(yy) - 0.5, 0))
    mean, size, square = (
        (4 * side + 2 * top) / 6
        for side, top in ((signed.mean(), lid.mean()), (d1.mean(), lid.mean()), (d2.mean(), (lid**2).mean()))
    )
    return mean, size, math.sqrt(square), math.sqrt(2) / 2 * math.cos(math.radians(45 - degrees)) - 0.5


def shifted(height: float, offset: np.ndarray | float = 0.0) -> tuple[Mesh, Mesh]:
    """A square above another one that reaches further."""
    vertices, faces = flat(9)
    other, other_faces = flat(6, size=3.0)
    return (vertices + np.array([0, 0, height]) + offset, faces), (other + offset, other_faces)


def rough(sigma: float, offset: np.ndarray | float = 0.0) -> tuple[Mesh, Mesh]:
    """A square of 160,000 faces with normal noise of its heights, and a flat one."""
    vertices, faces = grid(400, 400, 1.0 / 400)
    heights = np.random.default_rng(5).normal(scale=sigma, size=len(vertices))
    other, other_faces = flat(6, size=3.0)
    return (vertices + np.column_stack([0 * vertices[:, :2], heights]) + offset, faces), (other + offset, other_faces)


#: of linear interpolation of independent noise at three corners: the mean square over the triangle is half of the variance
ROUGH: Known = (0.0, math.nan, 1e-4 / math.sqrt(2.0), math.nan)
#: how far places of the faces of `icosphere(4)` lie below the sphere, in radii: 0.0017 at their middles
CHORD = 0.002

#: name: the two meshes, what is known, and how far tessellation makes that wrong
PAIRS: dict[str, tuple[Callable[[], tuple[Mesh, Mesh]], Known, float]] = {
    "a sphere 0.1 outside": (lambda: spheres(1.1, 1.0), (0.1, 0.1, 0.1, 0.1), 0.1 * CHORD),
    "a sphere 0.1 inside": (lambda: spheres(0.9, 1.0), (-0.1, 0.1, 0.1, 0.1), 0.1 * CHORD),
    "a sphere twice as large": (lambda: spheres(2.0, 1.0), (1.0, 1.0, 1.0, 1.0), CHORD),
    "a small sphere in a large one": (lambda: spheres(1.0, 3.0), (-2.0, 2.0, 2.0, 2.0), 3 * CHORD),
    "a sphere of other triangles": (
        lambda: (icosphere(4, 1.05), (icosphere(5)[0] @ rotation(1).T, icosphere(5)[1])),
        (0.05, 0.05, 0.05, 0.05),
        CHORD,
    ),
    "a sphere at UTM coordinates": (
        lambda: (moved(icosphere(4, 44.0), UTM), moved(icosphere(4, 40.0), UTM)),
        (4.0, 4.0, 4.0, 4.0),
        4.0 * CHORD,
    ),
    "a cube turned by 45 degrees": (lambda: turned_cubes(45), of_turned_cube(45), 1e-5),
    "a cube turned by 20 degrees": (lambda: turned_cubes(20), of_turned_cube(20), 1e-5),
    "a cube turned by 5 degrees": (lambda: turned_cubes(5), of_turned_cube(5), 1e-5),
    "a cube turned by a right angle": (lambda: turned_cubes(90), (0.0, 0.0, 0.0, 0.0), 1e-15),
    "a sine from a plane": (lambda: (wave(0.01), flat(size=3.0)), (0.0, 0.02 / math.pi, 0.01 / math.sqrt(2), 0.01), 2e-5),
    "a plane from a low sine": (lambda: (flat(80), wave(1e-4)), (0.0, 2e-4 / math.pi, 1e-4 / math.sqrt(2), 1e-4), 2e-7),
    "a plane above another": (lambda: shifted(0.25), (0.25, 0.25, 0.25, 0.25), 1e-12),
    "a plane below another": (lambda: shifted(-0.25), (-0.25, 0.25, 0.25, 0.25), 1e-12),
    "planes at UTM coordinates": (lambda: shifted(0.25, UTM), (0.25, 0.25, 0.25, 0.25), 2e-9),
    "noise": (lambda: rough(1e-4), ROUGH, 1e-6),
    "noise at UTM coordinates": (lambda: rough(1e-4, UTM), ROUGH, 1e-6),
    "a square that reaches further": (
        # Of nine times the area, 8 / 9 lie beyond: four strips of width 1, and four corners of 1 x 1.
        lambda: (flat(30, size=3.0), flat(5)),
        (math.nan, (4 * 0.5 + 4 * (math.sqrt(2) + math.asinh(1)) / 3) / 9, math.sqrt((4 / 3 + 4 * 2 / 3) / 9), math.sqrt(2)),
        1e-6,
    ),
    "the same torus, numbered anew": (lambda: (torus(), renumbered(torus())[:2]), (0.0, 0.0, 0.0, 0.0), 1e-15),
    "the same torus, its triangles cut": (lambda: (torus(), subdivided(*torus())), (0.0, 0.0, 0.0, 0.0), 1e-14),
}


@pytest.mark.parametrize("name", PAIRS)
def test_known_distances(name: str) -> None:
    """Mean, mean size and root mean square are right to the stated sampling error; nothing lies beyond what is stated."""
    meshes, (mean, size, rms, largest), tessellation = PAIRS[name]
    found = measured(*meshes())
    stated = found.statistics()
    for ours, known, error in (
        (stated.mean, mean, stated.mean_error),
        (stated.mean_size, size, stated.mean_size_error),
        (stated.rms, rms, stated.rms_error),
    ):
        assert math.isnan(known) or ours == pytest.approx(known, abs=error + tessellation)
    assert stated.samples >= 80_000
    assert stated.standard_deviation == pytest.approx(math.sqrt(max(stated.rms**2 - stated.mean**2, 0.0)), abs=1e-7 * stated.rms)
    if not math.isnan(largest):
        assert found.largest == pytest.approx(largest, abs=tessellation + 1e-12)
        assert found.at_most >= largest - tessellation


@pytest.mark.slow
def test_agrees_with_meshlab_on_samples_of_faces() -> None:
    """On a real scan and its noise mean and root mean square are those of MeshLab's samples to 1 %, and the largest no less."""
    vertices, faces = sample("bone.ply")
    used = np.unique(faces)
    before = vertices[used], np.searchsorted(used, faces).astype(np.int32)  # MeshLab samples vertices without a face, too
    edge = np.linalg.norm(before[0][before[1][:, 0]] - before[0][before[1][:, 1]], axis=1).mean()
    after = noisy(before, 0.5)
    meshes = pymeshlab.MeshSet()
    for mesh in (before, after):
        meshes.add_mesh(pymeshlab.Mesh(*mesh))
    for first, second, sampled, target in ((1, 0, after, before), (0, 1, before, after)):
        theirs = meshes.get_hausdorff_distance(
            sampledmesh=first,
            targetmesh=second,
            samplevert=True,
            sampleface=True,
            samplenum=200_000,
            maxdist=pymeshlab.PureValue(100 * edge),
        )
        found = surface_distance(*sampled, Surface.of(*target), count=200_000)
        assert found.statistics().mean_size == pytest.approx(theirs["mean"], rel=0.01)
        assert found.statistics().rms == pytest.approx(theirs["RMS"], rel=0.01)
        assert theirs["max"] * (1 - 1e-6) <= found.at_most
        assert found.largest >= 0.99 * theirs["max"]


def test_statistics_and_their_errors_are_those_of_random_samples() -> None:
    """Of 1,000 points at known heights over a plane; errors are two standard errors of the mean, with d rms = d rms^2 / 2 rms."""
    rng = np.random.default_rng(1)
    heights = rng.normal(loc=0.1, scale=0.2, size=1000)
    cloud = np.column_stack([rng.random((1000, 2)), heights]), np.empty((0, 3), dtype=np.int32)
    stated = measured(cloud, flat(6, size=3.0)).statistics(0.3)
    known = {"mean": heights, "mean_size": np.abs(heights), "within": (np.abs(heights) <= 0.3).astype(float)}
    for name, values in known.items():
        assert getattr(stated, name) == pytest.approx(values.mean(), rel=1e-12)
        assert getattr(stated, f"{name}_error") == pytest.approx(2 * values.std() / math.sqrt(1000), rel=1e-12)
    assert stated.rms == pytest.approx(math.sqrt((heights**2).mean()), rel=1e-12)
    assert stated.rms_error == pytest.approx((heights**2).std() / math.sqrt(1000) / stated.rms, rel=1e-12)
    assert stated.standard_deviation == pytest.approx(heights.std(), rel=1e-12)
    expected = {str(p): np.sort(np.abs(heights))[10 * p - 1] for p in (50, 90, 95, 99)}
    assert stated.percentiles == pytest.approx(expected, rel=1e-12)


def test_percentiles_and_share_within() -> None:
    """Over a plane tilted from 0 to 1 the distance is uniform: percentiles are themselves, and 30 % lie within 0.3."""
    vertices, faces = grid(60, 60, 1 / 60)
    tilted = np.column_stack([vertices[:, :2], vertices[:, 0]])
    stated = measured((tilted, faces), flat(6, size=3.0)).statistics(0.3)
    for percent, distance in stated.percentiles.items():
        assert distance == pytest.approx(float(percent) / 100, abs=0.005)
    assert stated.within is not None
    assert stated.within_error is not None
    assert stated.within == pytest.approx(0.3, abs=stated.within_error)


def test_the_side_is_right_everywhere() -> None:
    """Points round a cube, whose nearest places are mostly edges and corners, lie inside or outside as coordinates tell."""
    queries = np.random.default_rng(2).uniform(-0.5, 1.5, (2000, 3))
    outside = ((queries < 0) | (queries > 1)).any(axis=1)
    vertices, faces = cube()
    for offset in (np.zeros(3), UTM):
        nearest = Surface.of(vertices + offset, faces).nearest(queries + offset)
        np.testing.assert_array_equal(nearest.signed > 0, outside)


def test_nothing_lies_further_than_stated() -> None:
    """The bound holds for a dent that no sample and no vertex of the flat mesh meets, and is 0 for the same triangles."""
    flat_square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    vertices, faces = grid(2, 2, 0.5)
    dented = vertices - np.outer(np.arange(9) == 4, [0.0, 0, 0.4])
    found = surface_distance(*flat_square, Surface.of(dented, faces), count=3)
    assert found.at_most > 0.2
    assert measured((dented, faces), (dented, faces)).at_most < 1e-15


@pytest.mark.parametrize(("mesh", "other"), [(flat(size=2.0), cube()), (cube(), flat()), (wave(0.1, 20), flat())])
def test_the_furthest_place_has_its_face_and_its_side(mesh: Mesh, other: Mesh) -> None:
    """The furthest place lies on the face that is named, and the signed distance there is the one of `Surface.nearest`."""
    found = measured(mesh, other)
    face = Surface.of(mesh[0], mesh[1][[found.furthest_face]])
    assert face.nearest(found.furthest[None]).distances == pytest.approx(0.0, abs=1e-12)
    assert found.at_furthest == pytest.approx(Surface.of(*other).nearest(found.furthest[None]).signed[0], rel=1e-9)
    assert abs(found.at_furthest) == found.largest


def test_a_vertex_that_no_face_uses_is_no_place_of_the_surface() -> None:
    """It is far from both surfaces and in both meshes, and the largest distance stays that of the faces."""
    vertices, faces = icosphere(2)
    with_stray = np.concatenate([vertices, [[9.0, 0.0, 0.0]]])
    distance = surface_distance(1.01 * with_stray, faces, Surface.of(with_stray, faces))
    assert distance.largest == pytest.approx(0.01, rel=0.05)
    assert distance.at_most < 0.011


def test_nothing_has_no_distance() -> None:
    """A mesh without vertices is refused in words."""
    with pytest.raises(FilterInputError, match="no vertices"):
        surface_distance(np.empty((0, 3)), np.empty((0, 3), np.int32), Surface.of(*cube()))


def test_the_nearest_triangle_is_that_of_a_slow_search() -> None:
    """Against the distances from all triangles, one by one: the same bits."""
    vertices, faces = noisy(icosphere(2), 0.1)
    queries = np.concatenate([np.random.default_rng(3).normal(size=(200, 3)), vertices])
    found, _, distances = TriangleTree.of(vertices, faces).nearest(queries)
    every = np.column_stack([TriangleTree.of(vertices, faces[[f]]).nearest(queries)[2] for f in range(len(faces))])
    np.testing.assert_array_equal(distances, every.min(axis=1))
    np.testing.assert_array_equal(every[np.arange(len(queries)), found], distances)
