"""GlTF files whose references, lengths or chunks lie."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

P = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
I = np.array([0, 1, 2, 0], "<u2").tobytes()  # noqa: E741


def doc(**changes: Any) -> bytes:
    """A document of one triangle; ``nodes__0__mesh=7`` changes what is there, None deletes it."""
    document: Any = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8}],
        "buffers": [{"byteLength": 44, "uri": _uri(P + I)}],
    }
    for where, value in changes.items():
        *path, last = (int(word) if word.isdigit() else word for word in where.split("__"))
        part = document
        for word in path:
            part = part[word]
        if value is None:
            del part[last]
        else:
            part[last] = value
    return json.dumps(document).encode()


def _uri(data: bytes) -> str:
    return f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"


def nest(levels: int) -> bytes:
    """A document with lists in lists."""
    return b'{"asset":{"version":"2.0"},"extras":' + b"[" * levels + b"]" * levels + b"}"


def _padded(text: bytes) -> bytes:
    return text + b" " * (-len(text) % 4)


def mkglb(
    text: bytes, data: bytes = b"", ver: int = 2, length: int | None = None, chunks: Sequence[tuple[bytes, bytes]] = ()
) -> bytes:
    """A binary file of a document and its buffer, or of other chunks."""
    chunks = chunks or [(b"JSON", _padded(text)), *([(b"BIN\0", data)] if data else [])]
    body = b"".join(struct.pack("<I", len(chunk)) + kind + chunk for kind, chunk in chunks)
    return b"glTF" + struct.pack("<II", ver, len(body) + 12 if length is None else length) + body


bj = doc(buffers__0__uri=None)

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("honest.gltf", doc(), (3, 1)),
    ("no_scene.gltf", doc(scenes=None, scene=None), "it has no scene, so nothing in it is placed"),
    ("scene_oor.gltf", doc(scene=5), "it refers to number 5 of its 1 scenes"),
    ("node_oor.gltf", doc(scenes=[{"nodes": [9]}]), "it refers to number 9 of its 1 nodes"),
    ("mesh_oor.gltf", doc(nodes__0__mesh=7), "it refers to number 7 of its 1 meshes"),
    ("acc_oor.gltf", doc(meshes__0__primitives__0__indices=9), "it refers to number 9 of its 2 accessors"),
    ("neg_acc.gltf", doc(meshes__0__primitives__0__indices=-1), "it refers to number -1 of its 2 accessors"),
    ("float_acc.gltf", doc(meshes__0__primitives__0__indices=1.0), "it refers to number 1.0 of its 2 accessors"),
    ("str_acc.gltf", doc(meshes__0__primitives__0__indices="1"), "it refers to number 1 of its 2 accessors"),
    ("true_acc.gltf", doc(meshes__0__primitives__0__indices=True), "it refers to number True of its 2 accessors"),
    ("count0.gltf", doc(accessors__0__count=0), "the count of accessor 0 is '0'"),
    ("countf.gltf", doc(accessors__0__count=3.5), "the count of accessor 0 is '3.5'"),
    ("countneg.gltf", doc(accessors__0__count=-3), "the count of accessor 0 is '-3'"),
    ("counthuge.gltf", doc(accessors__0__count=10**18), "the count of accessor 0 is '1000000000000000000'"),
    ("mat_nan.gltf", doc(nodes__0__matrix=[float("nan")] * 16), "the matrix of node 0 is not finite"),
    ("mat15.gltf", doc(nodes__0__matrix=[1] * 15), "the matrix of node 0 is no list of 16 numbers"),
    ("mat0.gltf", doc(nodes__0__matrix=[0] * 16), "the last row of the matrix of node 0 is not 0 0 0 1"),
    ("mat_str.gltf", doc(nodes__0__matrix=["a"] * 16), "the matrix of node 0 is no list of 16 numbers"),
    ("scale0.gltf", doc(nodes__0__scale=[0, 0, 0]), (3, 1, "all its 3 vertices are at one place")),
    ("scale_huge.gltf", doc(nodes__0__scale=[1e300] * 3), (3, 1)),
    ("rot_nonunit.gltf", doc(nodes__0__rotation=[5, 0, 0, 0]), "the rotation of node 0 is of length 5 and not 1"),
    (
        "points.gltf",
        doc(meshes__0__primitives__0__mode=0),
        (3, 0),
    ),
    (
        "lines.gltf",
        doc(meshes__0__primitives__0__mode=1),
        "a primitive of its mesh 0 has 3 corners, which is no multiple of 2",
    ),
    (
        "strip.gltf",
        doc(meshes__0__primitives__0__mode=5),
        (3, 1),
    ),
    (
        "fan.gltf",
        doc(meshes__0__primitives__0__mode=6),
        (3, 1),
    ),
    (
        "mode99.gltf",
        doc(meshes__0__primitives__0__mode=99),
        "its mesh 0 has primitives of the unknown mode 99",
    ),
    (
        "idx_float.gltf",
        doc(accessors__1__componentType=5126),
        "its accessor 1 of corners has a type that glTF does not allow",
    ),
    (
        "idx_short.gltf",
        doc(accessors__1__componentType=5122),
        "its accessor 1 of corners has a type that glTF does not allow",
    ),
    (
        "idx_count2.gltf",
        doc(accessors__1__count=2),
        "a primitive of its mesh 0 has 2 corners, which is no multiple of 3",
    ),
    (
        "idx_u8.gltf",
        doc(accessors__1__componentType=5121),
        (3, 1),
    ),
    ("pos_vec2.gltf", doc(accessors__0__type="VEC2"), "the POSITION of its mesh 0 has a type that glTF does not allow"),
    (
        "pos_u8.gltf",
        doc(accessors__0__componentType=5121),
        "the POSITION of its mesh 0 has a type that glTF does not allow",
    ),
    ("pos_norm.gltf", doc(accessors__0__normalized=True), (3, 1)),
    (
        "sparse.gltf",
        doc(accessors__0__sparse={"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}),
        (3, 1),
    ),
    (
        "sparse_oor.gltf",
        doc(
            accessors__0__sparse={"count": 999, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}
        ),
        "the index list of sparse accessor 0 takes 1,998 bytes of a buffer view of 8",
    ),
    (
        "draco.gltf",
        doc(extensionsRequired=["KHR_draco_mesh_compression"], extensionsUsed=["KHR_draco_mesh_compression"]),
        "it needs KHR_draco_mesh_compression, unknown here; save the file without it",
    ),
    (
        "quant.gltf",
        doc(extensionsRequired=["KHR_mesh_quantization"]),
        (3, 1),
    ),
    ("ext_used.gltf", doc(extensionsUsed=["KHR_foo"]), (3, 1, "extension KHR_foo")),
    (
        "meshopt.gltf",
        doc(extensionsRequired=["EXT_meshopt_compression"]),
        "it needs EXT_meshopt_compression, unknown here; save the file without it",
    ),
    ("stride1.gltf", doc(bufferViews__0__byteStride=1), "the stride of buffer view 0 is 1"),
    ("stride_huge.gltf", doc(bufferViews__0__byteStride=10**9), "the stride of buffer view 0 is 1000000000"),
    ("stride4.gltf", doc(bufferViews__0__byteStride=4), "its accessor 0 has elements of 12 bytes in a buffer view of stride 4"),
    ("no_view.gltf", doc(accessors__0__bufferView=None), "its accessor 0 has 3 values in no buffer view"),
    ("b64bad.gltf", doc(buffers__0__uri="data:application/octet-stream;base64,@@@@"), "data within it is not written in base64"),
    (
        "b64short.gltf",
        doc(buffers__0__uri="data:application/octet-stream;base64,AAAA"),
        "its buffer 0 declares 44 bytes, but has 3",
    ),
    ("http.gltf", doc(buffers__0__uri="http://127.0.0.1/x.bin"), "its buffer 'http://127.0.0.1/x.bin' does not exist"),
    ("file.gltf", doc(buffers__0__uri="file:///etc/passwd"), "its buffer 'file:///etc/passwd' does not exist"),
    ("no_uri.gltf", doc(buffers__0__uri=None), "its buffer 0 declares 44 bytes, but has 0"),
    ("uri_num.gltf", doc(buffers__0__uri=7), "the uri of buffer 0 is no text"),
    ("missing.gltf", doc(buffers__0__uri="gone.bin"), "its buffer 'gone.bin' does not exist"),
    ("blob.gltf", doc(buffers__0__uri="data:text/plain,hello"), "data within it is not written in base64"),
    ("deep.gltf", nest(100000), "it holds no glTF document"),
    ("deep2.gltf", nest(3000), "it holds no glTF document"),
    ("dupkeys.gltf", doc()[:-1] + b',"meshes":[]}', "it refers to number 0 of its 0 meshes"),
    ("nanjson.gltf", doc(extras=float("nan")), (3, 1, "extras")),
    ("bomjson.gltf", b"\xef\xbb\xbf" + doc(), (3, 1)),
    ("u16json.gltf", doc().decode().encode("utf-16"), (3, 1)),
    ("trailing.gltf", doc() + b"xx", "it holds no glTF document"),
    ("array.gltf", b"[]", "it holds no glTF document"),
    ("null.gltf", b"null", "it holds no glTF document"),
    ("num.gltf", b"7", "it holds no glTF document"),
    ("str.gltf", b'"a"', "it holds no glTF document"),
    ("asset1.gltf", doc(asset={"version": "1.0"}), "its document is not of version 2"),
    ("asset3.gltf", doc(asset={"version": "3.0"}), "its document is not of version 2"),
    ("noasset.gltf", doc(asset=None), "it holds no glTF document"),
    ("meshes_dict.gltf", doc(meshes={}), "its meshes are no list of objects"),
    ("meshes_str.gltf", doc(meshes="abc"), "its meshes are no list of objects"),
    ("nodes_null.gltf", doc(nodes=[None]), "its nodes are no list of objects"),
    ("prims_none.gltf", doc(meshes=[{"primitives": []}]), "its mesh 0 has no primitives"),
    ("attr_none.gltf", doc(meshes=[{"primitives": [{"attributes": {}}]}]), "its mesh 0 has no positions"),
    ("no_mesh.gltf", doc(nodes=[{}]), "no vertex could be read from it"),
    ("color.gltf", doc(meshes__0__primitives__0__attributes={"POSITION": 0, "COLOR_0": 0}), (3, 1)),
    (
        "color_count.gltf",
        doc(meshes__0__primitives__0__attributes={"POSITION": 0, "COLOR_0": 1}),
        "the COLOR_0 of its mesh 0 has a type that glTF does not allow",
    ),
    ("morph.gltf", doc(meshes__0__primitives__0__targets=[{"POSITION": 0}]), (3, 1, "morph targets")),
    ("skin.gltf", doc(nodes__0__skin=0), "it refers to number 0 of its 0 skins"),
    ("anim.gltf", doc(animations=[{"channels": [], "samplers": []}]), (3, 1, "animations")),
    ("camera.gltf", doc(cameras=[{"type": "perspective"}]), (3, 1, "cameras")),
    ("two_scenes.gltf", doc(scenes=[{"nodes": [0]}, {"nodes": [0]}]), (3, 1, "scenes besides the one that it shows (1)")),
    ("mesh_twice.gltf", doc(nodes=[{"mesh": 0}, {"mesh": 0}], scenes=[{"nodes": [0, 1]}]), (6, 2)),
    ("selfchild.gltf", doc(nodes=[{"mesh": 0, "children": [0]}]), "a node of it is its own child, or has two parents"),
    (
        "two_parents.gltf",
        doc(nodes=[{"children": [2]}, {"children": [2]}, {"mesh": 0}], scenes=[{"nodes": [0, 1]}]),
        "a node of it is its own child, or has two parents",
    ),
    (
        "deepnodes.gltf",
        doc(nodes=[{"children": [k + 1]} for k in range(20000)] + [{"mesh": 0}]),
        "its parts are more than 200 levels deep",
    ),
    (
        "fanout.gltf",
        doc(nodes=[{"children": [k + 1] * 1 + [k + 1]} for k in range(30)] + [{"mesh": 0}]),
        "a node of it is its own child, or has two parents",
    ),
    (
        "nanpos.gltf",
        doc(buffers__0__uri=_uri(np.full(9, np.nan, "<f4").tobytes() + I)),
        "no vertex could be read from it",
    ),
    (
        "tex_oor.gltf",
        doc(materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 9}}}], meshes__0__primitives__0__material=0),
        "it refers to number 9 of its 0 textures",
    ),
    ("mat_oor.gltf", doc(meshes__0__primitives__0__material=4), "it refers to number 4 of its 0 materials"),
    ("img_http.gltf", doc(images=[{"uri": "http://127.0.0.1/a.png"}]), (3, 1)),
    (
        "img_bad.gltf",
        doc(images=[{"uri": "data:image/png;base64,AAAA"}]),
        (3, 1),
    ),
    (
        "img_view.gltf",
        doc(images=[{"bufferView": 0, "mimeType": "image/png"}]),
        (3, 1),
    ),
    ("ok.glb", mkglb(bj, P + I), (3, 1)),
    ("ver1.glb", mkglb(bj, P + I, ver=1), "it does not begin with a document of glTF 2"),
    ("len_more.glb", mkglb(bj, P + I, length=99999), "it declares 99,999 bytes, but has 532"),
    ("len_less.glb", mkglb(bj, P + I, length=100), "it declares 100 bytes, but has 532"),
    ("nobin.glb", mkglb(bj), "its buffer 0 declares 44 bytes, but has 0"),
    (
        "twojson.glb",
        mkglb(bj, chunks=[(b"JSON", _padded(bj)), (b"JSON", b"{}  "), (b"BIN\x00", P + I)]),
        "it has two documents",
    ),
    (
        "unknownchunk.glb",
        mkglb(bj, chunks=[(b"JSON", _padded(bj)), (b"BIN\x00", P + I), (b"XXXX", b"abcd")]),
        (3, 1),
    ),
    (
        "binfirst.glb",
        mkglb(bj, chunks=[(b"BIN\x00", P + I), (b"JSON", _padded(bj))]),
        "it does not begin with a document of glTF 2",
    ),
    ("binshort.glb", mkglb(bj, P), "its buffer 0 declares 44 bytes, but has 36"),
    ("nochunks.glb", mkglb(bj, chunks=[(b"XXXX", b"")]), "it does not begin with a document of glTF 2"),
    ("trailing.glb", mkglb(bj, P + I) + b"garbage!", "it declares 532 bytes, but has 540"),
    ("bin_longer.glb", mkglb(bj, P + I + b"12345678"), (3, 1)),
)
