"""The faces around a face, against sets built face by face."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from pymeshfair.filters.denoising.face_neighbourhoods import (
    FaceNeighbourhoods,
    Neighborhood,
    face_neighbourhoods,
    mean_centre_distance,
)
from pymeshfair.filters.geometry import measure_faces
from pymeshfair.filters.topology import vertex_faces
from tests.meshes import AWKWARD, Floats, Ints, grid, icosphere, irregular_grid, moebius_strip

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
