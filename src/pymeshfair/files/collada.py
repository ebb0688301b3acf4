"""Reads COLLADA documents strictly, and gives MeshLab one whose textures are those that were found and checked."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from .announced import Announced
from .errors import ContentsError
from .given import Given, find_textures
from .indices import check_range, indices, numbers
from .instances import MIRRORED, check_instances, mirrors
from .references import References, shown
from .xml_document import formatted_tree, read_tree

#: what names a part of the same document
_NAME = re.compile(r"[\w.:\-]*")
#: kinds of primitives, and how many corners a face of each has where that is the same for all
_PRIMITIVES = {"triangles": 3, "polylist": None, "polygons": None}
_UNREAD = {"lines", "linestrips", "trifans", "tristrips"}
#: how many numbers each way of placing a node takes
_TRANSFORMS = {"matrix": 16, "rotate": 4, "scale": 3, "translate": 3, "lookat": 9, "skew": 7}
_LOST = ("animation", "controller", "camera", "light", "extra", "physics_model")


def inspect_collada(path: Path, references: References, given: Given) -> Announced:
    """Read a COLLADA document; what it declares.

    Raises:
        ContentsError: it is none, or names what is not there.
        InputError: it names a file that must not be opened.
    """
    root = read_tree(path.read_bytes())
    if _kind(root) != "COLLADA":
        raise ContentsError("it holds no COLLADA document")
    parts = {part.attrib["id"]: part for part in root.iter() if "id" in part.attrib}
    for part in root.iter():
        for name in ("url", "source", "texture"):
            _check_inside(part.get(name, ""), name, part)
        if _kind(part) == "mesh":
            _check_mesh(part, parts)
        elif _kind(part) == "node":
            _check_transforms(part)
    _check_places(root, parts)
    images = [image for image in root.iter() if _kind(image) == "image"]
    places = [place for image in images for place in image.iter() if _kind(place) in ("init_from", "ref") and not len(place)]
    found = set(map(id, places))
    for place in (p for p in root.iter() if _kind(p) in ("init_from", "ref") and id(p) not in found):
        _check_inside((place.text or "").strip(), "init_from", place)
    names = [_path_of((place.text or "").strip()) for place in places]
    textures = find_textures([name for name in names if name], references)
    known = {t.name: t.given for t in textures}
    for place, name in zip(places, names, strict=True):
        place.text = known.get(name, "")
    given.link(textures)
    kinds = {_kind(part) for part in root.iter()}
    return Announced(
        normals=any(part.get("semantic") == "NORMAL" for part in root.iter() if _kind(part) == "input"),
        not_kept=tuple(f"{kind}s" for kind in _LOST if kind in kinds) + tuple(sorted(kinds & _UNREAD)) + tuple(_frame(root)),
        doubts=(MIRRORED,) if _is_mirrored(root) else (),
        side_files=tuple(t.file for t in textures if t.file),
        textures=textures,
        reading=given.write(formatted_tree(root)),
    )


def _kind(part: Element) -> str:
    return part.tag.rpartition(":")[2]


def _frame(root: Element) -> Iterator[str]:
    """The unit and the upright axis, of which no other format of ours has any."""
    for part in root.iter():
        if _kind(part) == "unit" and part.get("meter", "1").strip() not in ("1", "1.0"):
            yield f"its unit of {shown(part.get('meter', ''), 30)} m"
        elif _kind(part) == "up_axis" and (part.text or "").strip() != "Y_UP":
            yield f"its upright axis {shown((part.text or '').strip(), 30)}"


def _path_of(uri: str) -> str:
    """The path in a uri of a file."""
    return unquote(re.sub(r"\Afile:(//)?", "", uri))


def _check_inside(name: str, what: str, part: Element) -> None:
    if not _NAME.fullmatch(name.removeprefix("#")):
        raise ContentsError(f"the {what} of a {_kind(part)} of it is {shown(name)}, which is no part of the document")


def _children(part: Element, kind: str) -> Iterator[Element]:
    return (child for child in part if _kind(child) == kind)


def _check_mesh(mesh: Element, parts: Mapping[str, Element]) -> None:
    for array in (a for a in mesh.iter() if _kind(a) == "float_array"):
        found = len(numbers(array.text or "", f"the array {shown(array.get('id', ''))}"))
        if _count(array) != found:
            raise ContentsError(f"its array {shown(array.get('id', ''))} declares {_count(array):,} numbers, but has {found:,}")
    for primitive in (p for p in mesh if _kind(p) in _PRIMITIVES):
        _check_primitive(primitive, parts)


def _check_transforms(node: Element) -> None:
    for part in node:
        length = _TRANSFORMS.get(_kind(part))
        if length is not None and len(found := numbers(part.text or "", f"a {_kind(part)}")) != length:
            raise ContentsError(f"a {_kind(part)} of a node of it has {len(found)} numbers and not {length}")


def _is_mirrored(root: Element) -> bool:
    """Whether a node places its parts as in a mirror."""
    for part in (part for node in root.iter() if _kind(node) == "node" for part in node):
        if _kind(part) == "scale" and np.sign(numbers(part.text or "", "a scale")).prod() < 0:
            return True
        if _kind(part) == "matrix" and mirrors(numbers(part.text or "", "a matrix").reshape(4, 4)[:3, :3]):
            return True
    return False


def _check_places(root: Element, parts: Mapping[str, Element]) -> None:
    """Refuse nodes that are parts of themselves, or place too much."""
    places: dict[Hashable, list[Hashable]] = {}
    faces: dict[Hashable, int] = {}
    for part in root.iter():
        kind = _kind(part)
        if kind in ("node", "visual_scene", "geometry"):
            used = (parts.get(i.get("url", "").removeprefix("#")) for i in part if _kind(i).startswith("instance_"))
            places[id(part)] = [id(p) for p in (*_children(part, "node"), *used) if p is not None]
        if kind == "geometry":
            faces[id(part)] = sum(_count(p) for p in part.iter() if _kind(p) in _PRIMITIVES)
    check_instances(places, faces, [id(part) for part in root.iter() if _kind(part) == "visual_scene"])


def _count(part: Element) -> int:
    text = part.get("count", "")
    if not (text.isascii() and text.isdigit()):
        raise ContentsError(f"the count of a {_kind(part)} of it is {shown(text)}")
    return int(text)


def _check_primitive(primitive: Element, parts: Mapping[str, Element]) -> None:
    inputs = [(_offset(i), _length(i, parts)) for i in _children(primitive, "input")]
    if not inputs:
        raise ContentsError(f"its {_kind(primitive)} have no inputs")
    stride = 1 + max(offset for offset, _ in inputs)
    faces = _count(primitive)
    lists = [indices(p.text or "", f"the corners of its {_kind(primitive)}") for p in _children(primitive, "p")]
    corners = np.concatenate(lists) if lists else np.empty(0, np.int64)
    expected = _corners(primitive, faces, lists, stride)
    if len(corners) != expected * stride:
        raise ContentsError(
            f"its {faces:,} {_kind(primitive)} take {expected * stride:,} indices, but {len(corners):,} are there"
        )
    for offset, length in inputs:
        check_range(corners[offset::stride], 0, length, f"the corners of its {_kind(primitive)}")


def _corners(primitive: Element, faces: int, lists: list[NDArray[np.int64]], stride: int) -> int:
    """How many corners all faces have."""
    kind = _kind(primitive)
    each = _PRIMITIVES[kind]
    if each is not None:
        return each * faces
    if kind == "polygons":
        if any(_kind(child) == "ph" for child in primitive) or len(lists) != faces:
            raise ContentsError(f"it declares {faces:,} polygons, but has {len(lists):,} without holes")
        counts = np.array([len(corners) // stride for corners in lists], dtype=np.int64)
    else:
        counts = indices(" ".join(c.text or "" for c in _children(primitive, "vcount")), "the numbers of corners")
    if len(counts) != faces or (counts < 3).any():
        raise ContentsError(f"it declares {faces:,} faces, but says of {int((counts >= 3).sum()):,} how many corners they have")
    return int(counts.sum())


def _offset(part: Element) -> int:
    text = part.get("offset", "0")
    if text not in map(str, range(32)):
        raise ContentsError(f"the offset of an input of it is {shown(text)}")
    return int(text)


def _length(part: Element, parts: Mapping[str, Element]) -> int:
    """How many values an input has."""
    for _ in range(4):
        found = parts.get(part.get("source", "").removeprefix("#"))
        if found is None:
            raise ContentsError(f"an input of it names {shown(part.get('source', ''))}, which is not there")
        part = found
        if _kind(part) == "vertices":
            part = next((i for i in _children(part, "input") if i.get("semantic") == "POSITION"), part)
            continue
        accessor = next((a for a in part.iter() if _kind(a) == "accessor"), None)
        if accessor is None:
            break
        array = parts.get(accessor.get("source", "").removeprefix("#"))
        stride, offset = accessor.get("stride", "1"), accessor.get("offset", "0")
        if array is None or not (stride.isdigit() and offset.isdigit() and int(stride)):
            break
        count = _count(accessor)
        if _kind(array) != "float_array" or int(offset) + count * int(stride) > _count(array):
            raise ContentsError(f"an accessor of it takes {count:,} values of {_count(array):,} numbers")
        return count
    raise ContentsError(f"its input {shown(part.get('source', part.get('id', '')))} leads to no numbers")
