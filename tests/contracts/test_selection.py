"""What is not selected keeps every bit, and a selection of nothing is refused in the same words everywhere."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Bool, Filter, MeshElement
from tests.contracts.scenes import apply, arrays_of, mesh_set, scene_for
from tests.contracts.variants import FILTERS, VARIANTS, Variant


def takes_selection(declared: Filter) -> bool:
    """Whether the filter has the parameter `selected`."""
    return any(p.name == "selected" and isinstance(p, Bool) for p in declared.parameters)


#: chosen by evidence, of which a small selection has little
MAY_DO_NOTHING = {"apply_coord_normal_filtering", "apply_coord_spike_removal"}


@pytest.mark.parametrize("variant", [v for v in VARIANTS if takes_selection(v.declared)], ids=lambda v: v.name)
def test_what_is_not_selected_keeps_every_bit(variant: Variant) -> None:
    """Coordinates, scalars and colours of vertices that are not selected stay, and so do normals of faces that move nowhere.

    Something that is selected changes, or something is added.
    """
    scene = scene_for(variant.declared)
    before = arrays_of(mesh_set(scene, select=True))
    after = apply(variant.declared, scene, {**variant.values, "selected": True}).arrays
    held = dict.fromkeys(("vertices", "vertex_scalars", "vertex_colors"), ~scene.chosen)
    if not variant.declared.changes & (MeshElement.VERTCOORD | MeshElement.FACENUMBER):
        held["face_normals"] = ~scene.chosen_faces
    for name, keeps in held.items():
        assert after[name][: len(keeps)][keeps].tobytes() == before[name][keeps].tobytes(), name
    added = {len(after[name]) - len(before[name]) for name in ("vertices", "faces")}
    changed = max(added) > 0 or any((after[name] != before[name]).any() for name in held)
    assert changed or variant.declared.python_name in MAY_DO_NOTHING


@pytest.mark.parametrize("declared", [d for d in FILTERS if takes_selection(d)], ids=lambda d: d.python_name)
def test_a_selection_of_nothing_is_refused(declared: Filter) -> None:
    """The message names filter and layer, says what to select and the way out; the mesh stays as it was."""
    meshes = mesh_set(scene_for(declared))
    before = arrays_of(meshes)
    refusal = rf"^{declared.python_name}: nothing is selected in '.*': select .*, or use selected=False"
    with pytest.raises(pymeshlab.PyMeshLabException, match=refusal):
        meshes.apply_filter(declared.python_name, selected=True)
    after = arrays_of(meshes)
    assert all(np.array_equal(before[name], after[name]) for name in before)
