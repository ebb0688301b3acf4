"""Reads scenes in X3D."""

from pathlib import Path
from xml.etree.ElementTree import Element

from .errors import ContentsError
from .reading import Reading
from .references import References, shown
from .scene import Node, check_type, read_nodes
from .xml_document import read_tree


def read_x3d(path: Path, references: References) -> Reading:
    """Read a scene."""
    root = read_tree(path.read_bytes())
    scene = root.find("Scene")
    if root.tag != "X3D" or scene is None:
        raise ContentsError("it holds no X3D document with a scene")
    if root.find("./head/unit") is not None:
        raise ContentsError("it has units of its own, which are not known here")
    names: dict[str, Node] = {}
    return read_nodes([("children", _node(part, names)) for part in scene if part.tag not in _STATEMENTS], path, references)


_STATEMENTS = ("ROUTE", "EXPORT")


def _node(part: Element, names: dict[str, Node]) -> Node:
    """The node that an element is."""
    check_type(part.tag)
    if (used := part.get("USE")) is not None:
        if used not in names:
            raise ContentsError(f"it uses {shown(used, 30)}, which is not defined before")
        return names[used]
    node = Node(part.tag, {name: text.replace(",", " ") if "url" not in name else text for name, text in part.attrib.items()})
    node.parts = [
        (child.get("containerField", "children"), _node(child, names)) for child in part if child.tag not in _STATEMENTS
    ]
    names[part.get("DEF", "")] = node
    return node
