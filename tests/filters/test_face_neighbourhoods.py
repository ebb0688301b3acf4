"""The faces around a face, against sets built face by face."""

from __future__ import annotations

import heapq
from typing import get_args

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.face_neighbourhoods import (
    FaceNeighbourhoods,
    Neighborhood,
    face_neighbourhoods,
    mean_centre_distance,
)
from pymeshfair.filters.geometry import measure_faces
from pymeshfair.filters.topology import vertex_faces
from tests.meshes import AWKWARD, Floats, Ints, grid, icosphere, irregular_grid, moebius_strip, noisy

RINGS = {"vertex": 1, "two_ring": 2, "three_ring": 3}


def sets(around: FaceNeighbourhoods) -> list[set[int]]:
    """The neighbours of every face, and that each is named once."""
    result = [around.neighbours[a:b].tolist() for a, b in zip(around.offsets[:-1], around.offsets[1:], strict=True)]
    assert all(len(set(row)) == len(row) for row in result)
    return [set(row) for row in result]


def slow_sets(vertices: Floats, faces: Ints, kind: Neighborhood, radius: float = 0.0) -> list[set[int]]:
    """The definition, with sets of vertices."""
    named = [set(face.tolist()) if len(set(face.tolist())) == 3 else set() for face in faces]
    shared = 2 if kind == "edge" else 1
    near = [{j for j, other in enumerate(named) if len(own & other) >= shared and j != i} for i, own in enumerate(named)]
    if kind in ("edge", "vertex"):
        return near
    result = []
    centres = vertices[faces].mean(axis=1)
    if kind == "geodesic":
        return [set(slow_ways(centres, near, i, radius)) - {i} for i in range(len(faces))]
    for i in range(len(faces)):
        found, front = {i}, {i}
        rounds = RINGS.get(kind, len(faces))
        for _ in range(rounds):
            front = {j for g in front for j in near[g]} - found
            if kind == "radius":
                front = {j for j in front if np.linalg.norm(centres[j] - centres[i]) <= radius}
            found |= front
        result.append(found - {i})
    return result


def slow_ways(centres: Floats, near: list[set[int]], start: int, radius: float) -> dict[int, float]:
    """Dijkstra's algorithm: the faces within the radius and the lengths of their ways from the first."""
    lengths: dict[int, float] = {}
    waiting = [(0.0, start)]
    while waiting:
        length, face = heapq.heappop(waiting)
        if face in lengths or length > radius:
            continue
        lengths[face] = length
        for other in near[face]:
            heapq.heappush(waiting, (length + float(np.linalg.norm(centres[other] - centres[face])), other))
    return lengths


@pytest.mark.parametrize("kind", get_args(Neighborhood))
def test_neighbourhoods_are_those_of_the_definition(kind: Neighborhood) -> None:
    """Every kind of neighbourhood on closed, open, one-sided and broken meshes is the set that its definition names."""
    for vertices, faces in (icosphere(1), irregular_grid(5, 4), moebius_strip(), AWKWARD["ten pages"](), AWKWARD["bow tie"](),
                            AWKWARD["faces that name a vertex twice"](), AWKWARD["some duplicate faces"]()):  # fmt: skip
        centres = np.ascontiguousarray(vertices[faces].mean(axis=1))
        around = face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), kind, centres=centres, radius=0.71)
        assert sets(around) == slow_sets(vertices, faces, kind, 0.71)


def test_the_mean_distance_of_centres_is_that_over_edges() -> None:
    """On a grid of squares of side 3 the centres across diagonals are sqrt 2 apart, across sides sqrt 5."""
    vertices, faces = grid(4, 4, spacing=3.0)
    edge = face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), "edge")
    inner_sides, diagonals = 2 * 4 * 3, 16
    expected = (inner_sides * np.sqrt(5.0) + diagonals * np.sqrt(2.0)) / (inner_sides + diagonals)
    assert mean_centre_distance(measure_faces(vertices, faces), edge) == pytest.approx(expected, rel=1e-12)


def test_a_large_hub_needs_no_more_than_its_neighbours() -> None:
    """The faces of a fan are all neighbours at their vertex, however many they are."""
    vertices, faces = AWKWARD["large hub"]()
    around = face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), "vertex")
    assert np.diff(around.offsets).tolist() == [199] * 200


@pytest.mark.parametrize("radius", [0.9, 3.0, 7.5])
def test_geodesic_neighbourhoods_are_those_of_dijkstra(radius: float) -> None:
    """Small and large radii on a rough sheet give the faces whose shortest ways Dijkstra's algorithm finds short enough."""
    vertices, faces = noisy(irregular_grid(8, 8), 0.3)
    centres = np.ascontiguousarray(vertices[faces].mean(axis=1))
    around = face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), "geodesic", centres=centres, radius=radius)
    assert sets(around) == slow_sets(vertices, faces, "geodesic", radius)


def test_ways_on_a_plane_are_little_longer_than_straight() -> None:
    """On equal triangles no face is met from beyond the radius, and every face that is nearer than 1 / 1.04 of it is met."""
    for size, radii in ((16, np.arange(0.6, 5.0, 0.2)), (30, (6.0, 8.0, 9.8))):
        vertices, faces = grid(size, size)
        vertices = vertices @ np.array([[1.0, 0.0, 0.0], [-0.5, np.sqrt(0.75), 0.0], [0.0, 0.0, 1.0]])
        centres = np.ascontiguousarray(vertices[faces].mean(axis=1))
        middle = int(np.argmin(np.linalg.norm(centres - centres.mean(axis=0), axis=1)))
        distances = np.linalg.norm(centres - centres[middle], axis=1)
        at_vertices = vertex_faces(faces, len(vertices))
        for radius in radii:
            around = face_neighbourhoods(faces, at_vertices, "geodesic", centres=centres, radius=float(radius))
            found = around.neighbours[around.offsets[middle] : around.offsets[middle + 1]].tolist()
            assert distances[found].max() <= radius + 1e-12
            assert set(found) >= set(np.flatnonzero(distances < radius / 1.04).tolist()) - {middle}


def test_sheets_that_lie_close_do_not_mix() -> None:
    """The two sides of a thin wall, joined along one end: no face has a neighbour on the other side but near that end.

    Only faces at the end, whose centres are at most 2/3 from it, can be stepped over; the radius of 2 reaches 2.67 from it.
    """
    sheet, faces = grid(12, 6)
    bottom = sheet * [1.0, 1.0, 0.0] - [0.0, 0.0, 0.05]
    vertices = np.concatenate([sheet, bottom])
    lower = faces[:, ::-1] + len(sheet)
    ends = np.flatnonzero(sheet[:, 0] == 0.0)
    ends = ends[np.argsort(sheet[ends, 1])]
    a, b = ends[:-1], ends[1:]
    rim = np.concatenate([np.column_stack([a, b, a + len(sheet)]), np.column_stack([b, b + len(sheet), a + len(sheet)])])
    wall = np.concatenate([faces, lower, rim]).astype(np.int32)
    centres = np.ascontiguousarray(vertices[wall].mean(axis=1))
    around = face_neighbourhoods(wall, vertex_faces(wall, len(vertices)), "geodesic", centres=centres, radius=2.0)
    found = sets(around)
    upper = range(len(faces))
    crosses = np.array([any(len(faces) <= j < 2 * len(faces) for j in found[i]) for i in upper])
    far = centres[: len(faces), 0] > 2.67
    assert not crosses[far].any()
    assert crosses[~far].any()
    assert np.mean([len(found[i]) for i in upper if far[i]]) > 8


def test_unknown_neighbourhoods_are_refused() -> None:
    """The message names what is allowed."""
    vertices, faces = icosphere(0)
    with pytest.raises(FilterInputError, match="'four_ring' is not one of 'edge', 'vertex'"):
        face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), "four_ring")  # type: ignore[arg-type]
    for kind in ("radius", "geodesic"):
        with pytest.raises(FilterInputError, match="radius"):
            face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), kind)
        with pytest.raises(FilterInputError, match=r"^give the centres of the faces$"):
            face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), kind, radius=1.0)
