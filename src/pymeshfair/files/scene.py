"""The nodes of a VRML or X3D scene, and the mesh that its shapes make."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ..mesh_data import MeshData
from .assembly import Assembly, levels, triangles_of, turn, turned_over
from .errors import ContentsError
from .indices import check_range, indices, numbers, rows
from .inputs import Reading
from .references import References, shown

#: nodes that load, run or define something else
_REFUSED = frozenset(
    ("Inline", "EXTERNPROTO", "PROTO", "IMPORT", "Script", "ProtoDeclare", "ExternProtoDeclare", "ProtoInstance", "IS")
)
#: nodes that place others
_TRANSFORMS = ("Transform", "CADPart")
_GROUPS = (*_TRANSFORMS, "Group", "StaticGroup", "Anchor", "Billboard", "Collision", "Switch", "LOD", "CADAssembly", "CADFace")
#: their fields, of whose nodes one is shown by a number, and those that show nothing
_CHOSEN, _HIDDEN = {"Switch": "whichChoice", "LOD": ""}, ("proxy", "metadata")
#: the nodes of values: the field that has them, and how many numbers make one
_VALUES = {
    **dict.fromkeys(("Coordinate", "CoordinateDouble"), ("point", 3)),
    **{"Normal": ("vector", 3), "Color": ("color", 3), "ColorRGBA": ("color", 4), "TextureCoordinate": ("point", 2)},
}
#: corners of each face in sets of such faces, and the field with the corners of each strip or fan
_SIZES, _COUNTS = {"Triangle": 3, "Quad": 4}, {"TriangleStrip": "stripCount", "TriangleFan": "fanCount"}
_TEXTS = re.compile(r'"((?:[^"\\]|\\.)*)"|\'([^\']*)\'|(\S+)')


@dataclass(eq=False)
class Node:
    """A node: its type, the texts of its fields, and the nodes in them."""

    type: str
    fields: dict[str, str] = field(default_factory=dict)  # the numbers, truths or texts of each field
    parts: list[tuple[str, Node]] = field(default_factory=list)  # the nodes in fields, each with the name of the field

    def part(self, *types: str) -> Node | None:
        """The first part of one of these types."""
        return next((part for _, part in self.parts if part.type in types), None)

    def values(self, name: str, default: str, count: int | None = None) -> NDArray[np.float64]:
        """The numbers of a field."""
        return numbers(self.fields.get(name, default), f"the {name} of a {self.type}", count)

    def is_true(self, name: str) -> bool:
        """The truth of a field, which is true if it is not there."""
        return self.fields.get(name, "TRUE").strip().upper() == "TRUE"


def check_type(type: str) -> None:
    """Refuse a type of node that leads out of the document."""
    if type in _REFUSED:
        raise ContentsError(f"it has a node of the type {type}, which leads out of the file; save it without")


def read_nodes(nodes: list[tuple[str, Node]], path: Path, references: References) -> Reading:
    """The mesh that the shapes of a scene make."""
    reader = _Reader(references)
    with np.errstate(all="ignore"):
        reader.visit(Node("Group", parts=nodes), np.eye(4))
    if reader.unread and not reader.assembly:
        raise ContentsError(f"it has no shape that is known here, but nodes {', '.join(sorted(reader.unread))[:100]}")
    extras = [f"nodes {type} ({n:,})" for type, n in sorted(reader.unread.items())]
    return reader.assembly.reading(path, path.suffix[1:].lower(), extras)


class _Reader:
    """Places the shapes of a scene."""

    def __init__(self, references: References) -> None:
        self.assembly, self.unread = Assembly(), Counter[str]()
        self._references = references
        self._shapes: dict[int, MeshData | None] = {}
        self._harmless: set[int] = set()

    def visit(self, node: Node, above: NDArray[np.float64]) -> None:
        """Place what a node shows."""
        with self.assembly.within(id(node)):
            if not node.is_true("visible"):
                self.assembly.lost["parts that are not visible"] = None
            elif node.type in _GROUPS:
                self._visit_parts(node, above)
            elif node.type == "Shape":
                if id(node) not in self._shapes:
                    self._shapes[id(node)] = self._shape(node)
                if (part := self._shapes[id(node)]) is not None:
                    self.assembly.place(part, above)
            elif id(node) not in self._harmless:
                if _has_shape(node, self._harmless):
                    raise ContentsError(f"a {shown(node.type, 30)} of it has shapes, and such a node is not known here")
                self.unread[node.type] += 1

    def _visit_parts(self, node: Node, above: NDArray[np.float64]) -> None:
        """Place what the parts of a group show."""
        matrix = above @ _matrix(node) if node.type in _TRANSFORMS else above
        parts = [part for name, part in node.parts if name not in _HIDDEN and not part.type.startswith("Metadata")]
        if node.type in _CHOSEN:
            chosen = int(node.values(_CHOSEN[node.type], "-1", 1)[0]) if _CHOSEN[node.type] else 0
            if len(parts) > 1 or not 0 <= chosen < len(parts):
                self.assembly.lost[f"the parts of a {node.type} that it does not show"] = None
            parts = parts[chosen : chosen + 1] if chosen >= 0 else []
        for child in parts:
            self.visit(child, matrix)

    def _shape(self, shape: Node) -> MeshData | None:
        """The part of a shape; None if its geometry cannot be read."""
        look = shape.part("Appearance")
        geometry = next((p for _, p in shape.parts if p.type != "Appearance" and not p.type.startswith("Metadata")), None)
        if geometry is None or geometry.type not in _GEOMETRIES:
            self.unread[geometry.type if geometry else "Shape"] += 1
            return None
        part = _GEOMETRIES[geometry.type](geometry, self.assembly)
        texture = self._texture(look, geometry) if look is not None else -1
        if "wedge_texture_coordinates" in part.face_attributes:
            changed = None if texture < 0 else np.full(len(part.faces), texture, np.int32)
            kept = part.face_attributes["wedge_texture_coordinates"] if texture >= 0 else None
            part = part.with_attributes(face={"texture": changed, "wedge_texture_coordinates": kept})
        material = None if look is None else look.part("Material")
        coloured = "colors" in part.vertex_attributes or "colors" in part.face_attributes
        if material is not None and "diffuseColor" in material.fields and not coloured:
            shade = [*material.values("diffuseColor", "", 3), 1.0 - material.values("transparency", "0", 1)[0]]
            part = part.with_attributes(face={"colors": levels(np.tile(shade, (len(part.faces), 1)))})
        return part if geometry.is_true("ccw") else turned_over(part)

    def _texture(self, look: Node, geometry: Node) -> int:
        """The number of the texture of a shape, or -1."""
        if look.part("TextureTransform", "MultiTexture", "PixelTexture", "MovieTexture") is not None:
            self.assembly.lost["textures that are no single image as it is"] = None
            return -1
        if (image := look.part("ImageTexture")) is None:
            return -1
        names = [unquote(a or b or c) for a, b, c in _TEXTS.findall(image.fields.get("url", "")) if a or b or c]
        images = [name for name in names if self._references.find_image(name)] or names
        if not images:
            return -1
        if geometry.part("TextureCoordinate") is None:
            self.assembly.lost[f"the texture {shown(images[0])} of a shape without texture coordinates"] = None
            return -1
        return self.assembly.texture(images[0], self._references)


def _has_shape(node: Node, seen: set[int]) -> bool:
    """Whether a part of a node, however deep, is a shape; those in `seen` have none, and the parts are added."""
    seen.add(id(node))
    left = [node]
    while left:
        parts = [part for _, part in left.pop().parts if id(part) not in seen]
        seen.update(map(id, parts))
        left += parts
        if any(part.type == "Shape" for part in parts):
            return True
    return False


def _matrix(node: Node) -> NDArray[np.float64]:
    """(4, 4) T C R S C^-1, the scale S along axes that are turned."""
    turns = []
    for name in ("rotation", "scaleOrientation"):
        value = node.values(name, "0 0 1 0", 4)
        turns.append(turn(value[:3], value[3]))
    linear = turns[0] @ turns[1] @ np.diag(node.values("scale", "1 1 1", 3)) @ turns[1].T
    center = node.values("center", "0 0 0", 3)
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = node.values("translation", "0 0 0", 3) + center - linear @ center
    return matrix


def _points(geometry: Node) -> NDArray[np.float64]:
    """(n, 3) the coordinates of a geometry."""
    coord = geometry.part("Coordinate", "CoordinateDouble")
    if coord is None and any("Coordinate" in part.type and "Texture" not in part.type for _, part in geometry.parts):
        raise ContentsError(f"a {geometry.type} of it has coordinates of a kind that is not known here")
    return np.empty((0, 3)) if coord is None else _values_of(coord)


def _values_of(node: Node) -> NDArray[np.float64]:
    name, width = _VALUES[node.type]
    return rows(node.fields.get(name, ""), width, f"the values of a {node.type}")


def _runs(geometry: Node, name: str, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The indices of a field, which name one of so many values, and how many stand before each -1."""
    what = f"the {name} of a {shown(geometry.type, 30)}"
    numbers = indices(geometry.fields.get(name, ""), what)
    check_range(numbers, -1, count, what)
    ends = np.flatnonzero(numbers < 0)
    if len(numbers) and numbers[-1] >= 0:
        ends = np.append(ends, len(numbers))
    return numbers[numbers >= 0], np.diff(ends, prepend=-1) - 1


#: types of nodes: the attribute, the field of indices, and the field for one value a vertex or one a face
_ATTRIBUTES = (
    (("Color", "ColorRGBA"), "colors", "colorIndex", "colorPerVertex"),
    (("Normal",), "normals", "normalIndex", "normalPerVertex"),
    (("TextureCoordinate",), "wedge_texture_coordinates", "texCoordIndex", ""),
)


def _made(
    geometry: Node,
    assembly: Assembly,
    points: NDArray[np.float64],
    corners: NDArray[np.int64],
    lengths: NDArray[np.int64],
    what: str,
    chosen: NDArray[np.int64] | None = None,
) -> MeshData:
    """The part made of polygons, with the colours, normals and texture coordinates of the geometry.

    `chosen` are the triangles, as numbers of corners, that strips and fans become.
    """
    of_corners: dict[str, Any] = {}
    of_polygons: dict[str, Any] = {}
    for types, attribute, field_name, per_vertex in _ATTRIBUTES:
        if (node := geometry.part(*types)) is None:
            continue
        values = _values_of(node)
        of_faces = bool(per_vertex) and not geometry.is_true(per_vertex) and chosen is None
        if geometry.fields.get(field_name, "").strip() and chosen is None:
            own, own_lengths = _runs(geometry, field_name, len(values))
            if not of_faces and not np.array_equal(own_lengths, lengths):
                raise ContentsError(f"the {field_name} of a {geometry.type} of it does not fit its faces")
        else:
            own = np.arange(len(lengths)) if of_faces else corners
        needed = max(len(lengths) - len(own) + len(values) if of_faces else 0, int(own.max(initial=-1)) + 1)
        if len(values) < needed:
            raise ContentsError(f"a {node.type} of it has {len(values):,} values, but its faces take {needed:,}")
        if of_faces:
            values = values[own[: len(lengths)]]
            if attribute == "colors":
                of_polygons[attribute] = levels(values)
            else:
                assembly.lost["normals of faces"] = None
        else:
            of_corners[attribute] = values[own]
    if chosen is not None:
        of_corners = {name: values[chosen.ravel()] for name, values in of_corners.items()}
        corners, lengths = corners[chosen.ravel()], np.full(len(chosen), 3)
    return assembly.polygons(points, corners, lengths, what, of_corners, of_polygons)


def _face_set(geometry: Node, assembly: Assembly) -> MeshData:
    points = _points(geometry)
    corners, lengths = _runs(geometry, "coordIndex", len(points))
    return _made(geometry, assembly, points, corners, lengths, "the coordIndex of a 'IndexedFaceSet'")


def _set(geometry: Node, assembly: Assembly) -> MeshData:
    """A set of triangles, quads, strips or fans: indexed, or strips and fans with counts."""
    kind = geometry.type.removeprefix("Indexed").removesuffix("Set")
    points, what = _points(geometry), f"the corners of a {geometry.type!r}"
    if geometry.type.startswith("Indexed"):
        corners, lengths = _runs(geometry, "index", len(points))
    else:
        corners = np.arange(len(points))
        lengths = indices(geometry.fields.get(_COUNTS.get(kind, ""), ""), f"the {_COUNTS.get(kind, '')} of a {geometry.type}")
    if kind in _SIZES:
        size = _SIZES[kind]
        if len(corners) % size:
            raise ContentsError(f"{what} are {len(corners):,}, which are no whole number of {size}")
        return _made(geometry, assembly, points, corners, np.full(len(corners) // size, size), what)
    if (lengths < 3).any() or lengths.sum() != len(corners):
        name = "index" if geometry.type.startswith("Indexed") else _COUNTS[kind]
        raise ContentsError(f"{what} are {len(corners):,}, but {name} says otherwise")
    chosen = triangles_of(corners, lengths, fans=kind == "TriangleFan")
    return _made(geometry, assembly, points, corners, lengths, what, chosen)


def _lines(geometry: Node, assembly: Assembly) -> MeshData:
    """The edges of lines, or points alone."""
    points = _points(geometry)
    vertex: dict[str, Any] = {}
    if (color := geometry.part("Color", "ColorRGBA")) is not None:
        colors = _values_of(color)
        if len(colors) == len(points) and "colorIndex" not in geometry.fields and geometry.is_true("colorPerVertex"):
            vertex["colors"] = levels(colors)
        else:
            assembly.lost[f"the colours of a {geometry.type}"] = None
    corners, lengths = np.empty(0, np.int64), np.empty(0, np.int64)
    if geometry.type == "IndexedLineSet":
        corners, lengths = _runs(geometry, "coordIndex", len(points))
    elif geometry.type == "LineSet":
        corners, lengths = np.arange(len(points)), indices(geometry.fields.get("vertexCount", ""), "the vertexCount of a LineSet")
        if lengths.sum() != len(corners) or (lengths < 0).any():
            raise ContentsError("the vertexCount of a LineSet of it says otherwise than its points")
    starts = np.delete(np.arange(len(corners)), np.cumsum(lengths)[lengths > 0] - 1)
    return MeshData(vertices=points, edges=np.stack([corners[starts], corners[starts + 1]], axis=1), vertex_attributes=vertex)


def _elevation(geometry: Node, assembly: Assembly) -> MeshData:
    """A grid of heights, rows along z."""
    (wide, deep), heights = (int(geometry.values(f"{a}Dimension", "0", 1)[0]) for a in "xz"), geometry.values("height", "")
    if wide < 2 or deep < 2 or wide * deep != len(heights):
        raise ContentsError(f"an ElevationGrid of it has {len(heights):,} heights for {wide} x {deep}")
    z, x = np.divmod(np.arange(wide * deep), wide)
    x_spacing, z_spacing = geometry.values("xSpacing", "1", 1)[0], geometry.values("zSpacing", "1", 1)[0]
    points = np.stack([x * x_spacing, heights, z * z_spacing], axis=1)
    first = np.flatnonzero((x < wide - 1) & (z < deep - 1))
    corners = np.stack([first, first + wide, first + wide + 1, first + 1], axis=1)
    return _made(geometry, assembly, points, corners.ravel(), np.full(len(first), 4), "the corners of an ElevationGrid")


_GEOMETRIES: Mapping[str, Callable[[Node, Assembly], MeshData]] = {
    "IndexedFaceSet": _face_set,
    **{f"{prefix}{kind}Set": _set for prefix in ("", "Indexed") for kind in (*_SIZES, *_COUNTS)},
    **dict.fromkeys(("PointSet", "IndexedLineSet", "LineSet"), _lines),
    "ElevationGrid": _elevation,
}
