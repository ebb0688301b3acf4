"""The mesh files that a run reads and writes, and what each kind can hold.

What a format holds was found by writing a mesh that has everything with pymeshlab 2025.7 and reading it back; the tests do it
again. The edges of a PLY file are written here, see `ply_edges`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

#: Everything that MeshLab reads as a mesh, but for programs that generate one (.es), molecules (.pdb), MeshLab's own memory dumps
#: (.vmi) and .fbx, on which it crashes.
READABLE = (
    *("ply", "obj", "stl", "off", "3mf", "glb", "gltf", "dae", "wrl", "x3d", "x3dv", "3ds", "ctm", "qobj", "tri"),
    *("xyz", "pts", "asc", "txt", "apts", "ptx", "e57", "bre"),
)
#: clouds that a run reads and writes by tiles alone, and what to do about that
BY_TILES = ("las", "laz")
BY_TILES_ADVICE = (
    "LAS and LAZ clouds are read and written by tiles alone: `pymeshfair run remove_outliers IN.laz -o OUT.laz --tiles`, after "
    "`python -m pip install 'pymeshfair[las]'`; for other recipes and commands save it as .ply"
)


@dataclass(frozen=True)
class Format:
    """One kind of file that a run writes.

    Attributes:
        extension: without the dot, in lower case.
        rounding: how far writing moves a coordinate at most, as a share of its amount, and in units besides.
        holds: what of `ATTRIBUTES` it keeps; everything else that a mesh has is named in a warning.
        options: what to tell pymeshlab when saving.
    """

    extension: str
    rounding: tuple[float, float]
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
    "vertex opacities",
    "face opacities",
    "vertex radii",
)


def _format(extension: str, rounding: tuple[float, float], *holds: str, **options: Any) -> Format:
    assert set(holds) <= set(ATTRIBUTES)
    return Format(extension, rounding, frozenset(holds), MappingProxyType(options))


# Without `save_polygonal=False` MeshLab merges triangles back into polygons, and then writes 7 decimals and texture coordinates
# that are all 0.
_OBJ = ("faces", "edges", "vertex normals", "vertex colours", "face colours", "wedge texture coordinates", "textures")
_OFF = ("faces", "vertex normals", "vertex colours", "vertex opacities", "face colours", "vertex texture coordinates")
# Not .x3d, in which MeshLab tears a textured mesh apart, and not .ctm, .e57, .3ds and .dae, which lose more than they say.
_EXACT, _FLOAT = (0.0, 0.0), 2.0**-24
WRITABLE: Mapping[str, Format] = {
    f.extension: f
    for f in (
        _format("ply", _EXACT, *ATTRIBUTES, binary=True),
        _format("obj", _EXACT, *_OBJ, save_polygonal=False),
        _format("off", _EXACT, *_OFF, save_polygonal=False),
        _format("stl", (_FLOAT, 0.0), "faces", binary=True, save_face_color=False),
        _format("3mf", (_FLOAT, 1e-6), "faces"),
        _format("wrl", (5e-6, 0.0), "faces", "vertex colours", save_wedge_texcoord=False),
        _format("xyz", (0.0, 5e-7), "vertex normals"),
    )
}


def extension(path: Path) -> str:
    """The extension of a file without the dot, in lower case."""
    return path.suffix[1:].lower()


def listed(extensions: Mapping[str, object] | tuple[str, ...]) -> str:
    """The extensions as a message gives them: ``.ply, .obj, .stl``."""
    return ", ".join(f".{e}" for e in extensions)
