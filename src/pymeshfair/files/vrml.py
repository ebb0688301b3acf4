"""Reads scenes in VRML 2.0, and in X3D in the same words or in XML; writes VRML 2.0."""

import re
from pathlib import Path
from typing import BinaryIO
from xml.etree.ElementTree import Element

import numpy as np

from ..mesh_data import MeshData
from .assembly import MOST_PLACED
from .errors import ContentsError
from .inputs import Reading
from .references import References, shown
from .saving import Writing
from .scene import Node, check_type, read_nodes
from .xml_document import read_tree

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|#[^\n\r]*|[\[\]{}"]|[^\s,\[\]{}"#]+', re.DOTALL)
_REMARK = re.compile(r"#[^\n\r]*")
#: a list of numbers, which is kept as one text
_NUMBERS = re.compile(r"[\s,]*(?:#[^\n\r]*[\s,]*)*(?:[-+.\d]|nan|inf)", re.IGNORECASE)
_HEADS = ("#VRML V2.0 utf8", "#X3D V3")
#: statements, and how many words follow them
_STATEMENTS = {"ROUTE": 3, "PROFILE": 1, "COMPONENT": 1, "META": 2, "EXPORT": 1}
_DEEPEST = 200


def read_vrml(path: Path, references: References) -> Reading:
    """Read a scene."""
    text = path.read_bytes().decode("utf-8", "surrogateescape")
    if not text.startswith(_HEADS) or "\0" in text:
        raise ContentsError(f"it does not begin with {' or '.join(_HEADS)}; older ones are not known")
    return read_nodes(_Parser(text).nodes(), path, references)


class _Parser:
    """Takes a text apart, from one token to the next."""

    def __init__(self, text: str) -> None:
        self._text, self._at = text, 0
        self._names: dict[str, Node] = {}
        self._depth = self._count = 0

    def nodes(self) -> list[tuple[str, Node]]:
        """The nodes of the document."""
        nodes = []
        while token := self._next():
            if token == "UNIT":
                raise ContentsError("it has units of its own, which are not known here")
            if token in _STATEMENTS:
                for _ in range(_STATEMENTS[token]):
                    self._next()
            else:
                nodes.append(("children", self._node(token)))
        return nodes

    def _next(self) -> str:
        """The next token, "" at the end."""
        while match := _TOKEN.search(self._text, self._at):
            self._at = match.end()
            if match[0] == '"':
                raise ContentsError("it is cut short within a text")
            if not match[0].startswith("#"):
                return match[0]
        return ""

    def _node(self, token: str) -> Node:
        """The node that begins with a token."""
        if token == "USE":
            name = self._next()
            if name not in self._names:
                raise ContentsError(f"it uses {shown(name, 30)}, which is not defined before")
            return self._names[name]
        name = self._next() if token == "DEF" else ""
        node = Node(self._next() if name else token)
        check_type(node.type)
        if not re.match(r"[^\W\d]", node.type) or self._next() != "{":
            raise ContentsError(f"{shown(node.type, 30)} stands in it where a node is due")
        self._depth, self._count = self._depth + 1, self._count + 1
        if self._depth > _DEEPEST or self._count > MOST_PLACED:
            raise ContentsError(f"its nodes are more than {_DEEPEST} levels deep, or more than {MOST_PLACED:,}")
        token = self._next()
        while token != "}":
            if not token:
                raise ContentsError(f"it is cut short: a {shown(node.type, 30)} has no end")
            token = self._field(node, token)
        self._depth -= 1
        self._names[name] = node
        return node

    def _field(self, node: Node, name: str) -> str:
        """Read a field of a node; the token behind it."""
        if name == "ROUTE":
            for _ in range(3):
                self._next()
            return self._next()
        check_type(name)
        if not re.match(r"[^\W\d]", name):
            raise ContentsError(f"{shown(name, 30)} stands in a {shown(node.type, 30)} where the name of a field is due")
        if (token := self._next()) == "[":
            if _NUMBERS.match(self._text, self._at):
                end = self._text.find("]", self._at)
                if end < 0:
                    raise ContentsError("it is cut short within a list")
                node.fields[name] = _REMARK.sub(" ", self._text[self._at : end]).replace(",", " ")
                self._at = end + 1
                return self._next()
            texts = []
            while (token := self._next()) != "]":
                if not token:
                    raise ContentsError("it is cut short within a list")
                if token.startswith('"') or token in ("TRUE", "FALSE"):
                    texts.append(token)
                else:
                    node.parts.append((name, self._node(token)))
            node.fields[name] = " ".join(texts)
            return self._next()
        words = []
        while token and (token[0] in '-+.0123456789"' or token in ("TRUE", "FALSE", "NULL", "nan", "inf")):
            words.append(token)
            token = self._next()
        if words:
            node.fields[name] = " ".join(words)
            return token
        node.parts.append((name, self._node(token)))
        return self._next()


def read_x3d(path: Path, references: References) -> Reading:
    """Read a scene in XML."""
    root = read_tree(path.read_bytes())
    scene = root.find("Scene")
    if root.tag != "X3D" or scene is None:
        raise ContentsError("it holds no X3D document with a scene")
    if root.find("./head/unit") is not None:
        raise ContentsError("it has units of its own, which are not known here")
    names: dict[str, Node] = {}
    return read_nodes([("children", _of_element(part, names)) for part in scene if part.tag not in _STATEMENTS], path, references)


def _of_element(part: Element, names: dict[str, Node]) -> Node:
    """The node that an element is."""
    check_type(part.tag)
    if (used := part.get("USE")) is not None:
        if used not in names:
            raise ContentsError(f"it uses {shown(used, 30)}, which is not defined before")
        return names[used]
    node = Node(part.tag, {name: text.replace(",", " ") if "url" not in name else text for name, text in part.attrib.items()})
    node.parts = [
        (child.get("containerField", "children"), _of_element(child, names)) for child in part if child.tag not in _STATEMENTS
    ]
    names[part.get("DEF", "")] = node
    return node


def write_vrml(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write a mesh as one shape in VRML 2.0, every digit of its coordinates, with the colours of its vertices."""
    colors, colour = mesh.vertex_attributes.get("colors"), ""
    if colors is not None:
        shares = np.minimum((colors[:, :3] + 1e-4) / 255.0, 1.0)  # MeshLab truncates levels
        colour = "color Color {{ color [\n{}\n] }}\n".format(
            "\n".join("{:.7g} {:.7g} {:.7g}".format(*c) for c in shares.tolist())
        )
    points = "\n".join("{!r} {!r} {!r}".format(*place) for place in mesh.vertices.tolist())
    faces = "\n".join("{} {} {} -1".format(*face) for face in mesh.faces.tolist())
    coord = f"coord Coordinate {{ point [\n{points}\n] }}\n"
    body = f"IndexedFaceSet {{\nsolid FALSE\n{coord}{colour}coordIndex [\n{faces}\n]\n}}" if len(mesh.faces) else ""
    geometry = body or f"PointSet {{\n{coord}{colour}}}"
    target.write(
        f"#VRML V2.0 utf8\nShape {{ appearance Appearance {{ material Material {{ }} }}\ngeometry {geometry}\n}}\n".encode()
    )
    return ()
