"""What every declaration of a filter must say, and what a step of it in a script must do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pymeshfair.declaration import Filter, Float, Int, MeshElement, Percentage
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.registry import custom_filters, find_filter
from tests.contracts.scenes import arrays_of, mesh_set, scene_for
from tests.contracts.variants import each_filter
from tests.host.snapshots import NORMALS, add_attributes, differences, everything

#: what a bit of a declaration's `changes` allows to change, by the names of `everything`
CHANGES: dict[MeshElement, set[str]] = {
    MeshElement.VERTCOORD: {"vertices"} | NORMALS,
    MeshElement.FACENORMAL: {"face_normals"},
    MeshElement.VERTQUALITY: {"vertex_scalars"},
    MeshElement.VERTCOLOR: {"vertex_colors"},
    MeshElement.FACEQUALITY: {"face_scalars"},
    MeshElement.FACECOLOR: {"face_colors"},
    MeshElement.VERTFLAGSELECT: {"vertex_selection"},
    MeshElement.FACEFLAGSELECT: {"face_selection"},
}


@each_filter
def test_names_are_new_and_found(declared: Filter) -> None:
    """The registry knows each filter by both names, which no other filter, MeshLab's or ours, has."""
    for name in (declared.name, declared.python_name):
        assert find_filter(name).function is declared.function
        assert [name in (known.name, known.python_name) for known in (*meshlab_filters(), *custom_filters())].count(True) == 1


@each_filter
def test_numbers_tell_their_direction(declared: Filter) -> None:
    """The help of every number and length says what a larger one does, or more of it."""
    for parameter in declared.parameters:
        if isinstance(parameter, Int | Float | Percentage) and parameter.name != "mode":
            assert any(word in parameter.help.casefold() for word in ("larger", "more", "nearer", "smaller")), parameter.name


@each_filter
def test_scripts_say_every_parameter_and_read_back(declared: Filter, tmp_path: Path) -> None:
    """A step that was applied is saved with all its parameters, and the script does the same to the bit."""
    scene = scene_for(declared)
    meshes, again = (mesh_set(scene, select=True) for _ in range(2))
    for each in (meshes, again):
        each.on_note = lambda note: None
        each.clear_filter_script()
    meshes.apply_filter(declared.python_name)
    meshes.save_filter_script(str(tmp_path / "script.mlx"))
    again.load_filter_script(str(tmp_path / "script.mlx"))
    again.apply_filter_script()
    found, expected = arrays_of(again), arrays_of(meshes)
    assert all(np.array_equal(found[name], expected[name]) for name in expected)
    text = (tmp_path / "script.mlx").read_text(encoding="utf-8")
    assert all(f'name="{p.xml_name}"' in text for p in declared.parameters)


@each_filter
def test_what_is_not_declared_to_change_keeps_every_bit(declared: Filter) -> None:
    """Selection, colours, scalars, texture coordinates, custom attributes, label and id: all that `changes` does not name."""
    if declared.changes & (MeshElement.VERTNUMBER | MeshElement.FACENUMBER):
        pytest.skip("elements are added; tests/host has what they leave")
    meshes = mesh_set(scene_for(declared), select=True)
    meshes.on_note = lambda note: None
    add_attributes(meshes.current_mesh())
    if meshes.current_mesh().face_number():
        meshes.compute_texcoord_by_function_per_vertex(u="x", v="y")
        meshes.compute_texcoord_transfer_vertex_to_wedge()
    before = everything(meshes)
    meshes.apply_filter(declared.python_name)
    allowed = set().union(*(names for bit, names in CHANGES.items() if declared.changes & bit))
    assert set(differences(before, everything(meshes))) <= allowed
