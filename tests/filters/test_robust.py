"""The robust operator: against its library, intrinsic Delaunay triangulations, and what it is for."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import robust_laplacian

from pymeshfair.filters import operators, topology
from pymeshfair.filters.errors import FilterInputError
from pymeshfair.filters.operators import robust_cloud_laplacian, robust_mesh_laplacian
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
    assert abs(operators.cotangent_stiffness(vertices, faces).toarray() - expected).max() > 0.1
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
    plain, robust = (f(vertices, faces) for f in (operators.cotangent_laplacian, robust_mesh_laplacian))
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


def test_clouds_with_coincident_points_are_finite() -> None:
    """Points given twice, or all in one place, make no NaN."""
    points = np.random.default_rng(0).random((60, 3))
    for cloud in (np.concatenate([points, points[:30]]), np.full((40, 3), 3.0)):
        laplacian = robust_cloud_laplacian(cloud)
        assert np.isfinite(laplacian.stiffness.data).all()
        assert np.isfinite(laplacian.mass).all()


def test_a_cloud_needs_more_points_than_neighbours() -> None:
    """30 points have no 30 neighbours each: an error that says how many it takes."""
    with pytest.raises(FilterInputError, match="a point cloud of 30 points has no 30 neighbours for each: it takes at least 31"):
        robust_cloud_laplacian(np.random.default_rng(0).random((30, 3)))
    assert robust_cloud_laplacian(np.random.default_rng(0).random((31, 3))).mass.sum() > 0
