"""Holes closed by fairing: closed forms, samples, holes cut into a known surface, and rims that are awkward."""

from __future__ import annotations

import functools
from typing import Any

import holes as benchmark  # benchmarks/holes.py
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from pymeshfair.filters.checks import ConvergenceError, FilterInputError
from pymeshfair.filters.fairing.region import fair_region
from pymeshfair.filters.holes import HoleEnergy, HoleFilling, close_holes
from pymeshfair.filters.mesh import mask_of
from pymeshfair.filters.topology import (
    CLOSED,
    IRREGULAR,
    border_edges,
    connected_components,
    face_adjacency,
    non_manifold_edges,
    stars,
)
from tests.meshes import (
    AWKWARD,
    Mesh,
    area,
    book,
    diagonal,
    grid,
    icosphere,
    irregular_grid,
    noisy,
    renumbered,
    rotation,
    sample,
    torus,
    tube,
    with_needles,
)

Floats = NDArray[np.float64]


def filled(mesh: Mesh, filling: HoleFilling) -> Mesh:
    """The mesh with what closes its holes."""
    return np.concatenate([mesh[0], filling.new_vertices]), np.concatenate([mesh[1], filling.new_faces])


def cap_cut(subdivisions: int, sine: float, island: float = 0.0) -> Mesh:
    """The unit sphere without the faces nearer to the z axis than `sine` at the top, but for those nearer than `island`."""
    vertices, faces = icosphere(subdivisions)
    middles = vertices[faces].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    away = np.hypot(middles[:, 0], middles[:, 1])
    return vertices, np.ascontiguousarray(faces[(middles[:, 2] < 0.0) | (away > sine) | (away < island)])


def cap(degrees: float) -> Mesh:
    """The faces of the unit sphere up to an angle from the z axis."""
    vertices, faces = icosphere(4)
    middles = vertices[faces].mean(axis=1)
    return vertices, faces[np.degrees(np.arctan2(np.hypot(middles[:, 0], middles[:, 1]), middles[:, 2])) < degrees]


def sound(mesh: Mesh, filling: HoleFilling) -> bool:
    """Whether every closed rim is closed, coherently and as a manifold, and the counts of the result fit."""
    vertices, faces = filled(mesh, filling)
    half_edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    left = sum(len(rim.vertices) for rim in filling.left_open)
    irregular = [int((stars(f, len(v)).kinds == IRREGULAR).sum()) for v, f in (mesh, (vertices, faces))]
    return (
        len(non_manifold_edges(faces)) == 0
        and len(np.unique(half_edges, axis=0)) == len(half_edges)
        and len(border_edges(faces)) == left
        and irregular[1] <= irregular[0]
        and bool(np.isfinite(vertices).all())
        and len(filling.hole_of_face) == len(filling.new_faces)
        and len(filling.hole_of_vertex) == len(filling.new_vertices)
        and len(filling.islands) == len(filling.closed)
        and set(filling.hole_of_face.tolist()) == set(range(len(filling.closed)))
    )


def bends_at(mesh: Mesh, filling: HoleFilling) -> list[tuple[float, float, float, float]]:
    """For every rim the mean and largest angle between normals across it, and of those at the mesh's edges that end there."""
    vertices, faces = filled(mesh, filling)
    pairs, shared = face_adjacency(faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    one, other = normals[pairs[:, 0]], normals[pairs[:, 1]]
    angles = np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), (one * other).sum(axis=1))
    new = (pairs >= len(mesh[1])).sum(axis=1)
    found = []
    for rim in filling.closed:
        across = angles[(new == 1) & np.isin(shared, rim).all(axis=1)]
        around = angles[(new == 0) & np.isin(shared, rim).any(axis=1)]
        found.append((across.mean(), across.max(), around.mean(), around.max()))
    return found


# ------------------------------------------------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("energy", ["none", "membrane", "thin_plate", "minimum_variation"])
def test_a_flat_sheet_is_closed_flat(energy: HoleEnergy) -> None:
    """A hole in a plane is closed in the plane and with the area that is missing, no face turned over."""
    vertices, faces = irregular_grid(12, 12)
    middles = vertices[faces].mean(axis=1)
    mesh = vertices, faces[np.linalg.norm(middles[:, :2] - 6.0, axis=1) > 3.5]
    filling = close_holes(*mesh, energy=energy, max_edges=40)
    # Zeros go in and the equations are linear.
    assert np.abs(filling.new_vertices[:, 2]).max() == 0.0
    a, b, c = (filled(mesh, filling)[0][filling.new_faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    # 144 squares, each of area 1.
    assert area(*filled(mesh, filling)) == pytest.approx(144.0, rel=1e-12)


def test_a_cap_of_the_sphere_comes_back_with_the_order() -> None:
    """A disc misses a cap of radius 0.5 by 0.134; each order of fairing comes nearer than the one before it."""
    mesh = cap_cut(4, 0.5)
    errors = []
    for energy in ("membrane", "thin_plate", "minimum_variation"):
        filling = close_holes(*mesh, energy=energy, rounds=3)
        assert sound(mesh, filling)
        errors.append(float(np.abs(np.linalg.norm(filling.new_vertices, axis=1) - 1.0).max()))
    # The membrane is the disc: off by 1 - sqrt(1 - R^2) at the pole; R is that of the rim's vertices, out to an edge beyond 0.5.
    assert 0.1 < errors[0] < 0.2
    # In one round the thin plate would be off by 1 - sqrt(1 - R^2) - R^2 / 2 = 0.009 at 0.5; the rounds follow the surface.
    assert errors[1] < 0.01
    assert errors[2] < errors[1] / 2


def test_no_new_face_of_a_round_hole_meets_another() -> None:
    """Nothing intersects in a surface that is met once in every direction.

    Seen from the middle of the ball every face has a positive solid angle, and they sum to 4 pi.
    """
    for sine in (0.3, 0.7):
        mesh = cap_cut(4, sine)
        vertices, faces = filled(mesh, close_holes(*mesh))
        a, b, c = (vertices[faces[:, k]] / np.linalg.norm(vertices[faces[:, k]], axis=1, keepdims=True) for k in range(3))
        dots = 1.0 + (a * b).sum(axis=1) + (b * c).sum(axis=1) + (c * a).sum(axis=1)
        angles = 2.0 * np.arctan2(np.einsum("ij,ij->i", a, np.cross(b, c)), dots)
        assert (angles > 0.0).all()
        assert angles.sum() == pytest.approx(4.0 * np.pi, abs=1e-9)


def test_a_triangle_is_one_face_and_no_vertex() -> None:
    """A missing face is put back as it was, up to which corner comes first."""
    vertices, faces = icosphere(1)
    filling = close_holes(vertices, np.delete(faces, 17, axis=0))
    assert len(filling.new_vertices) == 0
    assert sorted(filling.new_faces[0].tolist()) == sorted(faces[17].tolist())
    assert trimesh.Trimesh(*filled((vertices, np.delete(faces, 17, axis=0)), filling), process=False).is_winding_consistent


def test_an_island_is_joined_and_guides_the_filling() -> None:
    """A piece of the sphere that floats in a hole is joined to its rim, and the filling is nearer to the sphere than without."""
    mesh = cap_cut(4, 0.5, 0.15)
    errors = []
    for islands in ("join", "leave"):
        filling = close_holes(*mesh, islands=islands)
        assert sound(mesh, filling)
        errors.append(float(np.abs(np.linalg.norm(filling.new_vertices, axis=1) - 1.0).max()))
    joined = close_holes(*mesh)
    assert joined.left_open == ()
    assert len(joined.islands[0]) > 3
    assert connected_components(filled(mesh, joined)[1], len(filled(mesh, joined)[0]))[1] == 1
    assert errors[0] < errors[1] / 2


# ------------------------------------------------------------------------------------------------------------------ samples


def test_the_five_holes_of_the_scanned_bunny_are_closed() -> None:
    """The textured bunny becomes watertight, coherently oriented, and no rim is bent more than 1.5 times its surroundings."""
    mesh = sample("bunny10k_textured.obj")
    filling = close_holes(*mesh)
    assert sorted(len(rim) for rim in filling.closed) == [8, 19, 22, 22, 38]
    assert sound(mesh, filling)
    body = trimesh.Trimesh(*filled(mesh, filling), process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    bends = np.array(bends_at(mesh, filling))
    assert (bends[:, 1] < 1.5 * bends[:, 3]).all()
    # Two of the holes are narrow slits whose sides do not match, and two edges wide.
    assert (bends[:, 0] < 1.5 * bends[:, 2]).all()


def test_the_holes_of_a_range_map_are_closed_and_its_outer_border_is_not() -> None:
    """All holes of the main part of face000, smooth at their rims; its border of 2,475 edges and 16 loose pieces stay."""
    mesh = sample("rangemaps/face000.ply")
    filling = close_holes(*mesh, max_edges=300)
    assert len(filling.closed) == 23
    assert max(len(rim) for rim in filling.closed) == 227
    assert sound(mesh, filling)
    reasons = sorted((rim.reason, len(rim.vertices)) for rim in filling.left_open)
    assert [reason for reason, _ in reasons] == ["outer"] * 17
    assert reasons[-1][1] == 2475
    bends = np.array(bends_at(mesh, filling))
    assert (bends[:, 0] < 1.5 * bends[:, 2]).all()
    assert (bends[:, 1] < 1.5 * bends[:, 3]).all()


def test_holes_cut_into_the_bunny_are_closed_nearer_to_it_than_by_meshlab() -> None:
    """Ten of the holes of benchmarks/holes.py: the mean distance to what was removed is under half of MeshLab's."""
    vertices, faces = sample("bunny.obj")
    pairs = []
    for seed in range(10):
        hole = benchmark.cut(vertices, faces, seed)
        pairs.append((benchmark.ours(hole, "thin_plate"), benchmark.meshlabs(hole)))
    assert all(own.border == 0 and own.non_manifold == 0 for own, _ in pairs)
    assert sum(own.there for own, _ in pairs) < 0.5 * sum(other.there for _, other in pairs)


# ------------------------------------------------------------------------------------------------------------- awkward rims


@pytest.mark.parametrize("refine", [True, False])
def test_random_holes_of_all_kinds_are_closed_as_manifolds(refine: bool) -> None:
    """Faces taken away at random leave holes that share vertices and parts that hang on one.

    All rims but outer borders are closed without a doubled edge, and no vertex is worse than before.
    """
    makers = [lambda: icosphere(2), lambda: noisy(icosphere(2), 0.03), lambda: torus(), lambda: grid(10, 10)]
    for seed in range(12):
        vertices, faces = makers[seed % 4]()
        rng = np.random.default_rng(seed)
        mesh = vertices, faces[rng.random(len(faces)) > rng.choice([0.05, 0.3, 0.5])]
        filling = close_holes(*mesh, refine=refine, rounds=1)
        assert sound(mesh, filling)
        assert {rim.reason for rim in filling.left_open} <= {"outer"}
        assert refine or len(filling.new_vertices) == 0


def test_two_holes_that_share_a_vertex() -> None:
    """Both are closed, and the vertex between them has one closed ring again."""
    vertices, faces = icosphere(3)
    hub = 200
    ring = np.flatnonzero((faces == hub).any(axis=1))
    opposite = ring[np.argmax(np.linalg.norm(vertices[faces[ring]].mean(axis=1) - vertices[faces[ring[0]]].mean(axis=0), axis=1))]
    mesh = vertices, np.delete(faces, [ring[0], opposite], axis=0)
    filling = close_holes(*mesh)
    assert len(filling.closed) == 2
    assert sound(mesh, filling)
    assert stars(filled(mesh, filling)[1], len(vertices)).kinds[hub] != IRREGULAR


def test_a_part_that_hangs_on_one_vertex_is_joined_all_round() -> None:
    """A triangle in a hole that touches its rim in a corner gets new faces all round; the corner has one closed ring again."""
    vertices, faces = icosphere(3)
    hub = 200
    kept = np.flatnonzero((faces == hub).any(axis=1))[0]
    near = np.isin(faces, faces[(faces == hub).any(axis=1)]).any(axis=1)
    near |= np.isin(faces, faces[near]).any(axis=1)
    outside = ~near
    corner = faces[kept][0]
    # The triangle is moved out so far that its corner becomes a vertex of the rim.
    rim = np.intersect1d(faces[near], faces[outside])
    triangle = np.where(faces[kept] == corner, rim[0], faces[kept]).astype(np.int32)
    mesh = vertices, np.concatenate([faces[outside], [triangle]])
    filling = close_holes(*mesh)
    assert [np.bincount(loop).max() for loop in filling.closed] == [2]
    assert sound(mesh, filling)
    closed = stars(filled(mesh, filling)[1], len(vertices) + len(filling.new_vertices))
    assert (closed.kinds[mesh[1]] == CLOSED).all()


def test_edges_that_are_there_already_are_not_doubled() -> None:
    """In the torus of seven vertices all are joined, so a vertex's star can be closed with new vertices only."""
    i = np.arange(7)
    faces = np.concatenate([np.column_stack([i, (i + 1) % 7, (i + 3) % 7]), np.column_stack([i, (i + 3) % 7, (i + 2) % 7])])
    mesh = np.random.default_rng(1).normal(size=(7, 3)), faces[(faces > 0).all(axis=1)].astype(np.int32)
    assert [rim.reason for rim in close_holes(*mesh, refine=False).left_open] == ["no_triangulation"]
    filling = close_holes(*mesh, energy="none")
    assert len(filling.closed) == 1
    assert sound(mesh, filling)


def test_a_non_manifold_border_is_left_and_the_others_are_closed() -> None:
    """Beside a tube whose two ends are closed, three pages that share an edge stay as they are, and the reason is given."""
    pages, body = book(3), tube(12, 6)
    vertices = np.concatenate([pages[0] + 10.0, body[0]])
    filling = close_holes(vertices, np.concatenate([pages[1], body[1] + len(pages[0])]))
    assert len(filling.closed) == 2
    assert [rim.reason for rim in filling.left_open] == ["non_manifold"]
    assert "more than two faces" in filling.left_open[0].message


def test_a_seam_that_was_never_merged_is_left() -> None:
    """A sphere in two halves that do not share the vertices between them but for two: triangles there would have no area."""
    vertices, faces = icosphere(2)
    upper = vertices[faces].mean(axis=1)[:, 1] > 0.0
    between = np.setdiff1d(np.intersect1d(faces[upper], faces[~upper]), [0])[1:]
    copies = np.arange(len(vertices), dtype=np.int32)
    copies[between] = len(vertices) + np.arange(len(between))
    split = np.where(upper[:, None], copies[faces], faces)
    filling = close_holes(np.concatenate([vertices, vertices[between]]), split)
    assert filling.closed == ()
    assert {rim.reason for rim in filling.left_open} == {"seam"}
    assert "merge" in filling.left_open[0].message


def test_a_whole_sheet_stays_open() -> None:
    """The border of a sheet is an outer border whatever `max_edges`, and whatever is selected."""
    assert [rim.reason for rim in close_holes(*grid(8, 9), max_edges=20).left_open] == ["outer"]
    filling = close_holes(*grid(8, 9), max_edges=100, selected=np.ones(90, dtype=np.bool_))
    assert [rim.reason for rim in filling.left_open] == ["outer"]


@pytest.mark.parametrize("degrees", [50, 90, 100, 120, 150])
def test_the_border_of_a_cap_of_a_ball_is_no_hole(degrees: int) -> None:
    """Up to arccos(-1/3) = 109 degrees a cap is an open sheet, whose rim is closed if it is selected; a larger cap has a hole."""
    mesh = cap(degrees)
    filling = close_holes(*mesh)
    if degrees > 109.5:
        assert len(filling.closed) == 1
        return
    assert [rim.reason for rim in filling.left_open] == ["probably_outer"]
    assert "select a vertex of it" in filling.left_open[0].message
    selected = np.zeros(len(mesh[0]), dtype=np.bool_)
    selected[filling.left_open[0].vertices[5]] = True
    assert len(close_holes(*mesh, selected=selected).closed) == 1


def test_holes_in_a_curved_sheet_are_closed_and_its_border_is_not() -> None:
    """A cap of a ball with three holes, as a scan of a head from one side, keeps its outer border alone."""
    vertices, faces = cap(50)
    centres = np.array([[0.0, 0.0, 1.0], [0.4, 0.1, 0.91], [-0.3, 0.35, 0.89]])
    gone = [np.linalg.norm(vertices[faces].mean(axis=1) - centre, axis=1) < 0.12 for centre in centres]
    filling = close_holes(vertices, faces[~np.any(gone, axis=0)])
    assert len(filling.closed) == 3
    assert [(rim.reason, len(rim.vertices)) for rim in filling.left_open] == [("probably_outer", 88)]


def test_the_inner_border_of_a_narrow_frame_is_a_hole() -> None:
    """A flat ring one edge wide has less area than its hole, which is closed; the outer border stays."""
    middles = (mesh := grid(12, 12))[0][mesh[1]].mean(axis=1)[:, :2]
    filling = close_holes(mesh[0], mesh[1][np.abs(middles - 6.0).max(axis=1) > 5.0])
    assert [len(rim) for rim in filling.closed] == [40]
    assert [(rim.reason, len(rim.vertices)) for rim in filling.left_open] == [("outer", 48)]


@pytest.mark.parametrize(
    ("place", "turn", "is_joined"),
    [
        ((5.0, 6.0, 0.0), 1, True),
        ((5.0, 6.0, 3.4), 1, True),
        ((5.0, 6.0, -3.4), 1, True),
        ((5.0, 6.0, 3.5), 1, False),
        ((5.0, 6.0, -3.5), 1, False),
        ((9.5, 4.5, 1.0), 1, True),
        ((4.5, 9.5, 1.0), 1, True),
        ((9.0, 9.0, 1.0), 1, False),
        ((7.0, 7.0, 1.0), 1, False),
        ((2.5, 6.0, 1.0), 1, False),
        ((5.0, 6.0, 0.0), -1, False),
    ],
    ids=["in it", "above", "below", "too high", "too low", "foot", "leg", "notch", "corner", "edge", "turned over"],
)
def test_an_island_is_what_lies_within_a_hole_near_its_plane(place: tuple[float, ...], turn: int, is_joined: bool) -> None:
    """In an L-shaped hole of area 48 all of it must lie inside the L, at most half the root of 48 high, and look upwards."""
    vertices, faces = grid(16, 16)
    x, y = vertices[faces].mean(axis=1)[:, :2].T
    hole = (np.minimum(x, y) > 4) & (np.maximum(x, y) < 12) & (np.minimum(x, y) < 8)
    island = grid(2, 2)
    mesh = (
        np.concatenate([vertices, island[0] + place]),
        np.concatenate([faces[~hole], island[1][:, ::turn] + np.int32(len(vertices))]),
    )
    filling = close_holes(*mesh, refine=False)
    assert [len(rim) for rim in filling.closed] == [32]
    assert [len(rim) for rim in filling.islands] == [8 if is_joined else 0]
    assert [rim.reason for rim in filling.left_open] == ["outer"] * (1 if is_joined else 2)


def test_an_island_within_a_frame_belongs_to_the_hole_of_the_frame() -> None:
    """Of two holes around an island it is joined to the smaller one, and the frame between them to the larger one."""
    vertices, faces = grid(16, 16)
    away = np.abs(vertices[faces].mean(axis=1)[:, :2] - 8.0).max(axis=1)
    parts = [faces[(away > low) & (away < high)] for low, high in ((6, 8), (2, 4), (0, 1))]
    own = np.concatenate([part + np.int32(k * len(vertices)) for k, part in enumerate(parts)])
    filling = close_holes(np.concatenate([vertices] * 3), own, refine=False)
    assert sorted((len(rim), len(island)) for rim, island in zip(filling.closed, filling.islands, strict=True)) == [
        (16, 8),
        (48, 32),
    ]


def test_an_island_may_have_any_number_of_edges() -> None:
    """One with more edges than a hole may have is joined all the same; its hole is not filled through it."""
    vertices, faces = cap_cut(3, 0.6)
    fine, triangles = cap(28)
    mesh = np.concatenate([vertices, fine]), np.concatenate([faces, triangles + np.int32(len(vertices))])
    sizes = {rim.reason: len(rim.vertices) for rim in close_holes(*mesh, max_edges=3).left_open}
    assert sizes["outer"] > sizes["size"]
    filling = close_holes(*mesh, max_edges=sizes["size"])
    assert filling.left_open == ()
    assert len(filling.islands[0]) == sizes["outer"]


def test_a_hole_with_more_edges_than_can_be_joined_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of edges of the hole together with its island is told, and the largest number."""
    mesh = cap_cut(4, 0.5, 0.15)
    edges = sum(len(rim.vertices) for rim in close_holes(*mesh, max_edges=3).left_open)
    monkeypatch.setattr("pymeshfair.filters.holes.closing.MOST_JOINED", 10)
    messages = [rim.message for rim in close_holes(*mesh, max_edges=edges - 1).left_open]
    assert sum(f"(the hole and its islands have {edges} edges, more than {edges - 1})" in message for message in messages) == 1


@pytest.mark.parametrize("way", ["seam", "island"])
def test_a_hole_stays_open_if_its_island_cannot_be_joined(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither is filled through where the island's vertices lie in pairs in the same places or no triangulation is found."""
    vertices, faces = cap_cut(4, 0.5, 0.15)
    (island,) = (rim.vertices for rim in close_holes(vertices, faces, islands="leave").left_open)
    if way == "seam":
        moved = vertices.copy()
        moved[island[1::2]] = moved[island[:-1:2]][: len(island[1::2])]
        vertices = moved
    else:
        monkeypatch.setattr("pymeshfair.filters.holes.closing.triangulate_polygon", lambda *_: None)
    filling = close_holes(vertices, faces)
    assert filling.closed == ()
    assert sorted(rim.reason for rim in filling.left_open) == ["island", way]
    assert any("an island lies in it" in rim.message for rim in filling.left_open)


def test_an_island_whose_hole_stays_open_may_be_a_hole_itself() -> None:
    """A cap of a ball in a hole with too many edges: its rim only seems to be an outer border, as without the hole."""
    vertices, faces = grid(16, 16)
    away = np.abs(vertices[faces].mean(axis=1)[:, :2] - 8.0).max(axis=1)
    island, triangles = cap(100)
    mesh = (
        np.concatenate([vertices, island + np.array([8.0, 8.0, 0.0])]),
        np.concatenate([faces[away > 4.0], triangles + np.int32(len(vertices))]),
    )
    assert len(close_holes(*mesh, max_edges=200, refine=False).islands[0]) > 0
    assert sorted(rim.reason for rim in close_holes(*mesh, max_edges=3).left_open) == ["outer", "probably_outer", "size"]


def test_only_selected_holes_are_closed() -> None:
    """Of the two ends of a tube the one with a selected vertex."""
    vertices, faces = tube(12, 6)
    selected = np.zeros(len(vertices), dtype=np.bool_)
    selected[3] = True
    filling = close_holes(vertices, faces, selected=selected)
    assert [sorted(rim.tolist()) for rim in filling.closed] == [list(range(12))]
    assert [rim.reason for rim in filling.left_open] == ["selection"]


def test_the_selected_rim_of_an_island_is_closed_if_the_hole_around_is_not_selected() -> None:
    """A cap of a ball in the hole that it was cut from: its own rim is closed, and the hole stays."""
    mesh = cap_cut(4, 0.9, 0.75)
    selected = mask_of(mesh[1], len(mesh[0])) & (mesh[0][:, 2] > 0.55)
    filling = close_holes(*mesh, selected=selected)
    assert [mesh[0][rim, 2].min() > 0.55 for rim in filling.closed] == [True]
    assert [rim.reason for rim in filling.left_open] == ["selection"]


def test_a_large_hole_is_closed() -> None:
    """A rim of more than a thousand edges, which is divided before it is triangulated."""
    mesh = tube(1_100, 2, radius=100.0, length=200.0)
    shares: list[float] = []
    filling = close_holes(*mesh, max_edges=2_000, refine=False, progress=shares.append)
    assert shares == sorted(shares)
    assert len(set(shares)) > 5
    assert len(filling.new_faces) == 2 * 1_098
    assert sound(mesh, filling)


#: Without two stars these have holes that can be closed.
CLOSABLE = {
    "caps",
    "thin caps",
    "caps without area",
    "edges without length",
    "needles",
    "faces that name a vertex twice",
    "isolated vertices",
    "two components",
    "1e30",
    "1e-30",
    "1e150",
    "geo-referenced",
}


@pytest.mark.parametrize("energy", ["thin_plate", "minimum_variation"])
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_come_through(name: str, energy: HoleEnergy) -> None:
    """Without the faces at two vertices, the work ends, all that is added is finite, and no non-manifold edge is added."""
    vertices, faces = AWKWARD[name]()
    if len(faces):
        hubs = faces[[len(faces) // 3, 2 * len(faces) // 3], 0]
        faces = faces[~np.isin(faces, hubs).any(axis=1)]
    filling = close_holes(vertices, faces, energy=energy)
    assert (len(filling.closed) > 0) == (name in CLOSABLE)
    closed = filled((vertices, faces), filling)
    assert np.isfinite(closed[0]).all()
    assert len(non_manifold_edges(closed[1])) == len(non_manifold_edges(faces))


def test_holes_beside_edges_without_length_are_closed() -> None:
    """Of some hundred holes all are placed, by the energy asked for or a lower one, though not all equations can be solved."""
    vertices, faces = with_needles(0.0)
    rng = np.random.default_rng(280383805)
    share = rng.uniform(0.02, 0.6)
    filling = close_holes(vertices, faces[rng.random(len(faces)) > share], energy="minimum_variation")
    assert len(filling.energies) == len(filling.closed) > 100
    assert filling.energies.count("minimum_variation") > 0.9 * len(filling.closed)
    assert np.isfinite(filling.new_vertices).all()


def test_a_degenerate_patch_does_not_stop_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """A patch whose equations cannot be solved gets the next lower energy, and the others the one asked for, as without it."""
    vertices, faces = icosphere(3)
    gone = [np.linalg.norm(vertices[faces].mean(axis=1) - centre, axis=1) < 0.4 for centre in np.eye(3)]
    mesh = vertices, faces[~np.any(gone, axis=0)]
    plain = close_holes(*mesh, energy="minimum_variation")

    def fair(points: Floats, triangles: Any, free: Any, **options: Any) -> Any:
        if options["energy"] == "minimum_variation" and points[free][:, 2].max() > 0.85 * points[:, 2].max():
            raise ConvergenceError("too ill-conditioned")
        return fair_region(points, triangles, free, **options)

    monkeypatch.setattr("pymeshfair.filters.holes.closing.fair_region", fair)
    filling = close_holes(*mesh, energy="minimum_variation")
    at_top = [bool(vertices[rim, 2].mean() > 0.8) for rim in filling.closed]
    assert sum(at_top) == 1
    assert filling.energies == tuple("thin_plate" if top else "minimum_variation" for top in at_top)
    for k in np.flatnonzero(~np.array(at_top)):
        # The solutions are refined to rounding, whoever is solved for at the same time.
        one, other = (f.new_vertices[f.hole_of_vertex == k] for f in (plain, filling))
        assert np.abs(one - other).max() < 1e-9


def test_a_vertex_without_a_face_changes_nothing() -> None:
    """Wherever it is, the filling is the same to the bit."""
    vertices, faces = rough()
    for place in (1e100, -3.0):
        stray = close_holes(np.concatenate([vertices, np.full((1, 3), place)]), faces)
        assert np.array_equal(stray.new_vertices, close_holes(vertices, faces).new_vertices)


# --------------------------------------------------------------------------------------------------------------- invariances


@functools.cache
def rough() -> Mesh:
    """A noisy sphere with a hole, whose triangulation no symmetry leaves open."""
    vertices, faces = noisy(icosphere(3), 0.01, 5)
    middles = vertices[faces].mean(axis=1)
    return vertices, faces[np.linalg.norm(middles - np.array([0.1, 0.2, 0.97]), axis=1) > 0.45]


def test_the_filling_moves_with_the_mesh() -> None:
    """Turned, moved and made a thousand times larger, a mesh gets the same faces and the vertices moved likewise."""
    vertices, faces = rough()
    filling = close_holes(vertices, faces)
    turn, shift = rotation(3), np.array([10.0, -20.0, 30.0])
    moved = close_holes((vertices @ turn.T) * 1e3 + shift, faces)
    assert np.array_equal(moved.new_faces, filling.new_faces)
    expected = (filling.new_vertices @ turn.T) * 1e3 + shift
    # The equations have a condition of some 1e6 in the squared operator.
    assert np.abs(moved.new_vertices - expected).max() < 1e-9 * diagonal(expected)


@pytest.mark.parametrize("exponent", [-400, 400])
def test_the_filling_does_not_depend_on_the_unit(exponent: int) -> None:
    """Multiplied by a power of two, 1e120 or 1e-120, the mesh gets the same filling to the bit, times that."""
    vertices, faces = rough()
    scaled = close_holes(np.ldexp(vertices, exponent), faces)
    assert np.array_equal(scaled.new_vertices, np.ldexp(close_holes(vertices, faces).new_vertices, exponent))


def test_the_filling_does_not_depend_on_the_numbering() -> None:
    """With vertices and faces in another order the new vertices are in the same places."""
    mesh = rough()
    filling = close_holes(*mesh)
    vertices, faces, _ = renumbered(mesh)
    again = close_holes(vertices, faces)
    assert len(again.new_vertices) == len(filling.new_vertices)
    apart = np.linalg.norm(again.new_vertices[:, None] - filling.new_vertices, axis=2)
    assert apart.min(axis=1).max() < 1e-9


def test_the_filling_is_the_same_to_the_bit() -> None:
    """Done twice."""
    one, two = close_holes(*rough()), close_holes(*rough())
    assert np.array_equal(one.new_vertices, two.new_vertices)
    assert np.array_equal(one.new_faces, two.new_faces)


# ------------------------------------------------------------------------------------------------------------------ requests


def test_progress_grows_to_one_and_may_stop_the_work() -> None:
    """It is told shares in order, the last 1, and what it raises comes through."""
    shares: list[float] = []
    close_holes(*rough(), progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0

    def stop(done: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        close_holes(*rough(), progress=stop)


def test_what_is_out_of_range_is_refused() -> None:
    """The message names the parameter."""
    mesh = rough()
    with pytest.raises(FilterInputError, match="max_edges"):
        close_holes(*mesh, max_edges=2)
    with pytest.raises(FilterInputError, match="rounds"):
        close_holes(*mesh, rounds=0)
    for value in (float("nan"), float("inf"), 2.5, "many", None):
        with pytest.raises(FilterInputError, match=r"max_edges is .* whole number"):
            close_holes(*mesh, max_edges=value)  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="energy"):
        close_holes(*mesh, energy="plate")  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="islands"):
        close_holes(*mesh, islands="drop")  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="selected"):
        close_holes(*mesh, selected=np.ones(3, dtype=np.bool_))


def test_a_short_rim_that_turns_like_a_border_is_a_hole() -> None:
    """The rim of a bell turns by 2 pi like the border of a disc; on the neck of a large ball it is closed, alone not."""
    around = 24
    heights = np.concatenate([[0.0, 0.0, -0.2, -1.0, -1.5], -6.5 + 5.0 * np.cos(np.linspace(0.1, 3.0, 20))])
    radii = np.concatenate([[1.0, 0.7, 0.3, 0.3, 0.4], 5.0 * np.sin(np.linspace(0.1, 3.0, 20))])
    for rows, reasons in ((25, []), (4, ["outer"])):
        vertices, faces = tube(around, rows - 1)
        vertices[:, :2] *= np.repeat(radii[:rows], around)[:, None]
        vertices[:, 2] = np.repeat(heights[:rows], around)
        filling = close_holes(vertices, faces, refine=False)
        assert [rim.reason for rim in filling.left_open] == reasons
        assert len(filling.closed) == 2 - len(reasons)
