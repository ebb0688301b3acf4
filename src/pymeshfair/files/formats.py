"""The mesh files that a run reads and writes, and the contents that each format holds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import missing_package

if TYPE_CHECKING:
    from ..mesh_data import MeshData

#: everything that a mesh may have besides its vertices and that a file may keep or lose, in the words of messages
ATTRIBUTES = (
    *("faces", "edges", "vertex normals", "vertex colours", "vertex scalars", "vertex texture coordinates"),
    *("face colours", "face scalars", "wedge texture coordinates", "textures", "custom attributes"),
    *("vertex opacities", "face opacities", "vertex radii", "polygons"),
)
#: formats that are read here, strictly and to their last byte
READABLE = (
    *("ply", "obj", "stl", "off", "3mf", "glb", "gltf", "dae", "wrl", "x3d", "x3dv"),
    *("xyz", "pts", "asc", "txt", "apts", "ptx", "las", "laz", "e57"),
)
#: those whose files may say the unit of their coordinates
WITH_UNIT = ("3mf", "glb", "gltf", "dae", "las", "laz", "e57")
#: formats that MeshLab's own readers alone know; they believe whatever a file says
UNCHECKED = ("3ds", "ctm", "qobj", "tri", "bre")
#: messages where the package for E57 files, or for LAS and LAZ files, is not installed
MISSING_PYE57, MISSING_LASPY = missing_package("pye57", "e57"), missing_package("laspy", "las")


@dataclass(frozen=True)
class Format:
    """One kind of file that a run writes."""

    extension: str  # without the dot, in lower case; the first of those that it has
    rounding: tuple[float, float]  # how far writing moves a coordinate at most, as a share of its amount, and in units besides
    holds: frozenset[str]  # the `ATTRIBUTES` that it keeps; everything else that a mesh has is named in a warning

    def lost(self, present: set[str]) -> list[str]:
        """The `ATTRIBUTES` among `present` that such a file does not keep."""
        lost = present - self.holds
        if self.extension in _ONE_PLACE and "wedge texture coordinates" in present:
            lost |= present & {"vertex texture coordinates"}
        return [a for a in ATTRIBUTES if a in lost]


#: formats whose vertices have texture coordinates only if the corners of faces have none
_ONE_PLACE = ("obj", "glb")


def _format(extension: str, rounding: tuple[float, float], *holds: str) -> Format:
    assert set(holds) <= set(ATTRIBUTES)
    return Format(extension, rounding, frozenset(holds))


_OBJ = ("faces", "edges", "vertex normals", "vertex colours", "vertex texture coordinates", "wedge texture coordinates")
_OFF = ("faces", "edges", "vertex normals", "vertex colours", "vertex opacities", "face colours", "face opacities")
_POINTS = ("vertex normals", "vertex colours", "custom attributes")  # or named by the writer
_EXACT, _FLOAT = (0.0, 0.0), 2.0**-24
_FORMATS = {
    f.extension: f
    for f in (
        _format("ply", _EXACT, *ATTRIBUTES),
        _format("obj", _EXACT, *_OBJ, "face colours", "textures", "polygons"),
        _format("off", _EXACT, *_OFF, "vertex texture coordinates", "polygons"),
        _format("stl", (_FLOAT, 0.0), "faces", "face colours"),
        _format("glb", (_FLOAT, 0.0), *_OBJ, "face colours", "vertex opacities", "face opacities", "textures"),
        _format("3mf", _EXACT, "faces", "vertex colours", "face colours", "vertex opacities", "face opacities"),
        _format("wrl", _EXACT, "faces", "vertex colours"),
        _format("las", _EXACT, *_POINTS, "vertex scalars", "vertex radii"),
        _format("xyz", _EXACT, *_POINTS),
        _format("dxf", _EXACT, "edges"),
        _format("svg", _EXACT, "edges"),
    )
}
#: extensions of the same format as another
_ALIKE = {"laz": "las", "pts": "xyz", "asc": "xyz", "txt": "xyz"}
WRITABLE: Mapping[str, Format] = _FORMATS | {e: _FORMATS[f] for e, f in _ALIKE.items()}


def attributes_of(mesh: MeshData) -> set[str]:
    """Which of `ATTRIBUTES` a mesh has."""
    from ..mesh_data.mesh_data import FACE_ATTRIBUTES, VERTEX_ATTRIBUTES  # numpy, for which no help waits

    vertex, face, has_faces = mesh.vertex_attributes, mesh.face_attributes, len(mesh.faces) > 0
    present = {
        "faces": has_faces,
        "edges": len(mesh.edges) > 0,
        "vertex normals": mesh.keeps_normals or (not has_faces and "normals" in vertex),
        "vertex colours": "colors" in vertex,
        "vertex scalars": "scalars" in vertex,
        "vertex texture coordinates": "texture_coordinates" in vertex,
        "face colours": "colors" in face,
        "face scalars": "scalars" in face,
        "wedge texture coordinates": "wedge_texture_coordinates" in face,
        "textures": bool(mesh.textures),
        "custom attributes": bool(vertex.keys() - VERTEX_ATTRIBUTES or face.keys() - FACE_ATTRIBUTES),
        "vertex opacities": "colors" in vertex and bool((vertex["colors"][:, 3] != 255).any()),
        "face opacities": "colors" in face and bool((face["colors"][:, 3] != 255).any()),
        "vertex radii": "radii" in vertex,
        "polygons": "polygon" in face and bool((face["polygon"] >= 0).any()),
    }
    return {name for name, there in present.items() if there}


def extension(path: Path) -> str:
    """The extension of a file without the dot, in lower case."""
    return path.suffix[1:].lower()


def listed(extensions: Iterable[str]) -> str:
    """The extensions as a message gives them: ``.ply, .obj, .stl``."""
    return ", ".join(f".{e}" for e in extensions)
