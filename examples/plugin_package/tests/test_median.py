"""The median filter, as mathematics and as a filter of mesh sets."""

import numpy as np
import pymeshlab
from meshfair_median.median import median_filtering

from pymeshfair import MeshSet

#: six triangles around vertex 0
FAN = np.array([[0, k, k % 6 + 1] for k in range(1, 7)], dtype=np.int32)


def test_a_speck_vanishes() -> None:
    """One vertex of another value among seven equal ones takes theirs."""
    values = np.ones(7)
    values[0] = 100.0
    np.testing.assert_array_equal(median_filtering(FAN, values), np.ones(7))


def test_a_mesh_set_has_the_filter() -> None:
    """It changes the scalars of a mesh and nothing else."""
    turn = np.arange(6) * np.pi / 3
    points = np.concatenate([[[0.0, 0.0, 0.0]], np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)])
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points, FAN, v_scalar_array=np.array([9.0, 1, 1, 1, 1, 1, 1])))
    meshes.apply_scalar_median_per_vertex()
    np.testing.assert_array_equal(meshes.current_mesh().vertex_scalar_array(), np.ones(7))
    np.testing.assert_array_equal(meshes.current_mesh().vertex_matrix(), points)
