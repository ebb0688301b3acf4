"""OBJ files: read as MeshLab reads them where it is right, and written as they were but for what has changed."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from pymeshfair.declaration import Edit
from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData, Texture, apply_edit, moved

from ..running.runs import SAMPLES, SMOOTH, session_report, staged_files
from .round_trips import assert_same, meshlab, read, save

IMAGE = SAMPLES / "TextureDouble_A.png"
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
WEDGES = "wedge_texture_coordinates"
#: materials, groups, a polygon, a continued line, comments, an old keyword, unused normals: all that a file may have
WHOLE = """\
# a house
mtllib  two words.mtl
o house
v 0 0 0 1.0
v 2.50 0 \\
 0 1.0
v\t2 2 0 1.0  # a corner
v 0 2 0 1.0
v 1 1 2 1.0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
g floor
s 1
usemtl brick wall
f 1/1 2/2 3/3 4/4

g roof
usemtl tiles
f -5/1 -4/2 -1/3
f 2/1 3/2 5/3
f 3/1 4/2 5/3
usemtl plain
f 4 1 5
l 1 2 5
p 1
"""
MATERIALS = """\
newmtl brick wall
Ka 0.1 0.1 0.1
Kd 0.5 0.25 1
map_Kd walls/brick.png
map_Bump -bm 0.5 bump.png
newmtl tiles
Kd 1 0 0
map_Kd tiles.png
newmtl plain
Kd 0.2 0.4 0.6
"""


def house(folder: Path) -> Path:
    """The house with its materials and images."""
    (folder / "walls").mkdir(parents=True)
    for name in ("walls/brick.png", "tiles.png", "bump.png"):
        shutil.copy(IMAGE, folder / name)
    (folder / "two words.mtl").write_text(MATERIALS)
    path = folder / "house.obj"
    path.write_text(WHOLE)
    return path


def test_the_parts_of_a_file(tmp_path: Path) -> None:
    """Polygons, edges, textures, texture coordinates and colours are what the text says; the rest is named."""
    mesh = read_file(house(tmp_path)).mesh
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [2.5, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 2]])
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    assert mesh.edges.tolist() == [[0, 1], [1, 4]]
    assert mesh.face_attributes["polygon"].tolist() == [0, 0, -1, -1, -1, -1]
    assert [t.name for t in mesh.textures] == ["walls/brick.png", "tiles.png"]
    assert mesh.face_attributes["texture"].tolist() == [0, 0, 1, 1, 1, -1]
    wedges = mesh.face_attributes["wedge_texture_coordinates"]
    assert wedges[:3].tolist() == [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]], [[0, 0], [1, 0], [1, 1]]]
    assert mesh.face_attributes["colors"][[0, 2, 5]].tolist() == [[127, 63, 255, 255], [255, 0, 0, 255], [51, 102, 153, 255]]
    assert mesh.source is not None
    assert mesh.source.extras == (
        "groups (2)",
        "objects (1)",
        "smoothing groups (1)",
        "comments (2)",
        "point elements (1)",
        "faces without texture coordinates, which get 0 0 (1)",
        "map_Bump of the material file two words.mtl",
    )


@pytest.mark.parametrize("name", ["airplane", "bunny", "bunny10k_textured", "cow", "cube"])
def test_samples_are_those_of_meshlab(name: str) -> None:
    """Vertices, faces, normals, texture coordinates, textures and colours of real files are MeshLab's, to the bit."""
    path = SAMPLES / f"{name}.obj"
    mesh, (theirs, _meshes) = read_file(path).mesh, meshlab(path)
    np.testing.assert_array_equal(mesh.vertices, theirs.vertex_matrix())
    np.testing.assert_array_equal(mesh.faces, theirs.face_matrix())
    if mesh.keeps_normals:
        np.testing.assert_array_equal(mesh.vertex_normals, theirs.vertex_normal_matrix())
    assert theirs.has_wedge_tex_coord() == mesh.has_wedge_tex_coords
    if mesh.has_wedge_tex_coords:
        wedges = mesh.face_attributes["wedge_texture_coordinates"]
        np.testing.assert_allclose(wedges.reshape(-1, 2), theirs.wedge_tex_coord_matrix(), rtol=0, atol=1e-7)
        np.testing.assert_array_equal(mesh.face_attributes["colors"], np.rint(255 * theirs.face_color_matrix()))
    assert [t.name for t in mesh.textures] == list(theirs.textures())


@pytest.mark.parametrize(
    "faces", ["f 1//4 2//2 3//1 4//3", "f 1//1 2//2 3//3\nf 1//4 3//3 4//1", "f 1 2 3\nf 1 3 4", "f 1//1 2//1 3//1"]
)
def test_normals_of_vertices_are_those_of_meshlab(tmp_path: Path, faces: str) -> None:
    """With as many normals as vertices each vertex has that of its last corner; MeshLab forgets them of quads."""
    path = tmp_path / "a.obj"
    mesh = read(path, SQUARE + "vn 0 0 3\nvn 0 4 0\nvn 1 0 1\nvn 0 0 -5\n" + faces + "\n")
    assert mesh.keeps_normals
    if len(faces.split()) != 5:
        theirs, _meshes = meshlab(path)
        np.testing.assert_array_equal(mesh.vertex_normals, theirs.vertex_normal_matrix())
    else:
        assert mesh.vertex_normals.tolist() == [[0, 0, -5], [0, 4, 0], [0, 0, 3], [1, 0, 1]]


def test_a_cloud_has_its_normals(tmp_path: Path) -> None:
    """Points without faces have the normals that stand in the file in their order, with the opacities of their colours."""
    mesh = read(tmp_path / "a.obj", "vn 0 0 1\nv 1 2 3 1 0 0 .2\nvn 0 1 0\nv 4 5 6 0 0.5 0 1\n")
    assert mesh.vertex_normals.tolist() == [[0, 0, 1], [0, 1, 0]]
    assert mesh.vertex_attributes["colors"].tolist() == [[255, 0, 0, 51], [0, 128, 0, 255]]


def test_colours_of_zbrush(tmp_path: Path) -> None:
    """Colours in comments, eight digits of a mask and a colour for each vertex, are those that MeshLab reads."""
    path = tmp_path / "a.obj"
    mesh = read(path, SQUARE + "#MRGB ff010203ffaabbcc\n#MRGB 00ff8000ff000001\nf 1 2 3\n")
    assert mesh.vertex_attributes["colors"][:, :3].tolist() == [[1, 2, 3], [170, 187, 204], [255, 128, 0], [0, 0, 1]]
    theirs, _meshes = meshlab(path)
    np.testing.assert_array_equal(np.rint(255 * theirs.vertex_color_matrix())[:, :3], mesh.vertex_attributes["colors"][:, :3])


def test_polylines_count_back_from_their_line(tmp_path: Path) -> None:
    """-1 is the last vertex before the line, not of the file; texture coordinates and comments are no vertices."""
    text = "v 0 0 0\r\nvt 0 0\r\nv 1 0 0\r\nl -2/1 -1/1 # two\r\nv 2 0 0\r\nl -1 \\\r\n -2 -3\r\n"
    mesh = read(tmp_path / "a.obj", text)
    assert mesh.edges.tolist() == [[0, 1], [2, 1], [1, 0]]
    long = read(tmp_path / "b.obj", "v 0 0 0\n" * 20_000 + f"l {' '.join(map(str, range(1, 20_001)))}\n")
    assert len(long.edges) == 19_999
    assert save(mesh, tmp_path / "out.obj") == ()
    assert (tmp_path / "out.obj").read_bytes() == text.encode()


def test_only_what_has_changed_is_written(tmp_path: Path) -> None:
    """Of a moved mesh the coordinates that changed are other words, materials have another name; all else is as it was."""
    mesh = read_file(house(tmp_path / "in")).mesh
    (tmp_path / "out").mkdir()
    assert save(mesh, tmp_path / "out" / "house.obj") == ()
    expected = WHOLE.replace("mtllib  two words.mtl", "mtllib house.obj.mtl")
    assert (tmp_path / "out" / "house.obj").read_text() == expected
    assert (tmp_path / "out" / "house.obj.mtl").read_text() == MATERIALS.replace("walls/", "")
    assert {p.name for p in (tmp_path / "out").glob("*.png")} == {"brick.png", "tiles.png", "bump.png"}
    vertices = mesh.vertices.copy()
    vertices[1:3, 0] += 1 / 3
    save(moved(mesh, vertices), tmp_path / "out" / "moved.obj")
    text = expected.replace("house.obj.mtl", "moved.obj.mtl").replace("v 2.50 0", f"v {2.5 + 1 / 3} 0")
    assert (tmp_path / "out" / "moved.obj").read_text() == text.replace("v\t2 2", f"v\t{2 + 1 / 3} 2")


@pytest.mark.parametrize("name", ["airplane", "bunny", "cow", "cube"])
def test_samples_are_written_as_they_were(tmp_path: Path, name: str) -> None:
    """A real file that nothing was done to comes out byte for byte, and read again after a move it is the moved mesh."""
    path = SAMPLES / f"{name}.obj"
    mesh = read_file(path).mesh
    save(mesh, tmp_path / "a.obj")
    assert (tmp_path / "a.obj").read_bytes() == path.read_bytes()
    other = moved(mesh, mesh.vertices / 3)
    save(other, tmp_path / "b.obj")
    again = read_file(tmp_path / "b.obj").mesh
    np.testing.assert_array_equal(again.vertices, other.vertices)
    np.testing.assert_array_equal(again.faces, other.faces)
    if mesh.keeps_normals:
        np.testing.assert_array_equal(again.vertex_normals, other.vertex_normals)


def test_a_filter_of_meshlab_changes_nothing_else(tmp_path: Path) -> None:
    """Smoothed by MeshLab, which keeps texture coordinates in single precision, a file has other coordinates alone."""
    path = SAMPLES / "bunny10k_textured.obj"
    found = staged_files(session_report(path, tmp_path / "out.obj", SMOOTH))["out.obj"].read_text()
    text = path.read_text().replace("bunny10k_textured.mtl", "out.obj.mtl").replace("./out", "out")
    before, after = text.split("\n"), found.split("\n")
    assert sum(a != b for a, b in zip(before, after, strict=True)) <= 5051
    assert [x for x in before if not x.startswith("v ")] == [x for x in after if not x.startswith("v ")]


CUBE = (
    "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    + "vn -1 0 0\nvn 1 0 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 0 -1\nvn 0 0 1\n"
    + "f 1//1 2//1 4//1 3//1\nf 5//2 7//2 8//2 6//2\nf 1//3 5//3 6//3 2//3\n"
    + "f 3//4 4//4 8//4 7//4\nf 1//5 3//5 7//5 5//5\nf 2//6 6//6 8//6 4//6\n"
)


def test_sharp_edges_stay_sharp(tmp_path: Path) -> None:
    """The normals of a cube's corners follow its sides: turned with it in the same lines, or in new ones where sides bend."""
    mesh = read(tmp_path / "cube.obj", CUBE)
    assert not mesh.keeps_normals
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1.0]])
    save(moved(mesh, mesh.vertices @ turn.T), tmp_path / "turned.obj")
    before, after = CUBE.splitlines(), (tmp_path / "turned.obj").read_text().splitlines()
    assert [x for x in before if not x.startswith("v")] == [x for x in after if not x.startswith("v")]
    normals = [[float(w) for w in line.split()[1:]] for line in after if line.startswith("vn")]
    sides = np.concatenate([[-axis, axis] for axis in np.eye(3)])
    np.testing.assert_allclose(normals, sides @ turn.T, atol=1e-15)
    bent = mesh.vertices + 0.1 * np.random.default_rng(1).random((8, 3))
    save(moved(mesh, bent), tmp_path / "bent.obj")
    again = read_file(tmp_path / "bent.obj").mesh
    assert again.source is not None
    document = again.source.document
    of_corners = document.normals[document.corner_normals]
    assert np.einsum("ijk,ik->ij", of_corners, again.face_normals).min() > 0.98  # 0.58 with one normal a vertex


def test_written_anew_with_groups_and_materials(tmp_path: Path) -> None:
    """Where faces are gone the others keep groups, objects, materials, texture coordinates and whole polygons."""
    mesh = read_file(house(tmp_path / "in")).mesh
    part = mesh.part(np.ones(5, np.bool_), np.array([True, True, True, False, True, True]))
    (tmp_path / "out").mkdir()
    (warning,) = save(part, tmp_path / "out" / "a.obj")
    assert warning == "a.obj: contents that cannot be rewritten are left out: comments (2); point elements (1)"
    lines = (tmp_path / "out" / "a.obj").read_text().splitlines()
    assert [x for x in lines if x[0] not in "v#"] == [
        *("mtllib a.obj.mtl", "o house", "g floor", "s 1", "usemtl brick wall", "f 1/1 2/2 3/3 4/4"),
        *("g roof", "usemtl tiles", "f 1/1 2/2 5/3", "f 3/1 4/2 5/3", "usemtl plain", "f 4 1 5", "l 1 2", "l 2 5"),
    ]
    assert (tmp_path / "out" / "a.obj.mtl").read_text() == MATERIALS.replace("walls/", "")
    again = read_file(tmp_path / "out" / "a.obj").mesh
    assert_same(again, MeshData(**{**vars(part), "vertex_attributes": part.vertex_attributes}))
    broken = mesh.part(np.ones(5, np.bool_), np.arange(6) > 0)
    assert save(broken, tmp_path / "out" / "b.obj")[1] == "b.obj: polygons that are not whole are written as triangles (1)"


def test_added_faces_belong_to_the_group_that_they_touch(tmp_path: Path) -> None:
    """Added faces, and those behind them, are written with the group and the material of the faces beside them."""
    (tmp_path / "a.mtl").write_text("newmtl grey\nKd 1 0 0\nnewmtl red\nKd 1 0 0\n")
    points = "".join(f"v {x} {y} 0\n" for x in range(5) for y in range(2))
    faces = "g ring\nusemtl grey\nf 1 3 2\ng label\nusemtl red\nf 7 9 8\n"
    mesh = read(tmp_path / "a.obj", f"mtllib a.mtl\n{points}{faces}")
    filled = apply_edit(mesh, Edit(added_faces=np.array([[2, 3, 4], [1, 2, 3]], np.int32)))
    save(filled, tmp_path / "b.obj")
    lines = (tmp_path / "b.obj").read_text().splitlines()
    ring = ["g ring", "usemtl grey"]
    assert lines[-10:] == [*ring, "f 1 3 2", "g label", "usemtl red", "f 7 9 8", *ring, "f 3 4 5", "f 2 3 4"]


def test_lines_of_any_length_are_written_whole(tmp_path: Path) -> None:
    """A line of group names, and one of material files that another name replaces, of more than 4096 bytes."""
    for k in range(2):
        (tmp_path / f"{k}.mtl").write_text(f"newmtl {k}\nKd 1 0 0\n")
    groups = "g " + " ".join(f"group_{k:04d}" for k in range(600))
    mesh = read(tmp_path / "a.obj", f"mtllib 0.mtl{' ' * 5000}1.mtl\n{SQUARE}{groups}\nf 1 2 3\ng other\nf 1 3 4\n")
    cut = mesh.part(np.ones(4, np.bool_), np.arange(2) < 1)
    for output, changed in (("moved", moved(mesh, mesh.vertices + 1.0)), ("cut", cut)):
        save(changed, tmp_path / output / "b.obj")
        lines = (tmp_path / output / "b.obj").read_text().splitlines()
        assert "mtllib b.obj.mtl" in lines
        assert groups in lines


def test_normals_of_vertices_are_written_anew(tmp_path: Path) -> None:
    """Vertices that are left keep the normals of the file if they did not move; others get those of their faces."""
    mesh = read_file(SAMPLES / "bunny.obj").mesh
    assert mesh.keeps_normals
    faces = np.ones(len(mesh.faces), np.bool_)
    faces[7] = False
    for k, other in enumerate((mesh, moved(mesh, mesh.vertices * 2))):
        part = other.part(np.ones(len(mesh.vertices), np.bool_), faces)
        save(part, tmp_path / f"{k}.obj")
        np.testing.assert_allclose(read_file(tmp_path / f"{k}.obj").mesh.vertex_normals, part.vertex_normals, atol=1e-15)


def test_colours_that_steps_paint(tmp_path: Path) -> None:
    """Painted vertices get three words more on their lines, or others; painted faces get materials of their own."""
    mesh = read(tmp_path / "a.obj", SQUARE + "# kept\nf 1 2 3 4\n")
    levels = np.array([[1, 2, 3, 255], [101, 202, 51, 255], [0, 0, 0, 255], [255, 254, 253, 255]], np.uint8)
    painted = mesh.with_attributes({"colors": levels})
    save(painted, tmp_path / "b.obj")
    assert "# kept\nf 1 2 3 4\n" in (tmp_path / "b.obj").read_text()
    again = read_file(tmp_path / "b.obj").mesh
    np.testing.assert_array_equal(again.vertex_attributes["colors"], levels)
    save(again.with_attributes({"colors": levels[::-1]}), tmp_path / "c.obj")
    np.testing.assert_array_equal(read_file(tmp_path / "c.obj").mesh.vertex_attributes["colors"], levels[::-1])
    faces = again.with_attributes({"colors": None}, {"colors": levels[:2]})
    assert save(faces, tmp_path / "d.obj") == (
        "d.obj: contents that cannot be rewritten are left out: comments (1)",
        "d.obj: polygons whose triangles have different values are written as triangles (1)",
    )
    np.testing.assert_array_equal(read_file(tmp_path / "d.obj").mesh.face_attributes["colors"], levels[:2])


def test_a_material_file_is_named_behind_the_byte_order_mark(tmp_path: Path) -> None:
    """A file that begins with a mark and names no material file is written so that it can be read."""
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\n")
    text = "\ufeffv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3\n"
    save(read(tmp_path / "a.obj", text), tmp_path / "b.obj")
    assert (tmp_path / "b.obj").read_text() == f"\ufeffmtllib b.obj.mtl\n{text[1:]}"
    assert read_file(tmp_path / "b.obj").mesh.face_attributes["colors"].tolist() == [[255, 0, 0, 255]]


def test_colours_in_levels_are_painted(tmp_path: Path) -> None:
    """In a file with colours up to 255, painting one vertex leaves the colours of the others as they are."""
    mesh = read(tmp_path / "a.obj", "v 0 0 0 200 10 10\nv 1 0 0 20 100 10\nv 1 1 0 20 10 100\nf 1 2 3\n")
    colors = mesh.vertex_attributes["colors"].copy()
    colors[0] = 128, 64, 32, 255
    save(mesh.with_attributes({"colors": colors}), tmp_path / "b.obj")
    np.testing.assert_array_equal(read_file(tmp_path / "b.obj").mesh.vertex_attributes["colors"], colors)


def test_a_texture_in_place_of_another_is_named(tmp_path: Path) -> None:
    """The new texture is that of the faces, and the material file names the former one no more."""
    for folder in ("in", "out"):
        (tmp_path / folder).mkdir()
    shutil.copy(IMAGE, tmp_path / "in" / "t.png")
    (tmp_path / "in" / "a.mtl").write_text("newmtl a\nmap_Kd t.png\n")
    mesh = read(tmp_path / "in" / "a.obj", f"mtllib a.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\n")
    assert save(replace(mesh, textures=(Texture("new.png", IMAGE),)), tmp_path / "out" / "a.obj") == ()
    again = read_file(tmp_path / "out" / "a.obj").mesh
    assert again.textures == (Texture("new.png", tmp_path / "out" / "new.png"),)
    assert again.face_attributes["texture"].tolist() == [0]


def test_coordinates_of_vertices_that_a_step_gives_are_written(tmp_path: Path) -> None:
    """A file without texture coordinates gets those of its vertices."""
    mesh = read(tmp_path / "a.obj", f"{SQUARE}f 1 2 3\n")
    save(mesh.with_attributes({"texture_coordinates": np.arange(8.0).reshape(4, 2)}), tmp_path / "b.obj")
    wedges = read_file(tmp_path / "b.obj").mesh.face_attributes["wedge_texture_coordinates"]
    assert wedges.tolist() == [[[0, 1], [2, 3], [4, 5]]]


def test_faces_without_normals_beside_others_stay_so(tmp_path: Path) -> None:
    """The file is written as it was, and without a face the normals of the others are those of the file, too."""
    text = f"{SQUARE}vt 0 0\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1/1/1 3/1/1 4/1/1\nf 2 3 4\nf 2/1 4/1 3/1\nf 1//1 2//1 4//1\np 1\n"
    mesh = read(tmp_path / "a.obj", text)
    save(mesh, tmp_path / "b.obj")
    assert (tmp_path / "b.obj").read_text() == text
    save(mesh.part(np.ones(4, np.bool_), np.arange(5) < 4), tmp_path / "c.obj")
    faces = [line for line in (tmp_path / "c.obj").read_text().splitlines() if line.startswith(("f", "vn"))]
    assert faces == ["vn 0.0 1.0 0.0", "f 1/1/1 2/1/1 3/1/1", "f 1/1/1 3/1/1 4/1/1", "f 2/1 3/1 4/1", "f 2/1 4/1 3/1"]


def test_a_cloud_gets_faces(tmp_path: Path) -> None:
    """Faces that a step gives to the points of a file are written."""
    mesh = read(tmp_path / "a.obj", SQUARE)
    save(replace(mesh, faces=np.array([[0, 1, 2]], np.int32), face_ids=np.array([-1])), tmp_path / "b.obj")
    assert read_file(tmp_path / "b.obj").mesh.faces.tolist() == [[0, 1, 2]]


def test_a_texture_on_coordinates_of_vertices_is_named(tmp_path: Path) -> None:
    """The faces of a mesh with texture coordinates at its vertices, and no texture numbers, show its first texture."""
    vertex = {"texture_coordinates": np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])}
    mesh = MeshData(
        vertices=np.eye(3), faces=np.array([[0, 1, 2]]), vertex_attributes=vertex, textures=(Texture("t.png", IMAGE),)
    )
    several = replace(mesh, textures=(*mesh.textures, Texture("u.png", IMAGE)))
    for name, each in (("a.obj", mesh), ("b.obj", several), ("c.glb", several)):
        save(each, tmp_path / name)
        again = read_file(tmp_path / name).mesh
        assert again.face_attributes["texture"].tolist() == [0], name
        assert len(again.textures) == 1


def everything() -> dict[str, Any]:
    """What a mesh may have that an OBJ file holds, by the words of messages."""
    rng = np.random.default_rng(3)
    levels = np.tile(np.arange(256, dtype=np.uint8)[:, None], (1, 4))
    levels[:, 3] = 255
    textures = (Texture("a-b.png", IMAGE), Texture("c.png", IMAGE))
    numbers = np.arange(254, dtype=np.int32) % 3 - 1
    wedges = np.round(rng.random((254, 3, 2)), 3)
    wedges[numbers < 0] = 0
    return {
        "normals": {"vertex_attributes": {"normals": rng.random((256, 3))}, "keeps_normals": True},
        "vertex colours": {"vertex_attributes": {"colors": levels}},
        "face colours": {"face_attributes": {"colors": levels[1:-1]}},
        "wedges": {"face_attributes": {"wedge_texture_coordinates": rng.random((254, 3, 2))}},
        "textures": {
            "face_attributes": {"wedge_texture_coordinates": wedges, "texture": numbers, "colors": levels[1:-1]},
            "textures": textures,
        },
        "polygons": {"face_attributes": {"polygon": np.arange(254, dtype=np.int32) // 2}},
        "edges": {"edges": np.array([[0, 5], [7, 3]])},
    }


@pytest.mark.slow
@pytest.mark.parametrize("kind", everything())
def test_what_is_written_is_read_everywhere(tmp_path: Path, kind: str) -> None:
    """Each attribute of a mesh of no file comes back to the bit, and MeshLab and trimesh read the same."""
    points = np.random.default_rng(2).random((256, 3))
    strip = np.stack([np.arange(254), np.arange(1, 255), np.arange(2, 256)], axis=1).astype(np.int32)
    strip[1::2] = strip[1::2, [1, 0, 2]]
    mesh = MeshData(vertices=points, faces=strip, **everything()[kind])
    path = tmp_path / "a.obj"
    assert save(mesh, path) == ()
    again = read_file(path).mesh
    if kind != "polygons":  # whose corners may come in another order
        assert_same(again, mesh)
    assert len(again.textures) == len(mesh.textures)
    theirs, _meshes = meshlab(path)
    np.testing.assert_array_equal(theirs.vertex_matrix(), points)
    if kind != "polygons":
        np.testing.assert_array_equal(theirs.face_matrix(), strip)
    if kind == "normals":
        np.testing.assert_array_equal(theirs.vertex_normal_matrix(), mesh.vertex_normals)
    if "colors" in mesh.vertex_attributes:
        np.testing.assert_array_equal(np.rint(255 * theirs.vertex_color_matrix()), mesh.vertex_attributes["colors"])
    if "colors" in mesh.face_attributes:
        np.testing.assert_array_equal(np.rint(255 * theirs.face_color_matrix()), mesh.face_attributes["colors"])
    if mesh.has_wedge_tex_coords:
        wedges = theirs.wedge_tex_coord_matrix().reshape(-1, 3, 2)
        chosen = again.face_attributes.get("texture", np.zeros(254)) >= 0
        np.testing.assert_allclose(wedges[chosen], mesh.face_attributes["wedge_texture_coordinates"][chosen], atol=1e-7)
        assert sorted(theirs.textures()) == sorted(t.name for t in again.textures)
    assert theirs.edge_number() == len(mesh.edges)
    other = trimesh.load_mesh(path, process=False)
    assert len(other.faces) == 254
    if kind == "polygons":
        assert (tmp_path / "a.obj").read_text().count("\nf ") == 127
    else:
        np.testing.assert_allclose(other.area, trimesh.Trimesh(points, strip, process=False).area, rtol=1e-12)


def test_more_materials_than_are_read(tmp_path: Path) -> None:
    """Colours of faces that would make more materials than any reader takes are named, and not written."""
    colors = np.zeros((30_000, 4), np.uint8)
    colors[:, 0], colors[:, 1] = np.arange(30_000) % 256, np.arange(30_000) // 256
    corners = np.arange(30_002)
    faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1).astype(np.int32)
    mesh = MeshData(vertices=np.random.default_rng(1).random((30_002, 3)), faces=faces, face_attributes={"colors": colors})
    assert "30,000 materials" in " ".join(save(mesh, tmp_path / "a.obj"))
    assert "colors" not in read_file(tmp_path / "a.obj").mesh.face_attributes


def test_new_faces_beside_faces_without_a_group_join_none(tmp_path: Path) -> None:
    """A face that is added beside faces before the first group is written at the end, and not in the last group."""
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\ng last\ns 1\nf 4 5 6\n"
    mesh = read(tmp_path / "a.obj", text)
    more = apply_edit(mesh, Edit(added_vertices=np.array([[1.0, 1, 0]]), added_faces=np.array([[1, 6, 2]])))
    save(more, tmp_path / "b.obj")
    lines = (tmp_path / "b.obj").read_text().splitlines()
    assert lines[-6:] == ["g last", "s 1", "f 4 5 6", "g default", "s off", "f 2 7 3"]


def test_a_face_without_a_texture_gets_none_from_the_face_before_it(tmp_path: Path) -> None:
    """No keyword ends the use of a material, so bare faces behind textured ones get a material without a texture."""
    mesh = MeshData(
        vertices=np.eye(3),
        faces=np.array([[0, 1, 2]] * 4),
        face_attributes={"texture": np.array([-1, 0, -1, 0]), "wedge_texture_coordinates": np.full((4, 3, 2), 0.5)},
        textures=(Texture("scan #1.png", IMAGE),),
    )
    assert save(mesh, tmp_path / "a.obj") == ()
    again = read_file(tmp_path / "a.obj").mesh
    assert again.face_attributes["texture"].tolist() == [-1, 0, -1, 0]
    assert (tmp_path / again.textures[0].name).read_bytes() == IMAGE.read_bytes()
    assert "usemtl" not in (tmp_path / "a.obj").read_text().partition("f ")[0]


@pytest.mark.parametrize("name", ["#1.png", "scan #1.png", "scan#1.png"])
def test_textures_whose_names_have_a_comment_mark_are_read_again(name: str, tmp_path: Path) -> None:
    """A mark behind a blank begins a comment in OBJ files; elsewhere, and in PLY files, the name stays."""
    mesh = MeshData(
        vertices=np.eye(3),
        faces=np.array([[0, 1, 2]]),
        vertex_attributes={"texture_coordinates": np.eye(3)[:, :2]},
        textures=(Texture(name, IMAGE),),
    )
    for output, kept in (("a.obj", name == "scan#1.png"), ("b.ply", True)):
        save(mesh, tmp_path / output)
        (texture,) = read_file(tmp_path / output).mesh.textures
        assert texture.image is not None
        assert (texture.name == name) is kept


def test_polygons_whose_triangles_disagree_are_triangles(tmp_path: Path) -> None:
    """A colour of each triangle, or texture coordinates of each, would not all be in the line of a polygon."""
    mesh = read(tmp_path / "a.obj", f"{SQUARE}v 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 5 6 3\n")
    colors = np.array([[255, 0, 0, 255], [0, 0, 255, 255], [9, 9, 9, 255], [9, 9, 9, 255]], np.uint8)
    wedges = np.tile(mesh.vertices[mesh.faces][:, :, :2], 1)
    wedges[0] += 7.0
    for name, values, kind in (
        ("colors", colors, "whose triangles have different values"),
        (WEDGES, wedges, "that are not whole"),
    ):
        painted = mesh.with_attributes(face={name: values})
        assert save(painted, tmp_path / f"{name}.obj") == (f"{name}.obj: polygons {kind} are written as triangles (1)",)
        again = read_file(tmp_path / f"{name}.obj").mesh
        np.testing.assert_array_equal(again.face_attributes[name], values)
        assert again.face_attributes["polygon"].tolist() == [-1, -1, 2, 2]
