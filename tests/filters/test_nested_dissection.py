"""Nested dissection: an order of the vertices, which is one, keeps factors sparse, and takes no time on regular meshes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.sparse.linalg import splu

from pymeshfair.filters.linear_solvers import Fronts
from pymeshfair.filters.operators import uniform_laplacian
from tests.meshes import grid, icosphere, torus


def filled(matrix: sparse.csc_matrix, order: np.ndarray) -> int:
    """The entries of the factor L of the matrix in an order."""
    ordered = sparse.csc_matrix(matrix[order][:, order])
    return int(splu(ordered, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).L.nnz)


def of_mesh(vertices: np.ndarray, faces: np.ndarray) -> sparse.csc_matrix:
    """A positive definite matrix with the pattern of the mesh."""
    n = len(vertices)
    return sparse.csc_matrix(sparse.eye_array(n) - uniform_laplacian(faces, n).stiffness)


@given(st.integers(1, 300), st.integers(0, 500), st.integers(0, 2**32 - 1))
def test_every_graph_gets_an_order_of_all_its_vertices(n: int, edges: int, seed: int) -> None:
    """Also of graphs in many pieces or without edges the order names every vertex once, and is always the same."""
    ends = np.random.default_rng(seed).integers(0, n, size=(2, edges))
    matrix = sparse.csc_matrix((np.ones(edges), (ends[0], ends[1])), shape=(n, n))
    matrix = sparse.csc_matrix(matrix + matrix.T + sparse.eye_array(n))
    order = Fronts.of(matrix).order
    assert np.array_equal(np.sort(order), np.arange(n))
    assert np.array_equal(Fronts.of(matrix).order, order)


@pytest.mark.parametrize("mesh", [icosphere(5), torus(160, 60), grid(100, 100)], ids=["icosphere", "torus", "grid"])
def test_factors_have_n_log_n_entries(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    """On surfaces, whatever their numbering, the factor has at most 4 n log2 n entries, and its size does not depend on that."""
    vertices, faces = mesh
    n = len(vertices)
    matrix = of_mesh(vertices, faces)
    shuffled = np.random.default_rng(0).permutation(n)
    mixed = sparse.csc_matrix(matrix[shuffled][:, shuffled])
    plain, again = filled(matrix, Fronts.of(matrix).order), filled(mixed, Fronts.of(mixed).order)
    assert plain <= 4 * n * np.log2(n)
    assert abs(plain - again) <= 0.2 * plain


def test_the_order_beats_the_numbering_of_a_mesh() -> None:
    """On a subdivided icosahedron the factor is less than a fifth of that in the order of subdivision."""
    matrix = of_mesh(*icosphere(4))
    assert filled(matrix, Fronts.of(matrix).order) < 0.2 * filled(matrix, np.arange(matrix.shape[0]))
