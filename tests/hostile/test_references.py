"""What a mesh file names: nothing from outside its folder is read or copied, and nothing but regular files is opened."""

from __future__ import annotations

import base64
import json
import os
import shutil
import struct
import zlib
from pathlib import Path

import pytest
from PIL import Image

from pymeshfair.files.errors import InputError
from pymeshfair.files.inputs import read_file

from ..running.runs import SAMPLES, ply_bytes, session_report, xyz
from .documents import collada, vrml, x3d

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs pipes, devices and links")

_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{}\nusemtl a\nf 1/1 2/1 3/1\n"
#: ways to name a file that a reader may miss
WAYS = {
    "mtllib": _OBJ.format("mtllib {}"),
    "mtllib after a blank": _OBJ.format(" mtllib {}"),
    "mtllib after a tab": _OBJ.format("\tmtllib\t{}"),
    "mtllib continued": _OBJ.format("mtllib \\\n{}"),
    "mtllib in an old Mac's file": _OBJ.format("mtllib {}").replace("\n", "\r"),
}
TARGETS = ("/dev/zero", "pipe", "../secret.txt", "{outside}/secret.txt", "link", "folder")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder of a mesh, with a pipe, a link to a secret and a folder; the secret is outside."""
    (tmp_path / "secret.txt").write_text("newmtl a\nmap_Kd t.png\n# secret\n")
    shutil.copy(SAMPLES / "TextureDouble_A.png", tmp_path / "secret.png")
    inside = tmp_path / "mesh"
    (inside / "folder").mkdir(parents=True)
    os.mkfifo(inside / "pipe")
    (inside / "link").symlink_to(tmp_path / "secret.txt")
    (inside / "link.png").symlink_to(tmp_path / "secret.png")
    (inside / "no_image.png").write_text("secret")
    (tmp_path / "out").mkdir()
    return inside


def refused(path: Path) -> None:
    """A run of the file is refused, and nothing of the secret is anywhere in the output's folder."""
    out = path.parent.parent / "out"
    with pytest.raises(InputError, match=r"outside its folder|and no file|is no image"):
        session_report(path, out / "out.obj")
    for file in out.rglob("*"):
        assert not file.is_file() or b"secret" not in file.read_bytes()


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("way", WAYS)
def test_material_files(folder: Path, way: str, target: str) -> None:
    """However the line is written, a material file that is a device, a pipe or outside is refused."""
    path = folder / "mesh.obj"
    path.write_text(WAYS[way].replace("{}", target.format(outside=folder.parent)))
    refused(path)


TEXTURES = ("/etc/passwd", "../secret.png", "link.png", "no_image.png", "pipe", "/dev/zero", "folder")


@pytest.mark.parametrize("target", TEXTURES)
@pytest.mark.parametrize("line", ["map_Kd {}", "  map_Kd\t{}", "map_Kd -s 1 1 1 {}", "map_Kd \\\n{}"])
def test_textures_of_materials(folder: Path, line: str, target: str) -> None:
    """A texture outside, or one that is no image by its content, is refused however its line is written."""
    path = folder / "mesh.obj"
    path.write_text(_OBJ.format("mtllib m.mtl"))
    (folder / "m.mtl").write_text(f"newmtl a\n{line.format(target)}\n")
    refused(path)


@pytest.mark.parametrize("target", TEXTURES)
@pytest.mark.parametrize(
    "line", ["comment TextureFile {}", "comment TextureFile\t{}", "comment texturefile  {}", "obj_info TextureFile {}"]
)
def test_textures_of_ply_files(folder: Path, line: str, target: str) -> None:
    """The same for what the header of a PLY file names."""
    path = folder / "mesh.ply"
    path.write_bytes(ply_bytes(xyz(), head=line.format(target)))
    refused(path)


@pytest.mark.parametrize("part", ["buffers", "images"])
@pytest.mark.parametrize(
    "target", ["../secret.txt", "%2e%2e/secret.txt", "%2e%2e%2fsecret.txt", "pipe", "%70ipe", "/dev/zero", "link"]
)
def test_files_of_gltf_documents(folder: Path, part: str, target: str) -> None:
    """The same for buffers and images of a glTF document, percent-encoded or not."""
    path = folder / "mesh.gltf"
    data = "data:application/octet-stream;base64," + base64.b64encode(bytes(48)).decode()
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": kind} for kind in ("VEC3", "VEC2")],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": data, "byteLength": 36}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "gone.png"}],
        part: [{"uri": target, "byteLength": 36}],
    }
    path.write_text(json.dumps(document))
    refused(path)


@pytest.mark.parametrize(
    "target", ["../secret.png", "/etc/passwd", "link.png", "pipe", "%70ipe", "/dev/zero", "%2e%2e/secret.png"]
)
@pytest.mark.parametrize("name", ["mesh.dae", "mesh.wrl", "mesh.x3d", "file.dae", "list.wrl"])
def test_textures_of_scenes(folder: Path, name: str, target: str) -> None:
    """The same for the images of COLLADA, VRML and X3D."""
    path = folder / name
    texts = {
        "mesh.dae": collada(image=target),
        "file.dae": collada(image=f"file://{target}"),
        "mesh.wrl": vrml(url=f'"{target}"'),
        "list.wrl": vrml(url=f'[ "gone.png", # "\n"{target}" ]'),
        "mesh.x3d": x3d(url=f'"gone.png" "{target}"'),
    }
    path.write_text(texts[name])
    refused(path)


def test_textures_of_scenes_within_the_folder(folder: Path) -> None:
    """An image beside the mesh is the texture of the output, whatever other texts the scene has."""
    shutil.copy(SAMPLES / "TextureDouble_A.png", folder / "t.png")
    path = folder / "mesh.dae"
    path.write_text(collada(image="./t%2Epng"))
    assert [(t.name, t.image) for t in read_file(path).mesh.textures] == [("./t.png", folder / "t.png")]
    path = folder / "mesh.wrl"
    path.write_text(vrml(url='"t.png"') + 'WorldInfo { title "../secret.txt" }\n')
    assert [t.image for t in read_file(path).mesh.textures] == [folder / "t.png"]


def _png(size: int) -> bytes:
    """A black square of one bit a pixel."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = zlib.compress(bytes((size // 8 + 1) * size), 9)
    head = struct.pack(">IIBBBBB", size, size, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    ("size", "why"), [(4000, None), (9600, "a file of .* bytes may have .* at most"), (20_000, "or is too large")]
)
def test_images_of_few_bytes_and_many_pixels(folder: Path, size: int, why: str | None) -> None:
    """An image that would take a thousand times its file in memory is refused by its head, a small one of a colour is not."""
    path = folder / "mesh.ply"
    path.write_bytes(ply_bytes(xyz(), head="comment TextureFile bomb.png"))
    (folder / "bomb.png").write_bytes(_png(size))
    if why is None:
        assert read_file(path).mesh.textures[0].image == folder / "bomb.png"
        return
    with pytest.raises(InputError, match=why):
        read_file(path)


@pytest.mark.parametrize("damage", ["cut", "altered"])
def test_a_damaged_png_is_no_texture(folder: Path, damage: str) -> None:
    """A PNG that ends early, or whose checksum is wrong, is refused by its name: MeshLab would write its dummy.png instead."""
    Image.effect_noise((64, 64), 80).save(folder / "t.png")
    data = bytearray((folder / "t.png").read_bytes())
    data[len(data) // 2] ^= 0xFF
    (folder / "t.png").write_bytes(data if damage == "altered" else data[: len(data) // 2])
    (folder / "mesh.ply").write_bytes(ply_bytes(xyz(), head="comment TextureFile t.png"))
    with pytest.raises(InputError, match=r"the texture 't\.png' is no image .*, is damaged, or is too large"):
        read_file(folder / "mesh.ply")


def test_outside_files_are_read_if_allowed(folder: Path) -> None:
    """With --allow-outside the textures of another folder are taken, if they are images."""
    path = folder / "mesh.ply"
    path.write_bytes(ply_bytes(xyz(), head="comment TextureFile ../secret.png"))
    report = session_report(path, folder.parent / "out" / "out.ply", allow_outside=True)
    assert [file.target.name for file in report["staged"]] == ["out.ply", "secret.png"]
    path.write_bytes(ply_bytes(xyz(), head="comment TextureFile ../secret.txt"))
    with pytest.raises(InputError, match="is no image"):
        session_report(path, folder.parent / "out" / "other.ply", allow_outside=True)
