"""Reads scenes in VRML 2.0, and in X3D with the same syntax or in XML; writes VRML 2.0."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import unquote
from xml.etree.ElementTree import Element

import numpy as np

from ..filters.mesh import Floats, Longs
from ..mesh_data import MeshData
from . import scenes
from .errors import ContentsError
from .inputs import Reading, References, quoted
from .outputs import Writing
from .polygons import edges_of, triangles_of
from .scenes import Assembly

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|#[^\n\r]*|[\[\]{}"]|[^\s,\[\]{}"#]+', re.DOTALL)
_REMARK = re.compile(r"#[^\n\r]*")
#: patterns: the beginning of a list of numbers, which is kept as one text; a value of a field; the strings of a field
_NUMBERS = re.compile(r"[\s,]*(?:#[^\n\r]*[\s,]*)*(?:[-+.\d]|nan|inf)", re.IGNORECASE)
_WORD = re.compile(r'[-+.0-9"]|(?:TRUE|FALSE|NULL|nan|inf)\Z')
_TEXTS = re.compile(r'"((?:[^"\\]|\\.)*)"|\'([^\']*)\'|(\S+)')
_HEADS = ("#VRML V2.0 utf8", "#X3D V3")
_STATEMENTS = {"ROUTE": 3, "PROFILE": 1, "COMPONENT": 1, "META": 2, "EXPORT": 1}  # statements, and how many words follow them
#: keywords and nodes that load other files, run scripts, or declare or fill in prototypes
_REFUSED = {"Inline", "EXTERNPROTO", "PROTO", "IMPORT", "Script", "ProtoDeclare", "ExternProtoDeclare", "ProtoInstance", "IS"}
_TRANSFORMS = ("Transform", "CADPart")
_GROUPS = (*_TRANSFORMS, "Group", "StaticGroup", "Anchor", "Billboard", "Collision", "Switch", "LOD", "CADAssembly", "CADFace")
#: nodes that show one child, with the field of the child's index ("": the first); fields whose nodes are not shown
_CHOSEN, _HIDDEN = {"Switch": "whichChoice", "LOD": ""}, ("proxy", "metadata")
#: nodes of values: the field of the values, and how many numbers a value has
_VALUES = {
    **dict.fromkeys(("Coordinate", "CoordinateDouble"), ("point", 3)),
    **{"Normal": ("vector", 3), "Color": ("color", 3), "ColorRGBA": ("color", 4), "TextureCoordinate": ("point", 2)},
}
#: for each kind of set: how many corners a face has, or the field with the corner count of each strip or fan
_SIZES, _COUNTS = {"Triangle": 3, "Quad": 4}, {"TriangleStrip": "stripCount", "TriangleFan": "fanCount"}
#: types of nodes, their mesh attribute, the field of indices, and the field that says whether values are per vertex or per face
_ATTRIBUTES = (
    (("Color", "ColorRGBA"), "colors", "colorIndex", "colorPerVertex"),
    (("Normal",), "normals", "normalIndex", "normalPerVertex"),
    (("TextureCoordinate",), "wedge_texture_coordinates", "texCoordIndex", ""),
)


@dataclass(eq=False)
class _Node:
    type: str
    fields: dict[str, str] = field(default_factory=dict)  # the numbers, booleans or strings of each field
    parts: list[tuple[str, _Node]] = field(default_factory=list)  # the child nodes, each with the name of its field

    def part(self, *types: str) -> _Node | None:
        return next((part for _, part in self.parts if part.type in types), None)

    def numbers(self, name: str, default: str, count: int | None = None) -> Floats:
        return scenes.numbers(self.fields.get(name, default), f"the {name} of a {self.type}", count)

    def values(self) -> Floats:
        name, width = _VALUES[self.type]
        return scenes.rows(self.fields.get(name, ""), width, f"the values of a {self.type}")

    def is_true(self, name: str) -> bool:
        return self.fields.get(name, "TRUE").strip().upper() == "TRUE"


def _check_type(type: str) -> None:
    if type in _REFUSED:
        raise ContentsError(f"it has a node of the type {type}, which is not supported; save it without such nodes")


def _defined_node(names: Mapping[str, _Node], name: str) -> _Node:
    if name not in names:
        raise ContentsError(f"it uses {quoted(name, 30)}, which is not defined before")
    return names[name]


def read_vrml(path: Path, references: References) -> Reading:
    """Reads a scene in VRML, or in X3D with the same syntax."""
    text = path.read_bytes().decode("utf-8", "surrogateescape")
    if not text.startswith(_HEADS) or "\0" in text:
        raise ContentsError(f"it does not begin with {' or '.join(_HEADS)}; other versions are not known")
    return _read_nodes(_Parser(text).nodes(), path, references)


class _Parser:
    def __init__(self, text: str) -> None:
        self._text, self._at = text, 0
        self._names: dict[str, _Node] = {}
        self._depth = self._count = 0

    def nodes(self) -> list[_Node]:
        nodes = []
        while token := self._next():
            if token == "UNIT":
                raise ContentsError("it has units of its own, which are not known here")
            if token in _STATEMENTS:
                self._next(_STATEMENTS[token])
            else:
                nodes.append(self._node(token))
        return nodes

    def _next(self, count: int = 1) -> str:
        while match := _TOKEN.search(self._text, self._at):
            self._at = match.end()
            if match[0] == '"':
                raise ContentsError("it is cut short within a text")
            count -= not match[0].startswith("#")
            if not count:
                return match[0]
        return ""

    def _node(self, token: str) -> _Node:
        if token == "USE":
            return _defined_node(self._names, self._next())
        name = self._next() if token == "DEF" else ""
        node = _Node(self._next() if name else token)
        _check_type(node.type)
        if not re.match(r"[^\W\d]", node.type) or self._next() != "{":
            raise ContentsError(f"{quoted(node.type, 30)} stands in it where a node is expected")
        self._depth, self._count = self._depth + 1, self._count + 1
        if self._depth > scenes.DEEPEST or self._count > scenes.MOST_PLACED:
            raise ContentsError(f"its nodes are more than {scenes.DEEPEST} levels deep, or more than {scenes.MOST_PLACED:,}")
        token = self._next()
        while token != "}":
            if not token:
                raise ContentsError(f"it is cut short: a {quoted(node.type, 30)} has no end")
            token = self._next(4) if token == "ROUTE" else self._field(node, token)
        self._depth -= 1
        self._names[name] = node
        return node

    def _field(self, node: _Node, name: str) -> str:
        _check_type(name)
        if not re.match(r"[^\W\d]", name):
            raise ContentsError(f"{quoted(name, 30)} stands in a {quoted(node.type, 30)} where the name of a field is expected")
        words: list[str] = []
        if (token := self._next()) == "[":
            if _NUMBERS.match(self._text, self._at):
                start, self._at = self._at, self._text.find("]", self._at)
                words = [_REMARK.sub(" ", self._text[start : self._at]).replace(",", " ")]
            while (token := self._next() if self._at >= 0 else "") != "]":
                if not token:
                    raise ContentsError("it is cut short within a list")
                if token.startswith('"') or token in ("TRUE", "FALSE"):
                    words.append(token)
                else:
                    node.parts.append((name, self._node(token)))
            node.fields[name] = " ".join(words)
            return self._next()
        while _WORD.match(token):
            words.append(token)
            token = self._next()
        if words:
            node.fields[name] = " ".join(words)
            return token
        node.parts.append((name, self._node(token)))
        return self._next()


def read_x3d(path: Path, references: References) -> Reading:
    """Reads a scene in X3D's XML syntax."""
    root = scenes.read_tree(path.read_bytes())
    scene = root.find("Scene")
    if root.tag != "X3D" or scene is None:
        raise ContentsError("it holds no X3D document with a scene")
    if root.find("./head/unit") is not None:
        raise ContentsError("it has units of its own, which are not known here")
    names: dict[str, _Node] = {}
    return _read_nodes([_of_element(part, names) for part in scene if part.tag not in _STATEMENTS], path, references)


def _of_element(part: Element, names: dict[str, _Node]) -> _Node:
    _check_type(part.tag)
    if (name := part.get("USE")) is not None:
        return _defined_node(names, name)
    node = _Node(part.tag, {name: text.replace(",", " ") if "url" not in name else text for name, text in part.attrib.items()})
    children = [child for child in part if child.tag not in _STATEMENTS]
    node.parts = [(child.get("containerField", "children"), _of_element(child, names)) for child in children]
    names[part.get("DEF", "")] = node
    return node


def _read_nodes(nodes: list[_Node], path: Path, references: References) -> Reading:
    reader = _Reader(references)
    with np.errstate(all="ignore"):
        reader.visit(_Node("Group", parts=[("children", node) for node in nodes]), np.eye(4))
    if reader.unread and all(part is None for part in reader.shapes.values()):
        raise ContentsError(f"it has no shape that is known here, but nodes {', '.join(sorted(reader.unread))[:100]}")
    extras = [f"nodes {type} ({n:,})" for type, n in sorted(reader.unread.items())]
    return reader.assembly.reading(path, path.suffix[1:].lower(), extras)


class _Reader:
    def __init__(self, references: References) -> None:
        self.assembly, self.unread = Assembly(references), Counter[str]()
        self._references = references
        self.shapes: dict[int, MeshData | None] = {}
        self._harmless: set[int] = set()

    def visit(self, node: _Node, parent_matrix: Floats) -> None:
        with self.assembly.within(id(node)):
            if not node.is_true("visible"):
                self.assembly.lost["parts that are not visible"] = None
            elif node.type in _GROUPS:
                self._visit_parts(node, parent_matrix)
            elif node.type == "Shape":
                if id(node) not in self.shapes:
                    self.shapes[id(node)] = self._shape(node)
                if (part := self.shapes[id(node)]) is not None:
                    self.assembly.place(part, parent_matrix)
            elif id(node) not in self._harmless:
                self._check_harmless(node)
                self.unread[node.type] += 1

    def _visit_parts(self, node: _Node, parent_matrix: Floats) -> None:
        matrix = parent_matrix @ _matrix(node) if node.type in _TRANSFORMS else parent_matrix
        parts = [part for name, part in node.parts if name not in _HIDDEN and not part.type.startswith("Metadata")]
        if node.type in _CHOSEN:
            chosen = int(node.numbers(_CHOSEN[node.type], "-1", 1)[0]) if _CHOSEN[node.type] else 0
            if len(parts) > 1 or not 0 <= chosen < len(parts):
                self.assembly.lost[f"the parts of a {node.type} that it does not show"] = None
            parts = parts[chosen : chosen + 1] if chosen >= 0 else []
        for child in parts:
            self.visit(child, matrix)

    def _check_harmless(self, node: _Node) -> None:
        """Refuses a node of an unknown type that contains a shape at any depth."""
        pending = [node]
        while pending:
            part = pending.pop()
            if part.type == "Shape":
                raise ContentsError(f"a {quoted(node.type, 30)} of it has shapes, and such a node is not known here")
            if id(part) not in self._harmless:
                self._harmless.add(id(part))
                pending += [child for _, child in part.parts]

    def _shape(self, shape: _Node) -> MeshData | None:
        look = shape.part("Appearance")
        geometry = next((p for _, p in shape.parts if p.type != "Appearance" and not p.type.startswith("Metadata")), None)
        if geometry is None or geometry.type not in _GEOMETRIES:
            self.unread[geometry.type if geometry else "Shape"] += 1
            return None
        part = _GEOMETRIES[geometry.type](geometry, self.assembly)
        texture = self._texture(look, geometry) if look is not None else -1
        if "wedge_texture_coordinates" in part.face_attributes:
            texture_ids = np.full(len(part.faces), texture, np.int32)
            part = part.with_attributes(face={"texture": texture_ids} if texture >= 0 else {"wedge_texture_coordinates": None})
            self.assembly.lost |= {scenes.NO_TEXTURE: None} if texture < 0 else {}
        material = None if look is None else look.part("Material")
        coloured = "colors" in part.vertex_attributes or "colors" in part.face_attributes
        shows = "diffuseColor" if len(part.faces) else "emissiveColor"  # no light falls on points and lines
        if material is not None and shows in material.fields and not coloured:
            shade = [*material.numbers(shows, "", 3), 1.0 - material.numbers("transparency", "0", 1)[0]]
            colors = {"colors": scenes.levels(np.tile(shade, (len(part.faces) or len(part.vertices), 1)))}
            part = part.with_attributes(face=colors) if len(part.faces) else part.with_attributes(colors)
        return part if geometry.is_true("ccw") else scenes.with_reversed_faces(part)

    def _texture(self, look: _Node, geometry: _Node) -> int:
        if look.part("TextureTransform", "MultiTexture", "PixelTexture", "MovieTexture") is not None:
            self.assembly.lost["textures that are not one unchanged image"] = None
            return -1
        if (image := look.part("ImageTexture")) is None:
            return -1
        names = [unquote(a or b or c) for a, b, c in _TEXTS.findall(image.fields.get("url", "")) if a or b or c]
        images = [name for name in names if self._references.find_image(name)] or names
        if images and geometry.part("TextureCoordinate") is None:
            self.assembly.lost[f"the texture {quoted(images[0])} of a shape without texture coordinates"] = None
            return -1
        return self.assembly.texture(images[0]) if images else -1


def _matrix(node: _Node) -> Floats:
    """Returns (4, 4) T C R S C^-1: translation, center, rotation; S scales along axes turned by ``scaleOrientation``."""
    turn, axes = (scenes.rotation(v[:3], v[3]) for v in (node.numbers(n, "0 0 1 0", 4) for n in ("rotation", "scaleOrientation")))
    linear = turn @ axes @ np.diag(node.numbers("scale", "1 1 1", 3)) @ axes.T
    center = node.numbers("center", "0 0 0", 3)
    return scenes.affine_matrix(linear, node.numbers("translation", "0 0 0", 3) + center - linear @ center)


def _points(geometry: _Node) -> Floats:
    coord = geometry.part("Coordinate", "CoordinateDouble")
    if coord is None and any("Coordinate" in part.type and "Texture" not in part.type for _, part in geometry.parts):
        raise ContentsError(f"a {geometry.type} of it has coordinates of a kind that is not known here")
    return np.empty((0, 3)) if coord is None else coord.values()


def _runs(geometry: _Node, name: str, count: int) -> tuple[Longs, Longs]:
    """Returns the indices of a field, each below `count`, without the -1 at the end of each run, and the length of each run."""
    what = f"the {name} of a {quoted(geometry.type, 30)}"
    numbers = scenes.indices(geometry.fields.get(name, ""), what)
    scenes.check_range(numbers, -1, count, what)
    ended = numbers if not len(numbers) or numbers[-1] < 0 else np.append(numbers, -1)
    return numbers[numbers >= 0], np.diff(np.flatnonzero(ended < 0), prepend=-1) - 1


def _polygon_part(
    geometry: _Node, assembly: Assembly, points: Floats, corners: Longs, lengths: Longs, what: str, chosen: Longs | None = None
) -> MeshData:
    """Makes a mesh of polygons, or of the triangles of strips and fans: `chosen` has their corners as indices into `corners`."""
    of_corners: dict[str, Any] = {}
    of_polygons: dict[str, Any] = {}
    of_vertices: dict[str, Any] = {}
    for types, attribute, field_name, per_vertex in _ATTRIBUTES:
        if (node := geometry.part(*types)) is None:
            continue
        values = node.values()
        of_faces = bool(per_vertex) and not geometry.is_true(per_vertex) and chosen is None
        if geometry.fields.get(field_name, "").strip() and chosen is None:
            chosen_values, value_counts = _runs(geometry, field_name, len(values))
            if not of_faces and not np.array_equal(value_counts, lengths):
                raise ContentsError(f"the {field_name} of a {geometry.type} of it does not fit its faces")
        else:
            chosen_values = np.arange(len(lengths)) if of_faces else corners
            if not of_faces and len(values) >= len(points):
                of_vertices[attribute] = values[: len(points)]
        needed = max(len(lengths) - len(chosen_values) + len(values) if of_faces else 0, int(chosen_values.max(initial=-1)) + 1)
        if len(values) < needed:
            raise ContentsError(f"a {node.type} of it has {len(values):,} values, but its faces take {needed:,}")
        if not of_faces:
            of_corners[attribute] = values[chosen_values if chosen is None else chosen_values[chosen.ravel()]]
        elif attribute == "colors":
            of_polygons[attribute] = scenes.levels(values[chosen_values[: len(lengths)]])
        else:
            assembly.lost["normals of faces"] = None
    if chosen is not None:
        corners, lengths = corners[chosen.ravel()], np.full(len(chosen), 3)
    return assembly.polygons(points, corners, lengths, what, of_corners, of_polygons, of_vertices)


def _face_set(geometry: _Node, assembly: Assembly) -> MeshData:
    kind = geometry.type.removeprefix("Indexed").removesuffix("Set")
    points, what, name = _points(geometry), f"the corners of a {geometry.type!r}", _COUNTS.get(kind, "")
    if kind == "Face":
        runs = _runs(geometry, "coordIndex", len(points))
        return _polygon_part(geometry, assembly, points, *runs, f"the coordIndex of a {geometry.type!r}")
    if geometry.type.startswith("Indexed"):
        name = "index"
        corners, lengths = _runs(geometry, name, len(points))
    else:
        corners = np.arange(len(points))
        lengths = scenes.indices(geometry.fields.get(name, ""), f"the {name} of a {geometry.type}")
    if kind in _SIZES:
        size = _SIZES[kind]
        if len(corners) % size:
            raise ContentsError(f"{what} are {len(corners):,}, which is no multiple of {size}")
        return _polygon_part(geometry, assembly, points, corners, np.full(len(corners) // size, size), what)
    if (lengths < 3).any() or lengths.sum() != len(corners):
        raise ContentsError(f"{what} are {len(corners):,}, which does not fit {name}")
    chosen = triangles_of(corners, lengths, fans=kind == "TriangleFan")
    return _polygon_part(geometry, assembly, points, corners, lengths, what, chosen)


def _line_set(geometry: _Node, assembly: Assembly) -> MeshData:
    points = _points(geometry)
    vertex: dict[str, Any] = {}
    if (color := geometry.part("Color", "ColorRGBA")) is not None:
        colors = color.values()
        if len(colors) == len(points) and "colorIndex" not in geometry.fields and geometry.is_true("colorPerVertex"):
            vertex["colors"] = scenes.levels(colors)
        else:
            assembly.lost[f"the colours of a {geometry.type}"] = None
    corners, lengths = np.empty(0, np.int64), np.empty(0, np.int64)
    if geometry.type == "IndexedLineSet":
        corners, lengths = _runs(geometry, "coordIndex", len(points))
    elif geometry.type == "LineSet":
        corners = np.arange(len(points))
        lengths = scenes.indices(geometry.fields.get("vertexCount", ""), "the vertexCount of a LineSet")
        if lengths.sum() != len(corners) or (lengths < 0).any():
            raise ContentsError("the vertexCount of a LineSet of it does not fit its points")
    return MeshData(vertices=points, edges=edges_of(corners, lengths), vertex_attributes=vertex)


def _elevation(geometry: _Node, assembly: Assembly) -> MeshData:
    (wide, deep), heights = (int(geometry.numbers(f"{a}Dimension", "0", 1)[0]) for a in "xz"), geometry.numbers("height", "")
    if wide < 2 or deep < 2 or wide * deep != len(heights):
        raise ContentsError(f"an ElevationGrid of it has {len(heights):,} heights for {wide} x {deep}")
    z, x = np.divmod(np.arange(wide * deep), wide)
    x_spacing, z_spacing = (geometry.numbers(f"{a}Spacing", "1", 1)[0] for a in "xz")
    points = np.stack([x * x_spacing, heights, z * z_spacing], axis=1)
    first = np.flatnonzero((x < wide - 1) & (z < deep - 1))
    corners = np.stack([first, first + wide, first + wide + 1, first + 1], axis=1)
    return _polygon_part(geometry, assembly, points, corners.ravel(), np.full(len(first), 4), "the corners of an ElevationGrid")


_GEOMETRIES: Mapping[str, Callable[[_Node, Assembly], MeshData]] = {
    "IndexedFaceSet": _face_set,
    **{f"{prefix}{kind}Set": _face_set for prefix in ("", "Indexed") for kind in (*_SIZES, *_COUNTS)},
    **dict.fromkeys(("PointSet", "IndexedLineSet", "LineSet"), _line_set),
    "ElevationGrid": _elevation,
}


def write_vrml(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Writes a mesh as one shape in VRML 2.0, with every digit of its coordinates, and the colours of its vertices."""
    colors, colour = mesh.vertex_attributes.get("colors"), ""
    if colors is not None:
        shares = np.minimum((colors[:, :3] + 1e-4) / 255.0, 1.0)  # MeshLab truncates levels
        color_lines = "\n".join("{:.7g} {:.7g} {:.7g}".format(*c) for c in shares.tolist())
        colour = f"color Color {{ color [\n{color_lines}\n] }}\n"
    points = "\n".join("{!r} {!r} {!r}".format(*place) for place in mesh.vertices.tolist())
    faces = "\n".join("{} {} {} -1".format(*face) for face in mesh.faces.tolist())
    coord = f"coord Coordinate {{ point [\n{points}\n] }}\n"
    body = f"IndexedFaceSet {{\nsolid FALSE\n{coord}{colour}coordIndex [\n{faces}\n]\n}}" if len(mesh.faces) else ""
    geometry = body or f"PointSet {{\n{coord}{colour}}}"
    scene = f"#VRML V2.0 utf8\nShape {{ appearance Appearance {{ material Material {{ }} }}\ngeometry {geometry}\n}}\n"
    target.write(scene.encode())
    return ()
