"""The operator of connectivity, which energies take where triangles are too uneven."""

from __future__ import annotations

import numpy as np

from pymeshfair.filters.fairing.region import evened_operator, surface_operator
from tests.meshes import Mesh, grid, icosphere


def _equilateral() -> Mesh:
    """A piece of the plane in triangles of side 1."""
    vertices, faces = grid(6, 6)
    steps = np.rint(vertices[:, :2] * 6 / np.ptp(vertices[:, 0]))
    x, y = steps.T
    turned = np.stack([x - y / 2, y * np.sqrt(3) / 2, np.zeros(len(x))], axis=1)
    return turned, faces


def test_equilateral_triangles_have_it_already() -> None:
    """Inside a mesh of equilateral triangles its weights are the cotangents, cot 60 for each edge; the mass is alike in all."""
    vertices, faces = _equilateral()
    operator = surface_operator(vertices, faces)
    even, inside = evened_operator(operator, faces, np.ones(len(vertices), dtype=bool))
    assert inside.all()
    difference = (even.dirichlet - operator.dirichlet).toarray()
    whole = np.bincount(faces.ravel()) == 6
    np.testing.assert_allclose(difference[np.ix_(whole, whole)], 0.0, atol=1e-14)
    assert np.isclose(even.mass.sum(), operator.mass.sum())
    assert np.ptp(even.mass) == 0.0


def test_components_without_an_irregular_vertex_keep_every_bit() -> None:
    """Of two spheres the one with the vertex is taken by its connectivity; rows sum to 0 and weights stay symmetric."""
    vertices, faces = icosphere(1)
    n = len(vertices)
    both = np.concatenate([vertices, vertices + 5.0]), np.concatenate([faces, faces + n])
    operator = surface_operator(*both)
    even, inside = evened_operator(operator, both[1], np.arange(2 * n) == n + 3)
    np.testing.assert_array_equal(inside, np.arange(2 * n) >= n)
    assert (even.dirichlet[:n] != operator.dirichlet[:n]).nnz == 0
    np.testing.assert_array_equal(even.mass[:n], operator.mass[:n])
    np.testing.assert_allclose(np.asarray(even.dirichlet.sum(axis=1)), 0.0, atol=1e-13)
    assert abs(even.dirichlet - even.dirichlet.T).max() == 0.0
