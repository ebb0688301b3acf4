"""Table of the mesh formats: which function reads or writes a format, and which contents its files keep."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import missing_package

if TYPE_CHECKING:
    from ..mesh_data import MeshData

#: contents of a mesh besides its vertices, by their names in messages
ATTRIBUTES = (
    *("faces", "edges", "vertex normals", "vertex colours", "vertex scalars", "vertex texture coordinates"),
    *("face colours", "face scalars", "wedge texture coordinates", "textures", "custom attributes"),
    *("vertex opacities", "face opacities", "vertex radii", "polygons"),
)
#: formats that only MeshLab's own readers understand; the readers do not check what a file declares
UNCHECKED = ("3ds", "ctm", "qobj", "tri", "bre")
MISSING_PYE57, MISSING_LASPY = missing_package("pye57", "e57"), missing_package("laspy", "las")


@dataclass(frozen=True)
class Format:
    """One kind of file that a run reads or writes."""

    extensions: tuple[str, ...]  # without the dot, in lower case
    reader: str = ""  # ``module.function`` that reads and checks a file; empty if there is none
    writer: str = ""  # ``module.function`` that writes a file; empty if there is none
    holds: frozenset[str] = frozenset()  # the `ATTRIBUTES` that a file keeps
    rounding: float = 0.0  # largest relative change of a coordinate by single precision
    begin: tuple[str, str] | None = None  # pattern for the first bytes of a file, decoded as Latin-1; how messages show it
    has_unit: bool = False  # whether a file may state the unit of its coordinates
    units: tuple[str, ...] = ()  # the units that a file can be written in

    @property
    def extension(self) -> str:
        return self.extensions[0]

    def lost(self, present: set[str]) -> list[str]:
        lost = present - self.holds
        if self.extension in _WEDGES_FIRST and "wedge texture coordinates" in present:
            lost |= present & {"vertex texture coordinates"}
        return [a for a in ATTRIBUTES if a in lost]


_WEDGES_FIRST = ("obj", "glb")  # formats that hold texture coordinates of vertices only if corners of faces have none
_FLOAT = 2.0**-24  # rounding to single precision
_OBJ = frozenset(ATTRIBUTES) - {"vertex scalars", "face scalars", "custom attributes", "vertex radii"}
_OBJ -= {"vertex opacities", "face opacities"}
_COLOURS = frozenset(("faces", "vertex colours", "face colours", "vertex opacities", "face opacities"))
_OFF = _COLOURS | {"edges", "vertex normals", "vertex texture coordinates", "polygons"}
_GLB = (_OBJ | _COLOURS) - {"polygons"}
_POINTS = frozenset(("vertex normals", "vertex colours", "custom attributes"))  # the writers report which of these they lose
_LAS = _POINTS | {"vertex scalars", "vertex radii"}
_XML = (r"(\xef\xbb\xbf)?\s*<|\xff\xfe|\xfe\xff", "'<'")
_EDGES = frozenset(("edges",))
_UNITS = ("um", "mm", "cm", "m", "in", "ft")
_FORMATS = (
    Format(("ply",), "ply.read_ply", "ply_write.write_ply", frozenset(ATTRIBUTES), begin=(r"ply\s", "'ply'")),
    Format(("obj",), "obj.read_obj", "obj.write_obj", _OBJ),
    Format(("off",), "plain.read_off", "plain.write_off", _OFF),
    Format(("stl",), "plain.read_stl", "plain.write_stl", frozenset(("faces", "face colours")), _FLOAT),
    Format(("glb",), "gltf.read_gltf", "gltf.write_glb", _GLB, _FLOAT, ("glTF", "'glTF'"), True, _UNITS),
    Format(("gltf",), "gltf.read_gltf", has_unit=True),
    Format(("3mf",), "three_mf.read_3mf", "three_mf.write_3mf", _COLOURS, 0.0, ("PK", "'PK'"), True, _UNITS),
    Format(("dae",), "collada.read_collada", begin=_XML, has_unit=True),
    Format(("wrl",), "vrml.read_vrml", "vrml.write_vrml", frozenset(("faces", "vertex colours")), begin=("#VRML", "'#VRML'")),
    Format(("x3d",), "vrml.read_x3d", begin=_XML),
    Format(("x3dv",), "vrml.read_vrml"),
    Format(("las", "laz"), "las.read_las", "las.write_las", _LAS, begin=("LASF", "'LASF'"), has_unit=True),
    Format(("xyz", "pts", "asc", "txt"), "points.read_points", "points.write_points", _POINTS),
    Format(("apts",), "points.read_points"),
    Format(("ptx",), "points.read_ptx"),
    Format(("e57",), "e57.read_e57", begin=("ASTM-E57", "'ASTM-E57'"), has_unit=True),
    Format(("dxf",), writer="plain.write_dxf", holds=_EDGES),
    Format(("svg",), writer="plain.write_svg", holds=_EDGES, units=("mm", "cm", "in")),
)
READABLE: Mapping[str, Format] = {e: f for f in _FORMATS if f.reader for e in f.extensions}
WRITABLE: Mapping[str, Format] = {e: f for f in _FORMATS if f.writer for e in f.extensions}


def load_function(name: str) -> Any:
    """Imports ``module.function`` of this package."""
    module, _, function = name.partition(".")
    return getattr(importlib.import_module(f".{module}", __package__), function)


def attributes_of(mesh: MeshData) -> set[str]:
    """Returns the `ATTRIBUTES` that a mesh has."""
    from ..mesh_data.mesh_data import FACE_ATTRIBUTES, VERTEX_ATTRIBUTES  # imports numpy, which help texts do not need

    vertex, face, has_faces = mesh.vertex_attributes, mesh.face_attributes, len(mesh.faces) > 0
    present = {
        "faces": has_faces,
        "edges": len(mesh.edges) > 0,
        "vertex normals": mesh.writes_normals,
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
    return {name for name, is_present in present.items() if is_present}


def contents_of(mesh: MeshData) -> set[str]:
    """Returns the `ATTRIBUTES` of a mesh that was just read, including custom attributes that only its file holds."""
    custom = getattr(mesh.source and mesh.source.document, "custom", None)
    has_custom = custom is not None and any(len(values) for e in ("vertex", "face", "edge") for values in custom(e).values())
    return attributes_of(mesh) | ({"custom attributes"} if has_custom else set())


def extension(path: Path) -> str:
    """Returns the extension of a file in lower case, without the dot."""
    return path.suffix[1:].lower()


def listed(extensions: Iterable[str]) -> str:
    """Lists extensions for a message: ``.ply, .obj, .stl``."""
    return ", ".join(f".{e}" for e in extensions)
