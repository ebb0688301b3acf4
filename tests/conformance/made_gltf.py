"""GlTF files that are right."""

from __future__ import annotations

import base64
import io
import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from .solids import ONE, POINTS, TRIANGLES, Array, Made, boxes, facts, moved, quaternion, scaled, turned

_KINDS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def png(colour: tuple[int, int, int] = (200, 100, 50)) -> bytes:
    """A small picture."""
    from PIL import Image

    stream = io.BytesIO()
    Image.new("RGB", (4, 4), colour).save(stream, "PNG")
    return stream.getvalue()


class Document:
    """A glTF document that grows."""

    def __init__(self) -> None:
        """Of nothing but a buffer."""
        self.data = b""
        self.parts: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}

    def view(self, data: bytes, **more: Any) -> int:
        """The number of a new buffer view."""
        self.data += bytes(-len(self.data) % 8)
        self.parts["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more})
        self.data += data
        return len(self.parts["bufferViews"]) - 1

    def accessor(self, values: Array, kind: str = "f4", **more: Any) -> int:
        """The number of a new accessor of these values."""
        values = np.asarray(values)
        width = values.shape[1] if values.ndim == 2 else 1
        data = values.astype(f"<{kind}")
        if data.dtype.itemsize * width % 4 and width > 1:  # rows are aligned
            padded = np.zeros((len(values), -(-width * data.dtype.itemsize // 4) * 4 // data.dtype.itemsize), data.dtype)
            padded[:, :width] = data
            view = self.view(padded.tobytes(), byteStride=padded.shape[1] * data.dtype.itemsize)
        else:
            view = self.view(data.tobytes())
        return self.add("accessors", bufferView=view, componentType=_KINDS[kind], count=len(values), type=_SHAPES[width], **more)

    def add(self, name: str, **part: Any) -> int:
        """The number of a new part of a kind."""
        self.parts.setdefault(name, []).append(part)
        return len(self.parts[name]) - 1

    def box(self, kind: str = "u2", **more: Any) -> dict[str, Any]:
        """A primitive of the box."""
        return {"attributes": {"POSITION": self.accessor(POINTS)}, "indices": self.accessor(TRIANGLES.ravel(), kind), **more}

    def scene(self, *primitives: dict[str, Any]) -> None:
        """A scene of one node with these primitives."""
        self.add("meshes", primitives=list(primitives))
        self.add("nodes", mesh=0)
        self.parts |= {"scenes": [{"nodes": [0]}], "scene": 0}

    def glb(self) -> bytes:
        """The document as one binary file."""
        self.data += bytes(-len(self.data) % 4)
        parts = self.parts | {"buffers": [{"byteLength": len(self.data)}]}
        text = json.dumps(parts).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(self.data), len(text), 0x4E4F534A)
        return head + text + struct.pack("<II", len(self.data), 0x004E4942) + self.data

    def text(self, uri: str = "") -> bytes:
        """The document as a text, its buffer within it or under a name."""
        uri = uri or f"data:application/octet-stream;base64,{base64.b64encode(self.data).decode()}"
        return json.dumps(self.parts | {"buffers": [{"byteLength": len(self.data), "uri": uri}]}).encode()


def _plain(name: str, document: Document, parts: Any = (ONE,), **more: Any) -> Made:
    known = more.pop("facts", None) or boxes(*parts)
    return Made(f"{name}.glb", document.glb(), **known, **more)


def _of_box(name: str, primitive: Any, **more: Any) -> Made:
    document = Document()
    document.scene(primitive(document))
    return _plain(name, document, **more)


def _kinds() -> Iterator[Made]:
    for kind in ("u1", "u2", "u4"):
        yield _of_box(f"indices_{kind}", lambda d, k=kind: d.box(k), more={"vertices": 8, "faces": 12})
    flat = POINTS[TRIANGLES.ravel()]
    yield _of_box("no_indices", lambda d: {"attributes": {"POSITION": d.accessor(flat)}}, more={"vertices": 36, "faces": 12})
    quads = [(a, b, d, c) for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))]
    for mode, name in ((5, "strip"), (6, "fan")):
        parts = [q if mode == 5 else (q[0], q[1], q[3], q[2]) for q in quads]
        document = Document()
        position = document.accessor(POINTS)
        document.scene(
            *(
                {"attributes": {"POSITION": position}, "indices": document.accessor(np.array(p), "u2"), "mode": mode}
                for p in parts
            )
        )
        yield _plain(name, document, more={"faces": 12})
    whole = [i for q in quads for i in (q[0], q[0], *q, q[3], q[3])]
    yield _of_box("stitched_strip", lambda d: {**d.box(), "indices": d.accessor(np.array(whole), "u2"), "mode": 5})
    wedge = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [2, 3, 0], [0, 1, 0]], float)
    fan = facts([(wedge, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4]]))])
    yield _of_box("fan_without_indices", lambda d: {"attributes": {"POSITION": d.accessor(wedge)}, "mode": 6}, facts=fan)
    strip = facts([(POINTS, np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4], [4, 5, 6], [5, 7, 6]]))])
    yield _of_box("strip_without_indices", lambda d: {"attributes": {"POSITION": d.accessor(POINTS)}, "mode": 5}, facts=strip)
    box = {"low": tuple(POINTS.min(axis=0)), "high": tuple(POINTS.max(axis=0)), "area": 0.0}
    for mode, name, edges in ((0, "points", 0), (1, "lines", 4), (2, "loop", 8), (3, "line_strip", 7)):
        primitive = lambda d, m=mode: {"attributes": {"POSITION": d.accessor(POINTS)}, "mode": m}  # noqa: E731
        yield _of_box(name, primitive, facts=box, more={"vertices": 8, "edges": edges})
    one = lambda d: {"attributes": {"POSITION": d.accessor(POINTS)}, "indices": d.accessor(np.array([3]), "u2"), "mode": 2}  # noqa: E731
    yield _of_box("loop_of_one", one, facts=box, more={"edges": 0})


def _accessors() -> Iterator[Made]:
    def interleaved(d: Document) -> dict[str, Any]:
        rows = np.zeros((8, 8), "<f4")
        rows[:, 1:4], rows[:, 4:7] = POINTS, (0, 0, 1)
        view = d.view(rows.tobytes(), byteStride=32)
        kind = {"bufferView": view, "componentType": 5126, "count": 8, "type": "VEC3"}
        place, normal = d.add("accessors", byteOffset=4, **kind), d.add("accessors", byteOffset=16, **kind)
        return {**d.box(), "attributes": {"POSITION": place, "NORMAL": normal}}

    yield _of_box("interleaved", interleaved)

    def offset(d: Document) -> dict[str, Any]:
        view = d.view(bytes(12) + POINTS.astype("<f4").tobytes() + bytes(8))
        corners = d.view(bytes(6) + TRIANGLES.astype("<u2").tobytes())
        place = d.add("accessors", bufferView=view, byteOffset=12, componentType=5126, count=8, type="VEC3")
        index = d.add("accessors", bufferView=corners, byteOffset=6, componentType=5123, count=36, type="SCALAR")
        return {"attributes": {"POSITION": place}, "indices": index}

    yield _of_box("offsets", offset)

    def sparse(d: Document, base: bool, kind: str = "u2") -> dict[str, Any]:
        chosen = np.arange(8) if not base else np.array([1, 4, 6])
        wrong = POINTS.copy()
        wrong[chosen] = 9.0
        index, values = d.view(chosen.astype(f"<{kind}").tobytes()), d.view(POINTS[chosen].astype("<f4").tobytes())
        part = {
            "count": len(chosen),
            "indices": {"bufferView": index, "componentType": _KINDS[kind]},
            "values": {"bufferView": values},
        }
        primitive = d.box()
        own = d.accessor(wrong) if base else d.add("accessors", componentType=5126, count=8, type="VEC3")
        d.parts["accessors"][own]["sparse"] = part
        return {**primitive, "attributes": {"POSITION": own}}

    yield _of_box("sparse", lambda d: sparse(d, True))
    yield _of_box("sparse_u1", lambda d: sparse(d, True, "u1"))
    yield _of_box("sparse_of_zeros", lambda d: sparse(d, False))
    for kind, factor, normalized in (("i2", 32767, True), ("u2", 1, False), ("u1", 255, True), ("i1", 127, True)):
        document = Document()
        stored = np.rint(POINTS / (4 if normalized else 0.25) * (factor if normalized else 1))
        place = document.accessor(stored, kind, normalized=normalized)
        document.scene({**document.box(), "attributes": {"POSITION": place}})
        document.parts |= {"extensionsRequired": ["KHR_mesh_quantization"], "extensionsUsed": ["KHR_mesh_quantization"]}
        scale = 4.0 if normalized else 0.25
        document.parts["nodes"][0]["scale"] = [scale] * 3
        vertices = stored / (factor if normalized else 1) * scale
        yield _plain(f"quantized_{kind}", document, facts=facts([(vertices, TRIANGLES)]))
    document = Document()
    document.scene(document.box())
    data = document.data
    cut = document.parts["bufferViews"][1]["byteOffset"]
    document.parts["bufferViews"][1] |= {"buffer": 1, "byteOffset": 0}
    uri = [f"data:application/gltf-buffer;base64,{base64.b64encode(d).decode()}" for d in (data[:cut], data[cut:])]
    buffers = [{"byteLength": cut, "uri": uri[0]}, {"byteLength": len(data) - cut, "uri": uri[1]}]
    yield Made("two_buffers.gltf", json.dumps(document.parts | {"buffers": buffers}).encode(), **boxes(ONE))
    document = Document()
    document.scene(document.box())
    yield Made("embedded.gltf", document.text(), **boxes(ONE))
    yield Made("beside.gltf", document.text("my%20data.bin"), **boxes(ONE), beside={"my data.bin": document.data})


def _nodes() -> Iterator[Made]:
    t, r, s = moved(3, -2, 5), turned(1, 2, 3, 40), scaled(2, 0.5, 3)
    trs = {"translation": [3, -2, 5], "rotation": quaternion(1, 2, 3, 40), "scale": [2, 0.5, 3]}
    for chosen in (("translation",), ("rotation",), ("scale",), ("translation", "scale"), tuple(trs)):
        document = Document()
        document.scene(document.box())
        document.parts["nodes"] = [{"mesh": 0} | {name: trs[name] for name in chosen}]
        matrix = np.linalg.multi_dot([ONE, ONE, *(m for name, m in zip(trs, (t, r, s), strict=True) if name in chosen)])
        yield _plain("-".join(chosen), document, [matrix])
    document = Document()
    document.scene(document.box())
    document.parts["nodes"][0]["matrix"] = (t @ r @ s).T.ravel().tolist()
    yield _plain("matrix", document, [t @ r @ s])
    document.parts["nodes"][0]["matrix"] = scaled(-1, 2, 1).T.ravel().tolist()
    yield _plain("mirror", document, [scaled(-1, 2, 1)])
    document.parts["nodes"] = [{"mesh": 0, "scale": [-2, -2, -2]}]
    yield _plain("mirror_of_all_axes", document, [scaled(-2, -2, -2)])
    document.parts["nodes"] = [
        {"children": [1], **trs},
        {"children": [2], "scale": [1, 1, 4]},
        {"mesh": 0, "rotation": trs["rotation"]},
    ]
    yield _plain("nested", document, [t @ r @ s @ scaled(1, 1, 4) @ r])
    document.parts["nodes"] = [{"mesh": 0, "children": [1], "translation": [9, 0, 0]}, {"mesh": 0, "translation": [0, 9, 0]}]
    yield _plain("mesh_and_child", document, [moved(9, 0, 0), moved(9, 9, 0)], more={"vertices": 16, "faces": 24})
    document.parts["nodes"] = [
        {"mesh": 0},
        {"mesh": 0, "translation": [7, 0, 0]},
        {"mesh": 0, "translation": [0, 7, 0], "scale": [2, 2, 2]},
    ]
    document.parts["scenes"] = [{"nodes": [0, 1, 2]}]
    yield _plain("instances", document, [ONE, moved(7, 0, 0), moved(0, 7, 0) @ scaled(2, 2, 2)])
    document.parts["scenes"] = [{"nodes": [0]}, {"nodes": [1]}]
    yield _plain("first_of_two_scenes", document, [ONE], more={"named": "scene"})
    document.parts["scene"] = 1
    yield _plain("second_of_two_scenes", document, [moved(7, 0, 0)], more={"named": "scene"})
    document.parts["scenes"] = [{"nodes": [0]}, {"nodes": [0, 1]}]
    yield _plain("scenes_that_share_a_node", document, [ONE, moved(7, 0, 0)])
    del document.parts["scene"]
    document.parts["scenes"] = [{"nodes": [2]}]
    yield _plain("scene_without_number", document, [moved(0, 7, 0) @ scaled(2, 2, 2)])
    document = Document()
    document.add("meshes", primitives=[document.box()])
    document.add("meshes", primitives=[document.box()])
    document.parts |= {"nodes": [{"mesh": 1, "translation": [1, 1, 1]}], "scenes": [{"nodes": [0]}], "scene": 0}
    yield _plain("mesh_that_is_not_placed", document, [moved(1, 1, 1)])


def _attributes() -> Iterator[Made]:
    yield _of_box("names", lambda d: {**d.box(), "extras": {"a": 1}})
    for kind, width, top in (("f4", 3, 1.0), ("f4", 4, 1.0), ("u1", 3, 255), ("u1", 4, 255), ("u2", 4, 65535)):
        colours = np.tile([0.2, 0.4, 0.8, 1.0][:width], (8, 1)) * top

        def coloured(d: Document, c: Array = colours, k: str = kind, t: float = top) -> dict[str, Any]:
            primitive = d.box()
            primitive["attributes"]["COLOR_0"] = d.accessor(np.rint(c) if t > 1 else c, k, normalized=t > 1)
            return primitive

        yield _of_box(f"colours_{kind}_{width}", coloured, more={"colour": (51, 102, 204)})
    document = Document()
    document.scene({**document.box(), "material": 0})
    document.add("materials", pbrMetallicRoughness={"baseColorFactor": [0.2, 0.4, 0.8, 1]})
    yield _plain("colour_of_material", document, more={"colour": (51, 102, 204)})
    uv = (POINTS[:, :2] - 0.5) / 4
    for kind, top in (("f4", 1.0), ("u1", 255), ("u2", 65535), ("i2", 32767)):
        for where in ("view", "data", "beside"):
            if where != "view" and kind != "f4":
                continue
            document = Document()
            document.scene({**document.box(), "material": 0})
            stored = uv if top == 1 else np.rint(uv * top)
            attributes = document.parts["meshes"][0]["primitives"][0]["attributes"]
            attributes["TEXCOORD_0"] = document.accessor(stored, kind, normalized=top > 1)
            uri = {"data": f"data:image/png;base64,{base64.b64encode(png()).decode()}", "beside": "a%20b.png"}.get(where)
            image = {"uri": uri} if uri else {"bufferView": document.view(png()), "mimeType": "image/png"}
            document.parts |= {"images": [image], "textures": [{"source": 0}]}
            if kind == "i2":
                document.parts["extensionsUsed"] = ["KHR_mesh_quantization"]
            document.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
            beside = {"a b.png": png()} if where == "beside" else {}
            mean = _mean_uv(stored / top)
            yield _plain(f"texture_{where}_{kind}", document, beside=beside, more={"uv": mean, "image": True}, tolerance=1e-4)
    for transform, name in ((False, "second_set"), (True, "texture_transform")):
        document = Document()
        primitive = {**document.box(), "material": 0}
        primitive["attributes"] |= {"TEXCOORD_0": document.accessor(uv * 0), "TEXCOORD_1": document.accessor(uv)}
        document.scene(primitive)
        document.parts |= {"images": [{"bufferView": document.view(png()), "mimeType": "image/png"}], "textures": [{"source": 0}]}
        texture: dict[str, Any] = {"index": 0, "texCoord": 1}
        found = uv
        if transform:
            change = {"offset": [0.1, 0.2], "rotation": 0.5, "scale": [2, 3]}
            texture["extensions"] = {"KHR_texture_transform": change}
            document.parts["extensionsUsed"] = ["KHR_texture_transform"]
            c, s = np.cos(0.5), np.sin(0.5)
            found = (uv * [2, 3]) @ np.array([[c, s], [-s, c]]).T + [0.1, 0.2]
        document.add("materials", pbrMetallicRoughness={"baseColorTexture": texture})
        yield _plain(
            name, document, more={"uv": _mean_uv(found), "image": True}, named=("texture_transform",) if transform else ()
        )
    normals = np.tile([0.0, 0.6, 0.8], (8, 1))

    def with_normals(d: Document) -> dict[str, Any]:
        primitive = d.box()
        primitive["attributes"]["NORMAL"] = d.accessor(normals)
        return primitive

    yield _of_box("normals", with_normals, more={"normal": (0.0, 0.6, 0.8)})
    document = Document()
    document.scene(with_normals(document))
    document.parts["nodes"][0] |= {"rotation": quaternion(1, 0, 0, 90), "scale": [1, 2, 1]}
    placed = np.array([0.0, -0.8, 0.3]) / np.hypot(0.8, 0.3)
    yield _plain("normals_placed", document, [turned(1, 0, 0, 90) @ scaled(1, 2, 1)], more={"normal": tuple(placed)})
    document = Document()
    position, half = document.accessor(POINTS), [TRIANGLES[:6].ravel(), TRIANGLES[6:].ravel()]
    document.scene(*({"attributes": {"POSITION": position}, "indices": document.accessor(h, "u2")} for h in half))
    yield _plain("primitives_that_share_vertices", document, more={"vertices": 8, "faces": 12})


def _deformed() -> Iterator[Made]:
    document = Document()
    primitive = document.box()
    delta = np.zeros((8, 3))
    delta[:, 0] = 2.0 * POINTS[:, 0]
    primitive["targets"] = [{"POSITION": document.accessor(delta)}]
    document.scene(primitive)
    document.parts["meshes"][0]["weights"] = [0.5]
    yield _plain("morphed", document, [scaled(2, 1, 1)], named=("morph",))
    document.parts["meshes"][0]["weights"] = [0.0]
    yield _plain("morph_at_rest", document, named=("morph",))
    document = Document()
    primitive = document.box()
    primitive["attributes"] |= {
        "JOINTS_0": document.accessor(np.zeros((8, 4)), "u1"),
        "WEIGHTS_0": document.accessor(np.tile([1.0, 0, 0, 0], (8, 1))),
    }
    document.scene(primitive)
    document.parts["nodes"] = [{"mesh": 0, "skin": 0}, {"translation": [5, 0, 0]}]
    document.parts |= {"skins": [{"joints": [1]}], "scenes": [{"nodes": [0, 1]}]}
    yield _plain("skinned", document, [moved(5, 0, 0)], named=("skin",))


def _mean_uv(uv: Array) -> tuple[float, float]:
    """Over the area of the box, with v upwards."""
    a, b, c = (POINTS[TRIANGLES[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    mean = (uv[TRIANGLES].mean(axis=1) * area[:, None]).sum(axis=0) / area.sum()
    return float(mean[0]), float(1 - mean[1])


def made() -> Iterator[Made]:
    """All of them."""
    yield from _kinds()
    yield from _accessors()
    yield from _nodes()
    yield from _attributes()
    yield from _deformed()
