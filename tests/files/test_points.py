"""Texts of points: what their columns are, and the same text again; grids of scanners."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData

from ..running.runs import SAMPLES
from .round_trips import assert_same, meshlab, read, save

#: a file, and what it holds besides places: the same text comes out again
TEXTS: tuple[tuple[str, str, dict[str, list[Any]]], ...] = (
    ("a.xyz", "1.5 2.0 3.0\n4.5 5.0 6.25\n", {}),
    ("a.xyz", "1.5 2.0 3.0 0.0 0.0 1.0\n4.5 5.0 6.0 0.0 1.0 0.0\n", {"normals": [[0, 0, 1], [0, 1, 0]]}),
    ("a.asc", "1.5 2.0 3.0 0 0 1\n4.5 5.0 6.0 0 255 0\n", {"colors": [[0, 0, 1, 255], [0, 255, 0, 255]]}),
    ("a.txt", "1.5 2.0 3.0 0.5\n4.5 5.0 6.0 -7.25\n", {"intensity": [0.5, -7.25]}),
    (
        "a.pts",
        "2\n1.5 2.0 3.0 -1200 1 2 3\n4.5 5.0 6.0 70 4 5 6\n",
        {"intensity": [-1200, 70], "colors": [[1, 2, 3, 255], [4, 5, 6, 255]]},
    ),
    (
        "a.xyz",
        "1.5 2.0 3.0 1 2 3 0.0 0.0 1.0\n4.5 5.0 6.0 4 5 6 0.0 1.0 0.0\n",
        {"colors": [[1, 2, 3, 255], [4, 5, 6, 255]], "normals": [[0, 0, 1], [0, 1, 0]]},
    ),
    ("a.xyz", "1.5 2.0 3.0 7 0.5\n4.5 5.0 6.0 8 0.25\n", {"column_4": [7, 8], "column_5": [0.5, 0.25]}),
    (
        "a.txt",
        "Scan_angle,Z,X,Y,Nx,Ny,Nz\n7,3.0,1.5,2.0,0.0,0.0,1.0\n-8,6.0,4.5,5.0,1.0,0.0,0.5\n",
        {"scan_angle": [7, -8], "normals": [[0, 0, 1], [1, 0, 0.5]]},
    ),
    ("a.xyz", "//X Y Z R G B\n2\n1.5 2.0 3.0 4 5 6\n4.5 5.0 6.0 7 8 9\n", {"colors": [[4, 5, 6, 255], [7, 8, 9, 255]]}),
    ("a.xyz", "//\n1.5 2.0 3.0\n4.5 5.0 6.25\n", {}),
    ("a.asc", "# x y z intensity\n1.5 2.0 3.0 0.5\n4.5 5.0 6.0 0.25\n", {"intensity": [0.5, 0.25]}),
    ("a.xyz", "1.5 2.0 3.0 0 0 0\n4.5 5.0 6.0 0 0 0\n", {"colors": [[0, 0, 0, 255], [0, 0, 0, 255]]}),
    ("a.xyz", "1.5 2.0 3.0 0 1 1\n4.5 5.0 6.0 0 0 0\n", {"colors": [[0, 1, 1, 255], [0, 0, 0, 255]]}),
    # numbers of no length near 1 are no normals
    (
        "a.xyz",
        "1.5 2.0 3.0 1000.5 2 3.5\n4.5 5.0 6.0 7.5 2 3.25\n",
        {"column_4": [1000.5, 7.5], "column_5": [2, 2], "column_6": [3.5, 3.25]},
    ),
    (
        "a.xyz",
        "1.5 2.0 3.0 1 2 3 0.5 0.25 2.0\n4.5 5.0 6.0 4 5 6 0.0 3.0 0.0\n",
        {
            "column_4": [1, 4],
            "column_5": [2, 5],
            "column_6": [3, 6],
            "column_7": [0.5, 0.0],
            "column_8": [0.25, 3.0],
            "column_9": [2.0, 0.0],
        },
    ),
    # shares that are no levels of 8 bits stay as they are
    (
        "a.txt",
        "x y z r g b\n1.5 2.0 3.0 0.25 0.5 1.0\n4.5 5.0 6.0 0.0 0.1 0.9\n",
        {"colors": [[64, 128, 255, 255], [0, 26, 230, 255]]},
    ),
)


@pytest.mark.parametrize(("name", "text", "attributes"), TEXTS)
def test_columns_are_kept(tmp_path: Path, name: str, text: str, attributes: dict[str, list[Any]]) -> None:
    """Columns are attributes by their titles or their number, whole numbers stay whole; the same text is written again."""
    mesh = read(tmp_path / name, text)
    assert mesh.vertices[0].tolist() == [1.5, 2, 3]
    assert {key: values.tolist() for key, values in mesh.vertex_attributes.items()} == attributes
    (tmp_path / "out").mkdir()
    assert save(mesh, tmp_path / "out" / name) == ()
    assert (tmp_path / "out" / name).read_text() == text
    half = mesh.part(np.array([False, True]))
    save(half, tmp_path / "out" / f"half-{name}")
    assert_same(read_file(tmp_path / "out" / f"half-{name}").mesh, half)


def test_columns_that_are_left_keep_their_titles(tmp_path: Path) -> None:
    """Without one of its columns a text has titles for the others, which may be in any order."""
    mesh = read(tmp_path / "a.txt", "Z;X;Angle;Y;Label\n3.0;1.5;7;2.0;8\n")
    save(mesh.with_attributes({"angle": None}), tmp_path / "b.txt")
    assert (tmp_path / "b.txt").read_text() == "z;x;y;label\n3.0;1.5;2.0;8\n"
    assert read_file(tmp_path / "b.txt").mesh.vertices.tolist() == [[1.5, 2.0, 3.0]]
    for name, mark in (("c.xyz", "# "), ("d.xyz", "//")):  # titles in a comment stay in one
        mesh = read(tmp_path / "a.xyz", f"{mark}X Y Z I\n1.5 2.0 3.0 7\n")
        save(mesh.with_attributes({"intensity": None}), tmp_path / name)
        assert (tmp_path / name).read_text() == f"{mark}x y z\n1.5 2.0 3.0\n"


def test_booleans_are_written_as_numbers(tmp_path: Path) -> None:
    """A column that a program replaces by booleans holds 1 and 0."""
    mesh = read(tmp_path / "a.xyz", "x y z flag\n1.5 2.0 3.0 7\n4.5 5.0 6.0 7\n")
    save(mesh.with_attributes({"flag": np.array([True, False])}), tmp_path / "b.xyz")
    assert (tmp_path / "b.xyz").read_text() == "x y z flag\n1.5 2.0 3.0 1\n4.5 5.0 6.0 0\n"


def test_numbers_whose_squares_overflow_are_no_normals(tmp_path: Path) -> None:
    """They are read as any other numbers, without a warning of numpy."""
    (tmp_path / "a.xyz").write_text("1e300 0 0\n0 1e300 0\n")
    assert read_file(tmp_path / "a.xyz").mesh.vertices.max() == 1e300


def test_what_a_text_cannot_hold_is_named(tmp_path: Path) -> None:
    """A cloud of another format is written with its normals, or as .pts with its colours; the rest is named."""
    rng = np.random.default_rng(1)
    levels = np.full((9, 4), 255, np.uint8)
    attributes: dict[str, Any] = {
        "normals": rng.random((9, 3)),
        "colors": levels,
        "intensity": rng.random(9),
        "scalars": rng.random(9),
    }
    mesh = MeshData(vertices=rng.random((9, 3)), vertex_attributes=attributes)
    assert save(mesh, tmp_path / "a.xyz") == (
        "a.xyz does not hold the vertex scalars of the mesh; .ply keeps them",
        "a.xyz: it does not hold vertex colours, intensity of the mesh; .ply keeps them",
    )
    theirs, _meshes = meshlab(tmp_path / "a.xyz")
    np.testing.assert_array_equal(theirs.vertex_matrix(), mesh.vertices)
    np.testing.assert_array_equal(theirs.vertex_normal_matrix(), mesh.vertex_normals)
    assert save(mesh, tmp_path / "a.pts")[1] == "a.pts: it does not hold vertex normals of the mesh; .ply keeps them"
    again = read_file(tmp_path / "a.pts").mesh
    np.testing.assert_array_equal(again.vertex_attributes["intensity"], attributes["intensity"])
    np.testing.assert_array_equal(again.vertex_attributes["colors"], levels)


@pytest.mark.parametrize(
    ("source", "output", "text", "warnings"),
    [
        ("1.5 2.0 3.0 0.0 0.0 1.0\n", "a.xyz b.pts", "1\n1.5 2.0 3.0\n", "it does not hold vertex normals of the mesh"),
        ("1\n1.5 2.0 3.0 7 4 5 6\n", "a.pts b.xyz", "1.5 2.0 3.0\n", "it does not hold vertex colours, intensity of the mesh"),
        ("1\n1.5 2.0 3.0 7 4 5 6\n", "a.pts b.pts", "1\n1.5 2.0 3.0 7 4 5 6\n", ""),
        ("1.5 2.0 3.0 0 4 5\n", "a.txt b.xyz", "1.5 2.0 3.0 0 4 5\n", ""),
        (
            "x y z r g b\n1.5 2.0 3.0 0.25 0.5 1\n",
            "a.xyz b.pts",
            "1\n1.5 2.0 3.0 64 128 255\n",
            "the decimals of colours of the text",
        ),
    ],
)
def test_pts_and_xyz_have_their_own_layouts(tmp_path: Path, source: str, output: str, text: str, warnings: str) -> None:
    """A .pts file begins with the count and has intensity and colours, an .xyz file has no count; what is left out is named."""
    name, target = output.split()
    told = save(read(tmp_path / name, source), tmp_path / target)
    assert (tmp_path / target).read_text() == text
    assert len(told) == bool(warnings)
    assert warnings in " ".join(told)


def test_comments_and_titles_do_not_say_how_numbers_are_separated(tmp_path: Path) -> None:
    """Commas and semicolons in comments do not count, and titles between commas may have blanks."""
    for name, comment in (("b.xyz", "# scanned by A, B\n"), ("c.xyz", "# a, b; c\n")):
        save(read(tmp_path / "a.xyz", comment + "1.5 2.0 3.0\n"), tmp_path / name)
        assert (tmp_path / name).read_text() == "1.5 2.0 3.0\n"
    text = "GPS Time,X,Y,Z\n7.5,1.5,2.0,3.0\n"
    mesh = read(tmp_path / "a.txt", text)
    assert mesh.vertices.tolist() == [[1.5, 2.0, 3.0]]
    assert mesh.vertex_attributes["gps_time"].tolist() == [7.5]
    assert save(mesh, tmp_path / "b.txt") == ()
    assert (tmp_path / "b.txt").read_text() == text


def test_a_point_set_of_expe(tmp_path: Path) -> None:
    """A binary point set has what MeshLab reads of it; the sample of the wheel is one of a text."""
    rng = np.random.default_rng(1)
    rows = np.zeros(5, [("p", "<f4", 3), ("n", "<f4", 3), ("r", "<f4"), ("c", "u1", 4), ("x", "<u2")])
    rows["p"], rows["n"], rows["r"], rows["c"] = rng.random((5, 3)), rng.random((5, 3)), rng.random(5), 77
    head = "[Expe/PointSet/Binary/0.1]\nproperty position 12\nproperty normal 12\nproperty radius 4\nproperty color 4\n"
    path = tmp_path / "a.pts"
    mesh = read(path, f"{head}property other 2\nnofpoints 5\ndata\n".encode() + rows.tobytes())
    theirs, _meshes = meshlab(path)
    np.testing.assert_array_equal(mesh.vertices, theirs.vertex_matrix())
    np.testing.assert_array_equal(mesh.vertex_normals, theirs.vertex_normal_matrix())
    np.testing.assert_array_equal(mesh.vertex_attributes["colors"], np.full((5, 4), 77))
    np.testing.assert_array_equal(mesh.vertex_attributes["radii"], rows["r"])
    assert mesh.source is not None
    assert mesh.source.extras == ("property 'other'",)
    path = SAMPLES / "chameleon.pts"
    theirs, _meshes = meshlab(path)
    np.testing.assert_array_equal(read_file(path).mesh.vertices, theirs.vertex_matrix())


def grid(columns: int, rows: int, matrix: np.ndarray, points: np.ndarray) -> str:
    """One grid of a PTX file."""
    head = [str(columns), str(rows), "1 2 3", "1 0 0", "0 1 0", "0 0 1", *(" ".join(map(repr, r)) for r in matrix.tolist())]
    return "\n".join([*head, *(" ".join(map(repr, r)) for r in points.tolist()), ""])


def test_grids_of_a_scanner(tmp_path: Path) -> None:
    """Each grid is where its matrix puts it, with intensities and colours; places without a measurement are named."""
    rng = np.random.default_rng(1)
    points = np.concatenate([rng.random((6, 4)), rng.integers(0, 256, (6, 3))], axis=1)
    points[2, :3] = 0.0
    turn = np.array([[0.0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [10, 20, 30, 1]])
    path = tmp_path / "a.ptx"
    path.write_text(grid(2, 3, np.eye(4), points) + grid(3, 2, turn, points[:, :4]))
    reading = read_file(path)
    mesh, left = reading.mesh, np.arange(6) != 2
    white = "1 of its 2 grids have no colours, and are white"
    assert reading.doubts == ("2 positions in its grids have no measured point and are left out", white)
    assert mesh.source is not None
    assert mesh.source.extras == ("the scanner's positions (2)",)
    places = points[left, :3]
    np.testing.assert_allclose(mesh.vertices, np.concatenate([places, places @ turn[:3, :3] + [10, 20, 30]]), atol=1e-15)
    np.testing.assert_array_equal(mesh.vertex_attributes["intensity"], np.tile(points[left, 3], 2))
    np.testing.assert_array_equal(mesh.vertex_attributes["colors"][:5, :3], points[left, 4:])
    assert (mesh.vertex_attributes["colors"][5:] == 255).all()
    meshes = pymeshlab.MeshSet()
    path.write_text(grid(3, 2, turn, points))
    meshes.load_new_mesh(str(path), pointsonly=True)
    theirs = meshes.current_mesh()
    theirs_places = np.c_[theirs.vertex_matrix(), np.ones(theirs.vertex_number())] @ theirs.transform_matrix().T
    ours = read_file(path).mesh.vertices
    for place in theirs_places[:, :3]:
        assert np.abs(ours - place).max(axis=1).min() < 1e-5


def test_an_attribute_named_like_a_coordinate_does_not_replace_it(tmp_path: Path) -> None:
    """Recipes may name attributes as they like: one with the name x is named as lost, and the coordinates are written."""
    mesh = MeshData(vertices=np.eye(3), vertex_attributes={"x": np.full(3, 7.0)})
    assert save(mesh, tmp_path / "a.xyz") == ("a.xyz: it does not hold x of the mesh; .ply keeps them",)
    np.testing.assert_array_equal(read_file(tmp_path / "a.xyz").mesh.vertices, np.eye(3))


def test_an_attribute_named_like_a_channel_does_not_replace_it(tmp_path: Path) -> None:
    """It is named as lost, and the colours are written."""
    colors = np.full((3, 4), 255, np.uint8)
    mesh = MeshData(vertices=np.eye(3), vertex_attributes={"colors": colors, "red": np.full(3, 7)})
    assert save(mesh, tmp_path / "a.pts") == ("a.pts: it does not hold red of the mesh; .ply keeps them",)
    np.testing.assert_array_equal(read_file(tmp_path / "a.pts").mesh.vertex_attributes["colors"], colors)
