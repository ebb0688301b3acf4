"""`pymeshfair info` tells everything about a filter, a recipe or a mesh."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair.commands.info import mlx_element
from pymeshfair.declaration import FilterClass
from pymeshfair.recipe import load_recipe, shipped_recipes
from pymeshfair.registry import all_filters, custom_filters, find_filter
from pymeshfair.scripts import parse_script
from tests.meshes import tetrahedron

from .command_line import document, invoke

OURS = custom_filters()


@pytest.mark.parametrize("python_name", [f.python_name for f in OURS])
def test_page_of_a_filter_holds_its_whole_declaration(python_name: str) -> None:
    """Names, text, and of every parameter the name, what is allowed, the default and the help are on the page."""
    known = find_filter(python_name)
    page = " ".join(invoke("info", python_name).stdout.split())
    for text in (known.python_name, known.name, known.origin, known.info, *known.references):
        assert " ".join(text.split()) in page
    for parameter in known.parameters:
        assert f" {parameter.name} (default " in page
        assert " ".join(f"{parameter.label}: {parameter.describe_allowed()}. {parameter.help}".split()) in page


@pytest.mark.parametrize("python_name", [f.python_name for f in OURS])
def test_document_of_a_filter_holds_every_parameter(python_name: str) -> None:
    """The JSON lists the parameters in declared order with names, type, bounds, default and help."""
    known = find_filter(python_name)
    read = document(invoke("info", python_name, "--json").stdout)["filter"]
    assert FilterClass(sum(FilterClass[name] for name in read["classes"])) == known.classes
    assert [p["name"] for p in read["parameters"]] == [p.name for p in known.parameters]
    for told, parameter in zip(read["parameters"], known.parameters, strict=True):
        assert told["mlx_name"] == parameter.xml_name
        assert told["help"] == parameter.help
        assert told["minimum"] == getattr(parameter, "minimum", None)
        assert parameter.check(told["default"]) == parameter.default


def test_a_filter_is_found_by_both_names() -> None:
    """MeshLab's name tells the same as Python's."""
    by_python, by_name = (invoke("info", n).stdout for n in ("apply_coord_taubin_smoothing", "Taubin Smooth"))
    assert by_python == by_name
    assert "a filter of MeshLab" in by_name


def test_shown_script_elements_are_valid_steps() -> None:
    """What `info` shows as a step of a script is read back as that filter with its defaults, for all filters of both kinds."""
    steps = "".join(mlx_element(known) for known in all_filters())
    read = parse_script(f"<!DOCTYPE FilterScript><FilterScript>{steps}</FilterScript>".encode(), "shown.mlx").steps
    assert [step.filter for step in read] == list(all_filters())
    for step in read:
        assert step.values == {p.name: p.default for p in step.filter.parameters if p.default is not None}


@pytest.mark.parametrize("name", shipped_recipes())
def test_page_of_a_recipe_holds_its_head_comment_and_steps(name: str) -> None:
    """Title, description, every step and every value that the recipe gives are shown."""
    recipe = load_recipe(name)
    shown = invoke("info", name).stdout
    assert recipe.title in shown
    assert recipe.description in shown
    for number, step in enumerate(recipe.script.steps, start=1):
        assert f"{number:>4}  {step.filter.name}  ({step.filter.python_name})" in shown
    read = document(invoke("info", name, "--json").stdout)["recipe"]
    assert [s["python_name"] for s in read["steps"]] == [s.filter.python_name for s in recipe.script.steps]
    assert [list(s["parameters"]) for s in read["steps"]] == [list(s.values) for s in recipe.script.steps]


def test_a_superseded_recipe_is_shown_with_a_better_one() -> None:
    """The page of a superseded recipe names the better one; so does the message about a withdrawn recipe."""
    (name, *_) = shipped_recipes(superseded=True)
    assert "\nSuperseded: take 'denoise'" in invoke("info", name).stdout
    assert "is no longer shipped: take 'denoise'" in invoke("info", "smooth_keep_features").stderr


def test_a_recipe_may_be_a_path(tmp_path: Path) -> None:
    """An .mlx file of the user's is told about like a shipped one."""
    path = tmp_path / "mine.mlx"
    path.write_text('<FilterScript><filter name="Select Border"/></FilterScript>', encoding="utf-8")
    assert "   1  Select Border" in invoke("info", path).stdout


@pytest.mark.parametrize(
    ("asked", "meant"),
    [("taubin smoth", "Taubin Smooth"), ("clean_rangemap", "clean_range_map"), ("Selct Border", "Select Border")],
)
def test_what_is_nothing_is_answered_with_the_nearest_name(asked: str, meant: str) -> None:
    """Filters and recipes are both suggested; the exit code is that of wrong usage."""
    done = invoke("info", asked, "--json")
    assert done.exit_code == 2
    error = document(done.stdout)["error"]
    assert (error["kind"], error["suggestion"]) == ("UnknownNameError", meant)
    assert f"did you mean {meant!r}?" in done.stderr


SAMPLES = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"


def test_mesh_is_told_with_its_measures_and_attributes() -> None:
    """A textured OBJ of pymeshlab's: its counts, and what else is in it; nothing is written beside it."""
    path = SAMPLES / "bunny10k_textured.obj"
    before = set(path.parent.iterdir())
    shown = invoke("info", path).stdout
    assert re.search(r"^vertices +5,051$", shown, re.MULTILINE)
    assert re.search(r"^faces +9,999$", shown, re.MULTILINE)
    assert "faces, " in shown
    told = document(invoke("info", path, "--json").stdout)
    read = told["mesh"]
    assert (read["vertices"], read["faces"], read["border_edges"], read["components"]) == (5051, 9999, 109, 1)
    assert {"faces", "wedge texture coordinates", "textures"} <= set(read["attributes"])
    assert [rim["edges"] for rim in read["rims"]] == [38, 22, 22, 19, 8]
    assert sum(rim["edges"] for rim in read["rims"]) == read["border_edges"]
    assert "hole of 38 edges" in shown
    low, high = read["box"]
    assert np.linalg.norm(np.subtract(high, low)) == pytest.approx(read["diagonal"])
    assert read["traits"]["texture"] == 1.0
    assert f"noise is about {read['traits']['noise']:.2g} mean edges" in shown.replace("Its ", "")
    best = told["recipes"][0]
    assert best["fits"]
    assert f"   1  {best['recipe']}: " in shown
    assert set(path.parent.iterdir()) == before


def test_faces_that_cut_others_are_counted(tmp_path: Path) -> None:
    """Of two tetrahedra one of which stands with a corner in the other; of one alone there are none."""
    vertices, faces = tetrahedron()
    for name, count, expected in (("one.ply", 1, "none"), ("two.ply", 2, "")):
        points = np.concatenate([vertices + 0.4 * k for k in range(count)])
        mesh = pymeshlab.Mesh(points, np.concatenate([faces + len(vertices) * k for k in range(count)]))
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(mesh)
        meshes.save_current_mesh(str(tmp_path / name))
        number = document(invoke("info", tmp_path / name, "--json").stdout)["mesh"]["self_intersecting_faces"]
        assert (number > 0) == (count > 1)
        assert f"Faces that cut others: {expected or number}." in invoke("info", tmp_path / name).stdout


def test_faces_that_are_turned_against_their_neighbours_are_said(tmp_path: Path) -> None:
    """A tetrahedron with one face turned over gets a line, one without none."""
    vertices, faces = tetrahedron()
    for turned in (False, True):
        faces[0] = faces[0, ::-1] if turned else faces[0]
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
        meshes.save_current_mesh(str(tmp_path / "mesh.ply"))
        assert ("Neighbouring faces are oriented differently" in invoke("info", tmp_path / "mesh.ply").stdout) == turned


def test_what_is_doubtful_of_a_mesh_is_a_warning(tmp_path: Path) -> None:
    """What a run would warn of when it reads the file is told on stderr; of a file that is read whole nothing is."""
    path = tmp_path / "cut.xyz"
    path.write_text("0 0 0\n1 0 0\n0 1 0\n0 0 14", encoding="utf-8")
    done = invoke("info", path)
    assert done.exit_code == 0
    assert "its last line has no line end" in done.stderr
    assert invoke("info", SAMPLES / "bone.ply").stderr == ""


def test_a_file_that_is_no_mesh_is_a_failed_run(tmp_path: Path) -> None:
    """A file of another kind ends with 1 and says which formats there are, one that MeshLab cannot read with its words."""
    for name, said in (("notes.docx", ".ply, .obj"), ("broken.ply", "broken.ply")):
        path = tmp_path / name
        path.write_text("no mesh", encoding="utf-8")
        done = invoke("info", path, "--json")
        assert done.exit_code == 1
        error = document(done.stdout)["error"]
        assert error["kind"] == "InputError"
        assert said in error["message"]
