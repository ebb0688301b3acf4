"""Vertices fitted to face normals, against loops over the faces of each vertex."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.vertex_update import VertexUpdate, fit_vertices, fitting_energy
from pymeshfair.filters.geometry import face_normals
from pymeshfair.filters.topology import vertex_faces
from tests.meshes import Floats, Ints, icosphere, irregular_grid, noisy

NOISY = noisy(icosphere(2), 0.03)
TRUE_NORMALS = face_normals(*icosphere(2))


def fit(vertices: Floats, faces: Ints, normals: Floats, update: VertexUpdate, iterations: int) -> Floats:
    """The fit of all vertices."""
    moves = np.ones(len(vertices), dtype=np.bool_)
    at_vertices = vertex_faces(faces, len(vertices))
    return fit_vertices(vertices, faces, at_vertices, normals, update=update, iterations=iterations, moves=moves)


def projected(vertices: Floats, faces: Ints, normals: Floats, update: VertexUpdate, iterations: int) -> Floats:
    """Steps to the mean of the projections, vertex by vertex and face by face, whatever they fold."""
    result = vertices.copy()
    for _ in range(iterations):
        now = result.copy()
        for i in range(len(now)):
            total, weights = np.zeros(3), 0.0
            for f in np.flatnonzero((faces == i).any(axis=1)):
                a, b, c = now[faces[f]]
                weight = 1.0 if update == "sun" else float(np.linalg.norm(np.cross(b - a, c - a))) / 2
                n = normals[f]
                total += weight * n * (n @ ((a + b + c) / 3 - now[i]))
                weights += weight
            result[i] = now[i] + total / weights
    return result


@pytest.mark.parametrize("update", ["sun", "ohtake"])
def test_a_step_is_the_mean_of_projections(update: VertexUpdate) -> None:
    """Both rules are those of the papers, as long as no face folds."""
    arguments = (*NOISY, TRUE_NORMALS, update, 2)
    np.testing.assert_allclose(fit(*arguments), projected(*arguments), rtol=0, atol=1e-13)


@pytest.mark.parametrize("update", get_args(VertexUpdate))
def test_the_fitting_energy_falls(update: VertexUpdate) -> None:
    """Every rule brings the normals nearer to those that are wanted: sum A |n - m|^2 falls to a tenth."""
    vertices, faces = NOISY
    fitted = fit(vertices, faces, TRUE_NORMALS, update, 20)
    assert fitting_energy(fitted, faces, TRUE_NORMALS) < 0.1 * fitting_energy(vertices, faces, TRUE_NORMALS)


def test_the_energy_is_the_sum_over_faces() -> None:
    """E = sum A |n - m|^2 with the faces' own areas and normals."""
    vertices, faces = NOISY
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    expected = (areas * ((face_normals(vertices, faces) - TRUE_NORMALS) ** 2).sum(axis=1)).sum()
    assert fitting_energy(vertices, faces, TRUE_NORMALS) == pytest.approx(expected, rel=1e-12)


def test_conjugate_gradients_begin_downhill() -> None:
    """The first step is against the gradient, which is compared with differences of the energy."""
    vertices, faces = NOISY
    step = vertices - fit(vertices, faces, TRUE_NORMALS, "conjugate_gradient", 1)
    gradient = np.zeros_like(vertices)
    for i in range(12):
        for k in range(3):
            for sign in (1, -1):
                moved = vertices.copy()
                moved[i, k] += sign * 1e-5
                gradient[i, k] += sign * fitting_energy(moved, faces, TRUE_NORMALS) / 2e-5
    length = np.linalg.norm(step[:12]) / np.linalg.norm(gradient)
    # Central differences of step h are off by h^2 = 1e-10, and by rounding, 1e-16 / h, of an energy of about 1.
    np.testing.assert_allclose(step[:12], length * gradient[:12], rtol=0, atol=1e-7)


@pytest.mark.parametrize("update", get_args(VertexUpdate))
def test_a_mesh_that_has_the_normals_stays(update: VertexUpdate) -> None:
    """The wanted normals being its own, a mesh keeps its place to rounding."""
    vertices, faces = NOISY
    fitted = fit(vertices, faces, face_normals(vertices, faces), update, 10)
    np.testing.assert_allclose(fitted, vertices, rtol=0, atol=1e-12)


def test_steps_that_would_fold_a_face_are_shortened() -> None:
    """With the normals of one half turned sideways fewer faces come to look away from their wanted normal than without care."""
    vertices, faces = irregular_grid(8, 9)
    vertices = vertices + np.random.default_rng(1).normal(0.0, 0.15, vertices.shape)
    rng = np.random.default_rng(0)
    wanted = face_normals(vertices, faces) + rng.normal(0.0, 0.8, (len(faces), 3))
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)

    def opposed(points: Floats) -> int:
        return int((np.einsum("ij,ij->i", face_normals(points, faces), wanted) < 0).sum())

    assert opposed(fit(vertices, faces, wanted, "sun", 10)) < opposed(projected(vertices, faces, wanted, "sun", 10))


def test_unknown_rules_are_refused() -> None:
    """The message names what is allowed."""
    with pytest.raises(FilterInputError, match="'newton' is not one of 'sun', 'ohtake', 'conjugate_gradient'"):
        fit(*NOISY, TRUE_NORMALS, "newton", 1)  # type: ignore[arg-type]
