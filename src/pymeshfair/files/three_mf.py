"""Reads 3MF files whole within limits, and gives MeshLab an archive of nothing else than what was understood.

An archive of a few kilobytes may hold gigabytes, a name in it may lead out of it, and two programs may see two different
archives in one file. What MeshLab gets is written anew, part by part.
"""

from __future__ import annotations

import io
import lzma
import struct
import zipfile
import zlib
from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from .announced import Announced
from .errors import ContentsError
from .given import Given
from .indices import check_range, indices, numbers
from .instances import MIRRORED, check_instances, mirrors
from .references import References, check_image, shown
from .xml_document import parse_xml

#: how many times as large as the file, and bytes besides, all that it holds may be: numbers written as text shrink to a tenth
_MOST_TIMES, _BESIDES = 100, 1 << 24
_MOST_PARTS = 10_000
#: what the library raises on an archive that is none, or encrypted, or of a kind that it does not know
_BROKEN = (zipfile.BadZipFile, RuntimeError, EOFError, zlib.error, lzma.LZMAError, struct.error, ValueError, LookupError, OSError)
#: what stands in an archive besides models: its list of types, relationships, and images
_LISTS, _IMAGES = (".xml", ".rels"), (".png", ".jpg", ".jpeg", ".texture")
#: the elements that MeshLab reads with their attributes; identifiers and names of spaces say nothing of a mesh
_KNOWN = {
    **{"model": {"unit", "requiredextensions", "recommendedextensions"}, "object": {"id", "type"}},
    **{"vertex": {"x", "y", "z"}, "triangle": {"v1", "v2", "v3"}},
    **{"component": {"objectid", "transform"}, "item": {"objectid", "transform"}},
    **{name: set[str]() for name in ("resources", "build", "components", "mesh", "vertices", "triangles")},
}
_UNSAID = ("xmlns", "xmlns:", "xml:", "p:UUID")
#: an extension without which the mesh is the same
_MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"


@dataclass
class _Model:
    """The meshes of the models: the coordinates and corners of the one that is open, and the counts of those before.

    Besides the unit, what each object is put together of, how many triangles it has itself, what is built, whether a part is
    mirrored, and how many there are of each kind of element and attribute that MeshLab does not read.
    """

    coordinates: list[str] = field(default_factory=list)
    corners: list[str] = field(default_factory=list)
    counts: list[tuple[int, int]] = field(default_factory=list)
    components: int = 0
    items: list[str] = field(default_factory=list)
    unit: str = "millimeter"
    parts: dict[Hashable, list[Hashable]] = field(default_factory=dict)
    faces: dict[Hashable, int] = field(default_factory=dict)
    object: str = ""
    mirrored: bool = False
    unread: Counter[str] = field(default_factory=Counter)
    beyond: int = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """An element begins."""
        kind = tag.rpartition(":")[2]
        if self.beyond or kind not in _KNOWN:
            if not self.beyond and attributes.get("name") != "Application":  # which says nothing of the mesh
                self.unread[f"elements {shown(kind, 30)}"] += 1
            self.beyond += 1
            return
        if attributes.keys() - _KNOWN[kind]:
            self._look_at(kind, attributes)
        try:
            match kind:
                case "vertex":
                    self.coordinates += (attributes["x"], attributes["y"], attributes["z"])
                case "triangle":
                    self.corners += (attributes["v1"], attributes["v2"], attributes["v3"])
                case "model":
                    self.unit = attributes.get("unit", self.unit)
                    _check_extensions(attributes)
                case "object":
                    self.object = attributes["id"]
                    if attributes.get("type", "model") != "model":
                        self.unread[f"objects of the type {shown(attributes['type'], 30)}"] += 1
                    self.parts.setdefault(self.object, [])
                case "component":
                    self.components += 1
                    self._place(attributes)
                    self.parts.setdefault(self.object, []).append(attributes["objectid"])
                case "item":
                    self.items.append(attributes["objectid"])
                    self._place(attributes)
        except KeyError as error:
            raise ContentsError(f"a {tag} of it has no {error.args[0]}") from None

    def _look_at(self, kind: str, attributes: dict[str, str]) -> None:
        """Count the attributes that MeshLab does not read."""
        for name in attributes.keys() - _KNOWN[kind]:
            if not name.startswith(_UNSAID):
                self.unread[f"attributes {shown(name, 30)} of the elements {kind!r}"] += 1

    def _place(self, attributes: dict[str, str]) -> None:
        """Refuse a transform that is none."""
        if "transform" not in attributes:
            return
        values = numbers(attributes["transform"], "a transform of it")
        if len(values) != 12:
            raise ContentsError(f"a transform of it has {len(values)} numbers and not 12")
        self.mirrored |= mirrors(values.reshape(4, 3)[:3])

    def end(self, tag: str) -> None:
        """An element ends."""
        if self.beyond:
            self.beyond -= 1
            return
        if tag.rpartition(":")[2] != "mesh":
            return
        number = len(self.counts) + 1
        coordinates = numbers(" ".join(self.coordinates), f"the coordinates of its mesh {number}")
        corners = indices(" ".join(self.corners), f"the corners of its mesh {number}")
        if len(coordinates) != len(self.coordinates) or len(corners) != len(self.corners):
            raise ContentsError(f"a vertex or a triangle of its mesh {number} has a value that is no number")
        check_range(corners, 0, len(coordinates) // 3, f"the corners of its mesh {number}")
        self.counts.append((len(coordinates) // 3, len(corners) // 3))
        self.faces[self.object] = self.faces.get(self.object, 0) + len(corners) // 3
        self.coordinates, self.corners = [], []

    @property
    def said(self) -> tuple[int | None, int | None]:
        """How many vertices and faces MeshLab must find; None where meshes are put together."""
        single = len(self.counts) == 1 and not self.components and len(self.items) == 1
        return self.counts[0] if single else (None, None)


def inspect_3mf(path: Path, references: References, given: Given) -> Announced:
    """Read a 3MF file; what it declares.

    Raises:
        ContentsError: it is none, or declares what cannot be.
        InputError: an image in it is none.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            parts = _parts(archive, path.stat().st_size)
    except ContentsError:
        raise
    except _BROKEN as error:
        raise ContentsError(f"it is no whole archive ({str(error)[:80]})") from error
    model = _Model()
    lost = []
    kept: dict[str, bytes] = {}
    for name, data in parts.items():
        small = name.lower()
        if small.endswith(".model"):
            parse_xml(data, model.start, model.end)
        elif small.endswith(_LISTS):
            parse_xml(data, lambda tag, attributes: None)
        elif small.endswith(_IMAGES):
            check_image(io.BytesIO(data), references.mesh, name)
        else:
            lost.append(f"its part {shown(name)}")
            continue
        kept[name] = data
    if not model.counts:
        raise ContentsError("it holds no mesh")
    check_instances(model.parts, model.faces, model.items)
    if model.unit != "millimeter":
        lost.append(f"its unit {shown(model.unit, 30)}")
    lost += [f"{what} ({number:,})" for what, number in sorted(model.unread.items())]
    vertices, faces = model.said
    return Announced(
        vertices=vertices,
        faces=faces,
        triangles=faces,
        not_kept=tuple(lost),
        doubts=(MIRRORED,) if model.mirrored else (),
        reading=given.write(_archive(kept)),
    )


def _check_extensions(attributes: dict[str, str]) -> None:
    """Refuse a model that cannot be understood without what MeshLab does not know."""
    for prefix in attributes.get("requiredextensions", "").split():
        space = attributes.get(f"xmlns:{prefix}", prefix)
        if space != _MATERIALS:
            raise ContentsError(f"it needs the extension {shown(space, 100)}, which MeshLab does not know")


def _parts(archive: zipfile.ZipFile, size: int) -> dict[str, bytes]:
    """What is in an archive by name."""
    left = _MOST_TIMES * size + _BESIDES
    entries = archive.infolist()
    if len(entries) > _MOST_PARTS:
        raise ContentsError(f"it holds {len(entries):,} parts; {_MOST_PARTS:,} are the most")
    parts: dict[str, bytes] = {}
    for entry in entries:
        if entry.is_dir():
            continue
        name = entry.filename
        if name in parts or name.startswith("/") or "\\" in name or ".." in PurePosixPath(name).parts:
            raise ContentsError(f"its part {shown(name)} is there twice, or leads out of the archive")
        with archive.open(entry) as stream:
            parts[name] = stream.read(left + 1)  # whatever the entry declares
        left -= len(parts[name])
        if left < 0:
            raise ContentsError(f"its {size:,} bytes hold more than {_MOST_TIMES} times as many, which no mesh does")
    return parts


def _archive(parts: dict[str, bytes]) -> bytes:
    """An archive of these parts, not compressed."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
        for name, data in parts.items():
            archive.writestr(zipfile.ZipInfo(name), data)
    return stream.getvalue()
