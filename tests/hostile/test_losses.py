"""Every property of an input is in the output to the bit, or is named, and then --keep-all makes an error of it."""

from __future__ import annotations

import base64
import json
import shutil
import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.files.errors import InputError, OutputError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_tables import read_header

from ..running.runs import SAMPLES, SMOOTH, TETRAHEDRON, columns, ply_bytes, session_report, staged_files, xyz

IMAGE = SAMPLES / "TextureDouble_A.png"
_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
_FACE = "f 1/1 2/2 3/3\n"
_SOLID = b"solid %s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"
_FOUR = [0.25, 0.5, 0.75, 1.0]


def _ply(*properties: tuple[str, str, Any], faces: Any = (), head: str = "") -> bytes:
    return ply_bytes([*xyz(), *properties], TETRAHEDRON[1].tolist(), faces, head)


def _gltf(more: Mapping[str, Any], attributes: Mapping[str, int]) -> bytes:
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    normals = np.array([[0, 0, 1]] * 3, "<f4").tobytes()
    pairs = np.array([[0, 0], [1, 0], [0, 1]], "<f4").tobytes()
    parts = (places, normals, pairs)
    starts = (0, 36, 72)
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, **attributes}}]}],
        "accessors": [
            {"bufferView": k, "componentType": 5126, "count": 3, "type": kind} for k, kind in enumerate(("VEC3", "VEC3", "VEC2"))
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": s, "byteLength": len(p)} for s, p in zip(starts, parts, strict=True)],
        "buffers": [{"byteLength": 96}],
        **more,
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(parts)
    head = b"glTF" + struct.pack("<IIII", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A)
    return head + text + struct.pack("<II", len(data), 0x004E4942) + data


RED: Mapping[str, Any] = {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}


def _points_gltf(attributes: Mapping[str, int], materials: Sequence[Any] = (), faces: bool = False) -> bytes:
    """Points with the first material, with `faces` beside a triangle on the same vertices."""
    points = {"attributes": {"POSITION": 0, **attributes}, "mode": 0, **({"material": 0} if materials else {})}
    both = [points, {"attributes": points["attributes"]}] if faces else [points]
    return _gltf({"meshes": [{"primitives": both}], "materials": list(materials)}, {})


#: input, its bytes, output, and what is said of the property that is lost
NAMED: tuple[tuple[str, bytes, str, str], ...] = (
    ("radius.ply", _ply(("float", "radius", _FOUR)), "out.obj", "vertex radii"),
    ("radius.ply", _ply(("float", "radius", _FOUR)), "out.off", "vertex radii"),
    ("radius.ply", _ply(("float", "radius", _FOUR)), "out.stl", "vertex radii"),
    ("alpha.ply", _ply(*(("uchar", c, [1, 2, 3, 4]) for c in ("red", "green", "blue", "alpha"))), "out.obj", "vertex opacities"),
    ("intensity.ply", _ply(("float", "intensity", _FOUR)), "out.obj", "vertex property 'float intensity'"),
    ("scalar.ply", _ply(("float", "quality", _FOUR)), "out.off", "vertex scalars"),
    ("face_normals.ply", _ply(faces=[("float", c, [1.0] * 4) for c in ("nx", "ny", "nz")]), "out.obj", "face property"),
    ("lists.ply", _ply(("list uchar int", "views", [[1, 2], [5], [3], [4]])), "out.obj", "'list int views'"),
    ("comment.ply", _ply(head="comment scanned on Monday"), "out.obj", "comment 'scanned on Monday'"),
    ("info.ply", _ply(head="obj_info range 3"), "out.obj", "range 3"),
    ("third.obj", (_TRIANGLE.replace("vt 1 0", "vt 1 0 7") + _FACE).encode(), "out.ply", "third texture coordinates"),
    ("no_library.obj", (_TRIANGLE + "usemtl a\n" + _FACE).encode(), "out.ply", "uses of materials (1)"),
    ("groups.obj", (_TRIANGLE + "g a\no b\ns 1\n" + _FACE).encode(), "out.ply", "groups (1); objects (1); smoothing groups (1)"),
    ("weights.obj", b"v 0 0 0 1\nv 1 0 0 2\nv 0 1 0 1\nf 1 2 3\n", "out.ply", "weights of vertices"),
    ("comments.off", b"OFF # by hand\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "out.ply", "comments"),
    ("notes.xyz", b"# on Monday\n0 0 0\n1 0 0\n", "out.ply", "does not hold these contents of notes.xyz: comments"),
    ("notes.pts", b"# x y z\n0 0 0 # here\n1 0 0\n", "out.xyz", "the comments of the text that was read are left out"),
    ("solids.stl", _SOLID % b"lid" + _SOLID % b"box", "out.ply", "solids.stl: its head 'lid'; solids (2)"),
    ("solids.stl", _SOLID % b"lid" + _SOLID % b"box", "out.stl", "solids.stl: its head 'lid'; solids (2)"),
    (
        "head.stl",
        b"made on Monday".ljust(80) + struct.pack("<I", 1) + bytes(12) + np.eye(3, dtype="<f4").tobytes() + bytes(2),
        "out.ply",
        "its head 'made on Monday'",
    ),
    ("comments.obj", b"# scanned by Anna\n#\nv 0 0 0\nv 1 0 0 # a tip\nv 0 1 0\nf 1 2 3\n", "out.stl", "comments (2)"),
    ("k\xf6rper.stl", _SOLID % "Körper".encode(), "out.ply", "its head 'Körper'"),
    ("second.glb", _gltf({}, {"TEXCOORD_1": 2}), "out.ply", "attribute TEXCOORD_1"),
    ("bare.glb", _gltf({}, {"TEXCOORD_0": 2}), "out.ply", "texture coordinates without a texture"),
    ("points.glb", _points_gltf({"TEXCOORD_0": 2}), "out.ply", "texture coordinates without a texture"),
    (
        "shared.glb",
        _points_gltf({}, materials=[RED], faces=True),
        "out.ply",
        "colours of points and lines that share vertices with faces or other colours",
    ),
    ("custom.glb", _gltf({}, {"_HEAT": 1}), "out.ply", "attribute _HEAT"),
    ("extras.glb", _gltf({"extras": {"by": "me"}}, {}), "out.ply", "extras"),
    ("names.glb", _gltf({"nodes": [{"mesh": 0, "name": "nose"}]}, {}), "out.ply", "names of nodes"),
    ("normals.glb", _gltf({}, {"NORMAL": 1}), "out.stl", "vertex normals"),
    ("unit.glb", _gltf({}, {}), "out.ply", "does not hold the unit of unit.glb, m; .3mf and .glb keep it"),
    ("e.glb", _gltf({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 3}]}]}, {}), "out.ply", "; .glb keeps"),
)


@pytest.mark.parametrize("case", NAMED, ids=lambda c: f"{c[0]}-{c[2]}")
def test_what_is_lost_is_named(tmp_path: Path, case: tuple[str, bytes, str, str]) -> None:
    """A warning names it; with --keep-all it is an error that names it, and nothing is staged."""
    name, data, output, said = case
    path = tmp_path / name
    path.write_bytes(data)
    assert said in " ".join(session_report(path, tmp_path / output)["warnings"])
    with pytest.raises((InputError, OutputError)) as caught:
        session_report(path, tmp_path / f"again-{output}", keep_all=True)
    assert said in str(caught.value)


SCANNER: Mapping[str, tuple[str, list[float]]] = {
    "intensity": ("float", [0.1, 0.2, 1e-3, 77.25]),
    "confidence": ("float", [1.0, 0.999, 0.5, 0.0]),
    "gps_time": ("double", [1.7e9 + 1 / 3, 1.7e9 + 2 / 3, 0.1, 1e-300]),
    "scan_angle": ("short", [-3, 7, 0, 32767]),
    "label": ("uchar", [0, 255, 3, 4]),
    "radius": ("double", [0.1, 3.4e38, 1e-300, 7.0]),
    "flags": ("int", [1, 0, 1, -7]),
}


@pytest.mark.parametrize("steps", [(), (SMOOTH,), (("apply_coord_taubin_fairing", {}),)], ids=["read", "built-in", "ours"])
def test_scanner_properties_travel(tmp_path: Path, steps: Any) -> None:
    """What MeshLab does not know or misreads, as a radius of double precision and flags, comes through filters with every bit,
    under its own name and in its own type.
    """
    path = tmp_path / "scan.ply"
    path.write_bytes(_ply(*((kind, name, values) for name, (kind, values) in SCANNER.items())))
    report = session_report(path, tmp_path / "out.ply", *steps)
    assert report["warnings"] == []
    staged = staged_files(report)["out.ply"]
    assert read_header(staged).elements == read_header(path).elements
    written, before = columns(staged), columns(path)
    for name, (kind, values) in SCANNER.items():
        expected = np.array(values, {"float": "f4", "short": "i2", "uchar": "u1", "int": "i4"}.get(kind, "f8"))
        np.testing.assert_array_equal(written["vertex", name], expected)
        assert written["vertex", name].dtype == before["vertex", name].dtype


@pytest.mark.parametrize("library", ["", "mtllib m.mtl\nusemtl a\n"], ids=["plain", "with materials"])
def test_levels_of_colours_are_kept(tmp_path: Path, library: str) -> None:
    """All 256 levels of an OBJ file's colours come through, with a material file or without."""
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 1 1\n")
    rows = "".join(f"v {k} {k % 7} 0 {k / 255} 0 {(255 - k) / 255}\n" for k in range(256))
    path = tmp_path / "colours.obj"
    path.write_text(rows + library + "".join(f"f {k} {k + 1} {k + 2}\n" for k in range(1, 255)))
    staged = staged_files(session_report(path, tmp_path / "out.ply"))["out.ply"]
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(staged))
    found = np.rint(255 * meshes.current_mesh().vertex_color_matrix())
    np.testing.assert_array_equal(found[:, 0], np.arange(256))
    np.testing.assert_array_equal(found[:, 2], np.arange(256)[::-1])


def _textured_obj(folder: Path) -> Path:
    shutil.copy(IMAGE, folder / "my tex.png")
    (folder / "m.mtl").write_text("newmtl a\nmap_Kd my tex.png\n")
    path = folder / "mesh.obj"
    path.write_text("mtllib m.mtl\n" + _TRIANGLE + "usemtl a\n" + _FACE)
    return path


def _textured_glb(folder: Path) -> Path:
    image = "data:image/png;base64," + base64.b64encode(IMAGE.read_bytes()).decode()
    more = {
        "images": [{"uri": image}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "material": 0}]}],
    }
    path = folder / "mesh.glb"
    path.write_bytes(_gltf(more, {}))
    return path


@pytest.mark.parametrize("make", [_textured_obj, _textured_glb])
@pytest.mark.parametrize("output", ["out.ply", "out.obj"])
def test_textures_are_images_with_a_name_for_it(tmp_path: Path, make: Callable[[Path], Path], output: str) -> None:
    """A texture whose name has a blank, or that is within a glTF file, comes out with its own bytes and an extension."""
    (tmp_path / "in").mkdir()
    staged = staged_files(session_report(make(tmp_path / "in"), tmp_path / output))
    (image,) = [path for name, path in staged.items() if Path(name).suffix == ".png"]
    assert image.read_bytes() == IMAGE.read_bytes()


def test_points_and_lines_have_the_colour_of_their_material(tmp_path: Path) -> None:
    """Their vertices have it, since they have no faces; in VRML it is the emitted colour, as no light falls on them."""
    path = tmp_path / "points.glb"
    path.write_bytes(_points_gltf({}, materials=[RED]))
    assert read_file(path).mesh.vertex_attributes["colors"].tolist() == [[255, 0, 0, 255]] * 3
    line = "IndexedLineSet { coord Coordinate { point [0 0 0, 1 0 0] } coordIndex [0 1] }"
    path = tmp_path / "line.wrl"
    path.write_text(
        f"#VRML V2.0 utf8\nShape {{ appearance Appearance {{ material Material {{ emissiveColor 0 1 0 }} }} geometry {line} }}"
    )
    assert read_file(path).mesh.vertex_attributes["colors"].tolist() == [[0, 255, 0, 255]] * 2


DAE = """<COLLADA><library_effects><effect id="e"><profile_COMMON><technique><lambert><diffuse><color>1 0 0 1</color></diffuse>
</lambert></technique></profile_COMMON></effect></library_effects><library_materials><material id="m"><instance_effect url="#e"/>
</material></library_materials><library_geometries><geometry id="g"><mesh><source id="s"><float_array id="a" count="6">0 0 0 1 0 0
</float_array><technique_common><accessor source="#a" count="2" stride="3"/></technique_common></source><vertices id="v">
<input semantic="POSITION" source="#s"/></vertices><lines count="1" material="x"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="COLOR" source="#s" offset="0"/><p>0 1</p></lines></mesh></geometry></library_geometries><library_visual_scenes>
<visual_scene id="w"><node><instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="x" target="#m"
/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes><scene>
<instance_visual_scene url="#w"/></scene></COLLADA>"""


def test_lines_of_collada_have_the_colour_of_their_material(tmp_path: Path) -> None:
    """Their vertices have it; further inputs of lines, such as colours, are named."""
    path = tmp_path / "lines.dae"
    path.write_text(DAE)
    mesh = read_file(path).mesh
    assert mesh.vertex_attributes["colors"].tolist() == [[255, 0, 0, 255]] * 2
    assert mesh.source is not None
    assert mesh.source.extras == ("inputs COLOR of lines",)
