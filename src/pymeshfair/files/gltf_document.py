"""The document of a glTF file: every reference within it leads somewhere, and every accessor stays in its buffer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import ContentsError
from .instances import mirrors

_COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
#: the attributes that MeshLab reads, and what their accessors may be
READ = {
    "POSITION": (("VEC3",), (5126,)),
    "NORMAL": (("VEC3",), (5126,)),
    "TEXCOORD_0": (("VEC2",), (5126, 5121, 5123)),
    "COLOR_0": (("VEC3", "VEC4"), (5126, 5121, 5123)),
}
_TRIANGLES = 4
_DEEPEST = 64
#: by how much what programs write of an exact matrix may be off
_ROUNDED = 1e-6


class GltfError(ContentsError):
    """The file is no glTF file that can be read; the message is the reason."""


@dataclass(frozen=True)
class Mesh:
    """One primitive that MeshLab reads.

    Attributes:
        attributes: its accessors by what they hold.
        indices: that of its corners, or None.
        vertices: how many it has.
        document: what it belongs to.
    """

    attributes: Mapping[str, int]
    indices: int | None
    vertices: int
    document: Mapping[str, Any]

    @property
    def faces(self) -> int:
        """How many triangles MeshLab makes of it."""
        count = self.vertices if self.indices is None else int(self.document["accessors"][self.indices]["count"])
        return count // 3

    def check_indices(self, buffers: Sequence[bytes]) -> None:
        """Refuse corners that are no vertices."""
        if self.indices is None:
            return
        accessor = self.document["accessors"][self.indices]
        view = self.document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        kind = np.dtype(_COMPONENTS[accessor["componentType"]]).newbyteorder("<")
        data = buffers[view["buffer"]][start : start + accessor["count"] * kind.itemsize]
        if len(data) == accessor["count"] * kind.itemsize and int(np.frombuffer(data, kind).max()) < self.vertices:
            return
        raise GltfError(f"its accessor {self.indices} names a vertex that is none of {self.vertices:,}, or is cut short")


def check_document(document: Any) -> list[Mesh]:
    """Check a document for everything that MeshLab follows; its primitives.

    Raises:
        GltfError: something in it leads nowhere, is of the wrong type, or declares what cannot be.
    """
    try:
        return _checked(document)
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
        if isinstance(error, GltfError):
            raise
        raise GltfError(f"its document lacks something or has it wrong ({type(error).__name__}: {str(error)[:60]})") from error


def _checked(document: Any) -> list[Mesh]:
    if not isinstance(document, dict) or not isinstance(document.get("asset"), dict):
        raise GltfError("it holds no glTF document")
    if not str(document["asset"].get("version", "")).startswith("2"):
        raise GltfError("its document is not of version 2")
    if required := set(document.get("extensionsRequired", ())) - {"KHR_materials_unlit", "KHR_texture_transform"}:
        raise GltfError(f"it needs {', '.join(sorted(map(str, required)))[:80]}, which MeshLab does not know")
    for name in ("buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes", "images", "textures", "materials"):
        if not isinstance(document.get(name, []), list) or not all(isinstance(x, dict) for x in document.get(name, ())):
            raise GltfError(f"its {name} are no list of objects")
    for k, part in enumerate(document.get("buffers", ())):
        _whole(part["byteLength"], f"the length of buffer {k}")
        if not isinstance(part.get("uri", ""), str):
            raise GltfError(f"the uri of buffer {k} is no text")
    for k in range(len(document.get("bufferViews", ()))):
        _check_view(document, k)
    for k in range(len(document.get("accessors", ()))):
        _check_accessor(document, k)
    _check_images(document)
    _check_nodes(document)
    if "scene" in document:
        _at(document, "scenes", document["scene"])
    meshes = []
    for k, mesh in enumerate(document.get("meshes", ())):
        if not mesh["primitives"]:
            raise GltfError(f"its mesh {k} has no primitives")
        meshes += [_primitive(document, k, p) for p in mesh["primitives"]]
    return meshes


def _whole(value: Any, what: str, least: int = 0) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value < 1 << 53:
        raise GltfError(f"{what} is {str(value)[:40]!r}")
    return value


def _at(document: Mapping[str, Any], name: str, index: Any) -> Any:
    parts = document.get(name, [])
    if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(parts):
        raise GltfError(f"it refers to number {str(index)[:40]} of its {len(parts)} {name}")
    return parts[index]


def _check_view(document: Mapping[str, Any], k: int) -> None:
    view = document["bufferViews"][k]
    buffer = _at(document, "buffers", view["buffer"])
    end = _whole(view.get("byteOffset", 0), f"the offset of buffer view {k}")
    end += _whole(view["byteLength"], f"the length of buffer view {k}", 1)
    if end > buffer["byteLength"]:
        raise GltfError(f"its buffer view {k} ends at byte {end:,} of a buffer of {buffer['byteLength']:,}")
    if "byteStride" in view and not 4 <= _whole(view["byteStride"], f"the stride of buffer view {k}") <= 252:
        raise GltfError(f"the stride of buffer view {k} is {view['byteStride']}")


def _check_accessor(document: Mapping[str, Any], k: int) -> None:
    accessor = document["accessors"][k]
    count = _whole(accessor["count"], f"the count of accessor {k}", 1)
    if accessor["componentType"] not in _COMPONENTS or accessor["type"] not in _WIDTHS:
        raise GltfError(f"its accessor {k} has an unknown type")
    if "sparse" in accessor or "bufferView" not in accessor:
        if _is_read(document, k):
            raise GltfError(f"its accessor {k} is sparse, which MeshLab does not read")
        return
    view = _at(document, "bufferViews", accessor["bufferView"])
    size = np.dtype(_COMPONENTS[accessor["componentType"]]).itemsize * _WIDTHS[accessor["type"]]
    stride = view.get("byteStride", size)
    end = _whole(accessor.get("byteOffset", 0), f"the offset of accessor {k}") + (count - 1) * stride + size
    if stride < size or end > view["byteLength"]:
        raise GltfError(f"its accessor {k} takes {end:,} bytes of a buffer view of {view['byteLength']:,}")


def _is_read(document: Mapping[str, Any], k: int) -> bool:
    for mesh in document.get("meshes", ()):
        for p in mesh.get("primitives", ()):
            if p.get("indices") == k or any(p.get("attributes", {}).get(name) == k for name in READ):
                return True
    return False


def _check_images(document: Mapping[str, Any]) -> None:
    for k, image in enumerate(document.get("images", ())):
        if "uri" in image:
            if not isinstance(image["uri"], str):
                raise GltfError(f"the uri of image {k} is no text")
        else:
            _at(document, "bufferViews", image.get("bufferView"))
    for k, texture in enumerate(document.get("textures", ())):
        if "source" not in texture:
            raise GltfError(f"its texture {k} has no image that MeshLab reads")
        _at(document, "images", texture["source"])
    for k, material in enumerate(document.get("materials", ())):
        surface = material.get("pbrMetallicRoughness", {})
        if "baseColorTexture" in surface:
            _at(document, "textures", surface["baseColorTexture"]["index"])
        _check_numbers(surface.get("baseColorFactor"), 4, f"the colour of material {k}")


def _check_numbers(values: Any, length: int, what: str) -> None:
    if values is None:
        return
    if not isinstance(values, list) or len(values) != length or not all(isinstance(v, int | float) for v in values):
        raise GltfError(f"{what} is no list of {length} numbers")
    if not np.isfinite(np.array(values, dtype=float)).all():
        raise GltfError(f"{what} is not finite")


def _check_nodes(document: Mapping[str, Any]) -> None:
    nodes = document.get("nodes", [])
    for k, node in enumerate(nodes):
        for name, length in (("matrix", 16), ("rotation", 4), ("scale", 3), ("translation", 3)):
            _check_numbers(node.get(name), length, f"the {name} of node {k}")
        if "matrix" in node and not np.allclose(node["matrix"][3::4], (0, 0, 0, 1), rtol=0, atol=_ROUNDED):
            raise GltfError(f"the last row of the matrix of node {k} is not 0 0 0 1")
        if "matrix" in node and node.keys() & {"rotation", "scale", "translation"}:
            raise GltfError(f"its node {k} has a matrix and a rotation, scale or translation besides, which are two places")
        for name in ("mesh", "skin", "camera"):
            if name in node:
                _at(document, f"{name}{'es' if name == 'mesh' else 's'}", node[name])
    seen: set[int] = set()
    level = [n for scene in document.get("scenes", ()) for n in scene.get("nodes", ())]
    for _ in range(_DEEPEST):
        for n in level:
            _at(document, "nodes", n)
        if len(set(level)) != len(level) or seen & set(level):
            raise GltfError("a node of it is its own child, or has two parents")
        seen |= set(level)
        level = [c for n in level for c in nodes[n].get("children", ())]
        if not level:
            return
    raise GltfError(f"its nodes are more than {_DEEPEST} levels deep")


def is_mirrored(document: Mapping[str, Any]) -> bool:
    """Whether a node places its parts as in a mirror."""
    for node in document.get("nodes", ()):
        matrix = np.array(node.get("matrix", np.eye(4)), dtype=float).reshape(4, 4)[:3, :3]
        if mirrors(matrix) or np.sign(node.get("scale", (1, 1, 1))).prod() < 0:
            return True
    return False


def _primitive(document: Mapping[str, Any], k: int, p: Mapping[str, Any]) -> Mesh:
    attributes = p["attributes"]
    if "POSITION" not in attributes:
        raise GltfError(f"its mesh {k} has no positions")
    counts = {}
    for name, index in attributes.items():
        accessor = _at(document, "accessors", index)
        counts[name] = accessor["count"]
        kinds, components = READ.get(name, ((accessor["type"],), (accessor["componentType"],)))
        if accessor["type"] not in kinds or accessor["componentType"] not in components:
            raise GltfError(f"the {name} of its mesh {k} are of a type that they cannot be")
    if len(set(counts.values())) != 1:
        raise GltfError(f"the attributes of its mesh {k} are not equally many")
    if "material" in p:
        _at(document, "materials", p["material"])
    mode, indices = p.get("mode", _TRIANGLES), p.get("indices")
    if mode not in (0, _TRIANGLES):
        raise GltfError(f"its mesh {k} is made of lines, strips or fans, which MeshLab does not read")
    if indices is not None:
        accessor = _at(document, "accessors", indices)
        if accessor["type"] != "SCALAR" or accessor["componentType"] not in (5121, 5123, 5125):
            raise GltfError(f"its accessor {indices} of corners is of a type that they cannot be")
    corners = accessor["count"] if indices is not None else counts["POSITION"]
    if mode == _TRIANGLES and corners % 3:
        raise GltfError(f"its mesh {k} is made of triangles, but has {corners:,} corners, which are no whole number of 3")
    return Mesh(attributes, indices if mode == _TRIANGLES else None, counts["POSITION"], document)
