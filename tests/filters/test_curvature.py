"""Curvatures at vertices."""

from __future__ import annotations

import math
from typing import Any, get_args

import numpy as np
import pymeshlab
import pytest

from pymeshfair.errors import FilterInputError
from pymeshfair.filters.inspection import CurvatureOperator, gaussian_curvature, mean_curvature, surface_measures
from tests.meshes import AWKWARD, cube, grid, icosphere, irregular_grid, noisy, rotation, sample, tetrahedron, torus, tube

CLOSED: dict[str, Any] = {
    "tetrahedron": tetrahedron,
    "cube": cube,
    "sphere": lambda: icosphere(3),
    "torus": torus,
    "noisy torus": lambda: noisy(torus(), 0.2),
    "coincident corners": AWKWARD["edges without length"],
    "bunny": lambda: sample("bunny.obj"),
}


@pytest.mark.parametrize("name", CLOSED)
def test_deficits_of_closed_meshes_add_up(name: str) -> None:
    """The angle deficits of a closed mesh sum to 2 pi chi, to 1e-9 (Gauss-Bonnet)."""
    vertices, faces = CLOSED[name]()
    expected = 2 * math.pi * surface_measures(vertices, faces).euler_characteristic
    assert abs(math.fsum(gaussian_curvature(vertices, faces, measure="deficit")) - expected) < 1e-9


@pytest.mark.parametrize("mesh", [grid(), irregular_grid(), tube()], ids=["grid", "irregular grid", "tube"])
def test_deficits_of_open_meshes_add_up(mesh: Any) -> None:
    """With how far the border turns, the deficits of an open mesh sum to 2 pi chi, too."""
    expected = 2 * math.pi * surface_measures(*mesh).euler_characteristic
    assert abs(math.fsum(gaussian_curvature(*mesh, measure="deficit")) - expected) < 1e-9


def test_deficit_of_a_cube_is_a_right_angle() -> None:
    """Three right angles meet at the corner of a cube, so that one is missing."""
    np.testing.assert_allclose(gaussian_curvature(*cube(), measure="deficit"), math.pi / 2, rtol=1e-14)


def test_mean_curvature_of_a_tube_is_exact() -> None:
    """On a cylinder of squares cut in two, the cotangent operator gives 1 / (2 r), whatever the number of sides."""
    vertices, faces = tube(16, 16, radius=2.0, length=4.0 * math.pi)
    inner = (vertices[:, 2] > 0.1) & (vertices[:, 2] < vertices[:, 2].max() - 0.1)
    np.testing.assert_allclose(mean_curvature(vertices, faces)[inner], 0.25, rtol=1e-12)
    np.testing.assert_allclose(gaussian_curvature(vertices, faces)[inner], 0.0, atol=1e-12)
    assert not mean_curvature(vertices, faces)[vertices[:, 2] == 0.0].any()


def test_curvatures_of_a_torus_converge() -> None:
    """On a torus of squares of triangles mean and Gaussian curvature converge with the square of the edge."""
    errors = []
    for along in (24, 48, 96):
        vertices, faces = torus(2 * along, along, major=2.0, minor=0.7)
        ring = np.hypot(vertices[:, 0], vertices[:, 1])
        cosine = (ring - 2.0) / 0.7
        mean = (2.0 + 2 * 0.7 * cosine) / (2 * 0.7 * ring)
        gauss = cosine / (0.7 * ring)
        errors.append(
            [
                np.abs(mean_curvature(vertices, faces) - mean).max(),
                np.abs(gaussian_curvature(vertices, faces) - gauss).max(),
            ]
        )
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders > 1.8).all()


def test_curvatures_of_a_sphere_converge() -> None:
    """On the icosphere the mean error falls with the square of the edge; that of the uniform operator is below 0.5 % in the end.

    On a sphere (p_j - p_i) . n = -|p_j - p_i|^2 / (2 r) for the true normal n, so the uniform operator errs by the normal alone.
    """
    errors = []
    for level in (2, 3, 4):
        vertices, faces = icosphere(level, radius=3.0)
        errors.append(
            [
                np.abs(mean_curvature(vertices, faces) - 1 / 3).mean(),
                np.abs(gaussian_curvature(vertices, faces) - 1 / 9).mean(),
            ]
        )
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders > 1.9).all()
    uniform = mean_curvature(*icosphere(4, radius=3.0), operator="uniform")
    assert np.abs(3 * uniform - 1).max() < 5e-3


def test_curvatures_scale_with_the_unit() -> None:
    """Lengths times 2^20 make mean curvature 2^-20 and Gaussian curvature 2^-40 times as large, to the bit."""
    vertices, faces = noisy(icosphere(2), 0.02)
    large = vertices * 2.0**20
    np.testing.assert_array_equal(mean_curvature(large, faces), mean_curvature(vertices, faces) * 2.0**-20)
    np.testing.assert_array_equal(gaussian_curvature(large, faces), gaussian_curvature(vertices, faces) * 2.0**-40)


def test_curvatures_do_not_depend_on_the_direction() -> None:
    """A turned mesh has the same curvatures, to rounding."""
    vertices, faces = noisy(torus(), 0.02)
    turned = vertices @ rotation().T
    np.testing.assert_allclose(mean_curvature(turned, faces), mean_curvature(vertices, faces), atol=1e-11)
    np.testing.assert_allclose(gaussian_curvature(turned, faces), gaussian_curvature(vertices, faces), atol=1e-11)


def test_turned_over_faces_change_the_sign_of_the_mean_curvature_alone() -> None:
    """The mean curvature is positive on the side to which the surface bulges."""
    vertices, faces = noisy(icosphere(2), 0.02)
    np.testing.assert_allclose(mean_curvature(vertices, faces[:, ::-1]), -mean_curvature(vertices, faces), atol=1e-12)
    np.testing.assert_allclose(gaussian_curvature(vertices, faces[:, ::-1]), gaussian_curvature(vertices, faces), atol=1e-11)


def test_gaussian_curvature_agrees_with_meshlab() -> None:
    """MeshLab's discrete Gaussian curvature is the deficit over the mixed area, too; of acute triangles the areas agree."""
    vertices, faces = icosphere(3)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Gaussian Curvature")
    theirs = meshes.current_mesh().vertex_scalar_array()
    # MeshLab takes areas in single precision.
    np.testing.assert_allclose(gaussian_curvature(vertices, faces), theirs, rtol=1e-4)


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_have_finite_curvatures(name: str) -> None:
    """Whatever the mesh, no curvature is NaN, and 0 where there is no face."""
    vertices, faces = AWKWARD[name]()
    unused = np.setdiff1d(np.arange(len(vertices)), faces)
    means = [mean_curvature(vertices, faces, operator=operator) for operator in get_args(CurvatureOperator)]
    for found in (*means, gaussian_curvature(vertices, faces)):
        assert np.isfinite(found).all()
        assert not found[unused].any()


def test_unknown_names_are_refused() -> None:
    """Another operator or measure is named with those that there are."""
    with pytest.raises(FilterInputError, match="operator 'cot' is not one of 'cotangent', 'uniform'"):
        mean_curvature(*cube(), operator="cot")  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="measure 'area'"):
        gaussian_curvature(*cube(), measure="area")  # type: ignore[arg-type]
