"""Inputs that are refused before they are opened, and what the others declare."""

from __future__ import annotations

import os
import shutil
import struct
from pathlib import Path

import pytest
import typer

from pymeshfair.commands.app import app
from pymeshfair.files.errors import InputError
from pymeshfair.files.inputs import check_input, read_file
from pymeshfair.files.obj import Materials

from .runs import BONE, SAMPLES, ply_bytes, xyz

IMAGE = SAMPLES / "TextureDouble_A.png"
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


posix = pytest.mark.skipif(os.name != "posix", reason="needs pipes, devices and links")


@posix
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("missing.ply", "there is no such file"),
        ("folder.ply", "it is a folder and no file"),
        ("pipe.ply", "it is a pipe and no file"),
        ("device.ply", "it is a device or a socket and no file"),
        ("loop.ply", "too many levels of symbolic links"),
        ("dangling.ply", "there is no such file"),
        ("empty.ply", "it is empty"),
        ("mesh.docx", r"'.docx' is no format for meshes; a run reads .ply, .obj"),
        ("mesh", "no extension that says the format"),
    ],
)
def test_what_is_no_mesh_file_is_refused_unopened(tmp_path: Path, name: str, reason: str) -> None:
    """Each kind of thing that is no mesh file is refused with its own reason, and a pipe does not make the check wait."""
    (tmp_path / "folder.ply").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    (tmp_path / "device.ply").symlink_to("/dev/zero")
    (tmp_path / "loop.ply").symlink_to("loop.ply")
    (tmp_path / "dangling.ply").symlink_to("nowhere.ply")
    (tmp_path / "empty.ply").touch()
    for other in ("mesh.docx", "mesh"):
        (tmp_path / other).write_text("x")
    with pytest.raises(InputError, match=reason) as caught:
        check_input(tmp_path / name)
    assert caught.value.path == tmp_path / name


def test_a_name_that_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    """Records cannot hold a name that is no UTF-8 text, so that is said beforehand."""
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff.ply"))
    path.write_bytes(BONE.read_bytes())
    with pytest.raises(InputError, match="not valid UTF-8"):
        check_input(path)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the superuser may read everything")
def test_an_unreadable_file_is_refused(tmp_path: Path) -> None:
    """A file without read permission is refused for that."""
    path = tmp_path / "secret.ply"
    path.write_text("x")
    path.chmod(0)
    with pytest.raises(InputError, match="cannot be read without permission"):
        check_input(path)


def test_an_extension_in_capitals_is_the_same(tmp_path: Path) -> None:
    """SCAN.PLY is as good as scan.ply, and so is a link to it."""
    (tmp_path / "SCAN.PLY").symlink_to(BONE)
    check_input(tmp_path / "SCAN.PLY")
    assert len(read_file(tmp_path / "SCAN.PLY").mesh.vertices) == 1872


def test_what_a_ply_file_declares(tmp_path: Path) -> None:
    """Counts, normals, losses and textures are those of the header; a texture is found beside the mesh by its last part."""
    shutil.copy(IMAGE, tmp_path / "t.png")
    names = ("C:\\scans\\t.png", "gone.png")
    head = "\n".join(f"comment TextureFile {name}" for name in names)
    normals = [("float", c, [1.0] * 4) for c in ("nx", "ny", "nz")]
    path = tmp_path / "mesh.ply"
    path.write_bytes(ply_bytes([*xyz(), *normals, ("int", "label", [1] * 4)], head=head))
    reading = read_file(path)
    mesh = reading.mesh
    assert (len(mesh.vertices), len(mesh.faces), mesh.keeps_normals) == (4, 4, True)
    assert [(t.name, t.image) for t in mesh.textures] == [(names[0], tmp_path / "t.png"), ("gone.png", None)]
    assert reading.side_files == (tmp_path / "t.png",)


def test_what_an_obj_file_declares(tmp_path: Path) -> None:
    """Vertices, polygons and normals are counted; groups and maps are named; side files are found."""
    path = tmp_path / "mesh.obj"
    lines = ["mtllib  my materials.mtl ", "o thing", "v 0 0 0", "v\t1 0 0", "v 1 1 0", "v 0 1 0", "vn 0 0 1", "vt 0 0"]
    lines += ["g one", "usemtl a", "f 1/1 2/1 3/1 4/1", "f 1 2 3", "p 1", "s 1"]
    path.write_text("\n".join(lines))
    (tmp_path / "my materials.mtl").write_text(
        "# x\nnewmtl a\nKd 1 1 1\nmap_Kd t.png\nmap_Bump b.png\nPr 0.5\nnewmtl b\nmap_Kd -s 1 u.png\n"
    )
    shutil.copy(IMAGE, tmp_path / "t.png")
    reading = read_file(path)
    mesh = reading.mesh
    assert (len(mesh.vertices), len(mesh.faces), mesh.keeps_normals) == (4, 3, False)
    expected = {"normals that no face names (1)", "groups (1)", "objects (1)", "smoothing groups (1)", "point elements (1)"}
    expected.add("faces without texture coordinates, which get 0 0 (1)")
    assert mesh.source is not None
    assert set(mesh.source.extras) == {*expected, "map_Bump, Pr, map_Kd -s 1 of the material file my materials.mtl"}
    assert reading.side_files == (tmp_path / "my materials.mtl", tmp_path / "t.png")


def test_the_textured_sample() -> None:
    """The textured bunny of the wheel names its material file and its texture, and nothing is missing."""
    reading = read_file(SAMPLES / "bunny10k_textured.obj")
    assert (len(reading.mesh.vertices), len(reading.mesh.faces)) == (5051, 9999)
    assert [f.name for f in reading.side_files] == ["bunny10k_textured.mtl", "TextureDouble_A.png"]


@posix
@pytest.mark.parametrize("target", ["/dev/zero", "pipe", "folder", "../outside.mtl"])
def test_material_files_that_must_not_be_opened(tmp_path: Path, target: str) -> None:
    """An OBJ file whose material file is a device, a pipe, a folder or outside its own folder is refused at once."""
    folder = tmp_path / "mesh"
    folder.mkdir()
    (folder / "folder").mkdir()
    os.mkfifo(folder / "pipe")
    (tmp_path / "outside.mtl").write_text("newmtl a\n")
    path = folder / "mesh.obj"
    path.write_text(f"mtllib {target}\n{TRIANGLE}")
    with pytest.raises(InputError, match=r"and no file|outside its folder"):
        read_file(path)
    path.write_text(f"mtllib link.mtl\n{TRIANGLE}")
    (folder / "link.mtl").symlink_to(target)
    with pytest.raises(InputError, match=r"and no file|outside its folder"):
        read_file(path)


@posix
@pytest.mark.parametrize("name", ["obj", "ply"])
def test_textures_that_must_not_be_opened(tmp_path: Path, name: str) -> None:
    """A mesh whose texture is a device is refused, whatever names it."""
    path = tmp_path / f"mesh.{name}"
    if name == "obj":
        path.write_text(f"mtllib m.mtl\n{TRIANGLE}")
        (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd /dev/zero\n")
    else:
        path.write_bytes(ply_bytes(xyz(), head="comment TextureFile /dev/zero"))
    with pytest.raises(InputError, match="'/dev/zero', which it names, is a device"):
        read_file(path)


def test_a_missing_material_file_is_named(tmp_path: Path) -> None:
    """A material file that does not exist is no error, but it is said."""
    path = tmp_path / "mesh.obj"
    path.write_text(f"mtllib gone.mtl\n{TRIANGLE}")
    source = read_file(path).mesh.source
    assert source is not None
    assert source.extras == ("the material file gone.mtl, which does not exist",)


def test_a_material_file_is_read_up_to_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A material file that is too long is refused without being read whole."""
    monkeypatch.setattr("pymeshfair.files.obj.MATERIAL_LIMIT", 20)
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd b.png\n")
    with pytest.raises(InputError, match=r"the material file 'm.mtl' has more than 20 bytes"):
        Materials().read(tmp_path / "m.mtl", tmp_path / "m.obj")


@pytest.mark.parametrize(
    ("name", "data", "reason"),
    [
        ("bomb.off", b"OFF\n1000000000 1000000000 0\n0 0 0\n", "lines follow"),
        ("bomb.stl", bytes(80) + struct.pack("<I", 10**9) + bytes(50), "take 50,000,000,084 bytes"),
        ("bad.ply", b"not a ply", "does not begin"),
        ("bad.glb", b"glTF" + bytes(8) + struct.pack("<I", 2**32 - 1) + b"JSON{", "declares 0 bytes, but has 21"),
        ("bad.gltf", b"[1]", "no glTF document"),
    ],
)
def test_declarations_that_no_file_can_hold(tmp_path: Path, name: str, data: bytes, reason: str) -> None:
    """Counts and lengths are held against the size of the file, in every format that declares them."""
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=reason):
        read_file(tmp_path / name)


def test_honest_counts_are_taken(tmp_path: Path) -> None:
    """The counts of OFF and STL headers are those of the mesh, and those of a text STL are counted."""
    (tmp_path / "a.off").write_text("# words\nNOFF # more\n3 1 0\n" + "0 0 0 0 0 1\n" * 3 + "3 0 1 2\n")
    off = read_file(tmp_path / "a.off").mesh
    assert (len(off.vertices), len(off.faces), off.keeps_normals) == (3, 1, True)
    (tmp_path / "a.stl").write_bytes(b"solid it is not".ljust(80) + struct.pack("<I", 2) + bytes(100))
    assert len(read_file(tmp_path / "a.stl").mesh.faces) == 2
    corners = "outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    (tmp_path / "b.stl").write_text("solid x\n" + f"facet normal 0 0 1\n{corners}endfacet\n" * 9 + "endsolid\n")
    assert len(read_file(tmp_path / "b.stl").mesh.faces) == 9
    assert len(read_file(SAMPLES / "chameleon.pts").mesh.vertices) == 4594


def test_the_commands_that_a_refusal_names_have_the_option(tmp_path: Path) -> None:
    """A file outside the folder of its mesh is refused with the commands that take --allow-outside, and no other command."""
    (tmp_path / "mesh").mkdir()
    (tmp_path / "outside.mtl").write_text("newmtl a\n")
    (tmp_path / "mesh" / "mesh.obj").write_text(f"mtllib ../outside.mtl\n{TRIANGLE}")
    with pytest.raises(InputError, match=r"take a command that has --allow-outside: (.*)$") as caught:
        read_file(tmp_path / "mesh" / "mesh.obj")
    named = set(str(caught.value).rpartition(": ")[2].replace(" or ", ", ").split(", "))
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    assert named == {name for name, command in commands.items() if any("--allow-outside" in p.opts for p in command.params)}
