"""Files that lie, as a table: what each is called, what it says, and what is to become of it."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..running.runs import TETRAHEDRON, ply_bytes, xyz
from .documents import collada, three_mf, vrml, x3d


@dataclass(frozen=True)
class Case:
    """One file.

    Attributes:
        name: of the file.
        data: its bytes.
        refusal: what the error must say, or None if the file is to be read.
        counts: how many vertices and faces must be read.
        warning: what a warning must say, or None if none is due.
    """

    name: str
    data: bytes
    refusal: str | None = None
    counts: tuple[int, int] | None = None
    warning: str | None = None


_V = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
_OFF = "0 0 0\n1 0 0\n0 1 0\n"
_FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"

#: texts and what is wrong with them; those without a refusal are read whole
_TEXTS: tuple[tuple[str, str, str | None, tuple[int, int] | None, str | None], ...] = (
    ("decimal_commas.xyz", "1,5 2,5 3,5\n4,5 5,5 6,5\n", "decimals are written with a point", None, None),
    ("decimal_commas.obj", "v 0,5 0 0\nv 1,5 0 0\nv 0 1,5 0\nf 1 2 3\n", "decimals are written with a point", None, None),
    ("decimal_commas.off", "OFF\n3 1 0\n0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "decimals are written with a point", None, None),
    ("word.obj", "v abc 1 2\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1.*else than numbers", None, None),
    ("word.off", "OFF\n3 1 0\nabc 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3.*else than numbers", None, None),
    ("short_row.obj", "v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1.*2 values", None, None),
    ("short_row.xyz", "1 2 3\n4 5\n7 8 9\n", "line 2.*2 numbers", None, None),
    ("short_row.off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 4.*2 values", None, None),
    ("colour_one_short.off", "COFF\n3 1 0\n0 0 0 9 9 9\n1 0 0 9 9\n0 1 0 9 9 9\n3 0 1 2\n", "line 4.*5 values", None, None),
    ("cut_in_an_index.obj", _V * 5 + "f 1 2 14\nf 3 4 1", None, (15, 2), "last line has no line end"),
    ("cut_in_a_number.xyz", "1 2 3\n4 5 6\n7 8 12", None, (3, 0), "last line has no line end"),
    ("titles.xyz", "X Y Z\n1 2 3\n4 5 6\n7 8 8\n", None, (3, 0), None),
    ("words.xyz", "scanned by hand\n1 2 3\n4 5 6\n7 8 8\n", None, (3, 0), "titles 'scanned by hand'"),
    ("unknown_keyword.obj", _V + "fx 1 2 3\n", "line 4.*no keyword", None, None),
    ("cut_face.obj", _V + "f 1 2 3\nf 1 2\n", "line 5.*fewer than 3", None, None),
    ("huge_index.obj", _V + "f 99999999999999999999 1 2\n", "line 4.*not among those before", None, None),
    ("broken_index.obj", _V + "f 1.7 2 3\n", "line 4.*whole numbers", None, None),
    ("zero_index.obj", _V + "f 0 1 2\n", "line 4.*not among those before", None, None),
    ("old_mac.obj", (_V + "f 1 2 3\n").replace("\n", "\r"), None, (3, 1), None),
    ("negative_out_of_range.obj", _V + "f -1 -2 -4\n", "line 4.*not among those before", None, None),
    ("negative.obj", "v 0 0 0\nvt 0 0\nv 1 0 0\nvt 1 0\nv 0 1 0\nvt 0 1\nf -1/-1 -2/-2 -3/-3\nvt 9 9\n", None, (3, 1), None),
    ("continued.obj", "v 0 0 0\nv 1 \\\n0 0\nv 0 1 0\nf 1 \\\r\n2 3\n", None, (3, 1), None),
    ("indented.obj", _V.replace("v", "  v") + "\tf 1 2 3 # a face\n", None, (3, 1), "comments (1)"),
    ("wide_blanks.obj", "v  0  0  0 \nv  1  0  0 \nv  0  1  0 \nf 1 2 3\n", None, (3, 1), None),
    ("mixed_widths.obj", "v 0 0 0\nv 1 0 0 1 1 1\nv 0 1 0\nf 1 2 3\n", "line 2.*6 values, while", None, None),
    ("large_face.obj", _V + "f" + " 1 2 3" * 300_000 + "\n", "line 4.*more than 10,000", None, None),
    ("no_library.obj", _V + "usemtl gone\nf 1 2 3\n", None, (3, 1), "no material file"),
    ("third_texture.obj", _V + "vt 0 0 5\nf 1/1 2/1 3/1\n", None, (3, 1), "third texture"),
    ("cut.stl", "solid a\n" + _FACET * 2 + _FACET[:60], "cut short", None, None),
    ("no_end.stl", "solid a\n" + _FACET, "cut short", None, None),
    ("two_solids.stl", f"solid a\n{_FACET}endsolid\nsolid b\n{_FACET.replace('0 1 0', '0 1 7')}endsolid\n", None, (4, 2), "'a'"),
    ("strange_normal.stl", f"solid\n{_FACET.replace('normal 0', 'normal -nan(ind)')}endsolid\n", None, (3, 1), None),
    ("colour_index.off", f"OFF\n3 1 0\n{_OFF}3 0 1 2 7\n", "line 6.*colour by its number", None, None),
    ("far_index.off", f"OFF\n3 1 0\n{_OFF}3 0 1 100000000\n", "line 6.*not among its 3", None, None),
    ("too_many.off", "OFF\n1000000000 1000000000 0\n0 0 0\n", "lines follow", None, None),
    ("too_few.off", f"OFF\n3 1 0\n{_OFF}3 0 1 2\n3 0 2 1\n", "line 7.*one more", None, None),
    ("remarks.off", f"OFF # one\n3 1 0\n# two\n {_OFF}3 0 1 2 255 0 0 # red\n", None, (3, 1), "comments"),
    ("standard.pts", "3\n1 2 3 0.5 10 20 30\n4 5 6 0.5 40 50 60\n7 8 8 0.5 1 2 3\n", None, (3, 0), None),
    ("declares_more.pts", "20000000\n1 2 3\n", "declares 20,000,000 points, but has 1", None, None),
)


def texts() -> Iterator[Case]:
    """Texts that MeshLab reads otherwise than they say."""
    for name, text, refusal, counts, warning in _TEXTS:
        yield Case(name, text.encode(), refusal, counts, warning)


def glb(change: dict[str, object], *, view: dict[str, object] | None = None, indices: bool = False) -> bytes:
    """A binary glTF file of one triangle, with changes to its accessor of places and its buffer view."""
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    corners = np.array([0, 1, 2, 0], "<u2").tobytes()
    primitive: dict[str, object] = {"attributes": {"POSITION": 0}} | ({"indices": 1} if indices else {})
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"} | change,
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36} | (view or {}),
            {"buffer": 0, "byteOffset": 36, "byteLength": 8},
        ],
        "buffers": [{"byteLength": 44}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = places + corners
    size = 28 + len(text) + len(data)
    return (
        b"glTF" + struct.pack("<IIII", 2, size, len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    )


def gltfs() -> Iterator[Case]:
    """GlTF files whose lengths and offsets lie."""
    yield Case("honest.glb", glb({}, indices=True), None, (3, 1))
    yield Case("long_accessor.glb", glb({"count": 3000}), "accessor 0 takes")
    yield Case("far_offset.glb", glb({"byteOffset": 1 << 40}), "accessor 0 takes")
    yield Case("long_view.glb", glb({}, view={"byteLength": 10**9}), "buffer view 0 ends")
    yield Case("negative_offset.glb", glb({}, view={"byteOffset": -4}), "offset of buffer view 0 is '-4'")
    yield Case("unknown_type.glb", glb({"type": "VEC9"}), "a type that glTF does not allow")
    yield Case("index_out_of_range.glb", glb({"count": 2}, indices=True), "names a vertex that is not among the 2 of the mesh")
    yield Case(
        "loop.gltf",
        json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]}).encode(),
        "its own child",
    )
    yield Case(
        "short_buffer.glb", glb({}).replace(b'"byteLength": 44', b'"byteLength": 99'), "buffer 0 declares 99 bytes, but has 44"
    )
    yield Case(
        "many_parts.gltf", b'{"asset": {"version": "2.0"}, "x": [' + b"{}," * 700_000 + b"0]}", "more than 1,000,000 parts"
    )


def plys() -> Iterator[Case]:
    """PLY files whose headers lie, and properties that MeshLab takes for its own."""
    faces = TETRAHEDRON[1].tolist()
    yield Case(
        "flags.ply",
        ply_bytes([*xyz(), ("int", "flags", [1, 0, 1, 0])], faces, [("int", "flags", [1] * 4)]),
        None,
        (4, 4),
        None,
    )
    yield Case(
        "bomb.ply", ply_bytes(xyz(), faces=()).replace(b"element vertex 4", b"element vertex 10000000"), "10,000,000 of 'vertex'"
    )


_SUBSET = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;">]>'
_PTX = "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


def headers() -> Iterator[Case]:
    """PLY files whose headers are long, or end where they do not seem to."""
    many = [("char", f"p{k}", [0] * 4) for k in range(45_000)]
    yield Case("properties.ply", ply_bytes([*xyz(), *many]), "more than 1,000 elements and properties")
    comments = "\n".join("comment " + "a" * 90 for _ in range(15_000))
    yield Case("long_header.ply", ply_bytes(xyz(), TETRAHEDRON[1].tolist(), head=comments), None, (4, 4), None)
    yield Case("long_comment.ply", ply_bytes(xyz(), TETRAHEDRON[1].tolist(), head="comment " + "a" * 99_999), None, (4, 4), None)
    hidden = ply_bytes(xyz(), TETRAHEDRON[1].tolist(), head="comment end_header")
    yield Case("end_in_comment.ply", hidden, None, (4, 4), None)


def documents() -> Iterator[Case]:
    """Scenes and archives that lie, or lead out of themselves."""
    yield Case("honest.dae", collada().encode(), None, (3, 1))
    yield Case("honest.wrl", vrml().encode(), None, (3, 1))
    yield Case("remarks.wrl", vrml(points='0 0 0 1 0 0 0 1 0 # "a" [\n').encode(), None, (3, 1))
    yield Case("honest.x3d", x3d().encode(), None, (3, 1))
    yield Case("honest.3mf", three_mf(), None, (3, 2))
    yield Case("count.dae", collada(count=900).encode(), "declares 900 numbers, but has 9")
    yield Case("accessor.dae", collada(accessor=300).encode(), "needs more than its 9 numbers: 300 x 3")
    yield Case("corner.dae", collada(corners="0 1 3").encode(), "number 3 of the corners.*is 3, which is no index into 3 values")
    yield Case("cut.dae", collada(corners="0 1").encode(), "declares 1 triangles, but has 0")
    yield Case("word.dae", collada(points="0 0 0 1 0 0 0 1 x").encode(), "'x' among .*is no number")
    yield Case("comma.dae", collada(points="0,5 0 0 1 0 0 0 1 0").encode(), "'0,5' among .*is no number")
    yield Case("elsewhere.dae", collada(url="other.dae#g").encode(), "which is no geometry of the document")
    yield Case("entities.dae", collada().replace("?>", f"?>{_SUBSET}", 1).encode(), "declares entities")
    many = "".join(f"<image><init_from>{k}.png</init_from></image>" for k in range(20_000))
    yield Case("textures.dae", collada().replace("<library_geo", f"{many}<library_geo").encode(), None, (3, 1))
    yield Case("half.dae", collada().encode()[:300], "is no XML")
    yield Case("deep.dae", b"<COLLADA>" + b"<a>" * 10_000, "levels deep")
    yield Case(
        "corner.wrl", vrml(corners="0 1 9 -1").encode(), "number 3 of the coordIndex.*is 9, which is no index into 3 values"
    )
    yield Case("short.wrl", vrml(points="0 0 0, 1 0 0, 0 1").encode(), "no multiple of 3")
    yield Case("half.wrl", vrml().encode()[:-6], "is cut short")
    yield Case("inline.wrl", vrml(more='Inline { url "b.wrl" }').encode(), "of the type Inline, which is not supported")
    yield Case("proto.wrl", vrml(more='EXTERNPROTO A [ ] "b.wrl"').encode(), "of the type EXTERNPROTO, which is not supported")
    yield Case("old.wrl", vrml().replace("V2.0 utf8", "V1.0 ascii").encode(), "other versions are not known")
    yield Case("corner.x3d", x3d(corners="0 1 -2 -1").encode(), "number 3 of the coordIndex.*is -2")
    yield Case("inline.x3d", x3d(more='<Inline url="b.x3d"/>').encode(), "of the type Inline, which is not supported")
    yield Case("corner.3mf", three_mf(last=7), "is 7, which is no index into 3 values")
    yield Case("bomb.3mf", three_mf(model=" " * (1 << 25)), "unpack to more than 100 times as many")
    yield Case("bomb_beside.3mf", three_mf(more=bytes(1 << 25)), None, (3, 2), "its part 'more.bin'")
    yield Case("entities.3mf", three_mf(model=f"{_SUBSET}<model/>"), "declares entities")
    yield Case("outside.3mf", three_mf(name="../3dmodel.model"), "or its name is not allowed")
    yield Case("no_mesh.3mf", three_mf(model="<model/>"), "it builds no mesh")
    yield Case("half.3mf", three_mf()[:-40], "its archive cannot be read")
    yield Case("no_archive.3mf", b"<model/>", "does not begin with 'PK'")
    yield Case("honest.ptx", (_PTX + "1 2 3 0.5\n4 5 6 0.5\n").encode(), None, (2, 0))
    yield Case("unmeasured.ptx", (_PTX + "1 2 3 0.5\n0 0 0 0.5\n").encode() * 2, None, (2, 0), "2 positions in its grids have no")
    yield Case("declares_more.ptx", (_PTX.replace("2\n", "20000000\n", 1) + "1 2 3 0.5\n").encode(), "declares 20,000,000 points")
    yield Case("short_row.ptx", (_PTX + "1 2 3 0.5\n4 5 6\n").encode(), "line 12.*has 3 numbers")
    yield Case("believed.ctm", b"OCTM", "it does not check their contents")
