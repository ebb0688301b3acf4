"""Feature weights: what they are, and that energy smoothing with them keeps the edges of noisy designed shapes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.fairing.bilaplacian import bilaplacian_smoothing, feature_weights, scalar_feature_weights
from pymeshfair.filters.geometry import face_normals, mean_edge_length
from pymeshfair.filters.mesh import Bools
from pymeshfair.filters.topology import face_adjacency
from tests.meshes import Floats, Ints, Mesh, cube, grid, icosphere, noisy


def fine_cube() -> Mesh:
    """The unit cube of 6,146 vertices."""
    return cube(5)


def hipped_block() -> Mesh:
    """The cube with its upper half drawn to a ridge, as on a designed part: edges of 90 and 45 degrees."""
    vertices, faces = fine_cube()
    x, _, z = vertices.T
    # The top is z = 1 between x = 1/4 and 3/4 and slopes down to z = 3/4 at the sides: piecewise linear, edges along mesh lines.
    roof = np.minimum(1.0, 0.75 + np.minimum(x, 1.0 - x))
    lifted = vertices.copy()
    lifted[:, 2] = z * roof
    return lifted, faces


def ridges(vertices: Floats, faces: Ints) -> Bools:
    """The vertices of a clean shape where two faces enclose 20 degrees or more."""
    normals = face_normals(vertices, faces)
    pairs, shared = face_adjacency(faces)
    on = np.zeros(len(vertices), dtype=np.bool_)
    on[shared[np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]]) < np.cos(np.radians(20))]] = True
    return on


def distances(points: Floats, mesh: Mesh) -> Floats:
    """How far points are from the planes of the clean faces at their vertex: the largest of these distances."""
    vertices, faces = mesh
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    largest = np.zeros(len(points))
    for k in range(3):
        np.maximum.at(largest, faces[:, k], np.abs(np.einsum("ij,ij->i", points[faces[:, k]] - a, normals)))
    return largest


@pytest.mark.parametrize("shape", [fine_cube, hipped_block])
def test_edges_of_noisy_designed_shapes_keep(shape: Callable[[], Mesh]) -> None:
    """With noise of a tenth of an edge and l of ten edges the error at ridges is below 30 % of the unweighted filter's."""
    vertices, faces = shape()
    edge = mean_edge_length(vertices, faces)
    rough, _ = noisy((vertices, faces), 0.1 * edge)
    on = ridges(vertices, faces)
    weights = feature_weights(rough, faces)
    plain = bilaplacian_smoothing(rough, faces, detail_size=10 * edge)
    spared = bilaplacian_smoothing(rough, faces, detail_size=10 * edge, feature_weights=weights)

    def error(points: Floats, where: Bools) -> float:
        return float(np.sqrt((distances(points, (vertices, faces))[where] ** 2).mean()))

    assert error(spared, on) < 0.3 * error(plain, on)
    assert error(spared, ~on) < error(plain, ~on)
    assert error(spared, ~on) < 0.35 * error(rough, ~on)


def test_noise_on_a_smooth_surface_is_no_feature() -> None:
    """A fine sphere with noise of a tenth of an edge has weights next to 1 almost everywhere, a clean one everywhere."""
    vertices, faces = icosphere(5)
    assert feature_weights(vertices, faces).min() > 0.999
    edge = mean_edge_length(vertices, faces)
    weights = feature_weights(noisy((vertices, faces), 0.1 * edge)[0], faces)
    assert (weights > 0.9).mean() > 0.95


def test_the_weight_at_the_edges_of_a_cube() -> None:
    """90 degrees are 4.5 times the feature angle: 1 / (1 + 4.5^8), or twice that after filtering, below the least weight."""
    vertices, faces = fine_cube()
    weights = feature_weights(vertices, faces)
    on = (np.isin(vertices, (0.0, 1.0)).sum(axis=1)) == 2
    assert weights[on].max() == weights.min() == 1e-4 > 2 / (1 + 4.5**8)
    assert weights[np.isin(vertices, (0.0, 1.0)).sum(axis=1) == 1].min() > 0.999


def test_scalar_weights() -> None:
    """1 / (1 + (v / half)^2), whatever the sign, not below the least."""
    assert scalar_feature_weights([0.0, 2.0, -2.0, 1e200], half=2.0) == pytest.approx([1.0, 0.5, 0.5, 1e-4])


def test_meshes_without_faces_have_weights_of_one() -> None:
    """There is nothing to bend."""
    assert np.array_equal(feature_weights(np.zeros((3, 3)), np.empty((0, 3), dtype=np.int32)), np.ones(3))


def test_wrong_arguments_are_named() -> None:
    """The message says which argument is wrong and what came."""
    vertices, faces = grid(3, 3)
    with pytest.raises(FilterInputError, match="feature_angle is 0: it must be"):
        feature_weights(vertices, faces, feature_angle=0)
    with pytest.raises(FilterInputError, match="half is 0: it must be"):
        scalar_feature_weights([1.0], half=0)
    with pytest.raises(FilterInputError, match="values must be finite"):
        scalar_feature_weights([np.nan], half=1)
