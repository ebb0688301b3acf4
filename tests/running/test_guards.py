"""Guards of a run, and its intervention map."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pymeshlab
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pymeshfair.declaration import Length
from pymeshfair.errors import GuardBroken, ParameterError
from pymeshfair.files.errors import OutputError
from pymeshfair.recipe import Recipe, load_recipe
from pymeshfair.running.guarding import _displacement
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.scripts.guards import NO_GUARDS, Guards
from pymeshfair.scripts.read import parse_script
from pymeshfair.scripts.script import ScriptError
from pymeshfair.scripts.write import format_script
from tests.meshes import cube, icosphere, noisy
from tests.running.runs import BONE, SMOOTH, names_in, ply_bytes, recipe_of, xyz

TAUBIN = recipe_of(SMOOTH)


class Read:
    """A file as MeshLab reads it, as arrays."""

    def __init__(self, path: Path) -> None:
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(path))
        mesh = meshes.current_mesh()
        self.vertices, self.faces = mesh.vertex_matrix(), mesh.face_matrix()
        self.vertex_scalars, self.vertex_colors = mesh.vertex_scalar_array(), mesh.vertex_color_matrix()
        if mesh.has_face_scalar():
            self.face_scalars, self.face_colors = mesh.face_scalar_array(), mesh.face_color_matrix()


def job(folder: Path, recipe: Recipe = TAUBIN, source: Path = BONE, **more: Any) -> Job:
    """A run into a folder, with guards by their texts."""
    guards = Guards.parse(more.pop("guards", {}))
    return Job(recipe, source, folder / "out.ply", guards=guards, **more)


def test_broken_displacement_names_vertex_place_and_amount(tmp_path: Path) -> None:
    """The error names the vertex that moved furthest, where it is, how far it moved and how far was allowed."""
    with pytest.raises(GuardBroken) as caught:
        run_job(job(tmp_path, guards={"max_displacement": "0.01edge"}))
    assert names_in(tmp_path) == set()
    assert str(caught.value).endswith("No output was written; change the limit or the recipe")
    run_job(job(tmp_path))
    before, after = Read(BONE).vertices, Read(tmp_path / "out.ply").vertices
    moved = np.linalg.norm(after - before, axis=1)
    (breach,) = caught.value.breaches
    assert breach["vertex"] == moved.argmax()
    # The output holds single precision.
    np.testing.assert_allclose(breach["amount"], moved.max(), rtol=1e-4)
    np.testing.assert_allclose(breach["place"], after[moved.argmax()], rtol=1e-6)
    assert breach["allowed"] < breach["amount"]
    assert f"vertex {moved.argmax()} at (" in str(caught.value)


def test_a_mesh_that_is_shifted_keeps_its_sharp_edges(tmp_path: Path) -> None:
    """A cube that a recipe shifts by twenty edges has all of its sharp edges."""
    (tmp_path / "cube.ply").write_bytes(ply_bytes(xyz(cube()[0]), cube()[1].tolist()))
    shift = recipe_of(("compute_matrix_from_translation", {"axisx": 40.0}))
    assert not run_job(job(tmp_path, shift, tmp_path / "cube.ply", guards={"keep_sharp": "100%"})).breaches


def test_run_within_its_limits_is_the_same_bytes(tmp_path: Path) -> None:
    """Guards and a map change no byte of the output, and leave no attribute in it."""
    plain, watched = tmp_path / "plain", tmp_path / "watched"
    for folder in (plain, watched):
        folder.mkdir()
    run_job(job(plain))
    result = run_job(
        job(watched, guards={"max_displacement": "1edge", "require": "watertight"}, map=watched / "map.ply"),
    )
    assert not result.breaches
    assert (plain / "out.ply").read_bytes() == (watched / "out.ply").read_bytes()
    record = json.loads((watched / "out.ply.provenance.json").read_bytes())
    assert record["guards"]["limits"] == {"max_displacement": "1.0edge", "require": "watertight"}
    assert [Path(f["path"]).name for f in record["guards"]["maps"]] == ["map.ply"]


def test_output_is_kept_if_asked_for(tmp_path: Path) -> None:
    """With `keep_broken` the output is there, and the result and the provenance say what was broken."""
    result = run_job(job(tmp_path, guards={"require": "components=2,genus=5"}, keep_broken=True))
    assert [b["message"] for b in result.breaches] == ["the result has components 1, not 2", "the result has genus 0, not 5"]
    assert (tmp_path / "out.ply").exists()


@pytest.mark.parametrize(
    ("guards", "words"),
    [
        ({"max_volume_change": "0.001%"}, "the volume changed from"),
        ({"require": "watertight"}, None),
        ({"keep_sharp": "100%"}, "of the length of the edges sharper than 40 degrees is kept"),
    ],
)
def test_each_guard(tmp_path: Path, guards: dict[str, str], words: str | None) -> None:
    """Each guard fails the run in words of its own, or lets it pass."""
    strong = recipe_of(("apply_coord_taubin_smoothing", {"stepsmoothnum": 50}))
    if words is None:
        assert not run_job(job(tmp_path, strong, guards=guards)).breaches
        return
    with pytest.raises(GuardBroken, match=words):
        run_job(job(tmp_path, strong, guards=guards))


def test_an_edge_of_more_than_two_faces_is_not_watertight(tmp_path: Path) -> None:
    """Two tetrahedra with an edge in common have no border; the edge with its four faces is why, and is counted."""
    points = [[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    faces = [
        [*np.take(corners, side)]
        for corners in ([0, 1, 2, 3], [0, 1, 4, 5])
        for side in ([0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2])
    ]
    source = tmp_path / "joined.ply"
    source.write_bytes(ply_bytes(xyz(np.array(points)), faces))
    with pytest.raises(GuardBroken, match="border edges 0, edges of more than two faces 1") as caught:
        run_job(job(tmp_path, source=source, guards={"require": "watertight"}))
    assert caught.value.breaches[0]["amount"] == 1


def test_open_meshes_have_no_volume_to_guard(tmp_path: Path) -> None:
    """A guard that cannot be judged is broken, and says why."""
    vertices, faces = icosphere(2)
    source = tmp_path / "open.ply"
    source.write_bytes(ply_bytes(xyz(vertices), faces[1:].tolist()))
    with pytest.raises(GuardBroken, match="the input is not closed and oriented, so it has no volume"):
        run_job(job(tmp_path, source=source, guards={"max_volume_change": "5%"}))


def test_map_shows_every_element(tmp_path: Path) -> None:
    """Holes filled, a piece removed and vertices moved: every element of the map is compared with what was done.

    The mesh is a sphere without three faces, moved by noise, and a small tetrahedron beside it.
    """
    vertices, faces = noisy(icosphere(2), 0.01)
    piece = np.array([[3.0, 0, 0], [3.1, 0, 0], [3, 0.1, 0], [3, 0, 0.1]])
    sides = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]) + len(vertices)
    all_vertices, all_faces = np.concatenate([vertices, piece]), np.concatenate([np.delete(faces, [5, 90, 200], axis=0), sides])
    source = tmp_path / "in.ply"
    source.write_bytes(ply_bytes(xyz(all_vertices), all_faces.tolist()))
    recipe = recipe_of(
        ("meshing_remove_connected_component_by_diameter", {"mincomponentdiag": "20%", "removeunref": True}),
        ("meshing_close_holes", {"maxholesize": 10}),
        ("compute_selection_by_condition_per_vertex", {"condselect": "x > 0.5"}),
        ("apply_coord_laplacian_smoothing", {"stepsmoothnum": 1, "selected": True}),
    )
    result = run_job(job(tmp_path, recipe, source, map=tmp_path / "map.ply"))
    assert [path.name for path in result.maps] == ["map.ply", "map.removed.ply"]
    shown, output, gone = (Read(tmp_path / name) for name in ("map.ply", "out.ply", "map.removed.ply"))
    after = shown.vertices
    np.testing.assert_allclose(after, output.vertices, atol=1e-6)
    distances = np.linalg.norm(after - vertices, axis=1)
    np.testing.assert_allclose(shown.vertex_scalars, distances, atol=1e-12)
    moved = distances > 0.0
    assert moved.any()
    assert not moved.all()
    assert set(np.flatnonzero(moved)) <= set(np.flatnonzero(vertices[:, 0] > 0.5))
    states = shown.face_scalars
    mesh_faces = shown.faces
    old = {tuple(sorted(face)) for face in np.delete(faces, [5, 90, 200], axis=0).tolist()}
    expected = [2 if tuple(sorted(face)) not in old else 1 if moved[face].any() else 0 for face in mesh_faces.tolist()]
    np.testing.assert_array_equal(states, expected)
    assert expected.count(2) == 3
    np.testing.assert_array_equal(gone.vertices, piece)
    np.testing.assert_array_equal(gone.vertex_scalars, np.arange(4) + len(vertices))
    assert len(gone.faces) == 4


def test_a_new_map_takes_away_the_removed_elements_of_a_former_one(tmp_path: Path) -> None:
    """A run that removes nothing leaves no file of removed elements; a map that the last run did not write stays."""
    removes = recipe_of(
        ("compute_selection_by_condition_per_face", {"condselect": "x0 > 0"}), ("meshing_remove_selected_faces", {})
    )
    first = run_job(job(tmp_path, removes, map=tmp_path / "map.ply"))
    assert [path.name for path in first.maps] == ["map.ply", "map.removed.ply"]
    second = run_job(job(tmp_path, map=tmp_path / "map.ply", overwrite=True))
    assert (second.maps, (tmp_path / "map.removed.ply").exists()) == ((tmp_path / "map.ply",), False)
    run_job(job(tmp_path, map=tmp_path / "other.ply"))
    with pytest.raises(OutputError, match=r"map\.ply: it exists and is not from the last run that wrote the output"):
        run_job(job(tmp_path, map=tmp_path / "map.ply"))


def test_what_moved_less_than_the_tolerance_is_kept_in_the_map(tmp_path: Path) -> None:
    """Without one all faces of a smoothed bone moved; with one those with a corner that moved further, by the map's scalars."""
    run_job(job(tmp_path, map=tmp_path / "map.ply"))
    whole = Read(tmp_path / "map.ply")
    assert set(whole.face_scalars) == {1.0}
    tolerance = float(np.median(whole.vertex_scalars))
    run_job(job(tmp_path, map=tmp_path / "map.ply", map_tolerance=Length(1000.0 * tolerance, "mm"), unit="m", overwrite=True))
    shown = Read(tmp_path / "map.ply")
    np.testing.assert_array_equal(shown.vertex_scalars, whole.vertex_scalars)
    beyond = shown.vertex_scalars[shown.faces].max(axis=1)
    sure = np.abs(beyond / tolerance - 1.0) > 1e-6  # the file has single precision
    np.testing.assert_array_equal(shown.face_scalars[sure], (beyond > tolerance)[sure])
    assert 0 < (shown.face_scalars == 0.0).sum() < len(shown.faces)
    record = json.loads((tmp_path / "out.ply.provenance.json").read_bytes())
    assert float(record["guards"]["map_tolerance"]) == pytest.approx(tolerance)
    with pytest.raises(ParameterError, match=r"0\.05 on a scan in mm"):
        run_job(job(tmp_path, map=tmp_path / "map.ply", map_tolerance=Length(0.05, "mm")))


def test_map_survives_meshlab(tmp_path: Path) -> None:
    """Written by MeshLab again, a map has the same scalars and colours."""
    run_job(job(tmp_path, map=tmp_path / "map.ply"))
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(tmp_path / "map.ply"))
    meshes.save_current_mesh(str(tmp_path / "again.ply"), save_face_quality=True, save_face_color=True)
    first, second = Read(tmp_path / "map.ply"), Read(tmp_path / "again.ply")
    for name in ("vertex_scalars", "face_scalars", "vertex_colors", "face_colors", "vertices"):
        np.testing.assert_allclose(getattr(second, name), getattr(first, name), rtol=1e-6, atol=1e-7)


def test_map_replaces_no_file_of_others(tmp_path: Path) -> None:
    """A map is refused where a file of someone else, the input or the output would be, and another format."""
    (tmp_path / "mine.ply").write_text("precious")
    with pytest.raises(OutputError, match="it exists and no provenance says"):
        run_job(job(tmp_path, map=tmp_path / "mine.ply"))
    with pytest.raises(OutputError, match="name another file for the map"):
        run_job(job(tmp_path, map=tmp_path / "out.ply"))
    with pytest.raises(OutputError, match=r"'\.obj' is no format for it; name a file that ends with \.ply"):
        run_job(job(tmp_path, map=tmp_path / "map.obj"))
    run_job(job(tmp_path, map=tmp_path / "map.ply"))
    run_job(job(tmp_path, map=tmp_path / "map.ply"))  # what a run wrote, the same run replaces


def test_broken_run_still_writes_the_map(tmp_path: Path) -> None:
    """The map that was asked for shows where a guard was broken."""
    with pytest.raises(GuardBroken, match=r"map\.ply shows where"):
        run_job(job(tmp_path, guards={"max_displacement": "0"}, map=tmp_path / "map.ply"))
    assert names_in(tmp_path) == {"map.ply"}


def test_new_meshes_are_measured_from_the_surface(tmp_path: Path) -> None:
    """A reconstruction has no element of the input: all count as added, and a warning says what the distances are."""
    vertices, faces = icosphere(3)
    source = tmp_path / "in.ply"
    source.write_bytes(ply_bytes(xyz(vertices), faces.tolist()))
    poisson = recipe_of(("generate_surface_reconstruction_screened_poisson", {"depth": 5}))
    result = run_job(job(tmp_path, poisson, source, map=tmp_path / "map.ply"))
    assert any("from the input are measured, not displacements" in warning for warning in result.warnings)
    shown = Read(tmp_path / "map.ply")
    assert (shown.face_scalars == 2.0).all()
    assert shown.vertex_scalars.max() < 0.2


@given(st.floats(0.0, 100.0))
def test_limits_come_back_from_their_texts(percent: float) -> None:
    """A limit in percent is read from its text to the bit, however small."""
    guards = Guards(max_volume_change=percent, keep_sharp=percent)
    assert Guards.parse(guards.texts()) == guards


def test_guards_in_the_head_of_a_recipe(tmp_path: Path) -> None:
    """A recipe sets guards in attributes, reads and writes them alike, and the command's go over them."""
    limits = {
        "max_displacement": "0.1%",
        "max_volume_change": "1.0%",
        "require": "watertight,components=1",
        "keep_sharp": "90.0%",
    }
    script = replace(load_recipe("smooth_taubin").script, guards=Guards.parse(limits))
    text = format_script(script)
    assert (
        '<FilterScript maxDisplacement="0.1%" maxVolumeChange="1.0%" require="watertight,components=1" keepSharp="90.0%">' in text
    )
    again = parse_script(text.encode(), "again.mlx")
    assert again.guards == script.guards
    assert again.guards.texts() == limits
    assert again.guards.overridden(Guards.parse({"require": "manifold"})).require == (("manifold", None),)
    with pytest.raises(GuardBroken, match=r"0.001% = "):
        run_job(job(tmp_path, Recipe("head", replace(TAUBIN.script, guards=Guards.parse({"max_displacement": "0.001%"})))))


@pytest.mark.parametrize(
    ("guards", "words"),
    [
        ({"max_displacement": "far"}, "'far' is no length"),
        ({"max_displacement": "-1"}, "is below 0"),
        ({"max_volume_change": "much"}, "is no percentage"),
        ({"keep_sharp": "101%"}, "is above 100 %"),
        ({"require": "watertigth"}, "did you mean 'watertight'"),
        ({"require": "components"}, "components=N"),
        ({"require": "keep_sharp"}, "'keep_sharp' is no requirement"),
    ],
)
def test_wrong_guards_are_refused(guards: dict[str, str], words: str) -> None:
    """What a guard does not take is refused with what it takes, in a recipe's head with its line."""
    with pytest.raises(ParameterError, match=words):
        Guards.parse(guards)
    names = {"max_displacement": "maxDisplacement", "max_volume_change": "maxVolumeChange", "keep_sharp": "keepSharp"}
    ((name, text),) = guards.items()
    head = f'<FilterScript {names.get(name, name)}="{text}">'
    script = f'<!DOCTYPE FilterScript>\n{head}<filter name="Laplacian Smooth"/></FilterScript>'
    with pytest.raises(ScriptError, match=words) as refused:
        parse_script(script.encode(), "x.mlx")
    assert "_" not in str(refused.value).replace(text, "")  # it names the attribute of the script


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("0.05mm", "mm", 0.05),
        ("0.05mm", "m", 5e-5),
        ("0.05 mm", "cm", 5e-3),
        ("2cm", "mm", 20.0),
        ("1e-3m", "mm", 1.0),
        ("1in", "mm", 25.4),
        (".5m", "in", 0.5 / 0.0254),
        ("0.05", "m", 0.05),
    ],
)
def test_a_length_with_a_unit_is_one_of_the_scan(text: str, unit: str, expected: float) -> None:
    """It is converted to the unit that the scan is said to be in; one without a unit is one of the mesh in any case."""
    limit = Guards.parse({"max_displacement": text}).in_mesh_units(unit).max_displacement
    assert isinstance(limit, Length)
    assert limit.unit == "absolute"
    assert limit.amount == pytest.approx(expected, rel=1e-15)
    assert not NO_GUARDS.in_mesh_units(unit)


def test_a_length_with_a_unit_needs_the_unit_of_the_scan(tmp_path: Path) -> None:
    """Else it is refused before the mesh is opened, with what it would be in millimetres and in metres, and the way out."""
    missing = tmp_path / "missing.ply"
    head = replace(TAUBIN.script, guards=Guards.parse({"max_displacement": "0.05mm"}))
    for limited in (
        job(tmp_path, source=missing, guards={"max_displacement": "0.05mm"}),
        job(tmp_path, Recipe("head", head), missing),
    ):
        with pytest.raises(
            ParameterError, match=r"0\.05 on a scan in mm and 5e-05 on a scan in m, .*--unit mm\|cm\|m\|in\|ft\|um \("
        ):
            run_job(limited)
    with pytest.raises(ParameterError, match="'inch' is no unit of scans; the units are mm, cm, m, in, ft, um"):
        run_job(job(tmp_path, source=missing, unit="inch"))


def test_a_scan_in_metres_moves_by_no_millimetre(tmp_path: Path) -> None:
    """A move by some thousandths of a unit is within 5 mm and beyond 0.1 mm if the units are metres; the record says the unit."""
    run_job(job(tmp_path, guards={"max_displacement": "5mm"}, unit="m"))
    record = json.loads((tmp_path / "out.ply.provenance.json").read_bytes())
    assert record["options"]["unit"] == "m"
    assert record["guards"]["limits"] == {"max_displacement": "0.005"}
    with pytest.raises(GuardBroken, match=r"which is more than 0\.1mm = 0\.0001 m"):
        run_job(job(tmp_path, guards={"max_displacement": "0.1mm"}, unit="m"))


def test_a_displacement_beyond_its_limit_never_looks_equal_to_it() -> None:
    """Single precision moves by a little more than 0.1, and the message has the digits that show it."""
    origins = SimpleNamespace(displaced=(None, np.array([0.0, np.float32(0.1)])), vertices=[0, 1])
    moved = SimpleNamespace(same=True, largest=float(np.float32(0.1)), vertex=1, place=(0.0, 0.0, 0.0))
    (breach,) = _displacement(origins, moved, 0.1, "0.1", "")  # type: ignore[arg-type]
    assert breach.message.endswith("has moved by 0.100000001, which is more than 0.1")
    (breach,) = _displacement(origins, moved, 0.1, "1%", " mm")  # type: ignore[arg-type]
    assert breach.message.endswith("has moved by 0.100000001 mm, which is more than 1% = 0.1 mm")
