"""Fairing as MeshLab users meet it: what is selected, what stays, what is told."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair.declaration import Filter, MeshElement
from pymeshfair.filters.fairing.region import ENERGIES, Energy, fair_region
from pymeshfair.filters.topology import border_vertices
from pymeshfair.meshlab_facts import meshlab_filters
from pymeshfair.plugins import fairing
from pymeshfair.registry import find_filter
from tests.host.snapshots import NORMALS, add_attributes, differences, everything
from tests.meshes import AWKWARD, Floats, Mesh, icosphere, noisy, tube, two_spheres

REGION = "apply_coord_region_fairing"


def mesh_set(mesh: Mesh, **attributes: Any) -> pymeshfair.MeshSet:
    """A mesh set with this mesh alone."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh, **attributes))
    return meshes


def vertices_of(meshes: pymeshfair.MeshSet) -> Floats:
    """The coordinates of the current mesh."""
    return np.asarray(meshes.current_mesh().vertex_matrix())


def select(meshes: pymeshfair.MeshSet, condition: str) -> Any:
    """Which vertices were selected by a condition."""
    meshes.compute_selection_by_condition_per_vertex(condselect=condition)
    return meshes.current_mesh().vertex_selection_array()


# ------------------------------------------------------------------------------------------------------------ region fairing


@pytest.mark.parametrize("energy", ENERGIES)
def test_a_region_is_that_of_the_function(energy: Energy) -> None:
    """The selected vertices go where the technique puts them, the others keep every bit, and the result tells the solution."""
    mesh = noisy(icosphere(3), 0.02)
    meshes = mesh_set(mesh)
    chosen = select(meshes, "z > 0.6")
    told = meshes.apply_filter(REGION, energy=energy)
    expected = fair_region(*mesh, chosen, energy=energy)
    found = vertices_of(meshes)
    np.testing.assert_allclose(found, expected.vertices, rtol=0, atol=1e-12)
    assert found[~chosen].tobytes() == mesh[0][~chosen].tobytes()
    assert told["moved"] == chosen.sum()
    assert told["backward_error"] <= 1e-13
    assert set(told) == {"moved", "backward_error", "last_correction", "refinements"}


def test_selected_triangles_stand_for_their_inner_vertices() -> None:
    """With no vertex selected, those move all of whose triangles are: the same as when these are selected themselves."""
    mesh = noisy(icosphere(3), 0.02)
    by_faces = mesh_set(mesh)
    by_faces.compute_selection_by_condition_per_face(condselect="z0 > 0.5 && z1 > 0.5 && z2 > 0.5")
    by_faces.apply_filter(REGION)
    moved = (vertices_of(by_faces) != mesh[0]).any(axis=1)
    directly = mesh_set(mesh)
    directly.compute_selection_by_condition_per_face(condselect="z0 > 0.5 && z1 > 0.5 && z2 > 0.5")
    directly.compute_selection_transfer_face_to_vertex()
    directly.apply_filter(REGION)
    np.testing.assert_allclose(vertices_of(by_faces), vertices_of(directly), rtol=0, atol=1e-15)
    assert 0 < moved.sum() < (mesh[0][:, 2] > 0.5).sum()


def test_borders_stay_and_a_note_says_so() -> None:
    """Of a selection that reaches an open border the border vertices keep every bit; how many is told."""
    vertices, faces = noisy(tube(24, 12), 0.02)
    meshes = mesh_set((vertices, faces))
    notes: list[str] = []
    meshes.on_note = notes.append
    chosen = select(meshes, "z > 2")
    told = meshes.apply_filter(REGION)
    border = border_vertices(faces, len(vertices))
    moved = (vertices_of(meshes) != vertices).any(axis=1)
    np.testing.assert_array_equal(moved, chosen & ~border)
    assert told["moved"] == moved.sum()
    assert notes == ["24 of the 108 selected vertices lie on an open border or have no triangle, and stay."]


def test_more_iterations_come_nearer_to_the_soap_film() -> None:
    """Between two rings a membrane's area falls with every repetition and its neck tends to that of the catenoid."""
    around, height = 96, 0.5
    vertices, faces = tube(around, 24, length=2 * height)
    meshes = mesh_set((vertices, faces))
    # the catenoid c cosh(z / c) through radius 1 at z = +-0.5
    c = 0.8483379
    assert c * np.cosh(height / c) == pytest.approx(1.0, abs=1e-6)
    necks = []
    for iterations in (1, 20):
        meshes = mesh_set((vertices, faces))
        select(meshes, "z > 0.001 && z < 0.999")
        meshes.apply_filter(REGION, energy="membrane", iterations=iterations)
        necks.append(np.linalg.norm(vertices_of(meshes)[:, :2], axis=1).min())
    assert abs(necks[1] - c) < 0.01 * c < abs(necks[0] - c)


def test_everything_but_the_coordinates_is_kept() -> None:
    """Selection, colours, scalars, texture coordinates, textures and custom attributes keep every bit."""
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny10k_textured.obj"))
    add_attributes(meshes.current_mesh())
    meshes.compute_selection_by_condition_per_vertex(condselect="vi > 100 && vi < 140")
    before = everything(meshes)
    meshes.apply_filter(REGION)
    assert set(differences(before, everything(meshes))) == {"vertices"} | NORMALS


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("x > 99", "nothing is selected in .*: select vertices"),
        ("x < 99", "all vertices are selected.*select the part that is to be faired and leave its surroundings"),
        ("x > 2.5", "touch no fixed vertex.*select less than a whole component"),
    ],
    ids=["nothing", "everything", "a whole component"],
)
def test_selections_that_say_nothing_are_refused(condition: str, message: str) -> None:
    """Nothing, everything, or one of two components as a whole: the message says what to select."""
    meshes = mesh_set(two_spheres())
    before = vertices_of(meshes)
    select(meshes, condition)
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        meshes.apply_filter(REGION)
    assert vertices_of(meshes).tobytes() == before.tobytes()


@pytest.mark.parametrize("name", [n for n in AWKWARD if n not in ("empty", "1e150")])
def test_awkward_meshes_go_through_region_fairing(name: str) -> None:
    """Coordinates stay finite and unselected vertices where they are, or an error of ours says what is wrong."""
    vertices, faces = AWKWARD[name]()
    for energy in ENERGIES:
        meshes = mesh_set((vertices, faces))
        before = vertices_of(meshes)
        chosen = select(meshes, "vi > 1" if len(vertices) < 20 else "vi > 10 && vi < 40")
        said = ""
        try:
            meshes.apply_filter(REGION, energy=energy)
        except pymeshlab.PyMeshLabException as error:
            said = str(error)
        assert not said or re.search("touch no fixed vertex|nothing is selected|ill-conditioned", said), said
        assert np.isfinite(vertices_of(meshes)).all()
        np.testing.assert_array_equal(vertices_of(meshes)[~chosen], before[~chosen])


# ------------------------------------------------------------------------------------------------------------ all of them

NAMES = (REGION,)
DECLARED: list[Filter] = [getattr(fairing, name) for name in NAMES]


@pytest.mark.parametrize("declared", DECLARED, ids=NAMES)
def test_names_are_new_and_found(declared: Filter) -> None:
    """The registry knows each filter by both names, which no filter of MeshLab has."""
    assert find_filter(declared.name).python_name == find_filter(declared.python_name).python_name == declared.python_name
    taken = {name for known in meshlab_filters() for name in (known.name, known.python_name)}
    assert not {declared.name, declared.python_name} & taken
    assert declared.requires & MeshElement.FACENUMBER


@pytest.mark.parametrize("declared", DECLARED, ids=NAMES)
def test_scripts_say_every_parameter_and_read_back(declared: Filter, tmp_path: Path) -> None:
    """A step that was applied is saved with all its parameters, and the script gives the same coordinates to the bit."""
    mesh = noisy(icosphere(3), 0.02)
    meshes = mesh_set(mesh)
    select(meshes, "z > 0.6")
    meshes.clear_filter_script()
    meshes.apply_filter(declared.python_name)
    meshes.save_filter_script(str(tmp_path / "script.mlx"))
    again = mesh_set(mesh)
    select(again, "z > 0.6")
    again.clear_filter_script()
    again.load_filter_script(str(tmp_path / "script.mlx"))
    again.apply_filter_script()
    assert vertices_of(again).tobytes() == vertices_of(meshes).tobytes()
    text = (tmp_path / "script.mlx").read_text(encoding="utf-8")
    assert all(f'name="{p.xml_name or p.name}"' in text for p in declared.parameters)


@pytest.mark.parametrize("declared", DECLARED, ids=NAMES)
def test_numbers_tell_their_direction(declared: Filter) -> None:
    """The help of every number and length says what a larger one does."""
    for parameter in declared.parameters:
        if parameter.rich_type in ("RichInt", "RichFloat", "RichDynamicFloat", "RichPercentage"):
            assert "Larger" in parameter.help or "More" in parameter.help, parameter.name
