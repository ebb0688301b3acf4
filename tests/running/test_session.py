"""What a worker reads, keeps, names as lost and writes; carried out in this process."""

from __future__ import annotations

import errno
import gc
import json
import pickle
import shutil
import tempfile
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Float, Int, Layer, Percentage, mesh_filter
from pymeshfair.errors import FilterInputError, StepFailedError
from pymeshfair.files.errors import InputError, OutputError
from pymeshfair.files.formats import ATTRIBUTES, READABLE, UNCHECKED, WRITABLE, attributes_of
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_tables import read_header
from pymeshfair.files.provenance import described_file, sha256_of
from pymeshfair.filters.compilation import kernel
from pymeshfair.recipe import Recipe, load_recipe
from pymeshfair.running.document import Document
from pymeshfair.running.job import Job
from pymeshfair.running.session import RunCache, Session
from pymeshfair.scripts.script import Script, Step
from tests.meshes import icosphere

from .runs import (
    BONE,
    SAMPLES,
    SMOOTH,
    TETRAHEDRON,
    Given,
    columns,
    element,
    names_in,
    ply_bytes,
    recipe_of,
    session_report,
    staged_files,
    xyz,
)


def reload(path: Path) -> tuple[pymeshlab.MeshSet, Any]:
    """A mesh file as plain pymeshlab reads it; the mesh lives as long as the set."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    return meshes, meshes.current_mesh()


def properties(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Everything that pymeshlab reads from a file, by name."""
    meshes, mesh = reload(path)
    found = {"vertices": mesh.vertex_matrix(), "faces": mesh.face_matrix(), "normals": mesh.vertex_normal_matrix()}
    names = ("vertex_color", "vertex_scalar", "vertex_tex_coord", "face_color", "face_scalar", "wedge_tex_coord")
    for name in names:
        if getattr(mesh, f"has_{name}")():
            found[name] = getattr(mesh, f"{name}_{'array' if name.endswith('scalar') else 'matrix'}")()
    del meshes
    return found


@pytest.fixture
def everything(tmp_path: Path) -> Path:
    """A PLY file of a tetrahedron with everything that MeshLab reads, a texture included."""
    rng = np.random.default_rng(1)
    vertex = [*xyz(TETRAHEDRON[0] + rng.random((4, 3)) * 1e-3)]
    normals = np.array([[0.6, 0.0, 0.8], [0, 1, 0], [1, 0, 0], [0, 0, -1]])
    vertex += [("double", c, normals[:, k].tolist()) for k, c in enumerate(("nx", "ny", "nz"))]
    vertex += [("uchar", c, [1, 2, 30, 250]) for c in ("red", "green", "blue", "alpha")]
    vertex += [("double", "quality", rng.random(4).tolist()), ("double", "radius", [1.5] * 4)]
    vertex += [("double", c, rng.random(4).astype("f").tolist()) for c in ("texture_u", "texture_v")]
    face: list[tuple[str, str, Any]] = [("list uchar float", "texcoord", rng.random((4, 6)).tolist())]
    face += [("uchar", c, [7, 8, 9, 200]) for c in ("red", "green", "blue", "alpha")]
    face += [("double", "quality", rng.random(4).tolist())]
    path = tmp_path / "everything.ply"
    faces = TETRAHEDRON[1].tolist()
    path.write_bytes(ply_bytes(vertex, faces, face, head="comment TextureFile TextureDouble_A.png"))
    shutil.copy(SAMPLES / "TextureDouble_A.png", tmp_path)
    return path


def noting(check: Callable[[Any, Any], Any], checked: list[object]) -> Callable[[Any, Any], Any]:
    """The check of a kind of parameter, which also takes down the values that it is given."""

    def noted(self: Any, value: object) -> Any:
        checked.append(value)
        return check(self, value)

    return noted


def test_a_value_is_checked_once_between_the_command_line_and_the_filter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`--set implicit.detail_size=4edge` is checked where it is read, and reaches the filter through the worker unchecked."""
    recipe = load_recipe("smooth_implicit")
    checked: list[object] = []
    for kind in (Percentage, Enum, Int, Float, Bool):
        monkeypatch.setattr(kind, "check", noting(kind.check, checked))
    recipe = recipe.override(["implicit.detail_size=4edge"])
    (tmp_path / "new").mkdir()
    job: Job = pickle.loads(pickle.dumps(Job(recipe, BONE, tmp_path / "out.ply")))
    report = Session(job, tmp_path, lambda event: None).run()
    assert checked == ["4edge"]
    (done,) = [step.parameters["detail_size"] for step in report.steps if "detail_size" in step.parameters]
    assert report.before is not None
    assert done == pytest.approx(4.0 * report.before["mean_edge"], rel=1e-12)


def test_a_ply_file_keeps_everything(tmp_path: Path, everything: Path) -> None:
    """Without a step a PLY file comes back byte for byte, and so does its texture; filters of both kinds keep what they do not
    change, to the bit.
    """
    (tmp_path / "out").mkdir()
    report = session_report(everything, tmp_path / "out" / "copy.ply")
    assert report["warnings"] == []
    staged = staged_files(report)
    assert staged["copy.ply"].read_bytes() == everything.read_bytes()
    assert staged["TextureDouble_A.png"].read_bytes() == (SAMPLES / "TextureDouble_A.png").read_bytes()
    before = columns(everything)
    for step in (SMOOTH, ("apply_coord_taubin_fairing", {})):
        report = session_report(everything, tmp_path / "out" / f"{step[0]}.ply", step)
        assert report["warnings"] == []
        after = columns(staged_files(report)[f"{step[0]}.ply"])
        assert after.keys() == before.keys()
        same = {name for name in before if np.array_equal(after[name], before[name])}
        assert {name for element, name in before.keys() - same} == {"x", "y", "z", "nx", "ny", "nz"}


def test_custom_attributes_that_new_elements_lack_are_named(tmp_path: Path) -> None:
    """A filter of MeshLab that divides faces, and one of ours that closes a hole, leave 0 at new vertices and faces."""
    vertices, faces = icosphere(1)
    path = tmp_path / "scan.ply"
    vertex = [*xyz(vertices), ("double", "height", (vertices[:, 2] + 2.0).tolist())]
    path.write_bytes(ply_bytes(vertex, faces[1:].tolist(), [("int", "label", list(range(1, len(faces))))]))
    divided = session_report(
        path, tmp_path / "a.ply", ("meshing_surface_subdivision_midpoint", {"iterations": 1, "threshold": "0"})
    )
    assert divided["warnings"] == [
        "120 of 162 vertices are new, and have 0 as height",
        "316 of 316 faces are new, and have 0 as label",
    ]
    closed = session_report(path, tmp_path / "b.ply", ("meshing_close_holes_by_fairing", {"refine": False}))
    assert closed["warnings"] == ["1 of 80 faces are new, and have 0 as label"]


def test_surfaces_that_are_cut_at_seams_of_a_texture_are_named(tmp_path: Path) -> None:
    """A cut would open, and merged vertices have one texture coordinate each: a warning names the steps that avoid both."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]])
    of_vertices = [("float", name, [0.1, 0.2, 0.3, 0.6, 0.7, 0.8]) for name in "st"]
    path, plain = tmp_path / "uv.ply", tmp_path / "plain.ply"
    path.write_bytes(ply_bytes([*xyz(square), *of_vertices], [[0, 1, 2], [3, 4, 5]]))
    plain.write_bytes(ply_bytes(xyz(square), [[0, 1, 2], [3, 4, 5]]))
    merge: Given = ("meshing_remove_duplicate_vertices", {})
    convert: Given = ("compute_texcoord_transfer_vertex_to_wedge", {})
    names = ["'Convert PerVertex UV into PerWedge UV'", "'Remove Duplicate Vertices'"]
    cut = "2 border edges lie exactly on others, as at seams of a texture: the steps"
    for source, steps, warnings in (
        (path, [SMOOTH], [f"{cut} may open gaps there; begin with {names[0]} and {names[1]}"]),
        (plain, [SMOOTH], [f"{cut} may open gaps there; begin with {names[1]}"]),
        (path, [merge, SMOOTH], [f"{cut} distort the texture there; begin with {names[0]}"]),
        (path, [convert, merge, SMOOTH], []),
        (plain, [merge, SMOOTH], []),
        (path, [], []),
    ):
        output = tmp_path / f"{source.stem}{len(list(tmp_path.iterdir()))}.ply"
        assert session_report(source, output, *steps)["warnings"] == warnings


def test_normals_that_no_step_changes_keep_their_length(tmp_path: Path) -> None:
    """Normals of length 2 pass MeshLab to the bit where a filter only takes away a vertex that is there twice."""
    normals = 2.0 * np.array([[0.6, 0.0, 0.8], [0, 1, 0], [1, 0, 0], [0, 0, -1], [0, 0, -1]])
    path = tmp_path / "cloud.ply"
    vertex = [
        *xyz(TETRAHEDRON[0][[0, 1, 2, 3, 3]]),
        *(("double", c, normals[:, k].tolist()) for k, c in enumerate(("nx", "ny", "nz"))),
    ]
    path.write_bytes(ply_bytes(vertex, []))
    report = session_report(path, tmp_path / "out.ply", ("meshing_remove_duplicate_vertices", {}))
    after = read_file(staged_files(report)["out.ply"]).mesh
    assert len(after.vertices) == 4
    np.testing.assert_array_equal(after.vertex_normals, normals[:4])


@pytest.mark.parametrize("extension", [e for e in WRITABLE if e in READABLE])
def test_what_a_format_holds(tmp_path: Path, everything: Path, extension: str) -> None:
    """Each format gives back what it is said to hold, and exactly the rest of what the mesh has is named in a warning."""
    report = session_report(everything, tmp_path / f"copy.{extension}")
    holds = WRITABLE[extension].holds
    if extension in ("obj", "glb"):
        holds -= {"vertex texture coordinates"}  # where corners of faces have some
    has = attributes_of(read_file(everything).mesh)
    assert has == set(ATTRIBUTES) - {"edges", "custom attributes", "polygons"}
    text = " ".join(w.replace(".ply keeps them", "") for w in report["warnings"] if "does not hold" in w)
    named = {a for a in has if a in text}
    named |= {"face colours"} if "colours of faces are left out" in " ".join(report["warnings"]) else set()
    after = attributes_of(read_file(staged_files(report)[f"copy.{extension}"]).mesh)
    assert named >= has - holds
    assert named == has - after - ({"face opacities"} if extension == "3mf" else set())


@pytest.mark.parametrize("extension", UNCHECKED)
def test_formats_that_meshlab_reads_for_us_are_known_to_it(tmp_path: Path, extension: str) -> None:
    """No extension is offered with --unchecked that the installed MeshLab does not know."""
    path = tmp_path / f"missing.{extension}"
    with pytest.raises(pymeshlab.PyMeshLabException) as caught:
        pymeshlab.MeshSet().load_new_mesh(str(path))
    assert "Unknown format" not in str(caught.value)


@pytest.mark.parametrize("extension", ["obj", "off", "stl", "ply"])
def test_radii_and_opacities_are_kept_or_named(tmp_path: Path, extension: str) -> None:
    """Radii of vertices go into PLY files alone, opacities of vertices into OFF files too."""
    colours = [("uchar", c, [1, 2, 30, 250]) for c in ("red", "green", "blue", "alpha")]
    path = tmp_path / "radii.ply"
    path.write_bytes(ply_bytes([*xyz(), *colours, ("float", "radius", [0.5, 1.5, 2.5, 3.5])], TETRAHEDRON[1].tolist()))
    told = " ".join(session_report(path, tmp_path / f"out.{extension}")["warnings"])
    assert ("vertex radii" in told) == (extension != "ply")
    assert ("vertex opacities" in told) == (extension in ("obj", "stl"))


def test_normals_of_faces_are_kept_in_their_format_and_named_in_others(tmp_path: Path) -> None:
    """A PLY file may have normals of faces; no other format has."""
    path = tmp_path / "normals.ply"
    normals = [("float", c, [1.0] * 4) for c in ("nx", "ny", "nz")]
    path.write_bytes(ply_bytes(xyz(), TETRAHEDRON[1].tolist(), normals))
    report = session_report(path, tmp_path / "out.ply")
    assert report["warnings"] == []
    assert staged_files(report)["out.ply"].read_bytes() == path.read_bytes()
    told = " ".join(session_report(path, tmp_path / "out.obj")["warnings"])
    assert "face property 'float nx'; face property 'float ny'; face property 'float nz'" in told


def test_everything_is_kept_or_nothing_is_written(tmp_path: Path, everything: Path) -> None:
    """With --keep-all a loss is an error that names it: of the input, of the steps, of the format."""
    plain = tmp_path / "plain.ply"
    colours = [("uchar", c, [1, 2, 30, 250]) for c in ("red", "green", "blue", "alpha")]
    plain.write_bytes(ply_bytes([*xyz(), *colours], TETRAHEDRON[1].tolist()))
    assert session_report(plain, tmp_path / "a.ply", keep_all=True)["warnings"] == []
    with pytest.raises(OutputError, match=r"does not hold the vertex colours .*--keep-all"):
        session_report(plain, tmp_path / "a.stl", keep_all=True)
    assert session_report(everything, tmp_path / "b.ply", keep_all=True)["warnings"] == []
    lists = tmp_path / "lists.ply"
    lists.write_bytes(ply_bytes([*xyz(), ("list uchar int", "views", [[1], [2, 3], [], [4]])]))
    assert session_report(lists, tmp_path / "d.ply", keep_all=True)["warnings"] == []
    with pytest.raises(OutputError, match=r"'list int views'.*--keep-all"):
        session_report(lists, tmp_path / "d.obj", keep_all=True)
    select: tuple[Given, ...] = (("set_selection_all", {}), ("meshing_remove_selected_faces", {}))
    with pytest.raises(OutputError, match=r"has no faces any more.*--keep-all"):
        session_report(plain, tmp_path / "c.ply", *select, keep_all=True)


def test_custom_attributes_are_kept(tmp_path: Path) -> None:
    """Attributes that a recipe makes are written to PLY with their values, and named where the format cannot hold them."""
    steps: tuple[Given, ...] = (
        ("compute_new_custom_scalar_attribute_per_vertex", {"name": "double_x", "expr": "x*2"}),
        ("compute_new_custom_scalar_attribute_per_face", {"name": "mine", "expr": "7"}),
    )
    report = session_report(BONE, tmp_path / "out.ply", *steps)
    header = read_header(staged_files(report)["out.ply"])
    assert {"double_x"} <= {p.name for p in element(header, "vertex").properties}
    assert {"mine"} <= {p.name for p in element(header, "face").properties}
    report = session_report(BONE, tmp_path / "out.obj", *steps)
    assert any("custom attributes of the mesh; .ply keeps them" in w for w in report["warnings"])


def test_normals_of_a_cloud_are_kept(tmp_path: Path) -> None:
    """A point cloud keeps its normals in PLY and XYZ; without normals none are written."""
    points = TETRAHEDRON[0] + 0.25
    normals = [("double", c, [0.0, 0.0, 0.6, 1.0]) for c in ("nx", "ny", "nz")]
    (tmp_path / "with.ply").write_bytes(ply_bytes([*xyz(points), *normals], faces=()))
    (tmp_path / "without.ply").write_bytes(ply_bytes(xyz(points), faces=()))
    for extension, keeps in (("ply", 6), ("xyz", 6)):
        for name in ("with", "without"):
            report = session_report(tmp_path / f"{name}.ply", tmp_path / f"{name}-out.{extension}")
            file = staged_files(report)[f"{name}-out.{extension}"]
            if extension == "ply":
                columns = len(element(read_header(file), "vertex").properties)
            else:
                columns = len(file.read_text().splitlines()[0].split())
            assert columns == (keeps if name == "with" else 3)
    assert report["after"]["mean_spacing"] == pytest.approx((3 + np.sqrt(1)) / 4)


def test_normals_of_a_mesh_are_unit_vectors(tmp_path: Path) -> None:
    """MeshLab leaves sums of face normals after smoothing; what is written has length one."""
    normals = [("double", c, [0.0, 0.0, 0.0, 1.0]) for c in ("nx", "ny", "nz")]
    (tmp_path / "in.ply").write_bytes(ply_bytes([*xyz(), *normals]))
    report = session_report(tmp_path / "in.ply", tmp_path / "out.ply", SMOOTH)
    lengths = np.linalg.norm(properties(staged_files(report)["out.ply"])["normals"], axis=1)
    np.testing.assert_allclose(lengths, 1, rtol=1e-12)


@pytest.mark.parametrize("extension", ["ply", "obj"])
def test_vertices_that_are_not_finite_are_left_out_and_counted(tmp_path: Path, extension: str) -> None:
    """With them go their faces, and how many of each is said; a face with a vertex twice stays."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 1], [1, 1, 1]])
    faces = [[0, 1, 2], [0, 1, 3], [1, 1, 2], [1, 2, 4]]
    path = tmp_path / f"holes.{extension}"
    if extension == "ply":
        path.write_bytes(ply_bytes(xyz(points), faces))
    else:
        lines = ["v " + " ".join(map(str, p)) for p in points] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
        path.write_text("\n".join([*lines, ""]))
    report = session_report(path, tmp_path / "out.ply")
    told = f"{path.name}: left out: 1 vertex with a coordinate that is not finite, and 1 face with such a vertex"
    assert report["warnings"] == [told]
    assert (report["before"]["vertices"], report["before"]["faces"]) == (4, 3)
    report = session_report(path, tmp_path / "smooth.ply", SMOOTH)
    assert (report["after"]["vertices"], report["after"]["faces"]) == (4, 2)
    assert report["warnings"] == [told, f"MeshLab leaves out faces of {path.name} with a vertex twice (1)"]


@pytest.mark.parametrize("extension", ["ply", "obj", "off"])
def test_polygons_are_kept_or_named(tmp_path: Path, extension: str) -> None:
    """Quads stay quads in formats that have them, through filters of both kinds; one that has none is said to lose them."""
    points = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
    faces = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    path = tmp_path / f"quads.{extension}"
    if extension == "ply":
        path.write_bytes(ply_bytes(xyz(points), faces))
    elif extension == "obj":
        lines = ["v " + " ".join(map(str, p)) for p in points] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
        path.write_text("\n".join([*lines, ""]))
    else:
        rows = [" ".join(map(str, p)) for p in points] + ["4 " + " ".join(map(str, f)) for f in faces]
        path.write_text("\n".join(["OFF", "9 4 0", *rows, ""]))
    for number, step in enumerate([(), (SMOOTH,), (("apply_coord_taubin_fairing", {}),)]):
        for written in ("ply", "obj", "off"):
            report = session_report(path, tmp_path / f"out-{number}.{written}", *step)
            assert report["warnings"] == []
            assert (report["before"]["faces"], report["before"]["area"]) == (8, 4.0)
            polygon = read_file(staged_files(report)[f"out-{number}.{written}"]).mesh.face_attributes["polygon"]
            assert np.unique(polygon, return_counts=True)[1].tolist() == [2, 2, 2, 2]
    assert "does not hold the polygons" in session_report(path, tmp_path / "out.stl")["warnings"][0]
    report = session_report(path, tmp_path / "remeshed.ply", ("meshing_isotropic_explicit_remeshing", {"targetlen": "1edge"}))
    assert "after the steps the mesh has no polygons any more" in report["warnings"]
    assert "polygon" not in read_file(staged_files(report)["remeshed.ply"]).mesh.face_attributes


def test_filters_that_turn_faces_give_no_normals(tmp_path: Path) -> None:
    """Filters in MeshLab's menu of normals that make no vertex normals leave a scan without them, and nothing is lost."""
    steps: list[Given] = [(f"meshing_{what}", {}) for what in ("invert_face_orientation", "re_orient_faces_coherently")]
    (tmp_path / "in.ply").write_bytes(ply_bytes(xyz()))
    assert session_report(tmp_path / "in.ply", tmp_path / "out.stl", *steps, keep_all=True)["warnings"] == []
    computed = session_report(tmp_path / "in.ply", tmp_path / "lost.stl", ("compute_normal_per_vertex", {}))["warnings"]
    assert computed == ["lost.stl does not hold the vertex normals of the mesh; .ply keeps them"]


def test_quads_keep_their_texture_coordinates(tmp_path: Path) -> None:
    """An OBJ file with one quad keeps texture coordinates, texture and material, all of which MeshLab's default loses."""
    shutil.copy(SAMPLES / "TextureDouble_A.png", tmp_path / "t.png")
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 0 0\nmap_Kd t.png\n")
    corners = ["0.25 0.5", "0.75 0.5", "0.75 1", "0.25 1"]
    lines = ["mtllib m.mtl", "v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", *(f"vt {c}" for c in corners), "usemtl a"]
    (tmp_path / "quad.obj").write_text("\n".join([*lines, "f 1/1 2/2 3/3 4/4", ""]))
    (tmp_path / "out").mkdir()
    report = session_report(tmp_path / "quad.obj", tmp_path / "out" / "quad.obj")
    files = staged_files(report)
    uv = properties(files["quad.obj"])["wedge_tex_coord"]
    assert {tuple(c) for c in uv.tolist()} == {tuple(map(float, c.split())) for c in corners}
    assert "map_Kd t.png" in files["quad.obj.mtl"].read_text()
    assert files["t.png"].read_bytes() == (tmp_path / "t.png").read_bytes()


def test_files_that_are_no_meshes(tmp_path: Path) -> None:
    """What is no document, and a mesh of no vertices, is an error about the input."""
    (tmp_path / "a.dae").write_text("what\n")
    with pytest.raises(InputError, match="does not begin with '<'"):
        session_report(tmp_path / "a.dae", tmp_path / "a-out.ply")
    (tmp_path / "b.obj").write_text("g nothing here\n")
    with pytest.raises(InputError, match="no vertex could be read"):
        session_report(tmp_path / "b.obj", tmp_path / "b-out.ply")


def test_nothing_left_is_an_error(tmp_path: Path) -> None:
    """A recipe that deletes the whole mesh, or every layer, fails; no empty file is staged."""
    steps: tuple[Given, ...] = (("set_selection_all", {}), ("meshing_remove_selected_vertices", {}))
    with pytest.raises(StepFailedError, match="nothing is left"):
        session_report(BONE, tmp_path / "a.ply", *steps)
    with pytest.raises(StepFailedError, match="left no mesh"):
        session_report(BONE, tmp_path / "b.ply", ("delete_current_mesh", {}))
    assert names_in(tmp_path / "stage-a.ply" / "new") == set()


def test_a_result_that_is_not_finite_is_an_error(tmp_path: Path) -> None:
    """If a filter's arithmetic overflows, nothing is staged."""
    with pytest.raises(StepFailedError, match="not finite"):
        session_report(BONE, tmp_path / "a.ply", ("compute_coord_by_function", {"x": "x*1e308*1e308"}))
    assert names_in(tmp_path / "stage-a.ply" / "new") == set()


def test_layers_and_matrices_are_not_lost_in_silence(tmp_path: Path) -> None:
    """Layers that are not written are named; a matrix that a step leaves on the layer is applied, and that is said."""
    copy: Given = ("generate_copy_of_current_mesh", {})
    report = session_report(BONE, tmp_path / "a.ply", copy, copy)
    assert any("3 layers; only the current one" in w for w in report["warnings"])
    report = session_report(BONE, tmp_path / "c.ply", copy)
    assert not any("layers" in w for w in report["warnings"]), "what was read is in its file"
    move = ("compute_matrix_from_translation", {"axisx": 1.0, "freeze": False})
    report = session_report(BONE, tmp_path / "b.ply", move)
    assert any("matrix was applied" in w for w in report["warnings"])
    moved = properties(staged_files(report)["b.ply"])["vertices"] - properties(BONE)["vertices"]
    np.testing.assert_allclose(moved, np.tile([1.0, 0, 0], (1872, 1)), atol=1e-12)


@pytest.mark.parametrize(("freeze", "words"), [(False, "turned the faces over, as it mirrors"), (True, "is inside out")])
def test_a_mirror_that_turns_faces_over_is_named(tmp_path: Path, *, freeze: bool, words: str) -> None:
    """A matrix that mirrors turns the faces over, whether it stays on the layer or a step applies it."""
    (tmp_path / "in.ply").write_bytes(ply_bytes(xyz(TETRAHEDRON[0])))
    mirror: Given = ("compute_matrix_from_scaling_or_normalization", {"axisx": -1.0, "uniformflag": False, "freeze": freeze})
    assert [words in text for text in session_report(tmp_path / "in.ply", tmp_path / "out.ply", mirror)["warnings"]] == [True]


def test_a_matrix_that_mirrors_is_said_to_turn_the_faces(tmp_path: Path) -> None:
    """The warning about an applied matrix says that faces change their side, and the filter that it names turns them back."""
    mirror: Given = ("set_matrix", {"transformmatrix": np.diag([-1.0, 1, 1, 1]), "freeze": False})
    warnings = session_report(BONE, tmp_path / "a.ply", mirror)["warnings"]
    assert warnings[0].endswith(" and turned the faces over, as it mirrors: Invert Faces Orientation turns them back")
    report = session_report(BONE, tmp_path / "b.ply", mirror, ("meshing_invert_face_orientation", {"forceflip": True}))
    assert report["after"]["volume"] > 0.0


def test_normals_of_a_mirrored_mesh_are_numbers(tmp_path: Path) -> None:
    """MeshLab makes NaN of them: those of a mesh are computed from its faces, those of a cloud are named as lost."""
    mirror: Given = ("compute_matrix_from_scaling_or_normalization", {"axisx": -1.0, "uniformflag": False})
    vertex = [*xyz(TETRAHEDRON[0]), *(("float", name, [0.0, 0.6, 0.8, 1.0]) for name in ("nx", "ny", "nz"))]
    (tmp_path / "in.ply").write_bytes(ply_bytes(vertex))
    report = session_report(tmp_path / "in.ply", tmp_path / "out.ply", mirror)
    assert np.isfinite(read_file(staged_files(report)["out.ply"]).mesh.vertex_attributes["normals"]).all()
    (tmp_path / "cloud.ply").write_bytes(ply_bytes(vertex, []))
    report = session_report(tmp_path / "cloud.ply", tmp_path / "cloud-out.ply", mirror)
    assert "after the steps the mesh has no vertex normals any more" in report["warnings"]


def test_what_the_steps_take_away_is_named(tmp_path: Path, everything: Path) -> None:
    """Remeshing drops colours, scalars and texture coordinates in silence; the run says which."""
    report = session_report(everything, tmp_path / "out.ply", ("generate_resampled_uniform_mesh", {"cellsize": "10%"}))
    (gone,) = [w for w in report["warnings"] if w.startswith("after the steps the mesh has no ")]
    for name in ("vertex scalars", "face scalars", "wedge texture coordinates", "textures"):
        assert name in gone


@pytest.mark.parametrize("name", ["glb", "gltf"])
def test_scenes_are_merged_where_their_matrices_put_them(tmp_path: Path, name: str) -> None:
    """Both meshes of a glTF scene are written, each where its node's matrix puts it."""
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    for x in (0.0, 5.0):
        matrix = trimesh.transformations.translation_matrix([x, 0, 0])
        scene.add_geometry(trimesh.Trimesh(*TETRAHEDRON), transform=matrix)
    files = {"scene.glb": scene.export(file_type="glb")} if name == "glb" else scene.export(file_type="gltf")
    for file, data in files.items():
        (tmp_path / file.replace("model", "scene")).write_bytes(data)
    report = session_report(tmp_path / f"scene.{name}", tmp_path / "out.ply")
    assert report["after"]["components"] == 2
    vertices = properties(staged_files(report)["out.ply"])["vertices"]
    assert (vertices.min(), vertices[:, 0].max()) == (0.0, 6.0)


UTM = np.array([451_234.0, 4_512_345.0, 123.0])


@pytest.mark.parametrize(
    ("extension", "size", "verdict"),
    [
        ("stl", 1000.0, "nothing"),
        ("stl", 10.0, "warning"),
        ("stl", 0.1, "error"),
        ("glb", 10.0, "warning"),
        ("glb", 0.1, "error"),
        ("wrl", 1e-3, "nothing"),
        ("3mf", 1e-3, "nothing"),
        ("xyz", 1e-3, "nothing"),
        ("ply", 1e-3, "nothing"),
        ("obj", 1e-3, "nothing"),
    ],
)
def test_formats_of_few_digits_far_from_the_origin(tmp_path: Path, extension: str, size: float, verdict: str) -> None:
    """At UTM coordinates a format that rounds a little is warned about, one that destroys the mesh refused, by its digits."""
    (tmp_path / "in.ply").write_bytes(ply_bytes(xyz(TETRAHEDRON[0] * size + UTM)))
    output = tmp_path / f"out.{extension}"
    if verdict == "error":
        with pytest.raises(OutputError, match=r"rounds coordinates .*; \.ply keeps every digit"):
            session_report(tmp_path / "in.ply", output)
    else:
        report = session_report(tmp_path / "in.ply", output)
        assert any("rounds coordinates" in w for w in report["warnings"]) == (verdict == "warning")


def test_the_report_describes_the_files(tmp_path: Path) -> None:
    """Sizes and digests of input and output, and their side files, are those of the files."""
    report = session_report(SAMPLES / "bunny10k_textured.obj", tmp_path / "out.obj", SMOOTH)
    for part, names in (
        ("input", ["bunny10k_textured.mtl", "TextureDouble_A.png"]),
        ("output", ["TextureDouble_A.png", "out.obj.mtl"]),
    ):
        described = report[part]
        assert [Path(f["path"]).name for f in described["side_files"]] == names
    for file in report["staged"]:
        entries = [report["output"], *report["output"]["side_files"]]
        entry = next(e for e in entries if e["path"] == str(file.target))
        assert entry["sha256"] == sha256_of(file.staged)
        assert entry["bytes"] == file.staged.stat().st_size
    json.dumps({name: part for name, part in report.items() if name not in ("staged", "maps")}, allow_nan=False)


@pytest.mark.parametrize("moment", ["files.outputs.stage_textures", "files.outputs.to_disk", "running.shape_change.to_disk"])
def test_a_disk_that_is_full_at_any_moment_of_writing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str) -> None:
    """Whatever part of writing finds the disk full, it is an error about the output and no defect."""

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(f"pymeshfair.{moment}", full)
    shutil.copy(SAMPLES / "TextureDouble_A.png", tmp_path / "t.png")
    path = tmp_path / "mesh.ply"
    path.write_bytes(ply_bytes(xyz(), head="comment TextureFile t.png"))
    with pytest.raises(OutputError, match="no space left on device"):
        session_report(path, tmp_path / "out.ply", map=tmp_path / "map.ply")


def test_a_file_that_changes_before_its_checksum_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the record would have the checksum of a file that was not read."""

    def described(path: Path) -> dict[str, Any]:
        path.write_bytes(ply_bytes(xyz(), head="comment another"))
        return described_file(path)

    monkeypatch.setattr("pymeshfair.running.session.described_file", described)
    path = tmp_path / "mesh.ply"
    path.write_bytes(ply_bytes(xyz()))
    with pytest.raises(InputError, match="it changed while it was read"):
        session_report(path, tmp_path / "out.ply")


def test_a_later_step_is_changed_without_the_earlier_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the steps after the first one that differs are applied, and every bit is that of a run without what was kept."""
    mesh = read_file(BONE, allow_outside=False).mesh
    applied: list[str] = []
    apply = Document.apply

    def counted(document: Document, step: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        applied.append(step.filter.python_name)
        return apply(document, step)

    monkeypatch.setattr(Document, "apply", counted)

    def result_of(*steps: Given, earlier: RunCache | None = None) -> tuple[int, Any]:
        applied.clear()
        job = Job(recipe_of(*steps), BONE, tmp_path / "out.ply")
        stage = Path(tempfile.mkdtemp(dir=tmp_path))
        outcome = Session(job, stage, lambda event: None).carry_out(mesh, earlier=earlier)
        assert len(outcome.steps) == len(steps)
        return len(applied), outcome.result.vertices

    clean: Given = ("meshing_remove_duplicate_vertices", {})
    first: Given = ("apply_coord_implicit_fairing", {"iterations": 2})
    again, other = (("apply_coord_implicit_fairing", {"iterations": k}) for k in (1, 3))
    earlier = RunCache()
    for steps, expected in (
        ((clean, first), 2),  # nothing is kept; after the first step MeshLab has the mesh
        ((clean, first, again), 1),
        ((clean, first, other), 1),
        ((clean, first, again), 0),
        ((first, again), 2),
    ):
        count, vertices = result_of(*steps, earlier=earlier)
        assert count == expected
        np.testing.assert_array_equal(vertices, result_of(*steps)[1])


@pytest.mark.parametrize(("size", "cause"), [("auto", "an automatic amount needs faces"), ("6edge", "the mesh has no faces")])
def test_a_step_without_faces_names_the_step_that_left_none(tmp_path: Path, size: str, cause: str) -> None:
    """The error of a step that misses the faces says which step before it has removed them."""
    steps: list[Given] = [
        ("apply_coord_taubin_fairing", {}),
        ("meshing_remove_connected_component_by_diameter", {"mincomponentdiag": "200%"}),
        ("apply_coord_implicit_fairing", {"detail_size": size}),
    ]
    with pytest.raises(
        StepFailedError, match=rf"^step 3 of 3, .*: {cause}.*; step 2, 'Remove Isolated pieces .*', left no faces$"
    ):
        session_report(BONE, tmp_path / "out.ply", *steps)


def test_a_run_from_kept_steps_names_the_step_that_left_no_faces(tmp_path: Path) -> None:
    """The error is the same in a second run, which takes the first steps from the cache."""
    steps: list[Given] = [
        ("meshing_remove_connected_component_by_diameter", {"mincomponentdiag": "200%", "removeunref": False}),
        ("compute_selection_by_grid_per_vertex", {"side": "1%"}),
        ("apply_coord_implicit_fairing", {}),
    ]
    mesh, earlier = read_file(BONE).mesh, RunCache()
    for stage in (tmp_path / "first", tmp_path / "second"):
        session = Session(Job(recipe_of(*steps), BONE, tmp_path / "out.ply"), stage, lambda event: None)
        with pytest.raises(StepFailedError, match=r"^step 3 of 3, .*; step 1, 'Remove Isolated pieces .*', left no faces$"):
            session.carry_out(mesh, earlier=earlier)


def test_a_step_without_points_names_the_step_that_left_none(tmp_path: Path) -> None:
    """Of 200 points spread in a cube the recipe for clouds removes all, and the next step's error says which step did."""
    (tmp_path / "cloud.xyz").write_text("".join("{} {} {}\n".format(*p) for p in np.random.default_rng(0).random((200, 3))))
    steps = [(step.filter.python_name, dict(step.values)) for step in load_recipe("clean_point_cloud").script.steps]
    with pytest.raises(StepFailedError, match=r"^step 4 of 7, .*; step 3, 'Delete Selected Vertices', left no points$"):
        session_report(tmp_path / "cloud.xyz", tmp_path / "out.ply", *steps)


def test_a_mesh_without_size_is_the_cause_and_not_the_detail_size(tmp_path: Path) -> None:
    """Where all vertices lie at one place a length in mean edges is 0, and the error says why."""
    point = tmp_path / "point.ply"
    point.write_bytes(ply_bytes(xyz(np.zeros((3, 3))), [[0, 1, 2]]))
    with pytest.raises(StepFailedError, match=r": the mesh has no edge with a length, so that detail_size is 0: nothing to do$"):
        session_report(point, tmp_path / "out.ply", ("apply_coord_implicit_fairing", {"detail_size": "6edge"}))


@pytest.mark.parametrize(
    ("raised", "told"),
    [(KeyError("x"), "KeyError: 'x'"), (AssertionError(), "AssertionError"), (FilterInputError("bad mesh"), "bad mesh")],
)
def test_an_unexpected_error_of_a_filter_is_told_with_its_kind(tmp_path: Path, raised: Exception, told: str) -> None:
    """The name of its class comes first, but for errors that are meant for users."""

    @mesh_filter(name="Odd One", classes=FilterClass.OTHER)
    def odd_one(layer: Layer) -> Edit:
        """Fails."""
        raise raised

    job = Job(Recipe("test", Script((Step(odd_one),))), BONE, tmp_path / "out.ply")
    with pytest.raises(StepFailedError) as caught:
        Session(job, tmp_path, lambda event: None).run()
    assert caught.value.reason == told


def test_a_process_keeps_nothing_of_a_run(tmp_path: Path) -> None:
    """The meshes of a run that is over are freed at once, so that a worker does not grow from run to run."""
    (tmp_path / "stage" / "new").mkdir(parents=True)
    session = Session(Job(recipe_of(SMOOTH), BONE, tmp_path / "a.ply"), tmp_path / "stage", lambda event: None)
    document = weakref.ref(session._document)
    gc.disable()
    try:
        session.run()
        del session
        assert document() is None
    finally:
        gc.enable()
    assert not kernel._listeners
