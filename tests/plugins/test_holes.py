"""Closing holes as MeshLab users meet it: on a mesh set, with selection, marks, values and sentences, and as a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair import MeshSet
from pymeshfair.declaration import Float, Int, MeshElement
from pymeshfair.filters.checks import ConvergenceError
from pymeshfair.filters.fairing.region import fair_region
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.plugins.holes import ORANGE, Mark
from pymeshfair.plugins.holes import meshing_close_holes_by_fairing as declared
from pymeshfair.recipe import load_recipe
from tests.commands.command_line import document, run_process
from tests.host.snapshots import PER_FACE, PER_VERTEX, add_attributes, differences, everything, sample
from tests.hostile.awkward import awkward_mesh
from tests.meshes import Mesh, icosphere

BUNNY = sample("bunny10k_textured.obj")
#: the edges of the bunny's five rims
RIMS = [8, 19, 22, 22, 38]


def mesh_set(mesh: Mesh) -> tuple[MeshSet, list[str]]:
    """A mesh set with this mesh alone, and the sentences that its filters say."""
    meshes, notes = MeshSet(), list[str]()
    meshes.on_note = notes.append
    meshes.add_mesh(pymeshlab.Mesh(*mesh))
    return meshes, notes


def cut_ball() -> Mesh:
    """A unit sphere without the faces of two caps, at the top and at the bottom, the upper one twice as wide."""
    vertices, faces = icosphere(4)
    height = vertices[faces][:, :, 2]
    return vertices, faces[(height.max(axis=1) < 0.92) & (height.min(axis=1) > -0.98)]


def test_holes_that_are_not_named_are_counted() -> None:
    """Of twelve closed holes the ten largest are named, and a note counts the others."""
    vertices, faces = icosphere(4)
    away = np.zeros(len(faces), bool)
    for corner in range(12):  # the first vertices, far from each other
        away |= (faces == corner).any(axis=1)
    meshes, notes = mesh_set((vertices, faces[~away]))
    meshes.meshing_close_holes_by_fairing(refine=False)
    assert len(notes) == 11
    assert notes[-1] == "further closed holes, of at most 5 edges each: 2"


def rims_of(mesh: Any) -> int:
    """How many border edges the mesh has."""
    return surface_measures(mesh.vertex_matrix(), mesh.face_matrix()).border_edges


def test_new_faces_come_last_selected_and_numbered() -> None:
    """Both holes of a ball are closed; what is new is selected and nothing else; the scalar of a face numbers its hole."""
    ball = cut_ball()
    meshes, notes = mesh_set(ball)
    meshes.set_selection_all()
    values = meshes.meshing_close_holes_by_fairing(mark="scalar")
    mesh = meshes.current_mesh()
    n, m = len(ball[0]), len(ball[1])
    assert values is not None
    assert (values["closed_holes"], values["left_open"]) == (2, {})
    # One sentence a hole, the wider one first, with the edges of the rim and the middle of its vertices.
    assert [int(note.split()[4]) for note in notes] == sorted(values["closed_rim_edges"])[::-1]
    assert [float(note.split(", ")[-1]) for note in notes] == pytest.approx([0.92, -0.98], abs=0.06)
    assert all(note.startswith("closed a hole of ") for note in notes)
    assert values["new_vertices"] == mesh.vertex_number() - n > 0
    assert values["new_faces"] == mesh.face_number() - m > 0
    np.testing.assert_array_equal(mesh.vertex_matrix()[:n], ball[0])
    np.testing.assert_array_equal(mesh.face_matrix()[:m], ball[1])
    np.testing.assert_array_equal(mesh.vertex_selection_array(), np.arange(mesh.vertex_number()) >= n)
    np.testing.assert_array_equal(mesh.face_selection_array(), np.arange(mesh.face_number()) >= m)
    marks = mesh.face_scalar_array()
    assert not marks[:m].any()
    assert set(marks[m:]) == {1.0, 2.0}
    for number in (1, 2):  # each hole's faces on its own side
        heights = mesh.vertex_matrix()[mesh.face_matrix()[marks == number]][:, :, 2]
        assert (heights > 0.5).all() or (heights < -0.5).all()
    assert rims_of(mesh) == 0


@pytest.mark.parametrize("mark", ["none", "color"])
def test_other_marks(mark: Mark) -> None:
    """Colour makes new faces orange and leaves the others their colours; without a mark there are no scalars and no colours."""
    meshes, _ = mesh_set(cut_ball())
    m = meshes.current_mesh().face_number()
    if mark == "color":
        meshes.compute_color_by_function_per_face(r="fi/20", g="0", b="0", a="255")
    before = meshes.current_mesh().face_color_matrix() if mark == "color" else None
    meshes.meshing_close_holes_by_fairing(mark=mark)
    mesh = meshes.current_mesh()
    assert not mesh.has_face_scalar()
    assert mesh.has_face_color() == (mark == "color")
    if before is not None:
        np.testing.assert_array_equal(mesh.face_color_matrix()[:m], before)
        np.testing.assert_allclose(mesh.face_color_matrix()[m:], np.tile(ORANGE, (mesh.face_number() - m, 1)), atol=1e-7)


@pytest.mark.parametrize("element", ["vertices", "faces"])
def test_only_holes_at_the_selection_are_closed(element: str) -> None:
    """With vertices or faces at the upper rim selected the lower hole stays open, which is told among the values."""
    meshes, notes = mesh_set(cut_ball())
    if element == "vertices":
        meshes.compute_selection_by_condition_per_vertex(condselect="z > 0.8")
    else:
        meshes.compute_selection_by_condition_per_face(condselect="z0 > 0.8")
    values = meshes.meshing_close_holes_by_fairing(selected=True)
    assert values is not None
    assert (values["closed_holes"], values["left_open"], len(notes)) == (1, {"selection": 1}, 1)
    mesh = meshes.current_mesh()
    assert mesh.vertex_matrix()[mesh.vertex_selection_array()][:, 2].min() > 0.5


def test_nothing_selected_is_said() -> None:
    """Without a selection the filter says what to select."""
    meshes, _ = mesh_set(cut_ball())
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"^meshing_close_holes_by_fairing: nothing is selected"):
        meshes.meshing_close_holes_by_fairing(selected=True)


def test_holes_away_from_the_selection_get_no_advice() -> None:
    """A hole that is too large and not selected is among the unselected: a larger number of edges would not close it."""
    meshes, notes = mesh_set(cut_ball())
    meshes.compute_selection_by_condition_per_vertex(condselect="z > 0.8")
    values = meshes.meshing_close_holes_by_fairing(selected=True, max_edges=3)
    assert values is not None
    assert values["left_open"] == {"selection": 1, "size": 1}
    assert len(notes) == 1


def test_a_selection_away_from_all_holes_is_said() -> None:
    """Where no hole has a selected vertex nothing is closed, and a note tells how many stay open."""
    meshes, notes = mesh_set(cut_ball())
    meshes.compute_selection_by_condition_per_vertex(condselect="z > -0.1 && z < 0.1")
    meshes.meshing_close_holes_by_fairing(selected=True)
    assert notes == ["no hole has a selected vertex: 2 stay open"]


def test_large_holes_are_left_and_named() -> None:
    """A rim of more edges than allowed stays; the sentence has its length and the bound; nothing is selected then."""
    meshes, notes = mesh_set(cut_ball())
    meshes.set_selection_all()
    edges = rims_of(meshes.current_mesh())
    values = meshes.meshing_close_holes_by_fairing(max_edges=3)
    assert values is not None
    assert (values["closed_holes"], values["left_open"], sum(values["left_open_rim_edges"])) == (0, {"size": 2}, edges)
    assert len(notes) == 2
    assert all(
        f"the rim of {k} edges" in note for k, note in zip(sorted(values["left_open_rim_edges"])[::-1], notes, strict=True)
    )
    assert "more than 3" in notes[0]
    assert meshes.current_mesh().selected_face_number() == meshes.current_mesh().selected_vertex_number() == 0


def test_a_closed_mesh_is_told_that_it_has_no_hole() -> None:
    """On a mesh without a border nothing changes but the selection, and that is said."""
    meshes, notes = mesh_set(icosphere(1))
    before = everything(meshes)
    meshes.meshing_close_holes_by_fairing()
    assert notes == ["there is no hole: every edge has two faces"]
    assert differences(before, everything(meshes)) == []


@pytest.mark.parametrize("mark", ["scalar", "color"])
def test_no_mark_is_written_if_nothing_was_closed(mark: Mark) -> None:
    """The scalars and colours that faces had are still there."""
    meshes, _ = mesh_set(cut_ball())
    meshes.compute_scalar_by_function_per_face(q="fi/7")
    before = everything(meshes)
    meshes.meshing_close_holes_by_fairing(max_edges=3, mark=mark)
    assert "face_scalars" in before
    assert differences(before, everything(meshes)) == []


def test_holes_behind_duplicate_faces_are_explained() -> None:
    """Cut into both copies, a hole has a rim of edges with two faces; the sentence says what to do."""
    vertices, faces = cut_ball()
    meshes, notes = mesh_set((vertices, np.concatenate([faces, faces])))
    meshes.meshing_close_holes_by_fairing()
    (note,) = notes
    assert note.startswith("no hole was found")
    assert "remove duplicate faces first" in note


def test_an_outer_border_that_may_be_a_hole_is_told() -> None:
    """The border of a half of a ball stays open, which is said; with the border selected it is closed."""
    vertices, faces = icosphere(3)
    meshes, notes = mesh_set((vertices, faces[vertices[faces].mean(axis=1)[:, 2] > 0.0]))
    values = meshes.meshing_close_holes_by_fairing()
    assert values is not None
    assert (values["closed_holes"], values["left_open"]) == (0, {"probably_outer": 1})
    assert len(notes) == 1
    assert "select a vertex of it" in notes[0]
    meshes.set_selection_all()
    values = meshes.meshing_close_holes_by_fairing(selected=True)
    assert values is not None
    assert values["closed_holes"] == 1


def test_a_lower_energy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Holes whose equations cannot be solved get a lower energy than asked for; their rims and that energy are said."""

    def fair(*mesh: Any, **options: Any) -> Any:
        if options["energy"] == "minimum_variation":
            raise ConvergenceError("too ill-conditioned")
        return fair_region(*mesh, **options)

    monkeypatch.setattr("pymeshfair.filters.holes.closing.fair_region", fair)
    meshes, notes = mesh_set(cut_ball())
    values = meshes.meshing_close_holes_by_fairing(energy="minimum_variation")
    assert values is not None
    assert (values["closed_holes"], values["lower_energy_holes"], len(notes)) == (2, 2, 4)
    assert all("was placed with energy 'thin_plate'" in note for note in notes[2:])


def test_a_filling_that_was_thrown_out_is_told() -> None:
    """Beside a spike a lower energy places the filling, and the note says that it would have reached too far."""
    meshes, notes = mesh_set(awkward_mesh(6000)[1])
    meshes.meshing_close_holes_by_fairing()
    (note,) = (note for note in notes if "was placed with energy 'membrane'" in note)
    assert "with 'thin_plate' it would reach further out of its rim than the rim is wide" in note


def test_without_refinement_there_are_faces_alone() -> None:
    """A hole of k edges is closed by k - 2 faces and no vertex."""
    meshes, _ = mesh_set(cut_ball())
    values = meshes.meshing_close_holes_by_fairing(refine=False)
    assert values is not None
    assert (values["new_vertices"], values["new_faces"]) == (0, sum(values["closed_rim_edges"]) - 4)


def test_the_bunny_keeps_its_texture_and_everything_else() -> None:
    """The five holes of the textured bunny are closed; old elements keep every property to the bit, the layer its texture."""
    meshes = MeshSet()
    meshes.load_new_mesh(BUNNY)
    add_attributes(meshes.current_mesh())
    before = everything(meshes)
    values = meshes.meshing_close_holes_by_fairing(mark="none")
    assert values is not None
    assert (values["closed_holes"], sorted(values["closed_rim_edges"])) == (5, RIMS)
    after = everything(meshes)
    n, m = len(before["vertices"]), len(before["faces"])
    uv = after["wedge_uv"].reshape(-1, 3, 2)
    old = {k: v[: n if k in PER_VERTEX else m] if k in PER_VERTEX + PER_FACE else v for k, v in after.items()}
    assert differences(before, old, but={"vertex_normals", "face_normals", "vertex_uv"}) == []
    assert rims_of(meshes.current_mesh()) == 0
    # Each new face shows one place of the texture, the middle of an old face.
    assert (uv[m:] == uv[m:, :1]).all()
    shown = {tuple(middle) for middle in uv[:m].mean(axis=1).astype(np.float32).astype(float).tolist()}
    assert {tuple(corner) for corner in uv[m:, 0].tolist()} <= shown


def wedge_uv(mesh: Any) -> NDArray[np.float64]:
    """(m, 3, 2) the texture coordinates of the faces."""
    return np.asarray(mesh.wedge_tex_coord_matrix()).reshape(-1, 3, 2)


@pytest.mark.slow
@pytest.mark.parametrize("extension", ["obj", "ply"])
def test_a_run_of_the_recipe_keeps_the_texture(extension: str, tmp_path: Path) -> None:
    """In a process of its own the recipe writes a closed bunny; read again it has the same texture, at the same places."""
    output = tmp_path / f"filled.{extension}"
    done = run_process("run", "fill_holes_smoothly", BUNNY, "-o", output, "--json")
    assert done.returncode == 0, done.stderr
    assert "texture coordinates" not in done.stderr
    (step,) = document(done.stdout)["steps"]
    assert sorted(step["values"]["closed_rim_edges"]) == RIMS
    assert step["values"]["left_open"] == {}
    plain = pymeshlab.MeshSet()
    plain.load_new_mesh(BUNNY)
    plain.load_new_mesh(str(output))
    old, new = plain.mesh(0), plain.mesh(1)
    m = old.face_number()
    np.testing.assert_array_equal(new.vertex_matrix()[: old.vertex_number()], old.vertex_matrix())
    np.testing.assert_array_equal(new.face_matrix()[:m], old.face_matrix())
    np.testing.assert_array_equal(wedge_uv(new)[:m], wedge_uv(old))
    assert rims_of(new) == 0
    assert list(new.textures()) == list(old.textures()) == ["TextureDouble_A.png"]
    assert (tmp_path / "TextureDouble_A.png").read_bytes() == (Path(BUNNY).parent / "TextureDouble_A.png").read_bytes()


def test_a_run_keeps_the_attributes_of_a_ply_file(tmp_path: Path) -> None:
    """Colours and scalars of vertices and faces come back to the bit; those of new elements are from near by."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*cut_ball()))
    meshes.compute_scalar_by_function_per_vertex(q="z/3")
    meshes.compute_scalar_by_function_per_face(q="fi/7")
    meshes.compute_color_by_function_per_vertex(x="128+100*z", y="vi", z="20", a="255")
    meshes.compute_color_by_function_per_face(r="fi", g="0", b="9", a="255")
    source, output = tmp_path / "ball.ply", tmp_path / "filled.ply"
    meshes.save_current_mesh(str(source))
    done = run_process("run", "fill_holes_smoothly", source, "-o", output)
    assert done.returncode == 0, done.stderr
    states = []
    for file in (source, output):
        read = MeshSet()
        read.load_new_mesh(str(file))
        states.append(everything(read))
    before, after = states
    n, m = len(before["vertices"]), len(before["faces"])
    old = {k: v[: n if k in PER_VERTEX else m] if k in PER_VERTEX + PER_FACE else v for k, v in after.items()}
    assert {"vertex_scalars", "vertex_colors", "face_scalars", "face_colors"} <= before.keys()
    assert differences(before, old, but={"label", "vertex_normals", "face_normals"}) == []
    # The scalars are a third of the height, and the upper rim lies above 0.8, the lower one below -0.9.
    scalars = after["vertex_scalars"][n:]
    assert ((scalars > 0.8 / 3) | (scalars < -0.9 / 3)).all()
    assert set(after["face_scalars"][m:].tolist()) <= set(before["face_scalars"].tolist())


def test_the_recipe_fills_a_ball_and_later_steps_see_the_filling() -> None:
    """After the recipe the filling is selected, so that a built-in step deletes it again and leaves the ball as it was."""
    ball = cut_ball()
    meshes, _ = mesh_set(ball)
    meshes.load_filter_script(str(load_recipe("fill_holes_smoothly").script.path))
    meshes.apply_filter_script()
    assert rims_of(meshes.current_mesh()) == 0
    assert not meshes.current_mesh().has_face_scalar()
    meshes.meshing_remove_selected_vertices_and_faces()
    np.testing.assert_array_equal(meshes.current_mesh().vertex_matrix(), ball[0])
    np.testing.assert_array_equal(meshes.current_mesh().face_matrix(), ball[1])


def test_every_parameter_of_the_recipe_is_written() -> None:
    """MeshLab's own reader fills nothing in, so the step says all."""
    (step,) = load_recipe("fill_holes_smoothly").script.steps
    assert set(step.values) == {p.name for p in declared.parameters}


def test_the_declaration_mirrors_meshlabs() -> None:
    """No filter of MeshLab has either name; numbers have bounds; the filter needs faces and says that it adds some."""
    taken = {name for known in meshlab_filters() for name in (known.name, known.python_name)}
    assert not {declared.name, declared.python_name} & taken
    assert all(p.minimum is not None for p in declared.parameters if isinstance(p, Int | Float))
    assert declared.requires == MeshElement.FACENUMBER
    assert declared.changes & MeshElement.FACENUMBER
    assert declared.references == ("liepa2003",)
