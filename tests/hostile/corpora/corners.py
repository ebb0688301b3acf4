"""Files at the corners of their formats: what a format allows and seldom anybody writes, or forbids and somebody does."""

from __future__ import annotations

import json
import struct
from typing import Any

from ..documents import collada, three_mf, vrml, x3d
from .gltf import I, P, _uri, doc

_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
_FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
_VERTEX = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
_TAGGED = "element vertex 3\nproperty uchar tag\nproperty float x\nproperty float y\nproperty float z\n"
_FACE = "element face 1\nproperty list uchar int vertex_indices\n"
_PLACES = "0 0 0\n1 0 0\n0 1 0\n"
_CORNERS = struct.pack("<B3i", 3, 0, 1, 2)
_GRID = "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
_BEAMS = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"


def _ply(head: str, body: str | bytes, form: str = "ascii") -> bytes:
    data = body if isinstance(body, bytes) else body.encode()
    return f"ply\nformat {form} 1.0\n{head}end_header\n".encode() + data


def _stl(facets: int, head: bytes = b"", bits: int = 0) -> bytes:
    each = struct.pack("<12fH", 0, 0, 1, *(0, 0, 0, 1, 0, 0, 0, 1, 0), bits)
    return head.ljust(80, b" ") + struct.pack("<I", facets) + each * facets


def _archive(old: str, new: str) -> bytes:
    model = (
        '<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        '<resources><object id="1" type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
        '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="1"/>'
        '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>'
    )
    assert old in model
    return three_mf(model=model.replace(old, new))


def _sparse(**change: Any) -> bytes:
    """A document whose first accessor says two of its places anew."""
    data = P + I + struct.pack("<4H", 0, 1, 2, 2) + P
    sparse: dict[str, Any] = {"count": 2, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3}}
    lengths = (36, 8, 8, 36)
    views = [{"buffer": 0, "byteOffset": sum(lengths[:k]), "byteLength": n} for k, n in enumerate(lengths)]
    buffer = {"byteLength": sum(lengths), "uri": _uri(data)}
    return doc(accessors__0__sparse=sparse | change, bufferViews=views, buffers=[buffer])


def _without_view() -> bytes:
    document = json.loads(_sparse())
    del document["accessors"][0]["bufferView"]
    return json.dumps(document).encode()


_RED = '<basematerials id="5"><base name="r" displaycolor="#FF0000"/></basematerials>'
_ITEM, _OBJECT = '<item objectid="1"/>', '<object id="1" type="model">'
_MAGICS = b"COLOR=\xff\x01\x01\xff,MATERIAL=\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01"

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("comment_with_backslash.obj", _OBJ + "# from c:\\scans\\\nf 1 2 3\n", (3, 1, "comments (1)")),
    ("remark_with_backslash.obj", _OBJ + "f 1 2 3 # first \\\nf 3 2 1\n", (3, 2, "comments (1)")),
    ("hash_in_a_name.obj", "o a#b \\\n c\n" + _OBJ + "f 1 2 3\n", (3, 1, "objects (1)")),
    ("form_feed.obj", _OBJ + "f\f1 2 3\n", "its line 4, 'f\\x0c1 2 3', begins with no keyword of the format"),
    ("vertical_tab.obj", _OBJ + "f\v1 2 3\n", "its line 4, 'f\\x0b1 2 3', begins with no keyword of the format"),
    ("no_break_space.obj", _OBJ + "f\u00a01 2 3\n", "begins with no keyword of the format"),
    ("glued_remark.obj", _OBJ + "f 1 2 3#x\n", "has something else than whole numbers"),
    ("open_exponent.obj", _OBJ.replace("1 0 0", "1e 0 0") + "f 1 2 3\n", "has something else than numbers"),
    ("relative_then_more.obj", _OBJ + "f -1 -2 -3\nv 9 9 9\nf -1 -2 -3\n", (4, 2)),
    ("line_separators.obj", _OBJ.replace("\n", "\u2028") + "f 1 2 3\n", "its line 1, "),
    (
        "list_of_vertices.ply",
        _ply(_VERTEX + "property list uchar int near\n" + _FACE, "0 0 0 2 1 2\n1 0 0 0\n0 1 0 1 0\n3 0 1 2\n"),
        (3, 1),
    ),
    (
        "huge_list.ply",
        _ply(
            _VERTEX + "element face 1\nproperty list uint int vertex_indices\n",
            P + struct.pack("<I3i", 0xFFFFFFF0, 0, 1, 2),
            "binary_little_endian",
        ),
        "is cut short, or a list in it has an impossible length",
    ),
    (
        "largest_index.ply",
        _ply(
            _VERTEX + "element face 1\nproperty list uchar uint vertex_indices\n",
            P + struct.pack("<B3I", 3, 0, 1, 0xFFFFFFFF),
            "binary_little_endian",
        ),
        "names a vertex that is not among its 3",
    ),
    (
        "line_feed_first.ply",
        _ply(_TAGGED + _FACE, b"".join(b"\n" + P[k : k + 12] for k in (0, 12, 24)) + _CORNERS, "binary_little_endian"),
        (3, 1),
    ),
    (
        "two_ends_of_lines.ply",
        f"ply\r\nformat binary_little_endian 1.0\n{_VERTEX}{_FACE}end_header\r\n".encode() + P + _CORNERS,
        (3, 1),
    ),
    ("zero_in_a_row.ply", _ply(_VERTEX + _FACE, _PLACES + "3 0 1\0 2\n"), "has a 'vertex_indices' that is no int"),
    (
        "wrong_end_first.ply",
        _ply(_VERTEX + _FACE, P + struct.pack(">B3i", 3, 0, 1, 2), "binary_little_endian"),
        "names a vertex that is not among its 3",
    ),
    (
        "open_strips.ply",
        _ply(_VERTEX + "element tristrips 1\nproperty list int int vertex_indices\n", _PLACES + "5 -1 -1 0 1 -1\n"),
        (3, 0),
    ),
    (
        "colours_of_reals.ply",
        _ply(
            _VERTEX + "property float red\nproperty float green\nproperty float blue\n" + _FACE,
            "0 0 0 1 0 0\n1 0 0 2 0 0\n0 1 0 nan 0 0\n3 0 1 2\n",
        ),
        (3, 1),
    ),
    (
        "fourth_column.ptx",
        _GRID.replace("1 0 0 0\n", "1 0 0 5\n", 1) + "1 2 3 0.5\n4 5 6 0.5\n",
        "the last column of a grid's matrix is not 0 0 0 1",
    ),
    (
        "matrix_nan.ptx",
        _GRID.replace("1 0 0 0\n", "nan 0 0 0\n", 1) + "1 2 3 0.5\n4 5 6 0.5\n",
        "a grid's matrix makes points infinite",
    ),
    (
        "more_than_64_bits.ptx",
        _GRID.replace("2\n1\n", "4294967296\n4294967296\n", 1) + "1 2 3 0.5\n",
        "declares 9,007,199,254,740,992 points",
    ),
    ("head_alone.ptx", _GRID, "declares 2 points, but 0 lines follow"),
    ("unmeasured_alone.ptx", _GRID + "0 0 0 0\n0 0 0 0\n", "no vertex could be read"),
    ("two_widths.ptx", _GRID + "1 2 3 0.5\n4 5 6 0.5 1 2 3\n", "points have 4 or 7, the same in the whole grid"),
    (
        "third_grid_short.ptx",
        (_GRID + "1 2 3 0.5\n4 5 6 0.5\n") * 2 + _GRID + "1 2 3 0.5\n",
        "declares 2 points, but 1 lines follow",
    ),
    ("sparse_in_order.gltf", _sparse(), (3, 1)),
    ("sparse_without_view.gltf", _without_view(), (3, 1)),
    ("sparse_of_words.gltf", _sparse(count="2", indices=None, values=[]), "the count of sparse values of accessor 0 is '2'"),
    (
        "restart.gltf",
        doc(buffers__0__uri=_uri(P + struct.pack("<4H", 0, 1, 65535, 0))),
        "names a vertex that is not among the 3 of the mesh",
    ),
    (
        "perspective.gltf",
        doc(nodes__0__matrix=[1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
        "the last row of the matrix of node 0 is not 0 0 0 1",
    ),
    (
        "two_places.gltf",
        doc(nodes__0={"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "translation": [5, 5, 5]}),
        "has a matrix and a rotation, scale or translation besides",
    ),
    ("mirror.gltf", doc(nodes__0__matrix=[-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), (3, 1)),
    ("mirror_by_scale.gltf", doc(nodes__0__scale=[1, -2, 1]), (3, 1)),
    ("turned_twice.gltf", doc(nodes__0__scale=[-1, -2, 1]), (3, 1)),
    ("halves.gltf", doc(accessors__0__byteOffset=0.5), "the offset of its accessor 0 is '0.5'"),
    ("digits.gltf", doc().replace(b'"count": 3', b'"count": ' + b"9" * 5000, 1), "it holds no glTF document"),
    ("mirror.dae", collada().replace('<node id="n">', '<node id="n"><scale>1 1 -1</scale>'), (3, 1)),
    (
        "mirror_by_matrix.dae",
        collada().replace('<node id="n">', '<node id="n"><matrix>-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>'),
        (3, 1),
    ),
    (
        "mirror.x3d",
        x3d().replace("<Shape>", '<Transform scale="-1 1 1"><Shape>').replace("</Shape>", "</Shape></Transform>"),
        (3, 1),
    ),
    (
        "mirror.wrl",
        vrml().replace("Shape {", "Transform { translation 0 0 0 scale -1 1 1 children [ Shape {", 1) + "] }\n",
        (3, 1),
    ),
    ("mirror.3mf", _archive(_ITEM, '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'), (3, 2)),
    (
        "colours.3mf",
        _archive(
            _OBJECT,
            _RED + '<object id="1" type="model" pid="5" pindex="0">',
        ),
        (3, 2, "attributes 'name' of the elements 'base' (1)"),
    ),
    (
        "colour_of_nothing.3mf",
        _archive('v3="2"/>', 'v3="2" pid="77" p1="9"/>'),
        (3, 2, "properties of triangles in its group '77'"),
    ),
    (
        "not_to_be_printed.3mf",
        _archive(_ITEM, '<item objectid="1" printable="0"/>'),
        (3, 2, "attributes 'printable' of the elements 'item' (1)"),
    ),
    ("support.3mf", _archive('type="model"', 'type="support"'), (3, 2, "the object type 'support' (1)")),
    ("title.3mf", _archive("<resources>", '<metadata name="Title">cat</metadata><resources>'), (3, 2, "elements 'metadata' (1)")),
    ("program.3mf", _archive("<resources>", '<metadata name="Application">x</metadata><resources>'), (3, 2)),
    (
        "beams.3mf",
        _archive("<model ", f'<model requiredextensions="b" xmlns:b="{_BEAMS}" '),
        f"it needs the extension '{_BEAMS}'",
    ),
    ("unknown_prefix.3mf", _archive("<model ", '<model requiredextensions="zz" '), "it needs the extension 'zz'"),
    (
        "number_and_letter.3mf",
        _archive(_ITEM, '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 5x 0 0"/>'),
        "'5x' among a transform of it is no number",
    ),
    (
        "infinite_place.3mf",
        _archive(_ITEM, '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 1e400 0 0"/>'),
        "number 10 of a transform of it is not finite",
    ),
    (
        "thirteen.3mf",
        _archive(_ITEM, '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0 7"/>'),
        "a transform of it has 13 numbers and not 12",
    ),
    ("script_before.3mf", b"#!/bin/sh\nexit\n" + three_mf(), "it does not begin with 'PK'"),
    ("viscam.stl", _stl(2, bits=0xFC00), (3, 2)),
    ("magics.stl", _stl(2, _MAGICS, 0x001F), (3, 2)),
    (
        "magics_with_a_zero.stl",
        _stl(2, _MAGICS.replace(b"\x01", b"\0", 1), 0x001F),
        (3, 2),
    ),
    ("colour_of_the_head.stl", _stl(2, _MAGICS, 0x8000), (3, 2)),
    ("of_meshlab.stl", _stl(2, b"COLOR=\x7f\x7f\x7f MATERIAL=\x7f\x7f\x7f \x7f\x7f\x7f \x7f\x7f\x7f", 0xFC1F), (3, 2)),
    ("bits_for_something_else.stl", _stl(2, bits=7), (3, 2, "the data after 2 of its facets, which is no colour")),
    ("byte_order_mark.stl", "\ufeffsolid a\n" + _FACET + "endsolid\n", (3, 1, "its head 'a'")),
    ("remark_first.stl", "# by hand\nsolid a\n" + _FACET + "endsolid a\n", "it is neither a text that begins with 'solid'"),
    ("coloured_text.stl", "solid a\ncolor 1 0 0\n" + _FACET + "endsolid\n", "its line 2, 'color 1 0 0', is not what comes next"),
    ("other_end_first.stl", _stl(2)[:80] + struct.pack(">I", 2) + _stl(2)[84:], "it declares 33,554,432 triangles"),
)
