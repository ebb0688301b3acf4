"""Reads glTF 2.0 files, text or binary: joins the meshes of the scene, and checks that all values it reads lie in their buffers.

Writes binary files: one mesh with embedded images, a primitive for each pair of a texture and a face colour, and one for edges.
"""

import base64
import io
import json
import struct
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias
from urllib.parse import unquote

import numpy as np

from ..declaration.parameters import METRES
from ..filters.mesh import Floats, Longs
from ..mesh_data import MeshData, Texture
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import Reading, References, check_image
from .outputs import Writing
from .polygons import numbered, triangles_of
from .scenes import NO_TEXTURE, Assembly, affine_matrix, levels

_PARTS = 1_000_000  # the largest number of JSON values in a document; reading a million takes a second
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
#: attributes that are read, each with the allowed numbers of components, and the numpy kinds of components allowed besides float
_READ = {"POSITION": ((3,), ""), "NORMAL": ((3,), ""), "TEXCOORD": ((2,), "u"), "COLOR": ((3, 4), "u")}
#: required extensions that are accepted: integer attributes besides colours; and unlit materials, which are read as lit ones
_QUANTIZED = "KHR_mesh_quantization"
_UNDERSTOOD = {_QUANTIZED, "KHR_materials_unlit"}
_ROUNDED, _UNIT = 1e-6, 0.01  # tolerances: for the last row of a matrix, and for the length of the quaternion of a rotation
_Part: TypeAlias = Mapping[str, Any]


def read_gltf(path: Path, references: References) -> Reading:
    """Reads a glTF file."""
    text, binary = _chunks(path.read_bytes())
    if sum(text.count(mark) for mark in (b",", b"{", b"[")) > _PARTS:
        raise ContentsError(f"its document has more than {_PARTS:,} parts")
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        raise ContentsError("it holds no glTF document") from None
    try:
        reader = _Reader(document, binary, references)
        with np.errstate(all="ignore"):
            reader.read_scene()
        reading = reader.assembly.reading(path, path.suffix[1:].lower(), _losses(document), "m")
    except ContentsError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError, IndexError) as error:
        what = f"{type(error).__name__}: {str(error)[:60]}"
        raise ContentsError(f"its document lacks a part or has a wrong one ({what})") from error
    return replace(reading, side_files=tuple(reader.files))


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    if not data.startswith(b"glTF"):
        return data, None
    if len(data) < 20:
        raise ContentsError("it is cut short")
    version, length = struct.unpack_from("<II", data, 4)
    if length != len(data):
        raise ContentsError(f"it declares {length:,} bytes, but has {len(data):,}")
    parts, position = list[tuple[int, bytes]](), 20
    while position <= length:
        size, kind = struct.unpack_from("<II", data, position - 8)
        if size > length - position:
            raise ContentsError(f"a part of it declares {size:,} bytes, but only {length - position:,} follow")
        parts.append((kind, data[position : position + size]))
        position += size + 8
    if parts[0][0] != _JSON or version != 2:
        raise ContentsError("it does not begin with a document of glTF 2")
    if [kind for kind, _ in parts].count(_JSON) > 1:
        raise ContentsError("it has two documents")
    return parts[0][1], dict(reversed(parts)).get(_BINARY)


class _Reader:
    def __init__(self, document: Any, binary: bytes | None, references: References) -> None:
        if not isinstance(document, dict) or not isinstance(document.get("asset"), dict):
            raise ContentsError("it holds no glTF document")
        if not str(document["asset"].get("version", "")).startswith("2"):
            raise ContentsError("its document is not of version 2")
        required = set(document.get("extensionsRequired", ()))
        if unknown := required - _UNDERSTOOD:
            raise ContentsError(f"it needs {', '.join(sorted(map(str, unknown)))[:80]}, unknown here; save the file without it")
        for name in ("buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes", "images", "textures", "materials"):
            if not isinstance(document.get(name, []), list) or not all(isinstance(x, dict) for x in document.get(name, ())):
                raise ContentsError(f"its {name} are no list of objects")
        self.assembly = Assembly(references)
        self.files: list[Path] = []
        self._document, self._references = document, references
        self._quantized = _QUANTIZED in required.union(document.get("extensionsUsed", ()))
        self._binary, self._buffers = binary, dict[int, bytes]()
        self._meshes: dict[int, list[MeshData]] = {}
        self._seen: set[int] = set()

    def read_scene(self) -> None:
        scenes = self._document.get("scenes", [])
        if not scenes:
            raise ContentsError("it has no scene, so nothing in it is placed")
        scene = self._at("scenes", self._document.get("scene", 0))
        if len(scenes) > 1:
            self.assembly.lost[f"scenes besides the one that it shows ({len(scenes) - 1})"] = None
        for node in scene.get("nodes", ()):
            self._visit(node, np.eye(4))
        if unused := len(self._document.get("meshes", ())) - len(self._meshes):
            self.assembly.lost[f"meshes that its scene does not place ({unused})"] = None

    def _at(self, name: str, index: Any) -> Any:
        parts = self._document.get(name, [])
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(parts):
            raise ContentsError(f"it refers to number {str(index)[:40]} of its {len(parts)} {name}")
        return parts[index]

    def _visit(self, k: int, parent_matrix: Floats) -> None:
        node = self._at("nodes", k)
        if k in self._seen:
            raise ContentsError("a node of it is its own child, or has two parents")
        self._seen.add(k)
        with self.assembly.within(k):
            matrix = parent_matrix @ _matrix(node, k)
            if "mesh" in node and (mesh := node["mesh"]) not in self._meshes:
                groups: dict[str, list[_Part]] = {}  # primitives with the same vertices
                for p in self._at("meshes", mesh)["primitives"]:
                    groups.setdefault(json.dumps(p["attributes"], sort_keys=True), []).append(p)
                if not groups:
                    raise ContentsError(f"its mesh {mesh} has no primitives")
                self._meshes[mesh] = [self._part(mesh, group) for group in groups.values()]
            for part in self._meshes[node["mesh"]] if "mesh" in node else ():
                self.assembly.place(part, matrix)
            if "skin" in node:
                self._at("skins", node["skin"])
            for child in node.get("children", ()):
                self._visit(child, matrix)

    def _part(self, k: int, primitives: list[_Part]) -> MeshData:
        attributes = primitives[0]["attributes"]
        if "POSITION" not in attributes:
            raise ContentsError(f"its mesh {k} has no positions")
        points = self._attribute(k, attributes, "POSITION")
        if {self._at("accessors", index)["count"] for index in attributes.values()} != {len(points)}:
            raise ContentsError(f"the attributes of its mesh {k} have different counts")
        parts = ((*self._corners(k, p, len(points)), *self._material(k, p, attributes)) for p in primitives)
        faces, edges, textures, uvs, colours = zip(*parts, strict=True)
        counts, corners = [len(each) for each in faces], np.concatenate(faces)
        if "TEXCOORD_0" in attributes and max(textures) < 0:
            self.assembly.lost[NO_TEXTURE] = None
        wedges = [np.full((f.size, 2), np.nan) if uv is None else uv[f.ravel()] for f, uv in zip(faces, uvs, strict=True)]
        shades = np.repeat(colours, counts, axis=0)
        firsts = numbers = np.arange(len(points))
        if len(corners) and any(name.startswith("TEXCOORD") for name in attributes):  # vertices are split at seams of the texture
            kept = (self._accessor(i) for name, i in attributes.items() if not name.startswith(("TEXCOORD", "TANGENT")))
            firsts, numbers = numbered(np.column_stack([*kept]))
        part = self.assembly.polygons(
            points[firsts],
            numbers[corners.ravel()],
            np.full(len(corners), 3),
            f"the corners of its mesh {k}",
            {"wedge_texture_coordinates": np.concatenate(wedges)},
            {
                "texture": np.repeat(np.array(textures, np.int32), counts),
                "colors": levels(shades) if (shades != 1.0).any() else None,
            },
        )
        normals = self._attribute(k, attributes, "NORMAL")[firsts] if "NORMAL" in attributes else None
        colors = levels(self._attribute(k, attributes, "COLOR_0"))[firsts] if "COLOR_0" in attributes else None
        part = replace(part, edges=numbers[np.concatenate(edges)]).with_attributes({"normals": normals, "colors": colors})
        bare = [number for number, count in enumerate(counts) if not count]  # points and lines
        if any(textures[number] >= 0 for number in bare):
            self.assembly.lost["textures of points and lines"] = None
        return self.assembly.tinted(part, [colours[number] for number in bare])

    def _attribute(self, k: int, attributes: _Part, name: str) -> Floats:
        """Returns (n, w) values of an attribute; normalised integers are scaled to at most 1."""
        accessor = self._at("accessors", attributes[name])
        widths, kinds = _READ[name.partition("_")[0]]
        dtype, width = _COMPONENTS.get(accessor["componentType"]), _WIDTHS.get(accessor["type"])
        allowed = "iu" if self._quantized and not name.startswith("COLOR") else kinds
        if width not in widths or dtype is None or np.dtype(dtype).kind not in f"f{allowed}" or dtype is np.uint32:
            raise ContentsError(f"the {name} of its mesh {k} has a type that glTF does not allow")
        values = self._accessor(attributes[name])
        if (accessor.get("normalized") or allowed == "u") and values.dtype.kind != "f":
            return np.asarray(np.maximum(values / np.iinfo(values.dtype).max, -1.0))
        return values.astype(np.float64)

    def _corners(self, k: int, p: _Part, count: int) -> tuple[Longs, Longs]:
        mode, corners = p.get("mode", 4), np.arange(count)
        if "indices" in p:
            accessor = self._at("accessors", p["indices"])
            if accessor["type"] != "SCALAR" or accessor["componentType"] not in (5121, 5123, 5125):
                raise ContentsError(f"its accessor {p['indices']} of corners has a type that glTF does not allow")
            corners = self._accessor(p["indices"])[:, 0].astype(np.int64)
            if corners.max() >= count:
                raise ContentsError(f"its accessor {p['indices']} names a vertex that is not among the {count:,} of the mesh")
        width = {1: 2, 4: 3}.get(mode, 1)
        if len(corners) % width:
            raise ContentsError(f"a primitive of its mesh {k} has {len(corners):,} corners, which is no multiple of {width}")
        no_faces, no_edges, whole = np.empty((0, 3), np.int64), np.empty((0, 2), np.int64), np.array([len(corners)])
        match mode:
            case 0:
                return no_faces, no_edges
            case 1:
                return no_faces, corners.reshape(-1, 2)
            case 2 | 3:
                return no_faces, np.stack([corners, np.roll(corners, -1)], 1)[: len(corners) - (mode == 3 or len(corners) < 2)]
            case 4:
                return corners.reshape(-1, 3), no_edges
            case 5 | 6:
                return corners[triangles_of(corners, whole, fans=mode == 6)], no_edges
        raise ContentsError(f"its mesh {k} has primitives of the unknown mode {str(mode)[:40]}")

    def _material(self, k: int, p: _Part, attributes: _Part) -> tuple[int, Floats | None, list[float]]:
        surface = self._at("materials", p["material"]).get("pbrMetallicRoughness", {}) if "material" in p else {}
        colour = _numbers(surface.get("baseColorFactor", [1, 1, 1, 1]), 4, f"the colour of material {p.get('material')}")
        if (texture_use := surface.get("baseColorTexture")) is None:
            return -1, None, colour
        texture = self._at("textures", texture_use["index"])
        if "source" not in texture:
            raise ContentsError(f"its texture {texture_use['index']} is in a form that is not known here")
        if (name := f"TEXCOORD_{texture_use.get('texCoord', 0)}") not in attributes:
            self.assembly.lost[f"the texture of mesh {k}, which has no {name}"] = None
            return -1, None, colour
        uv = self._attribute(k, attributes, name)
        return self._image(texture["source"]), _upright(uv), colour

    def _image(self, k: int) -> int:
        image, mesh = self._at("images", k), self._references.mesh
        uri = image.get("uri")
        if uri is not None and not uri.startswith("data:"):
            return self.assembly.texture(unquote(uri))
        data = _decoded(uri) if uri is not None else self._view(image["bufferView"])[0]
        name = f"{mesh.stem}-texture-{k}{'.jpg' if data.startswith(bytes([0xFF, 0xD8])) else '.png'}"
        check_image(io.BytesIO(data), mesh, name)
        return self.assembly.texture(name, lambda _: data)

    def _buffer(self, k: int) -> bytes:
        if k in self._buffers:
            return self._buffers[k]
        part = self._at("buffers", k)
        length, uri = _whole(part["byteLength"], f"the length of buffer {k}"), part.get("uri")
        if uri is None:
            data = (self._binary or b"") if k == 0 else b""
        elif not isinstance(uri, str):
            raise ContentsError(f"the uri of buffer {k} is no text")
        elif uri.startswith("data:"):
            data = _decoded(uri)
        elif (file := self._references.find(unquote(uri))) is None:
            raise ContentsError(f"its buffer {unquote(uri)[:80]!r} does not exist")
        else:
            self.files.append(file)
            data = file.read_bytes()
        if length > len(data):
            raise ContentsError(f"its buffer {k} declares {length:,} bytes, but has {len(data):,}")
        return self._buffers.setdefault(k, data[:length])

    def _view(self, k: int) -> tuple[bytes, int | None]:
        view = self._at("bufferViews", k)
        data = self._buffer(view["buffer"])
        start = _whole(view.get("byteOffset", 0), f"the offset of buffer view {k}")
        end = start + _whole(view["byteLength"], f"the length of buffer view {k}", 1)
        if end > len(data):
            raise ContentsError(f"its buffer view {k} ends at byte {end:,} of a buffer of {len(data):,}")
        stride = view.get("byteStride")
        if "byteStride" in view and not 4 <= _whole(stride, f"the stride of buffer view {k}") <= 252:
            raise ContentsError(f"the stride of buffer view {k} is {stride}, and not 4 to 252")
        return data[start:end], stride

    def _accessor(self, k: int) -> Array:
        accessor = self._at("accessors", k)
        count = _whole(accessor["count"], f"the count of accessor {k}", 1)
        dtype, width = _COMPONENTS[accessor["componentType"]], _WIDTHS[accessor["type"]]
        sparse = accessor.get("sparse")
        if "bufferView" in accessor:
            values = self._values(accessor, dtype, width, count, f"its accessor {k}")
        elif sparse is None or count > sum(map(len, self._buffers.values())) + (1 << 20):
            raise ContentsError(f"its accessor {k} has {count:,} values in no buffer view")
        else:
            values = np.zeros((count, width), dtype)
        if sparse is not None:
            number = _whole(sparse["count"], f"the count of sparse values of accessor {k}", 1)
            kind = _COMPONENTS[sparse["indices"]["componentType"]]
            places = self._values(sparse["indices"], kind, 1, number, f"the index list of sparse accessor {k}")[:, 0]
            if places.min() < 0 or places.max() >= count:
                raise ContentsError(f"its accessor {k} changes a value that is not among its {count:,}")
            values = values.copy()
            values[places] = self._values(sparse["values"], dtype, width, number, f"the value list of sparse accessor {k}")
        return values

    def _values(self, part: _Part, kind: Any, width: int, count: int, what: str) -> Array:
        data, stride = self._view(part["bufferView"])
        dtype = np.dtype(kind).newbyteorder("<")
        size = dtype.itemsize * width
        if (stride := stride or size) < size:
            raise ContentsError(f"{what} has elements of {size} bytes in a buffer view of stride {stride}")
        start = _whole(part.get("byteOffset", 0), f"the offset of {what}")
        end = start + (count - 1) * stride + size
        if end > len(data):
            raise ContentsError(f"{what} takes {end:,} bytes of a buffer view of {len(data):,}")
        return np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))


def _matrix(node: _Part, k: int) -> Floats:
    if "matrix" in node:
        matrix = np.array(_numbers(node["matrix"], 16, f"the matrix of node {k}")).reshape(4, 4).T
        if not np.allclose(matrix[3], (0, 0, 0, 1), rtol=0, atol=_ROUNDED):
            raise ContentsError(f"the last row of the matrix of node {k} is not 0 0 0 1")
        if node.keys() & {"rotation", "scale", "translation"}:
            raise ContentsError(f"its node {k} has a matrix and a rotation, scale or translation besides, which place it twice")
        return matrix
    linear = np.eye(3)
    if "rotation" in node:
        q = np.array(_numbers(node["rotation"], 4, f"the rotation of node {k}"))
        if abs(np.linalg.norm(q) - 1.0) > _UNIT:
            raise ContentsError(f"the rotation of node {k} is of length {np.linalg.norm(q):.3g} and not 1")
        x, y, z, w = q / np.linalg.norm(q)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        linear += 2 * (w * cross + cross @ cross)
    linear *= _numbers(node.get("scale", [1, 1, 1]), 3, f"the scale of node {k}")
    return affine_matrix(linear, _numbers(node.get("translation", [0, 0, 0]), 3, f"the translation of node {k}"))


def _losses(document: _Part) -> Iterator[str]:
    yield from (name for name in ("animations", "skins", "cameras") if document.get(name))
    primitives = [p for mesh in document.get("meshes", ()) for p in mesh.get("primitives", ())]
    names = {n for p in primitives for n in p["attributes"]} - {"POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"}
    yield from (f"attribute {name}" for name in sorted(names))
    if any(p.get("targets") for p in primitives):
        yield "morph targets"
    if named := [n for n in ("meshes", "nodes", "materials") if any("name" in x for x in document.get(n, ()))]:
        yield f"names of {', '.join(named)}"
    objects = [x for v in document.values() if isinstance(v, list) for x in v if isinstance(x, dict)]
    if any("extras" in x for x in (document, *objects)):
        yield "extras"
    yield from (f"extension {name}" for name in document.get("extensionsUsed", ()) if name != _QUANTIZED)
    keys = {key for m in document.get("materials", ()) for key in (*m, *m.get("pbrMetallicRoughness", {}))}
    keys -= {"name", "extras", "extensions", "pbrMetallicRoughness", "baseColorFactor", "baseColorTexture"}
    if keys:
        yield f"material properties {', '.join(sorted(keys))}"


def _upright(uv: Floats) -> Floats:
    return np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1)


def _whole(value: Any, what: str, least: int = 0) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value < 1 << 53:
        raise ContentsError(f"{what} is {str(value)[:40]!r}, no whole number from {least} to 2^53 - 1")
    return value


def _numbers(values: Any, length: int, what: str) -> list[float]:
    if not isinstance(values, list) or len(values) != length or not all(isinstance(v, int | float) for v in values):
        raise ContentsError(f"{what} is no list of {length} numbers")
    if not np.isfinite(np.array(values, dtype=float)).all():
        raise ContentsError(f"{what} is not finite")
    return [float(v) for v in values]


def _decoded(uri: str) -> bytes:
    head, comma, data = uri.partition(",")
    with suppress(ValueError):
        if comma and head.endswith(";base64"):
            return base64.b64decode(data, validate=True)
    raise ContentsError("data within it is not written in base64")


_MOST_MATERIALS = 1000  # the largest number of materials that are written


class _Document:
    def __init__(self) -> None:
        self.parts: dict[str, Any] = {"asset": {"version": "2.0", "generator": "pymeshfair"}}
        self._pieces: list[bytes] = []
        self._length = 0

    def add(self, name: str, **part: Any) -> int:
        self.parts.setdefault(name, []).append(part)
        return len(self.parts[name]) - 1

    def view(self, data: bytes) -> int:
        self._pieces += [data, bytes(-len(data) % 4)]
        view = self.add("bufferViews", buffer=0, byteOffset=self._length, byteLength=len(data))
        self._length += len(data) + -len(data) % 4
        return view

    def accessor(self, values: Array, **fields: Any) -> int:
        kind = next(code for code, dtype in _COMPONENTS.items() if values.dtype.newbyteorder("=") == dtype)
        shape = next(name for name, width in _WIDTHS.items() if values.shape[1] == width)
        view = self.view(values.tobytes())
        return self.add("accessors", bufferView=view, componentType=kind, count=len(values), type=shape, **fields)

    def write(self, target: BinaryIO) -> None:
        self.parts["buffers"] = [{"byteLength": self._length}]
        text = json.dumps(self.parts, separators=(",", ":")).encode("ascii")
        text += b" " * (-len(text) % 4)
        target.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + self._length, len(text), _JSON) + text)
        target.write(struct.pack("<II", self._length, _BINARY))
        target.writelines(self._pieces)


def write_glb(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Writes a mesh, in metres if it has a unit; a vertex with several texture coordinates is split."""
    document, notes = _Document(), list[str]()
    vertex, uv, faces = _vertices(mesh)
    places = mesh.vertices[vertex].astype("<f4")
    low, high = places.min(axis=0).tolist(), places.max(axis=0).tolist()
    attributes = {"POSITION": document.accessor(places, min=low, max=high)}
    if mesh.writes_normals:
        normals = mesh.vertex_normals
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        lengths[~np.isfinite(lengths)] = 0.0
        if missing := int((lengths == 0.0).sum()):
            notes.append(f"normals of length 0 or not finite are written as 0 0 1 ({missing:,})")
        units = np.where(lengths > 0.0, normals / np.where(lengths > 0.0, lengths, 1.0), (0.0, 0.0, 1.0))
        attributes["NORMAL"] = document.accessor(units[vertex].astype("<f4"))
    if (colors := mesh.vertex_attributes.get("colors")) is not None:
        attributes["COLOR_0"] = document.accessor(colors[vertex], normalized=True)
    if uv is not None:
        attributes["TEXCOORD_0"] = document.accessor(_upright(uv).astype("<f4"))
    textures = [_texture(document, texture, notes) for texture in mesh.textures]
    numbers = mesh.face_attributes.get("texture", 0 if textures and uv is not None else -1)
    colors = np.ascontiguousarray(mesh.face_attributes.get("colors", np.full((len(faces), 4), 255, np.uint8)))
    looks = (np.zeros(len(faces), np.int64) + numbers + 1 << 32) + colors.view(">u4").ravel()
    kinds, kind_of_face = np.unique(looks, return_inverse=True)
    if len(kinds) > _MOST_MATERIALS:
        notes.append(f"the colours of faces are left out: {len(kinds):,} materials would be too many")
        kinds, kind_of_face = np.unique(looks | 0xFFFFFFFF, return_inverse=True)
    primitives: list[dict[str, Any]] = []
    for k, kind in enumerate(kinds.tolist()):
        number, color = (kind >> 32) - 1, list(struct.pack(">I", kind & 0xFFFFFFFF))
        corners = faces[kind_of_face == k].reshape(-1, 1).astype("<u4")
        primitives.append({"attributes": attributes, "indices": document.accessor(corners)})
        surface = {"metallicFactor": 0, "baseColorFactor": [level / 255 for level in color]}
        if 0 <= number < len(textures) and textures[number] is not None:
            surface["baseColorTexture"] = {"index": textures[number]}
        if number >= 0 or color != [255] * 4:
            primitives[-1]["material"] = document.add("materials", pbrMetallicRoughness=surface)
    if len(mesh.edges):
        ends = np.searchsorted(vertex, mesh.edges.reshape(-1, 1))
        primitives.append({"attributes": attributes, "indices": document.accessor(ends.astype("<u4")), "mode": 1})
    document.add("meshes", primitives=primitives or [{"attributes": attributes, "mode": 0}])
    metres = METRES.get(mesh.unit or "m", 1.0)
    document.add("nodes", mesh=0, **({"scale": [metres] * 3} if metres != 1.0 else {}))
    document.add("scenes", nodes=[0])
    document.parts["scene"] = 0
    document.write(target)
    return tuple(notes)


def _vertices(mesh: MeshData) -> tuple[Longs, Floats | None, Longs]:
    """Returns for each vertex of the file its mesh vertex (ascending) and texture coordinates; also the faces of the file."""
    n, faces = len(mesh.vertices), mesh.faces.astype(np.int64)
    wedges = mesh.face_attributes.get("wedge_texture_coordinates")
    if wedges is None or not len(faces):
        return np.arange(n), mesh.vertex_attributes.get("texture_coordinates"), faces
    alone = np.setdiff1d(np.arange(n), faces)
    vertex = np.append(faces.ravel(), alone)
    uv = np.concatenate([wedges.reshape(-1, 2), np.zeros((len(alone), 2))])
    firsts, numbers = numbered(np.column_stack([vertex, uv]))
    order = np.lexsort((uv[firsts, 1], uv[firsts, 0], vertex[firsts]))
    chosen = firsts[order]
    return vertex[chosen], uv[chosen], np.argsort(order)[numbers[: faces.size]].reshape(-1, 3)


def _texture(document: _Document, texture: Texture, notes: list[str]) -> int | None:
    from PIL import Image

    data = texture.image.read_bytes() if isinstance(texture.image, Path) else texture.image
    if data is None:
        notes.append(f"the texture {texture.name!r} does not exist and is left out")
        return None
    kind = "image/jpeg" if data.startswith(b"\xff\xd8") else "image/png"
    if not data.startswith((b"\x89PNG", b"\xff\xd8")):
        stream = io.BytesIO()
        with Image.open(io.BytesIO(data)) as image:
            image.save(stream, "PNG")
        data = stream.getvalue()
    return document.add("textures", source=document.add("images", bufferView=document.view(data), mimeType=kind))
