"""The mesh files that a run reads and writes, and what each kind can hold.

What a format holds was found by writing a mesh that has everything with pymeshlab 2025.7 and reading it back; the tests do it
again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

#: Everything that MeshLab reads as a mesh, but for programs that generate one (.es), molecules (.pdb), MeshLab's own memory dumps
#: (.vmi) and .fbx, on which it crashes.
READABLE = (
    *("ply", "obj", "stl", "off", "3mf", "glb", "gltf", "dae", "wrl", "x3d", "x3dv", "3ds", "ctm", "qobj", "tri"),
    *("xyz", "pts", "asc", "txt", "apts", "ptx", "e57", "bre"),
)

#: How exactly coordinates are written: all digits of a double, of a float, six digits in all, or six after the point.
Precision: TypeAlias = Literal["double", "float", "six digits", "six decimals"]


@dataclass(frozen=True)
class Format:
    """One kind of file that a run writes.

    Attributes:
        extension: without the dot, in lower case.
        precision: of coordinates.
        holds: what of `ATTRIBUTES` it keeps; everything else that a mesh has is named in a warning.
        options: what to tell pymeshlab when saving.
    """

    extension: str
    precision: Precision
    holds: frozenset[str]
    options: Mapping[str, Any]


#: everything that a mesh of MeshLab may have besides its vertices and that a file may keep or lose, in the words of warnings
ATTRIBUTES = (
    "faces",
    "edges",
    "vertex normals",
    "vertex colours",
    "vertex scalars",
    "vertex texture coordinates",
    "face colours",
    "face scalars",
    "wedge texture coordinates",
    "textures",
    "custom attributes",
)


def _format(extension: str, precision: Precision, *holds: str, **options: Any) -> Format:
    assert set(holds) <= set(ATTRIBUTES)
    return Format(extension, precision, frozenset(holds), MappingProxyType(options))


# Without `save_polygonal=False` MeshLab merges triangles back into polygons, and then writes 7 decimals and texture coordinates
# that are all 0.
_ALL_BUT_EDGES = tuple(a for a in ATTRIBUTES if a != "edges")
_OBJ = ("faces", "edges", "vertex normals", "vertex colours", "face colours", "wedge texture coordinates", "textures")
_OFF = ("faces", "vertex normals", "vertex colours", "face colours", "vertex texture coordinates")
WRITABLE: Mapping[str, Format] = {
    f.extension: f
    for f in (
        _format("ply", "double", *_ALL_BUT_EDGES, binary=True),
        _format("obj", "double", *_OBJ, save_polygonal=False),
        _format("off", "double", *_OFF, save_polygonal=False),
        _format("stl", "float", "faces", binary=True, save_face_color=False),
        _format("3mf", "float", "faces"),
        _format("wrl", "six digits", "faces", "vertex colours", save_wedge_texcoord=False),
        _format("x3d", "six digits", "faces", "vertex colours", save_wedge_texcoord=False),
        _format("xyz", "six decimals", "vertex normals"),
    )
}


def extension(path: Path) -> str:
    """The extension of a file without the dot, in lower case."""
    return path.suffix[1:].lower()


def listed(extensions: Mapping[str, object] | tuple[str, ...]) -> str:
    """The extensions as a message gives them: ``.ply, .obj, .stl``."""
    return ", ".join(f".{e}" for e in extensions)
