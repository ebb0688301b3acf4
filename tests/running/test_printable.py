"""The written file as a slicer sees it: equal points merged, closed, manifold, oriented, nothing that cuts anything."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
import trimesh

import pymeshfair
from pymeshfair.errors import GuardBroken
from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import Recipe, load_recipe
from pymeshfair.running.guarding import print_faults
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.scripts.guards import Guards
from pymeshfair.scripts.script import Script
from tests.meshes import Mesh, cube, icosphere, torus


def _saved(path: Path, *meshes: Mesh) -> Path:
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    vertices = np.concatenate([vertices for vertices, _ in meshes])
    faces = np.concatenate([faces + np.int32(first) for (_, faces), first in zip(meshes, counts, strict=False)])
    document = pymeshlab.MeshSet()
    document.add_mesh(pymeshlab.Mesh(vertices, faces))
    document.save_current_mesh(str(path))
    return path


def _faults(path: Path, folder: Path) -> list[str]:
    return [fault.message for fault in print_faults(read_file(path).mesh, folder / "meshlab")]


def test_a_cube_of_loose_triangles_is_printable(tmp_path: Path) -> None:
    """An STL file has three points a face; merged they make a closed cube."""
    assert _faults(_saved(tmp_path / "cube.stl", cube()), tmp_path) == []


def test_a_file_without_faces_is_not_printable() -> None:
    """Points alone, as in an .xyz file, are nothing that can be printed."""
    told = [fault.message for fault in print_faults(MeshData(vertices=cube()[0]))]
    assert told == ["the written file has no volume"]


@pytest.mark.parametrize(
    ("other", "expected"),
    [((1.0, 1.0, 0.0), "1 edge with more than two faces, around 1, 1, 0.5"), ((0.5, 0.4, 0.3), "faces that cut others")],
)
def test_what_only_merging_and_looking_shows_has_a_place(tmp_path: Path, other: tuple[float, ...], expected: str) -> None:
    """Two closed cubes that share an edge have four faces there; two that overlap cut each other."""
    vertices, faces = cube()
    told = "; ".join(_faults(_saved(tmp_path / "cubes.stl", (vertices, faces), (vertices + other, faces)), tmp_path))
    assert expected in told
    assert "around" in told


def test_a_face_that_merging_collapses_is_no_error_of_ours(tmp_path: Path) -> None:
    """Two of its points are one: that is a fault of the file, and what cuts others is found beside it."""
    vertices, faces = cube()
    doubled, sliver = np.concatenate([vertices, vertices[:1]]), np.array([[0, len(vertices), 1]], dtype=np.int32)
    written = _saved(tmp_path / "cubes.stl", (doubled, np.concatenate([sliver, faces])), (vertices + 0.4, faces))
    told = _faults(written, tmp_path)
    assert "1 border edge, around 0, 0, 0" in told[0]
    assert "faces that cut others" in told[-1]


def test_a_wrap_is_no_remedy_for_a_wrap(tmp_path: Path) -> None:
    """Where faces of a wrap cut each other the way out is not wrap_for_print."""
    vertices, faces = cube()
    written = _saved(tmp_path / "cubes.stl", (vertices, faces), (vertices + 0.4, faces))
    (told,) = (fault.message for fault in print_faults(read_file(written).mesh, tmp_path / "meshlab", wrapped=True))
    assert told.endswith("mend these places, or wrap with another alpha or offset")


def test_an_open_cube_and_one_inside_out_are_refused(tmp_path: Path) -> None:
    """The border is named with its place; the faces that look inwards as such, also of one part of two, and a way out."""
    vertices, faces = cube()
    assert "3 border edges" in _faults(_saved(tmp_path / "open.stl", (vertices, faces[1:])), tmp_path / "a")[0]
    assert "look inwards" in _faults(_saved(tmp_path / "in.stl", (vertices, faces[:, ::-1])), tmp_path / "b")[0]
    parts = (3.0 * vertices, faces), (vertices + 5.0, faces[:, ::-1])
    (told,) = _faults(_saved(tmp_path / "two.stl", *parts), tmp_path / "c")
    assert told.startswith(
        "the written file has 12 faces of parts that look inwards, around 5.5, 5.5, 5.5; turn these parts over"
    )


@pytest.mark.parametrize("name", ["prepare_for_print", "prepare_for_simulation"])
def test_parts_that_share_an_edge_or_look_inwards_are_no_silent_success(tmp_path: Path, name: str) -> None:
    """Blocks that touch along an edge, and a block inside out beside another, are errors of both recipes, with a way out."""
    vertices, faces = cube()
    edge = _saved(tmp_path / "edge.ply", (vertices * [3.0, 3.0, 1.0], faces), (vertices + np.array([3.0, 3.0, 0.0]), faces))
    words = "edges? with more than two faces, .*; .*take wrap_for_print" if name == "prepare_for_print" else "is not watertight"
    with pytest.raises(GuardBroken, match=words):
        run_job(Job(load_recipe(name), edge, tmp_path / "out.ply"))
    turned = _saved(tmp_path / "turned.ply", (3.0 * vertices, faces), (vertices + 5.0, faces[:, ::-1]))
    with pytest.raises(GuardBroken, match=r"12 faces of parts that look inwards, around .*; turn these parts over"):
        run_job(Job(load_recipe(name), turned, tmp_path / "out.ply"))


def test_a_face_turned_over_and_parts_that_touch_have_a_place(tmp_path: Path) -> None:
    """A turned face has three edges around it; cubes that share a corner touch there."""
    vertices, faces = cube()
    turned = np.concatenate([faces[:1, ::-1], faces[1:]])
    told = _faults(_saved(tmp_path / "turned.stl", (vertices, turned)), tmp_path / "a")
    assert told[0].startswith("the written file has 3 edges whose two faces look to different sides, around ")
    told = _faults(_saved(tmp_path / "corner.stl", (vertices, faces), (vertices + 1.0, faces)), tmp_path / "b")
    assert told == ["the written file has 1 vertex where the surface touches itself, around 1, 1, 1"]


def test_lids_that_cross_are_an_error_with_places(tmp_path: Path) -> None:
    """Half a torus has two round borders, one within the other, whose lids lie in each other: nothing is written."""
    vertices, faces = torus(30, 16)
    half = np.ascontiguousarray(faces[vertices[faces].mean(axis=1)[:, 2] > 0.0])
    scan = _saved(tmp_path / "half.ply", (vertices, half))
    with pytest.raises(GuardBroken, match=r"faces that cut others, around .*wrap_for_print"):
        run_job(Job(load_recipe("prepare_for_print"), scan, tmp_path / "out.stl"))
    assert not (tmp_path / "out.stl").exists()


def test_balls_that_cut_each_other_are_wrapped_in_one_surface(tmp_path: Path) -> None:
    """The wrapped file is closed and oriented for trimesh too, in one piece, a little larger than the two balls."""
    vertices, faces = icosphere(3)
    scan = _saved(tmp_path / "balls.ply", (vertices, faces), (vertices + np.array([1.0, 0.0, 0.0]), faces))
    result = pymeshfair.run("wrap_for_print", scan, tmp_path / "out.stl", settings={"alpha": "4%", "offset": "0.5%"})
    assert not any("prepare_for_print" in text for text in result.warnings)
    made = trimesh.load(tmp_path / "out.stl", force="mesh")
    assert isinstance(made, trimesh.Trimesh)
    assert made.is_watertight
    assert made.is_winding_consistent
    both = 2.0 * 4.0 / 3.0 * np.pi - np.pi * (4.0 + 1.0) * 1.0 / 12.0  # less the lens that they share
    assert made.volume == pytest.approx(both, rel=0.06)


def test_a_wrap_tells_what_it_closes_in(tmp_path: Path) -> None:
    """A ball in a ball is, and a third of the area of both."""
    vertices, faces = icosphere(4)
    scan = _saved(tmp_path / "balls.ply", (vertices, faces), (np.sqrt(0.5) * vertices, faces))
    result = pymeshfair.run("wrap_for_print", scan, tmp_path / "out.stl", settings={"alpha": "10%", "offset": "0.5%"})
    assert result.steps[-1].messages[-1].startswith("33.3% of the scanned area is enclosed")
    assert "the recipe prepare_for_print keeps its surface" in result.warnings[-1]  # it prints as it is


def test_the_walls_are_told(tmp_path: Path) -> None:
    """A cube of side 1 is 1 thick; the run says so with its last step."""
    result = pymeshfair.run("prepare_for_print", _saved(tmp_path / "cube.ply", cube()), tmp_path / "out.stl")
    assert (
        "half of the area is thicker than 1, 1 % is thinner than 1, the thinnest place is 1 at " in result.steps[-1].messages[-1]
    )


@pytest.mark.parametrize("keep_broken", [False, True])
def test_a_recipe_without_steps_can_ask_for_a_printable_mesh(tmp_path: Path, keep_broken: bool) -> None:
    """A printable file passes the check, though there is no step that could tell its walls."""
    limits = Guards(require=(("printable", None),))
    job = Job(Recipe("none", Script(())), _saved(tmp_path / "cube.ply", cube()), tmp_path / "out.ply", guards=limits)
    assert run_job(replace(job, keep_broken=keep_broken)).breaches == ()
