"""Implicit Fairing as MeshLab users meet it: what it says where a parameter has no effect or cannot be used."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from tests.meshes import icosphere


@pytest.mark.parametrize("amount", [{"detail_size": "20edge"}, {"time_step": 4.0}])
def test_a_note_says_that_a_partly_selected_component_keeps_no_volume(amount: dict[str, object]) -> None:
    """With both options the note says which components are rescaled; with one of them there is none."""
    for options, count in (
        ({"preserve_volume": True, "selected": True}, 1),
        ({"preserve_volume": True}, 0),
        ({"selected": True}, 0),
    ):
        meshes = pymeshfair.MeshSet()
        notes: list[str] = []
        meshes.on_note = notes.append
        meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)))
        meshes.compute_selection_by_condition_per_vertex(condselect="x > 0")
        meshes.apply_filter("apply_coord_implicit_fairing", **amount, **options)
        assert notes == ["preserve_volume rescales only closed components whose vertices are all selected."] * count


def test_duplicate_points_are_named_as_the_cause() -> None:
    """Where every point of a cloud is there twice, the mean distance to the nearest point is 0, and so is a size in edges."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.repeat(icosphere(2)[0], 2, axis=0)))
    with pytest.raises(pymeshlab.PyMeshLabException, match="the mesh has only duplicate points, so that detail_size is 0"):
        meshes.apply_filter("apply_coord_implicit_fairing", operator="robust")
    for name, values in (("apply_coord_implicit_fairing", {"time_step": 1.0}), ("apply_coord_explicit_smoothing", {"step": 1.0})):
        with pytest.raises(pymeshlab.PyMeshLabException, match="the mesh has only duplicate points, so that its mean edge is 0"):
            meshes.apply_filter(name, operator="robust", **values)
