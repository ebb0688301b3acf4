"""Whatever the mesh: every filter ends with finite numbers, or refuses in words of ours and leaves the mesh as it was."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair.declaration import Filter
from pymeshfair.errors import PymeshfairError
from tests.contracts.scenes import Scene, arrays_of, curves, mesh_set, scene_of
from tests.contracts.variants import each_filter
from tests.host.snapshots import differences, everything
from tests.meshes import AWKWARD, Mesh, icosphere


def without_faces() -> Mesh:
    """The vertices of a sphere."""
    return icosphere(2)[0], np.empty((0, 3), dtype=np.int32)


SCENES: dict[str, Scene] = {
    **{name: scene_of(make()) for name, make in AWKWARD.items()},
    "no faces": scene_of(without_faces()),
    "edges alone": curves(),
}


@pytest.mark.parametrize("name", SCENES)
@each_filter
def test_every_mesh_is_filtered_or_refused(declared: Filter, name: str) -> None:
    """Nothing that comes out of a finite mesh is infinite or NaN; an error names the filter and is one that was foreseen."""
    meshes = mesh_set(SCENES[name], select=True)
    meshes.on_note = lambda note: None
    before = everything(meshes)
    refusal = None
    try:
        meshes.apply_filter(declared.python_name)
    except pymeshlab.PyMeshLabException as error:
        refusal = error
    if refusal is None:
        for array in ("vertices", "vertex_scalars", "vertex_colors"):
            assert np.isfinite(arrays_of(meshes)[array]).all(), array
        return
    assert isinstance(refusal, PymeshfairError)
    assert str(refusal).startswith(declared.python_name)
    assert refusal.__cause__ is None or isinstance(refusal.__cause__, PymeshfairError)
    assert differences(before, everything(meshes)) == []


@each_filter
def test_a_mesh_set_without_a_mesh_is_refused(declared: Filter) -> None:
    """The message says what to do first."""
    with pytest.raises(pymeshlab.PyMeshLabException, match=f"^{declared.python_name} needs a mesh, .*: load one first"):
        pymeshfair.MeshSet().apply_filter(declared.python_name)
