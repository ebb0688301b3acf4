"""The nodes of a VRML or X3D scene as they open and close, and whether the faces in it name points that are there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .errors import ContentsError
from .indices import check_range, indices, numbers
from .instances import check_placed
from .references import shown

#: nodes that load, run or define something else
_REFUSED = frozenset(
    ("Inline", "EXTERNPROTO", "PROTO", "IMPORT", "Script", "ProtoDeclare", "ExternProtoDeclare", "ProtoInstance", "Import")
)
#: the nodes whose values faces name: the field that has them, and how many numbers make one
_VALUES = {
    "Coordinate": ("point", 3),
    "CoordinateDouble": ("point", 3),
    "Normal": ("vector", 3),
    "Color": ("color", 3),
    "ColorRGBA": ("color", 4),
    "TextureCoordinate": ("point", 2),
}
#: fields of indices, and the nodes that they name
_INDICES = {
    "coordIndex": ("Coordinate", "CoordinateDouble"),
    "index": ("Coordinate", "CoordinateDouble"),
    "normalIndex": ("Normal",),
    "colorIndex": ("Color", "ColorRGBA"),
    "texCoordIndex": ("TextureCoordinate",),
}
#: values that are named by ``coordIndex`` without indices of their own, and the field that says they are one a face instead
_SHARED = (
    (("Color", "ColorRGBA"), "colorIndex", "colorPerVertex"),
    (("Normal",), "normalIndex", "normalPerVertex"),
    (("TextureCoordinate",), "texCoordIndex", ""),
)
_DEEPEST = 200


@dataclass
class _Node:
    type: str
    name: str
    fields: dict[str, str] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    placed: int = 1


class Scene:
    """Follows the nodes of a document.

    Attributes:
        normals: whether any mesh has normals.
        mirrored: whether a node places its parts as in a mirror.
        kinds: the types of all nodes.
    """

    def __init__(self) -> None:
        """See the class."""
        self.normals = self.mirrored = False
        self.kinds: set[str] = set()
        self._open: list[_Node] = []
        self._counts: dict[str, tuple[str, int]] = {}
        self._placed: dict[str, int] = {}

    def begin(self, type: str, name: str = "") -> None:
        """A node begins, with the name that others may use it by.

        Raises:
            ContentsError: of a type that leads out of the document, or too deep.
        """
        check_type(type)
        if len(self._open) == _DEEPEST:
            raise ContentsError(f"its nodes are more than {_DEEPEST} levels deep")
        self.kinds.add(type)
        self._open.append(_Node(type, name))

    def field(self, name: str, text: str) -> None:
        """A field of the innermost node."""
        if self._open:
            self._open[-1].fields[name] = text

    def use(self, name: str) -> None:
        """The innermost node has another one, by its name, as a part."""
        self._place(self._placed.get(name, 0))
        if self._open and name in self._counts:
            type, count = self._counts[name]
            self._open[-1].counts[type] = count

    def end(self) -> None:
        """The innermost node ends.

        Raises:
            ContentsError: it names what is not there.
        """
        if not self._open:
            raise ContentsError("a node of it ends that has not begun")
        node = self._open.pop()
        self._placed[node.name] = node.placed
        self._place(node.placed)
        if node.type in _VALUES:
            field_name, width = _VALUES[node.type]
            values = numbers(node.fields.get(field_name, ""), f"the values of a {node.type}")
            if len(values) % width:
                raise ContentsError(f"a {node.type} of it has {len(values):,} numbers, which are no whole number of {width}")
            if node.name:
                self._counts[node.name] = node.type, len(values) // width
            if self._open:
                self._open[-1].counts[node.type] = len(values) // width
        self.normals |= node.type == "Normal"
        if node.type == "Transform" and "scale" in node.fields:
            scale = numbers(node.fields["scale"], "the scale of a Transform")
            self.mirrored |= bool(np.sign(scale).prod() < 0)
        for name in _INDICES.keys() & node.fields.keys():
            self._check_indices(node, name)

    def _place(self, parts: int) -> None:
        """So many nodes are parts of the innermost one."""
        if self._open:
            self._open[-1].placed += parts
            check_placed(self._open[-1].placed, 0)

    def finish(self) -> None:
        """The document ends.

        Raises:
            ContentsError: nodes are open.
        """
        if self._open:
            raise ContentsError(f"it is cut short: a {shown(self._open[-1].type, 30)} has no end")

    def _check_indices(self, node: _Node, name: str) -> None:
        found = indices(node.fields[name], f"the {name} of a {node.type}")
        values = [node.counts[type] for type in _INDICES[name] if type in node.counts]
        if not len(found):
            return
        check_range(found, -1, values[0] if values else 0, f"the {name} of a {shown(node.type, 30)}")
        if name != "coordIndex":
            return
        faces = int((found[:-1] < 0).sum()) + 1
        for types, own, one_a_corner in _SHARED:
            for type in (t for t in types if t in node.counts and own not in node.fields):
                needed = faces if node.fields.get(one_a_corner, "").strip().upper() == "FALSE" else int(found.max()) + 1
                if node.counts[type] < needed:
                    raise ContentsError(f"a {type} of it has {node.counts[type]:,} values, but its faces take {needed:,}")


def check_type(type: str) -> None:
    """Refuse a type of node that leads out of the document.

    Raises:
        ContentsError: it is one.
    """
    if type in _REFUSED:
        raise ContentsError(f"it has a node of the type {type}, which leads out of the file; save it without")
