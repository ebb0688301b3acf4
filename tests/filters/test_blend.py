"""Bands between rims, and the necks that fairing makes of them."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.fairing import blend
from pymeshfair.filters.fairing.blend import blend_parts, bridge_rims, nearest_rims
from pymeshfair.filters.fairing.region import Energy
from pymeshfair.filters.mesh import Bools
from pymeshfair.filters.topology import edge_face_counts
from tests.meshes import Floats, Ints, Mesh, cube, grid, icosphere, noisy, renumbered, rotation, tube


def two_tubes(first: int = 24, second: int = 24, *, gap: float = 1.5, tilt: float = 0.0, shift: float = 0.0) -> Mesh:
    """Two open tubes of radius 1 and length 3 about the z axis, the upper one `gap` above the other, tilted and shifted."""
    (low, faces_low), (high, faces_high) = tube(first, 9), tube(second, 9)
    turn = np.array([[math.cos(tilt), 0, math.sin(tilt)], [0, 1, 0], [-math.sin(tilt), 0, math.cos(tilt)]])
    high = high @ turn.T + [shift, 0.0, 3.0 + gap]
    return np.concatenate([low, high]), np.concatenate([faces_low, faces_high + np.int32(len(low))])


def joined(mesh: Mesh, vertices: Floats, faces: Ints) -> Mesh:
    """The mesh with what joins its parts."""
    return np.concatenate([mesh[0], vertices]), np.concatenate([mesh[1], faces])


def shapes(vertices: Floats, faces: Ints) -> Floats:
    """4 sqrt(3) area over the sum of squared edges of every triangle: 1 for an equilateral one."""
    corners = vertices[faces]
    twice = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(2 * math.sqrt(3) * twice / ((corners - np.roll(corners, 1, axis=1)) ** 2).sum(axis=(1, 2)))


BENT: tuple[dict[str, float], ...] = ({}, {"second": 31}, {"first": 50, "second": 20}, {"tilt": 0.6, "shift": 1.0, "gap": 2.0})


@pytest.mark.parametrize("shape", BENT, ids=["aligned", "24 and 31", "50 and 20", "bent"])
def test_a_band_joins_both_rims_and_nothing_else(shape: dict[str, float]) -> None:
    """Both rims are gone, the far ones are left, every edge has the faces of a surface, oriented as one."""
    mesh = two_tubes(**shape)  # type: ignore[arg-type]
    first, second = nearest_rims(*mesh)
    band = bridge_rims(*mesh, first, second)
    vertices, faces = joined(mesh, band.vertices, band.faces)
    pairs, counts = edge_face_counts(faces)
    assert counts.max() == 2
    assert len(pairs[counts == 1]) == len(first) + len(second)
    assert not np.isin(pairs[counts == 1], np.concatenate([first, second])).any()
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(halves, axis=0)) == len(halves)
    assert len(vertices) - len(pairs) + len(faces) == 0  # a tube again
    assert shapes(vertices, band.faces).mean() > 0.9
    assert shapes(vertices, band.faces).min() > 0.6


def test_one_row_has_no_new_vertices_and_the_shortest_spans() -> None:
    """Between two equal squares an edge apart it is the side of a box: 8 triangles, 4 straight spans, 4 diagonals."""
    vertices, faces = cube()
    sides = faces[4:]
    apart = np.concatenate([sides, sides + np.int32(8)])
    mesh = np.concatenate([vertices, vertices + np.array([0.0, 0.0, 2.0])]), apart
    band = bridge_rims(*mesh, *nearest_rims(*mesh))
    assert band.vertices.shape == (0, 3)
    corners = mesh[0][band.faces]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    np.testing.assert_allclose(np.sort(lengths, axis=1), np.tile([1.0, 1.0, math.sqrt(2)], (8, 1)), atol=1e-15)


def test_no_span_is_taken_twice() -> None:
    """Between any two loops each span occurs once, also if one vertex is the nearest to a whole loop."""
    rng = np.random.default_rng(1)
    for _ in range(400):
        first, second = rng.normal(size=(2, 12, 3))
        spans = np.column_stack(blend.shortest_spans(first[: rng.integers(3, 13)], second[: rng.integers(3, 13)], lambda _: None))
        assert len(np.unique(spans, axis=0)) == len(spans)
        steps = spans != np.roll(spans, 1, axis=0)
        assert (steps.sum(axis=1) == 1).all()


def test_at_most_two_searches_for_spans() -> None:
    """Also for rims as different as a coarse opening and a fine, small one beside it, where 61 edges were barred one by one."""
    large, small = (np.exp(2j * math.pi * np.arange(n) / n) for n in (40, 500))
    first, second = (np.column_stack([z.real, z.imag, 0.0 * z.real]) for z in (large, 1.1 + 0.05 * small))
    searches: list[float] = []
    spans = np.column_stack(blend.shortest_spans(first, second, searches.append))
    assert len(searches) == 2
    assert len(np.unique(spans, axis=0)) == len(spans)


def test_rows_divide_the_spans_evenly() -> None:
    """Rows as high as equilateral triangles divide the way between rims at heights 3 and 4.5, on the cylinder's chords."""
    mesh = two_tubes()
    band = bridge_rims(*mesh, *nearest_rims(*mesh))
    heights, counts = np.unique(np.round(band.vertices[:, 2], 12), return_counts=True)
    rows = round(1.5 / (math.sqrt(0.75) * 2 * math.sin(math.pi / 24)))
    np.testing.assert_allclose(heights, 3 + 1.5 * np.arange(1, rows) / rows)
    assert (counts == 24).all()
    assert np.linalg.norm(band.vertices[:, :2], axis=1).min() > math.cos(math.pi / 24) - 1e-12


def neck(height: Floats, half: float, energy: str) -> Floats:
    """The radius of the faired neck between two tubes of radius 1, `height` from its middle, half as long as 2 `half`.

    The Laplace-Beltrami operator of the cylinder takes f(z) cos(phi) to (f'' - f) cos(phi); order 1 has f'' = f, order 2
    f'''' - 2 f'' + f = 0, with f = 1 at the rims and, at order 2, f' = 0 there.
    """
    if energy == "membrane":
        return np.asarray(np.cosh(height) / np.cosh(half))
    # f = a cosh z + b z sinh z
    a, b = np.linalg.solve(
        [[math.cosh(half), half * math.sinh(half)], [math.sinh(half), math.sinh(half) + half * math.cosh(half)]], [1.0, 0.0]
    )
    return np.asarray(a * np.cosh(height) + b * height * np.sinh(height))


@pytest.mark.parametrize(("energy", "tolerance"), [("membrane", 0.0005), ("thin_plate", 0.0025)])
def test_the_neck_between_two_tubes_has_the_profile_of_its_equation(energy: Energy, tolerance: float) -> None:
    """With 96 vertices around, radii are those of the equation on the cylinder, 0.23 or 0.012 below 1 in the middle."""
    (low, faces_low), (high, faces_high) = tube(96, 46), tube(96, 46)
    mesh = np.concatenate([low, high + np.array([0.0, 0.0, 4.5])]), np.concatenate([faces_low, faces_high + np.int32(len(low))])
    found = blend_parts(*mesh, energy=energy)
    radii = np.linalg.norm(found.vertices[:, :2], axis=1)
    expected = neck(found.vertices[:, 2] - 3.75, 0.75, energy)
    assert 1 - expected.min() > 4 * tolerance
    np.testing.assert_allclose(radii, expected, rtol=0, atol=tolerance)


def test_a_thin_plate_continues_the_tangent_planes() -> None:
    """Where a bent neck meets its tubes the angle between triangles is under a third of that of a membrane."""
    mesh = two_tubes(48, 48, tilt=0.6, shift=1.0, gap=2.0)
    angles = {}
    energies: tuple[Energy, ...] = ("membrane", "thin_plate")
    for energy in energies:
        neck_band = blend_parts(*mesh, energy=energy)
        vertices, faces = joined(mesh, neck_band.vertices, neck_band.faces)
        normals = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        first, second = nearest_rims(*mesh)
        rim = np.zeros(len(vertices), dtype=bool)
        rim[np.concatenate([first, second])] = True
        face_of = {}
        for f, (a, b, c) in enumerate(faces.tolist()):
            for u, v in ((a, b), (b, c), (c, a)):
                if rim[u] and rim[v]:
                    face_of[u, v] = f
        across = [normals[f] @ normals[face_of[v, u]] for (u, v), f in face_of.items() if (v, u) in face_of]
        assert len(across) == 2 * 96
        angles[energy] = np.arccos(np.clip(across, -1, 1)).mean()
    assert angles["thin_plate"] < angles["membrane"] / 3


def test_the_band_turns_and_grows_with_the_mesh() -> None:
    """Rotated, scaled by 100 and shifted parts get the same band, turned along."""
    mesh = noisy(two_tubes(24, 31, tilt=0.3), 0.01)  # no two spans of equal length
    turn = rotation(3)
    plain = blend_parts(*mesh)
    moved = blend_parts(100 * mesh[0] @ turn.T + [5.0, 6.0, 7.0], mesh[1])
    np.testing.assert_array_equal(moved.faces, plain.faces)
    np.testing.assert_allclose(moved.vertices, 100 * plain.vertices @ turn.T + [5.0, 6.0, 7.0], rtol=0, atol=1e-8)


@pytest.mark.parametrize("unit", [1e-100, 1e-30, 1e30, 1e100])
def test_any_unit_will_do(unit: float) -> None:
    """Parts in other units get the same triangles, and vertices that differ by the unit."""
    vertices, faces = noisy(two_tubes(24, 31), 0.01)
    plain, other = blend_parts(vertices, faces), blend_parts(unit * vertices, faces)
    np.testing.assert_array_equal(other.faces, plain.faces)
    np.testing.assert_allclose(other.vertices / unit, plain.vertices, rtol=0, atol=1e-9)


def test_the_rims_are_those_nearest_each_other() -> None:
    """Of the four rims of two tubes the facing two are found, whatever the order of vertices and faces."""
    vertices, faces, _ = renumbered(two_tubes(), seed=4)
    first, second = nearest_rims(vertices, faces)
    heights = sorted({float(vertices[first, 2].mean().round(9)), float(vertices[second, 2].mean().round(9))})
    assert heights == [3.0, 4.5]
    assert len(first) == len(second) == 24


def test_selected_rims_may_belong_to_one_part() -> None:
    """The two rims of a single tube are joined when they are the ones selected: a handle, without border."""
    vertices, faces = tube(24, 9, length=1.0)
    on_rims = np.isin(vertices[:, 2], [0.0, 1.0])
    with pytest.raises(FilterInputError, match=re.escape("no two rims of different components to join: 2 found")):
        nearest_rims(vertices, faces)
    band = bridge_rims(vertices, faces, *nearest_rims(vertices, faces, among=on_rims))
    assert (edge_face_counts(np.concatenate([faces, band.faces]))[1] == 2).all()
    with pytest.raises(FilterInputError, match="no two rims with only selected vertices to join: 1 found"):
        nearest_rims(vertices, faces, among=vertices[:, 2] == 0.0)
    with pytest.raises(FilterInputError, match="among must be a boolean array"):
        nearest_rims(vertices, faces, among=on_rims[1:])


def test_what_cannot_be_joined_is_refused() -> None:
    """An inside-out part, rims that touch, a single rim: each is said."""
    vertices, faces = two_tubes()
    half = len(faces) // 2
    inside_out = np.concatenate([faces[:half], faces[half:, ::-1]])
    with pytest.raises(FilterInputError, match="one of the parts is inside out"):
        bridge_rims(vertices, inside_out, *nearest_rims(vertices, inside_out))
    first, _ = nearest_rims(vertices, faces)
    with pytest.raises(FilterInputError, match="the rims share vertex"):
        bridge_rims(vertices, faces, first, first)
    with pytest.raises(FilterInputError, match="no two rims of different components to join: 1 found"):
        nearest_rims(*grid())


def test_a_rim_that_passes_a_vertex_twice_is_not_passed_over() -> None:
    """With a triangle that hangs at a vertex of the facing rim no other rims are joined: the vertex is named."""
    vertices, faces = two_tubes()
    n, at = len(vertices), np.flatnonzero(np.isclose(vertices[:, 2], 3.0))[0]
    hanging = np.concatenate([vertices, vertices[[at, at]] + np.array([[0.0, 0.1, 0.3], [0.0, -0.1, 0.3]])])
    with pytest.raises(FilterInputError, match=rf"the rims share vertex {at}, or one passes it twice"):
        blend_parts(hanging, np.concatenate([faces, [[at, n, n + 1]]]))


def opened(vertices: Floats, faces: Ints, *centres: tuple[float, float, float], radius: float = 0.4) -> Mesh:
    """The mesh without the faces whose centroids lie within `radius` of one of the centres."""
    middles = vertices[faces].mean(axis=1)
    near = [np.linalg.norm(middles - centre, axis=1) < radius for centre in centres]
    return vertices, faces[~np.any(near, axis=0)]


def two_opened_spheres(degrees: float) -> Mesh:
    """Unit spheres 3 apart along x, each with a round opening that many degrees up from the line between them."""
    vertices, faces = icosphere(3)
    x, z = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    both = (
        np.concatenate([vertices, vertices + np.array([3.0, 0.0, 0.0])]),
        np.concatenate([faces, faces + np.int32(len(vertices))]),
    )
    return opened(*both, (x, 0.0, z), (3.0 - x, 0.0, z))


def elbow(degrees: float) -> Mesh:
    """Two tubes whose axes meet at that angle."""
    angle = math.radians(degrees)
    (low, faces_low), (high, faces_high) = tube(24, 6, length=2.0), tube(24, 6, length=2.0)
    turn = np.array([[math.cos(angle), 0, math.sin(angle)], [0, 1, 0], [-math.sin(angle), 0, math.cos(angle)]])
    there = [1.5 * math.sin(angle / 2), 0.0, 2.0 + 1.5 * math.cos(angle / 2)]
    return np.concatenate([low, high @ turn.T + there]), np.concatenate([faces_low, faces_high + np.int32(len(low))])


def turned_over(mesh: Mesh, which: str) -> Mesh:
    """The mesh with the faces of its "first", "second", "both" or "no" part turned over."""
    vertices, faces = mesh
    second = faces[:, 0] >= len(vertices) // 2
    over = {"no": second & ~second, "first": ~second, "second": second, "both": second | ~second}[which]
    return vertices, np.where(over[:, None], faces[:, ::-1], faces)


RIGHT = {f"spheres {degrees}": (two_opened_spheres, degrees) for degrees in (0, 20, 30, 35, 45, 60)}
RIGHT |= {f"elbow {degrees}": (elbow, degrees) for degrees in (0, 60, 90, 120)}


@pytest.mark.parametrize("name", RIGHT)
def test_one_part_inside_out_is_refused_and_two_right_ones_are_joined(name: str) -> None:
    """However the openings are tilted, up to 60 degrees and in elbows up to 120: right is both alike, wrong one turned over."""
    make, degrees = RIGHT[name]
    for which in ("no", "both"):
        vertices, faces = turned_over(make(degrees), which)
        band = bridge_rims(vertices, faces, *nearest_rims(vertices, faces))
        assert not band.doubtful
        halves = np.concatenate([np.roll(np.concatenate([faces, band.faces]), k, axis=1)[:, :2] for k in range(3)])
        assert len(np.unique(halves, axis=0)) == len(halves)  # one orientation
    for which in ("first", "second"):
        vertices, faces = turned_over(make(degrees), which)
        with pytest.raises(FilterInputError, match=r"one of the parts is inside out, the part with vertex \d+ or"):
            bridge_rims(vertices, faces, *nearest_rims(vertices, faces))


@pytest.mark.parametrize("which", ["no", "first"])
def test_openings_side_by_side_are_joined_in_doubt(which: str) -> None:
    """Of two spheres open upwards no rim tells which way out is right: joined either way, and said to be doubtful."""
    vertices, faces = turned_over(two_opened_spheres(90), which)
    assert bridge_rims(vertices, faces, *nearest_rims(vertices, faces)).doubtful


def test_rims_too_wide_for_their_distance_are_judged_by_their_planes() -> None:
    """Two halves of a sphere 0.1 apart, the upper one shifted sideways by more than that: joined, or refused if one is turned."""
    (vertices, faces), apart = icosphere(3), np.array([0.2, 0.0, 0.1])
    low = faces[(vertices[faces][:, :, 2] < 0.05).all(axis=1)]
    high = faces[(vertices[faces][:, :, 2] > -0.05).all(axis=1)]
    halves = np.concatenate([vertices, vertices + apart]), np.concatenate([low, high + np.int32(len(vertices))])
    assert not bridge_rims(*halves, *nearest_rims(*halves)).doubtful
    wrong = turned_over(halves, "second")
    with pytest.raises(FilterInputError, match="one of the parts is inside out"):
        bridge_rims(*wrong, *nearest_rims(*wrong))


@pytest.mark.parametrize("degrees", [40, 60, 90, 180])
def test_two_holes_of_one_sphere_get_a_handle(degrees: float) -> None:
    """Rims of one component are oriented alike by it, whatever the angle between them: the result is closed and has genus 1."""
    angle = math.radians(degrees)
    vertices, faces = opened(*icosphere(4), (1.0, 0.0, 0.0), (math.cos(angle), math.sin(angle), 0.0), radius=0.3)
    assert_handle(vertices, faces, np.ones(len(vertices), dtype=bool))


def test_two_holes_of_a_plate_get_a_handle() -> None:
    """Rims in one plane, which face nowhere; the plate's own border stays."""
    vertices, faces = grid(20, 40)
    inside: Bools = np.asarray((np.abs(vertices[:, :2] - [20.0, 10.0]) < [19.5, 9.5]).all(axis=1))
    assert_handle(*opened(vertices, faces, (10.0, 10.0, 0.0), (30.0, 10.0, 0.0), radius=3.0), inside, border=120)


def assert_handle(vertices: Floats, faces: Ints, among: Bools, border: int = 0) -> None:
    """What two rims of one part get is a handle: an oriented surface of Euler characteristic 0, or -1 with one border."""
    band = blend_parts(vertices, faces, among=among)
    assert not band.doubtful
    everything = np.concatenate([faces, band.faces])
    pairs, counts = edge_face_counts(everything)
    assert counts.max() == 2
    assert (counts == 1).sum() == border
    halves = np.concatenate([np.roll(everything, k, axis=1)[:, :2] for k in range(3)])
    assert len(np.unique(halves, axis=0)) == len(halves)
    assert len(np.unique(everything)) - len(pairs) + len(everything) == (-1 if border else 0)


def test_long_rims_tell_how_far_they_are_and_too_long_ones_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shares rise from 0 to 1 in many steps, and stop the work when they raise; above the largest grid of spans it is said."""
    mesh = two_tubes(400, 300, gap=0.3)
    shares: list[float] = []
    monkeypatch.setattr(blend, "_SPANS_AT_A_TIME", 10_000)
    blend_parts(*mesh, progress=shares.append)
    assert len(shares) > 50
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= shares[-1] <= 1.0
    assert shares[-1] > 0.9
    monkeypatch.setattr(blend, "MOST_SPANS", 400 * 300 - 1)
    with pytest.raises(FilterInputError, match=r"the rims or rows have [34]00 and [34]00 edges: a band is searched"):
        blend_parts(*mesh)


def test_rows_between_unequal_rims_are_refused_where_their_spans_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between rims of 20 and 400 edges lie rows of hundreds of edges, whose spans need more memory than those of the rims."""
    mesh = two_tubes(20, 400, gap=1.0)
    monkeypatch.setattr(blend, "MOST_SPANS", 400 * 20)
    with pytest.raises(FilterInputError, match=r"the rims or rows have \d+ and \d+ edges: a band is searched"):
        blend_parts(*mesh)


def test_the_rims_found_are_the_nearest_of_all_pairs() -> None:
    """Of 12 sheets thrown about, the two found have the least mean distance of all 66 pairs, measured one by one."""
    random = np.random.default_rng(5)
    vertices, faces = grid(3, 4)
    sheets = [vertices @ rotation(k).T + random.uniform(0, 12, 3) for k in range(12)]
    everything = np.concatenate(sheets)
    first, second = nearest_rims(everything, np.concatenate([faces + np.int32(len(vertices) * k) for k in range(12)]))

    def apart(a: Floats, b: Floats) -> float:
        distances = np.linalg.norm(a[:, None] - b, axis=2)
        return float(distances.min(axis=0).mean() + distances.min(axis=1).mean())

    rims = [sheet[np.isin(vertices[:, 0], [0, 4]) | np.isin(vertices[:, 1], [0, 3])] for sheet in sheets]
    least = min(apart(rims[a], rims[b]) for a in range(12) for b in range(a))
    assert apart(everything[first], everything[second]) == pytest.approx(least)
