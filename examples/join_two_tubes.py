"""Joins two open tubes by a smooth neck: ``python examples/join_two_tubes.py joined.ply``.

Each tube is a layer of its own, as in a MeshLab project. The recipe `blend_parts` merges the layers, finds the two rims that face
each other and builds the neck between them. The same two steps join parts of any shape that are open where they are to meet.
"""

from __future__ import annotations

import sys

import numpy as np
import pymeshlab

from pymeshfair import MeshSet
from pymeshfair.recipe import load_recipe


def tube(radius: float, length: float, around: int) -> pymeshlab.Mesh:
    """An open cylinder about the z axis, of nearly square cells that are cut in two."""
    along = round(length / (2 * np.pi * radius / around))
    angle, height = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0.0, length, along + 1))
    vertices = np.column_stack([radius * np.cos(angle).ravel(), radius * np.sin(angle).ravel(), height.ravel()])
    row, place = np.divmod(np.arange(along * around), around)
    a, b = row * around + place, row * around + (place + 1) % around
    faces = np.concatenate([np.column_stack([a, b, b + around]), np.column_stack([a, b + around, a + around])])
    return pymeshlab.Mesh(vertices, faces)


def two_tubes() -> MeshSet:
    """An upright tube, and a thinner one that leans over it."""
    meshes = MeshSet()
    meshes.add_mesh(tube(1.0, 2.0, 64), "low")
    meshes.add_mesh(tube(0.6, 1.5, 44), "high")
    meshes.compute_matrix_from_rotation(rotaxis="Y axis", angle=50.0)
    meshes.compute_matrix_from_translation(axisx=0.7, axisz=3.2)
    return meshes


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("usage: python join_two_tubes.py OUTPUT, a mesh file to write such as joined.ply")
    meshes = two_tubes()
    meshes.load_filter_script(str(load_recipe("blend_parts").script.path))
    meshes.apply_filter_script()
    meshes.save_current_mesh(sys.argv[1])
    measures = meshes.get_topological_measures()
    print(f"{measures['connected_components_number']} part, {measures['number_holes']} open rims, genus {measures['genus']}")
