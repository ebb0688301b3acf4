"""How far meshes lie from each other."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.errors import FilterInputError
from pymeshfair.filters.inspection import displacement
from tests.meshes import grid, icosphere, noisy, renumbered, sample

NO_FACES = np.empty((0, 3), dtype=np.int32)


def test_larger_sphere_lies_outside() -> None:
    """The vertices of a sphere of radius 1.1 lie 0.1 outside those of the unit sphere, by vertex and to the surface."""
    vertices, faces = icosphere(3)
    grown = displacement(1.1 * vertices, faces, vertices, faces)
    assert grown.by_vertex
    np.testing.assert_allclose(grown.distances, 0.1, rtol=1e-12)
    np.testing.assert_allclose(
        grown.signed, 0.1, rtol=2e-5
    )  # along the normals of the vertices, which are nearly those of the sphere
    apart = displacement(1.1 * vertices, faces, vertices, faces, correspondence="surface")
    assert not apart.by_vertex
    np.testing.assert_allclose(apart.signed, 0.1, rtol=1e-12)
    shrunk = displacement(0.9 * vertices, faces, vertices, faces, correspondence="surface")
    assert (shrunk.signed < 0.0).all()


def test_slide_along_a_plane_is_seen_by_vertex_alone() -> None:
    """Vertices that move within their plane move by their distance and stay on the surface: neither out nor in."""
    vertices, faces = grid()
    inside = (vertices[:, 0] % 9 > 0) & (vertices[:, 1] % 8 > 0)
    slid = vertices + inside[:, None] * [0.25, 0.0, 0.0]
    by_vertex = displacement(slid, faces, vertices, faces)
    np.testing.assert_array_equal(by_vertex.distances, 0.25 * inside)
    np.testing.assert_array_equal(by_vertex.signed, 0.0)
    np.testing.assert_allclose(displacement(slid, faces, vertices, faces, correspondence="surface").distances, 0.0, atol=1e-15)


@pytest.mark.slow
def test_nearest_places_are_those_of_a_slow_search() -> None:
    """The distance to the nearest triangle of all, found one by one, is the distance that is given."""
    vertices, faces = noisy(icosphere(1), 0.1)
    queries = np.random.default_rng(3).normal(size=(8, 3))
    found = displacement(queries, NO_FACES, vertices, faces)
    np.testing.assert_allclose(found.distances, [_slow(q, vertices[faces]) for q in queries], rtol=1e-9)


def _slow(query: np.ndarray, triangles: np.ndarray) -> float:
    """The least distance over a fine barycentric grid, made finer twice round the best place; the distance is convex there."""
    best = np.inf
    for triangle in triangles:
        centre, size = np.array([1 / 3, 1 / 3]), 1.0
        for _ in range(30):
            s, t = np.meshgrid(*(c + size * np.linspace(-1, 1, 9) for c in centre))
            pairs = np.column_stack([s.ravel(), t.ravel()])
            pairs = np.clip(pairs, 0.0, 1.0)
            over = pairs.sum(axis=1) > 1.0
            pairs[over] /= pairs[over].sum(axis=1, keepdims=True)
            places = triangle[0] + pairs @ (triangle[1:] - triangle[0])
            distances = np.linalg.norm(places - query, axis=1)
            centre, size = pairs[distances.argmin()], size * 0.45
            best = min(best, float(distances.min()))
    return best


def test_far_from_the_origin_nothing_is_lost() -> None:
    """Moved by UTM coordinates, displacements are the same to a relative 1e-9, given coordinates that can be moved exactly."""
    vertices, faces = icosphere(3, 50.0)
    vertices = np.round(vertices * 2.0**16) / 2.0**16
    moved = np.round(noisy((vertices, faces), 0.5)[0] * 2.0**16) / 2.0**16
    offset = np.array([5e5, 5.5e6, 300.0])
    for correspondence in ("vertex", "surface"):
        near = displacement(moved, faces, vertices, faces, correspondence=correspondence).distances
        far = displacement(moved + offset, faces, vertices + offset, faces, correspondence=correspondence).distances
        np.testing.assert_allclose(far, near, rtol=1e-9, atol=1e-9 * near.max())


def test_other_numbers_are_another_connectivity() -> None:
    """A renumbered mesh has other faces, so that places are compared: it lies nowhere else."""
    vertices, faces = sample("bunny.obj")
    other, other_faces, _ = renumbered((vertices, faces))
    found = displacement(other, other_faces, vertices, faces)
    assert not found.by_vertex
    assert found.distances.max() < 1e-12


def test_clouds_are_compared_point_by_point() -> None:
    """Without faces the counterpart is the nearest point of the cloud."""
    found = displacement(np.array([[0.0, 0, 0], [10, 0, 0]]), NO_FACES, np.array([[9.0, 0, 0], [0, 2, 0]]), NO_FACES)
    np.testing.assert_array_equal(found.distances, [2.0, 1.0])


def test_a_point_without_a_face_is_displaced_by_its_distance() -> None:
    """Compared by number, a moved cloud, and a vertex without a face, have the signed distance that they have moved, not 0."""
    vertices, faces = icosphere(1)
    moved = vertices + np.array([0.0, 0.3, 0.4])
    np.testing.assert_allclose(displacement(moved, NO_FACES, vertices, NO_FACES, correspondence="vertex").signed, 0.5, rtol=1e-12)
    loose = np.concatenate([vertices, [[3.0, 0.0, 0.0]]])
    assert displacement(loose * 2.0, faces, loose, faces).signed[-1] == 3.0


def test_vertices_that_cannot_correspond_are_refused() -> None:
    """Other numbers of vertices, and an empty reference, are named with what to do."""
    vertices, faces = grid()
    with pytest.raises(FilterInputError, match="take the correspondence 'surface'"):
        displacement(vertices[:-1], NO_FACES, vertices, faces, correspondence="vertex")
    with pytest.raises(FilterInputError, match="the reference has no vertices"):
        displacement(vertices, faces, np.empty((0, 3)), NO_FACES)
