"""Filters that show a surface in colours."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from pymeshfair.meshset import MeshSet
from tests.meshes import grid, rotation

CURVATURES = {
    "mean": ("compute_scalar_by_mean_curvature_per_vertex", {}),
    "gaussian": ("compute_scalar_by_gaussian_curvature_per_vertex", {}),
    "deficit": ("compute_scalar_by_gaussian_curvature_per_vertex", {"measure": "deficit"}),
}


@pytest.mark.parametrize("size", [1e-140, 1e-9, 1.0, 1e6, 1e140])
@pytest.mark.parametrize("name", CURVATURES)
def test_flat_parts_are_nearly_white_in_any_position(name: str, size: float) -> None:
    """On a turned plane, and beside one corner that is pulled out of it, rounding errors have no colour."""
    vertices, faces = grid(20, 20)
    inside = ((vertices[:, :2] > 0.0) & (vertices[:, :2] < 20.0)).all(axis=1)
    away = np.linalg.norm(vertices - vertices[220], axis=1) > 3.0
    filter_name, values = CURVATURES[name]
    for pulled in (0.0, 0.5):
        vertices[220, 2] = pulled
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(size * (vertices @ rotation(3).T), faces))
        meshes.apply_filter(filter_name, **values)
        colors = meshes.current_mesh().vertex_color_matrix()[:, :3]
        assert (colors[inside & away] > 0.9).all()
        assert (colors[inside & ~away].min() < 0.9) == (pulled > 0.0)


def test_displacement_from_a_polyline_is_the_distance_from_its_edges() -> None:
    """Points beside the middles of edges of length 1 are as far away as beside their ends."""
    places = np.array([[x, 0.0, 0.0] for x in range(5)])
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(places, edge_matrix=np.array([[k, k + 1] for k in range(4)])))
    meshes.add_mesh(pymeshlab.Mesh(np.array([[0.5, 0.2, 0.0], [2.0, 0.0, 0.2], [3.5, 0.0, -0.2]])))
    meshes.compute_scalar_by_displacement_per_vertex(reference=0)
    assert np.allclose(meshes.current_mesh().vertex_scalar_array(), 0.2)
