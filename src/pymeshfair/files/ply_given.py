"""The header that MeshLab is given in place of a PLY file's own, where its reader would make something else of it.

MeshLab takes a property called flags for its own marks, of which one means deleted, reads numbers of the wrong width into some
properties, and takes sizes of grids and names of textures from comments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .ply import PlyElement, PlyHeader, PlyProperty
from .references import Texture

#: what a renamed property begins with; MeshLab passes over names that it does not know
_SET_ASIDE = "kept_"
#: properties that MeshLab's reader takes for its own, whatever they mean, and of other types only for what is written here
_MISREAD: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "vertex": {
        "flags": (),
        "intensity": (),
        "confidence": (),
        "radius": ("float",),
    },
    "face": {"flags": (), "color": (), "colors": ()},
}
#: a longer comment is more than MeshLab's reader takes for one line
_LONGEST = 250
#: what comments mean something to MeshLab begin with, in lower case
_MEANT = ("texturefile", "texturenormalfile", "num_cols", "num_rows")


def is_misread(element: str, p: PlyProperty) -> bool:
    """Whether MeshLab would take a property for something else."""
    return p.name in _MISREAD.get(element, {}) and p.type not in _MISREAD[element][p.name]


def must_be_altered(header: PlyHeader) -> bool:
    """Whether MeshLab needs another header."""
    return any(len(c) > _LONGEST or c.lower().startswith(_MEANT) for c in header.comments) or any(
        is_misread(e.name, p) for e in header.elements for p in e.properties
    )


def given_header(header: PlyHeader, textures: Sequence[Texture]) -> bytes:
    """The header with properties that MeshLab misreads set aside, and textures under the names that they are given by."""
    lines = ["ply", f"format {header.format} 1.0", *(f"comment TextureFile {t.given}" for t in textures)]
    grid = header.element("range_grid").count
    lines += [f"obj_info {c}" for c in header.comments if grid and c.startswith(("num_cols", "num_rows"))]
    for element in header.elements:
        lines.append(f"element {element.name} {element.count}")
        lines += [_declared(element, p) for p in element.properties]
    return "\n".join([*lines, "end_header", ""]).encode("utf-8", "surrogateescape")


def kept_name(element: str, p: PlyProperty) -> str:
    """The name under which a property is given to MeshLab, and kept."""
    return f"{_SET_ASIDE}{p.name}" if is_misread(element, p) else p.name


def _declared(element: PlyElement, p: PlyProperty) -> str:
    name = kept_name(element.name, p)
    return f"property {p.type} {name}" if p.count_type is None else f"property list {p.count_type} {p.type} {name}"
