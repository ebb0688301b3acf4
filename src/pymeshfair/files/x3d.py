"""Reads scenes in X3D, and gives MeshLab one whose textures were found and checked."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote
from xml.etree.ElementTree import Element

from .announced import Announced
from .errors import ContentsError
from .given import Given, find_textures
from .instances import MIRRORED
from .references import References
from .scene import Scene
from .xml_document import formatted_tree, read_tree

_FIELDS = (
    *("point", "vector", "color", "coordIndex", "normalIndex", "colorIndex", "texCoordIndex", "index"),
    *("colorPerVertex", "normalPerVertex", "scale"),
)

_TEXTS = re.compile(r'"([^"]*)"|\'([^\']*)\'|(\S+)')


def inspect_x3d(path: Path, references: References, given: Given) -> Announced:
    """Read a scene; what it declares.

    Raises:
        ContentsError: it is none, or names what is not there.
        InputError: it names a file that must not be opened.
    """
    root = read_tree(path.read_bytes())
    if root.tag.rpartition(":")[2] != "X3D":
        raise ContentsError("it holds no X3D document")
    scene = Scene()
    _follow(scene, root)
    places = [part for part in root.iter() if "url" in part.attrib]
    names = [[unquote(a or b or c) for a, b, c in _TEXTS.findall(part.attrib["url"])] for part in places]
    textures = find_textures([name for found in names for name in found], references)
    known = {t.name: t.given for t in textures}
    for part, found in zip(places, names, strict=True):
        part.attrib["url"] = " ".join(f'"{known[name]}"' for name in found)
    for part in root.iter():
        for name in [name for name in part.attrib if "url" in name.lower() and name != "url"]:
            del part.attrib[name]
    given.link(textures)
    return Announced(
        normals=scene.normals,
        doubts=(MIRRORED,) if scene.mirrored else (),
        side_files=tuple(t.file for t in textures if t.file),
        textures=textures,
        reading=given.write(formatted_tree(root)),
    )


def _follow(scene: Scene, part: Element) -> None:
    """Tell the nodes to a scene."""
    used = part.get("USE")
    if used is not None:
        scene.use(used)
        return
    scene.begin(part.tag.rpartition(":")[2], part.get("DEF", ""))
    for name in _FIELDS:
        if name in part.attrib:
            scene.field(name, part.attrib[name].replace(",", " "))
    for child in part:
        _follow(scene, child)
    scene.end()
