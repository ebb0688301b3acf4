"""Writes binary glTF 2.0 files: one mesh, a primitive for each texture, its images within."""

import io
import json
import struct
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..mesh_data import MeshData, Texture
from .assembly import METRES
from .gltf import BINARY, JSON
from .saving import Writing

_FLOAT, _BYTE, _WHOLE = 5126, 5121, 5125
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
#: the first bytes of the two kinds of image that glTF may hold
_IMAGES = {b"\x89PNG": "image/png", b"\xff\xd8": "image/jpeg"}
#: materials, one for each texture and colour of faces
_MOST_MATERIALS = 1000


class _Document:
    """A document and its buffer, as they grow."""

    def __init__(self) -> None:
        self.parts: dict[str, Any] = {"asset": {"version": "2.0", "generator": "pymeshfair"}}
        self._pieces: list[bytes] = []
        self._length = 0

    def add(self, name: str, **part: Any) -> int:
        """The number of a new part of a kind."""
        self.parts.setdefault(name, []).append(part)
        return len(self.parts[name]) - 1

    def view(self, data: bytes) -> int:
        """The number of a new buffer view."""
        self._pieces += [data, bytes(-len(data) % 4)]
        view = self.add("bufferViews", buffer=0, byteOffset=self._length, byteLength=len(data))
        self._length += len(data) + -len(data) % 4
        return view

    def accessor(self, values: NDArray[Any], kind: int, **more: Any) -> int:
        """The number of a new accessor of (n, w) values."""
        shape = _TYPES[values.shape[1]]
        return self.add(
            "accessors", bufferView=self.view(values.tobytes()), componentType=kind, count=len(values), type=shape, **more
        )

    def write(self, target: BinaryIO) -> None:
        """Write all of it."""
        self.parts["buffers"] = [{"byteLength": self._length}]
        text = json.dumps(self.parts, separators=(",", ":")).encode("ascii")
        text += b" " * (-len(text) % 4)
        target.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + self._length, len(text), JSON) + text)
        target.write(struct.pack("<II", self._length, BINARY))
        target.writelines(self._pieces)


def write_glb(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write a mesh as a binary glTF file, in metres if its unit is known.

    Vertices with several texture coordinates become several vertices; all others keep their order.
    """
    document, notes = _Document(), list[str]()
    vertex, uv, faces = _vertices(mesh)
    places = mesh.vertices[vertex].astype("<f4")
    low, high = places.min(axis=0).tolist(), places.max(axis=0).tolist()
    attributes = {"POSITION": document.accessor(places, _FLOAT, min=low, max=high)}
    normals = mesh.vertex_attributes.get("normals")
    if normals is not None and (mesh.keeps_normals or not len(faces)):
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        if missing := int((lengths == 0.0).sum()):
            notes.append(f"{missing:,} normals of length 0 are written as 0 0 1")
        units = np.where(lengths > 0.0, normals / np.where(lengths > 0.0, lengths, 1.0), (0.0, 0.0, 1.0))
        attributes["NORMAL"] = document.accessor(units[vertex].astype("<f4"), _FLOAT)
    if (colors := mesh.vertex_attributes.get("colors")) is not None:
        attributes["COLOR_0"] = document.accessor(colors[vertex], _BYTE, normalized=True)
    if uv is not None:
        attributes["TEXCOORD_0"] = document.accessor(np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1).astype("<f4"), _FLOAT)
    textures = [_texture(document, texture, notes) for texture in mesh.textures]
    numbers = mesh.face_attributes.get("texture", 0 if len(textures) == 1 and uv is not None else -1)
    colors = np.ascontiguousarray(mesh.face_attributes.get("colors", np.full((len(faces), 4), 255, np.uint8)))
    looks = (np.zeros(len(faces), np.int64) + numbers + 1 << 32) + colors.view(">u4").ravel()
    kinds, own = np.unique(looks, return_inverse=True)
    if len(kinds) > _MOST_MATERIALS:
        notes.append(f"the colours of faces are left out, {len(kinds):,} materials would be too many")
        kinds, own = np.unique(looks | 0xFFFFFFFF, return_inverse=True)
    primitives: list[dict[str, Any]] = []
    for k, kind in enumerate(kinds.tolist()):
        number, color = (kind >> 32) - 1, list(struct.pack(">I", kind & 0xFFFFFFFF))
        corners = faces[own == k].reshape(-1, 1).astype("<u4")
        primitives.append({"attributes": attributes, "indices": document.accessor(corners, _WHOLE)})
        surface = {"metallicFactor": 0, "baseColorFactor": [level / 255 for level in color]}
        if number >= 0 and textures[number] is not None:
            surface["baseColorTexture"] = {"index": textures[number]}
        if number >= 0 or color != [255] * 4:
            primitives[-1]["material"] = document.add("materials", pbrMetallicRoughness=surface)
    if len(mesh.edges):
        first = np.searchsorted(vertex, mesh.edges.reshape(-1, 1))
        primitives.append({"attributes": attributes, "indices": document.accessor(first.astype("<u4"), _WHOLE), "mode": 1})
    document.add("meshes", primitives=primitives or [{"attributes": attributes, "mode": 0}])
    metres = METRES.get(mesh.unit or "m", 1.0)
    document.add("nodes", mesh=0, **({"scale": [metres] * 3} if metres != 1.0 else {}))
    document.add("scenes", nodes=[0])
    document.parts["scene"] = 0
    document.write(target)
    return tuple(notes)


def _vertices(mesh: MeshData) -> tuple[NDArray[np.int64], NDArray[np.float64] | None, NDArray[np.int64]]:
    """The vertex of the mesh that each vertex of the file is, ascending; its texture coordinate; the faces of the file."""
    n, faces = len(mesh.vertices), mesh.faces.astype(np.int64)
    wedges = mesh.face_attributes.get("wedge_texture_coordinates")
    if wedges is None or not len(faces):
        return np.arange(n), mesh.vertex_attributes.get("texture_coordinates"), faces
    alone = np.ones(n, np.bool_)
    alone[faces] = False
    vertex = np.concatenate([faces.ravel(), np.flatnonzero(alone)])
    uv = np.concatenate([wedges.reshape(-1, 2), np.zeros((int(alone.sum()), 2))])
    order = np.lexsort((uv[:, 1], uv[:, 0], vertex))
    first = np.ones(len(order), np.bool_)
    first[1:] = (np.diff(vertex[order]) != 0) | (np.diff(uv[order], axis=0) != 0).any(axis=1)
    number = np.empty(len(order), np.int64)
    number[order] = np.cumsum(first) - 1
    chosen = order[first]
    return vertex[chosen], uv[chosen], number[: faces.size].reshape(-1, 3)


def _texture(document: _Document, texture: Texture, notes: list[str]) -> int | None:
    """The number of a texture in the document; None if it has no image."""
    data = texture.image.read_bytes() if isinstance(texture.image, Path) else texture.image
    if data is None:
        notes.append(f"the texture {texture.name!r} does not exist and is left out")
        return None
    kind = next((kind for begin, kind in _IMAGES.items() if data.startswith(begin)), None)
    if kind is None:
        data, kind = _as_png(data), "image/png"
    return document.add("textures", source=document.add("images", bufferView=document.view(data), mimeType=kind))


def _as_png(data: bytes) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    with Image.open(io.BytesIO(data)) as image:
        image.save(stream, "PNG")
    return stream.getvalue()
