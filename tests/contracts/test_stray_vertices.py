"""A vertex that no face and no edge uses changes nothing of the rest."""

from __future__ import annotations

import numpy as np
import pytest

from tests.contracts.scenes import apply, curves, scene_for, two_open_spheres
from tests.contracts.variants import Variant, each_variant, is_of_points, outcome_of
from tests.meshes import diagonal

#: what counts all vertices, used or not, or the box around them: by name, as filters report it
OF_ALL_VERTICES = {"vertices", "unreferenced_vertices", "diagonal", "mean_spacing"}


@pytest.mark.parametrize("distance", [0.01, 1e9, 1e16], ids=["0.01", "1e9", "1e16"])
@each_variant
def test_a_stray_vertex_changes_nothing(variant: Variant, distance: float) -> None:
    """To the bit, be it in the middle of mesh and numbering or many diagonals away, last or first; it stays where it is."""
    if is_of_points(variant.declared):
        pytest.skip("every vertex is data to a filter of points")
    scene = scene_for(variant.declared)
    at = {0.01: len(scene.vertices) // 2, 1e9: len(scene.vertices), 1e16: 0}[distance]
    position = np.array([1.0, -0.5, 0.25]) * distance * diagonal(scene.vertices)
    found = apply(variant.declared, scene.with_stray(at, position), variant.values)
    expected = outcome_of(variant)
    assert set(found.without_vertex(at).differences(expected)) <= OF_ALL_VERTICES
    assert found.vertices[at].tobytes() == position.tobytes()


def test_the_scenes_have_no_stray_vertex() -> None:
    """Every vertex of a scene is used, so that the one that is added is the only one."""
    for scene in (curves(), two_open_spheres()):
        used = np.union1d(scene.faces, scene.edges)
        np.testing.assert_array_equal(used, np.arange(len(scene.vertices)))
