"""Meshes of edges: what is read of them, and in which files they are whole."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair.files.errors import InputError, OutputError
from pymeshfair.files.formats import READABLE, WRITABLE
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_tables import read_header

from ..files.plys import Element, ply_file
from .runs import SAMPLES, Given, element, session_report, staged_files

#: a square, its diagonals' crossing, and a branch
POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.25]]) + 1 / 3
EDGES = np.array([[0, 1], [2, 1], [2, 3], [3, 0], [4, 1], [4, 0]], dtype=np.int32)
SMOOTH = ("apply_coord_curve_smoothing", {"method": "explicit", "iterations": 2})


def obj_text(*polylines: str) -> str:
    """The points as an OBJ file with these polylines at its end."""
    return "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in POINTS.tolist()) + "".join(f"l {line}\n" for line in polylines)


def read_edges(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32], Any]:
    """The vertices and edges that plain pymeshlab reads, and the mesh set that holds them."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.edge_matrix(), meshes


@pytest.fixture
def curves(tmp_path: Path) -> Path:
    """The curves as an OBJ file with one edge a line, as MeshLab writes them."""
    path = tmp_path / "curves.obj"
    path.write_text(obj_text(*(f"{a + 1} {b + 1}" for a, b in EDGES)))
    return path


@pytest.mark.parametrize("extension", [e for e in WRITABLE if e in READABLE])
def test_edges_are_kept_or_the_mesh_is_not_written(tmp_path: Path, curves: Path, extension: str) -> None:
    """PLY, OBJ, OFF and GLB give back every edge in its order and direction, PLY and OBJ to MeshLab, too; a format without edges
    is refused, not emptied.
    """
    output = tmp_path / f"copy.{extension}"
    if "edges" not in WRITABLE[extension].holds:
        with pytest.raises(OutputError, match=r"made of edges, which the format cannot hold; \.ply and \.obj keep them"):
            session_report(curves, output)
        return
    report = session_report(curves, output)
    assert report["warnings"] == []
    staged = staged_files(report)[output.name]
    mesh = read_file(staged).mesh
    np.testing.assert_allclose(mesh.vertices, POINTS, rtol=WRITABLE[extension].rounding, atol=1e-15)
    np.testing.assert_array_equal(mesh.edges, EDGES)
    if extension in ("ply", "obj"):
        vertices, edges, _ = read_edges(staged)
        np.testing.assert_allclose(vertices, POINTS, rtol=0, atol=1e-15)
        np.testing.assert_array_equal(edges, EDGES)


def test_edges_beside_faces_and_a_texture_are_kept(tmp_path: Path) -> None:
    """A textured mesh with edges keeps faces, texture coordinates and edges in PLY; in STL the edges are named as lost."""
    for name in ("bunny10k_textured.mtl", "TextureDouble_A.png"):
        shutil.copy(SAMPLES / name, tmp_path)
    source = tmp_path / "both.obj"
    source.write_text((SAMPLES / "bunny10k_textured.obj").read_text().rstrip("\n") + "\nl 1 2\nl 2 3\n")
    (tmp_path / "out").mkdir()
    report = session_report(source, tmp_path / "out" / "out.ply")
    _, edges, meshes = read_edges(staged_files(report)["out.ply"])
    np.testing.assert_array_equal(edges, [[0, 1], [1, 2]])
    mesh = meshes.current_mesh()
    assert mesh.face_number() == report["before"]["faces"] > 9_000
    assert mesh.has_wedge_tex_coord()
    report = session_report(source, tmp_path / "out" / "out.stl")
    assert any("does not hold the edges" in warning for warning in report["warnings"])


def test_a_run_smooths_a_ply_file_of_edges(tmp_path: Path, curves: Path) -> None:
    """From PLY to PLY through the filter: vertices move, edges are those of the input."""
    first = staged_files(session_report(curves, tmp_path / "first.ply"))["first.ply"]
    report = session_report(first, tmp_path / "second.ply", SMOOTH)
    vertices, edges, _ = read_edges(staged_files(report)["second.ply"])
    np.testing.assert_array_equal(edges, EDGES)
    assert np.abs(vertices - POINTS).max() > 0.1


def test_a_section_has_no_normals_though_its_mesh_had(tmp_path: Path) -> None:
    """MeshLab gives a section sums of the normals of the faces that it cut; no file takes them for its normals."""
    section = ("generate_polyline_from_planar_section", {"relativeto": "Bounding box center"})
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / "bone.ply"))
    meshes.generate_polyline_from_planar_section(relativeto="Bounding box center")
    assert np.linalg.norm(meshes.current_mesh().vertex_normal_matrix(), axis=1).max() > 2
    report = session_report(SAMPLES / "bone.ply", tmp_path / "section.ply", section, SMOOTH)
    header = read_header(staged_files(report)["section.ply"])
    assert [p.name for p in element(header, "vertex").properties][:3] == ["x", "y", "z"]
    assert not {"nx", "ny", "nz"} & {p.name for p in element(header, "vertex").properties}
    text = staged_files(session_report(SAMPLES / "bone.ply", tmp_path / "section.obj", section))["section.obj"].read_text()
    assert "\nvn " not in text


def test_normals_that_curves_came_with_are_kept(tmp_path: Path) -> None:
    """A file of edges with normals gives them back, to the digit, through filters of both kinds."""
    normals = np.tile([0.6, 0.0, 0.8], (len(POINTS), 1))
    source = tmp_path / "curves.ply"
    rows = np.concatenate([POINTS, normals], axis=1).tolist()
    vertex = Element("vertex", [("double", name) for name in ("x", "y", "z", "nx", "ny", "nz")], rows)
    edge = Element("edge", [("int", "vertex1"), ("int", "vertex2")], EDGES.tolist())
    source.write_bytes(ply_file([vertex, edge]))
    moved: Given = ("compute_coord_by_function", {"x": "x+1"})
    for number, step in enumerate((SMOOTH, moved)):
        report = session_report(source, tmp_path / f"out{number}.ply", step)
        assert report["warnings"] == []
        _, edges, meshes = read_edges(staged_files(report)[f"out{number}.ply"])
        np.testing.assert_array_equal(edges, EDGES)
        np.testing.assert_array_equal(meshes.current_mesh().vertex_normal_matrix(), normals)


def test_a_report_measures_the_edges_of_curves(tmp_path: Path, curves: Path) -> None:
    """The mean edge is that of the curves, and no vertex of theirs counts as unreferenced."""
    before = session_report(curves, tmp_path / "out.ply")["before"]
    lengths = np.linalg.norm(POINTS[EDGES[:, 1]] - POINTS[EDGES[:, 0]], axis=1)
    assert before["mean_edge"] == pytest.approx(lengths.mean(), rel=1e-14)
    assert (before["unreferenced_vertices"], before["components"], before["edges"]) == (0, 1, 6)


@pytest.mark.parametrize(
    "lines",
    [
        ["1 2 3 4 1", "5 2", "5 1"],
        ["-5 -4 -3 -2 -5", "-1 2", "5/1 1/2"],
        ["1 2 \\\n3 \\\r\n 4 1", "5 \\\n2", "\\\n5 1"],
    ],
)
@pytest.mark.parametrize("faces", ["", "f 1 2 3\n"])
def test_long_and_relative_polylines_are_read_whole(tmp_path: Path, lines: list[str], faces: str) -> None:
    """Of `l 1 2 3` MeshLab reads one edge, of `l -2 -1` none that exists; a run reads all of them, without a warning."""
    source = tmp_path / "long.obj"
    source.write_text(obj_text(*lines) + faces)
    _, plain, meshes = read_edges(source)
    assert not np.array_equal(np.sort(plain, axis=1), np.sort(EDGES, axis=1))
    del meshes
    report = session_report(source, tmp_path / "out.ply")
    assert report["warnings"] == []
    _, edges, _ = read_edges(staged_files(report)["out.ply"])
    expected = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 1], [4, 0]]
    np.testing.assert_array_equal(edges, expected)


def test_long_polylines_beside_materials_are_read_whole(tmp_path: Path) -> None:
    """A material file makes no difference to that."""
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 0 0\n")
    source = tmp_path / "long.obj"
    source.write_text("mtllib m.mtl\n" + obj_text("1 2 3 4", "5 2") + "usemtl a\nf 1 2 3\n")
    report = session_report(source, tmp_path / "out.ply")
    assert report["warnings"] == []
    _, edges, _ = read_edges(staged_files(report)["out.ply"])
    np.testing.assert_array_equal(edges, [[0, 1], [1, 2], [2, 3], [4, 1]])


@pytest.mark.parametrize("line", ["1 6", "0 1", "-6 1", "1 x", "1 2 3 9/9"])
def test_polylines_of_other_vertices_are_refused(tmp_path: Path, line: str) -> None:
    """MeshLab would read past the end of the vertices; the line is named instead."""
    source = tmp_path / "bad.obj"
    source.write_text(obj_text("1 2", line))
    with pytest.raises(
        InputError, match=f"its line 7, 'l {line}', (names a vertex that is not among those before it|has something else)"
    ):
        session_report(source, tmp_path / "out.ply")


def test_relative_numbers_count_back_from_the_line(tmp_path: Path) -> None:
    """-1 is the last vertex before the line, not of the file; comments and texture coordinates are no vertices."""
    source = tmp_path / "in.obj"
    source.write_bytes(b"v 0 0 0\r\nvt 0 0\r\nv 1 0 0\r\nl -2/1 -1/1 # two\r\nv 2 0 0\r\nusemtl x\r\nl -1 -2 -3\r\n")
    np.testing.assert_array_equal(read_file(source).mesh.edges, [[0, 1], [2, 1], [1, 0]])


def test_edges_of_deleted_vertices_are_gone(tmp_path: Path, curves: Path) -> None:
    """MeshLab keeps such edges with ends that do not exist; the others stay, and the run does not speak of coordinates."""
    select = ("compute_selection_by_condition_per_vertex", {"condselect": "vi==1"})
    report = session_report(curves, tmp_path / "out.obj", select, ("meshing_remove_selected_vertices", {}), SMOOTH)
    mesh = read_file(staged_files(report)["out.obj"]).mesh
    assert mesh.edges.tolist() == [[1, 2], [2, 0], [3, 0]]
