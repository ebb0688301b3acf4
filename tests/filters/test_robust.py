"""The robust operator: against its library, intrinsic Delaunay triangulations, and what it is for."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import robust_laplacian

from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.operators import cotangent_laplacian, cotangent_stiffness, robust_cloud_laplacian, robust_mesh_laplacian
from tests.meshes import AWKWARD, area, icosphere, irregular_grid, noisy, sample


def test_it_is_the_librarys_with_our_sign() -> None:
    """On a mesh that needs no repair stiffness and mass are those of robust_laplacian, the stiffness negated, to its rounding."""
    vertices, faces = noisy(icosphere(2), 0.05)
    positive, mass = robust_laplacian.mesh_laplacian(vertices, faces)
    laplacian = robust_mesh_laplacian(vertices, faces)
    # Ours is computed at the origin and at another scale, which rounds differently.
    np.testing.assert_allclose(laplacian.stiffness.toarray(), -positive.toarray(), atol=1e-12)
    np.testing.assert_allclose(laplacian.mass, mass.diagonal(), rtol=1e-12)


def test_it_is_the_cotangent_operator_of_the_intrinsic_delaunay_triangulation() -> None:
    """On an obtuse mesh its stiffness is igl's on intrinsic Delaunay edges, up to the mollification by 1e-5 of the mean edge."""
    vertices, faces = irregular_grid(amount=0.45)
    lengths = np.linalg.norm(vertices[faces[:, [1, 2, 0]]] - vertices[faces[:, [2, 0, 1]]], axis=2)
    expected = igl.intrinsic_delaunay_cotmatrix(vertices, faces)
    expected = (expected[0] if isinstance(expected, tuple) else expected).toarray()
    assert abs(cotangent_stiffness(vertices, faces).toarray() - expected).max() > 0.1
    # An edge of length l moved by d changes a cotangent by some d / l of its square.
    tolerance = 10 * 1e-5 * lengths.mean() / lengths.min() * np.abs(expected).max()
    np.testing.assert_allclose(robust_mesh_laplacian(vertices, faces).stiffness.toarray(), expected, atol=tolerance)


def test_its_mass_is_the_area() -> None:
    """The masses of a mesh add up to its area, in the square of its unit, up to the mollification."""
    vertices, faces = noisy(icosphere(2, radius=50.0), 1.0)
    assert robust_mesh_laplacian(vertices, faces).mass.sum() == pytest.approx(area(vertices, faces), rel=1e-3)


@pytest.mark.parametrize("name", [n for n in AWKWARD if n not in ("empty", "only faces that name a vertex twice")])
def test_no_weight_is_negative_on_awkward_meshes(name: str) -> None:
    """Slivers, non-manifold edges and vertices, duplicates: all weights are at least 0 up to rounding, all entries finite."""
    vertices, faces = AWKWARD[name]()
    stiffness = robust_mesh_laplacian(vertices, faces).stiffness.toarray()
    assert np.isfinite(stiffness).all()
    off_diagonal = stiffness - np.diag(np.diag(stiffness))
    assert off_diagonal.min() >= -1e-9 * np.abs(stiffness).max()


def test_no_weight_is_negative_on_an_obtuse_scan() -> None:
    """The cow, where a sixth of the cotangent weights is negative, has at most rounding below 0."""
    vertices, faces = sample("cow.obj")
    plain, robust = (f(vertices, faces) for f in (cotangent_laplacian, robust_mesh_laplacian))
    weights = plain.stiffness.tocoo()
    assert (weights.data[weights.row != weights.col] < 0).mean() > 0.15
    weights = robust.stiffness.tocoo()
    assert weights.data[weights.row != weights.col].min() > -1e-9


def test_vertices_without_triangles_have_no_row() -> None:
    """Unreferenced vertices neither count nor disturb the others: the rest is the operator without them."""
    vertices, faces = AWKWARD["isolated vertices"]()
    laplacian = robust_mesh_laplacian(vertices, faces)
    plain = robust_mesh_laplacian(*icosphere(2))
    assert laplacian.mass[[0, -1]].tolist() == [0.0, 0.0]
    assert not topology.referenced_vertices(faces, len(vertices))[[0, -1]].any()
    np.testing.assert_allclose(laplacian.mass[1:-1], plain.mass, rtol=1e-12)
    np.testing.assert_allclose(laplacian.stiffness.toarray()[1:-1, 1:-1], plain.stiffness.toarray(), atol=1e-12)


def test_a_cloud_of_points_on_a_sphere_has_its_curvature() -> None:
    """From an icosphere's points alone L p comes within 2 % of -2 p in the mean square, and the masses of 4 pi."""
    points = icosphere(4)[0]
    laplacian = robust_cloud_laplacian(points)
    error = np.linalg.norm(laplacian.apply(points) + 2 * points, axis=1)
    assert np.sqrt((error**2).mean()) < 0.04
    assert laplacian.mass.sum() == pytest.approx(4 * np.pi, rel=0.02)


def test_points_in_one_place_move_as_one() -> None:
    """With some points given three times the others have the operator they have without, and the copies that of their place."""
    points = np.random.default_rng(0).random((60, 3))
    plain = robust_cloud_laplacian(points).apply(points)
    doubled = np.concatenate([points, points[:20], points[:20]])
    laplacian = robust_cloud_laplacian(doubled)
    np.testing.assert_allclose(laplacian.apply(doubled), np.concatenate([plain, plain[:20], plain[:20]]), atol=1e-9)
    assert abs(laplacian.stiffness - laplacian.stiffness.T).max() < 1e-12
    assert np.abs(laplacian.stiffness.sum(axis=1)).max() < 1e-12


def test_points_on_a_line_are_an_error() -> None:
    """Points on a line have no triangles: the error says so, and what to do."""
    with pytest.raises(FilterInputError, match=r"leave a point of the cloud without a triangle, .* lie on a line"):
        robust_cloud_laplacian(np.outer(np.random.default_rng(0).random(60), [1.0, 2.0, 3.0]))


def test_a_cloud_needs_more_points_than_neighbours() -> None:
    """30 places, one of them taken by nine points, have no 30 neighbours each: an error that says how many it takes."""
    few = np.random.default_rng(0).random((30, 3))
    with pytest.raises(FilterInputError, match=r"30 distinct points has fewer than 30 neighbours for each point: .* at least 31"):
        robust_cloud_laplacian(np.concatenate([few, np.repeat(few[:1], 8, axis=0)]))
    assert robust_cloud_laplacian(np.random.default_rng(0).random((31, 3))).mass.sum() > 0
