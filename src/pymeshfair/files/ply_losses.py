"""What a PLY file declares and MeshLab drops silently.

The table is that of vcglib's ``wrap/io_trimesh/import_ply.h``, less what MeshLab reads but does not write again (flags, cameras,
normals of faces, colours of wedges).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from .ply import PlyHeader, PlyProperty
from .ply_given import is_misread

_REAL, _FLOAT, _BYTE, _INT = ("float", "double"), ("float",), ("uchar",), ("int",)
_KNOWN: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "vertex": {
        **dict.fromkeys(("x", "y", "z", "nx", "ny", "nz", "quality", "radius", "texture_u", "texture_v"), _REAL),
        **dict.fromkeys(("red", "green", "blue", "alpha"), _BYTE),
        **dict.fromkeys(("diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"), _BYTE),
        **dict.fromkeys(("s", "t"), _FLOAT),
    },
    "face": {
        **dict.fromkeys(("vertex_indices", "vertex_index"), ("int", "uint", "short")),
        "quality": _REAL,
        "texcoord": _FLOAT,
        "texnumber": _INT,
        **dict.fromkeys(("red", "green", "blue", "alpha"), _BYTE),
    },
    "tristrips": {"vertex_indices": _INT},
    "range_grid": {"vertex_indices": _INT},
    "edge": dict.fromkeys(("vertex1", "vertex2"), ("int", "uint")),
}
#: properties that MeshLab reads only if all of them are there
_TOGETHER = (
    *(frozenset(g) for g in (("x", "y", "z"), ("nx", "ny", "nz"), ("s", "t"), ("texture_u", "texture_v"))),
    *(frozenset(f"{prefix}{c}" for c in ("red", "green", "blue")) for prefix in ("", "diffuse_")),
)
_LISTS = {("face", "vertex_indices"), ("face", "vertex_index"), ("face", "texcoord")}
_LISTS |= {("tristrips", "vertex_indices"), ("range_grid", "vertex_indices")}


#: names that mean something else in the expressions of MeshLab's filters
_TAKEN = frozenset(
    ("x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "a", "q", "rad", "vi", "fi", "ti", "vtu", "vtv", "vsel", "fsel")
)
_TAKEN |= {f"{c}{k}" for c in "xyzqrgba" for k in range(3)}


def carried(header: PlyHeader) -> frozenset[tuple[str, str]]:
    """(element, property) of what MeshLab does not read and a run keeps as custom attributes: numbers of vertices and faces."""
    own_marks = any(c.startswith("VCGLIB") for c in header.comments)
    return frozenset(
        (element.name, p.name)
        for element in header.elements
        if element.name in ("vertex", "face")
        for p in element.properties
        if p.count_type is None
        and (is_misread(element.name, p) or not _is_known(element.name, _KNOWN[element.name], p))
        and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", p.name)
        and p.name not in _TAKEN | _KNOWN[element.name].keys() - {"radius"}
        and not (own_marks and p.name == "flags")
    )


def not_kept(header: PlyHeader, kept: frozenset[tuple[str, str]] = frozenset()) -> list[str]:
    """What the file declares and MeshLab does not keep, in words, in the order of the file.

    Args:
        header: of the file.
        kept: (element, property) of what is kept in another way.
    """
    lost = []
    for element in header.elements:
        known = _KNOWN.get(element.name)
        if element.count == 0:
            continue
        if known is None:
            lost.append(f"element {element.name!r} ({element.count:,})")
            continue
        read = {p.name for p in element.properties if _is_known(element.name, known, p)}
        lost += [
            f"{element.name} property {str(p)!r}{_consequence(element.name, p)}"
            for p in element.properties
            if (element.name, p.name) not in kept
            and (p.name not in read or any(p.name in group and not group <= read for group in _TOGETHER))
        ]
    told = [c for c in header.comments if c and c != "VCGLIB generated" and not c.lower().startswith("texturefile")]
    if told:
        lost.append(f"comment {told[0][:60]!r}" + (f" and {len(told) - 1} more" if len(told) > 1 else ""))
    return lost


def _is_known(element: str, known: Mapping[str, tuple[str, ...]], p: PlyProperty) -> bool:
    return p.type in known.get(p.name, ()) and ((element, p.name) in _LISTS) == (p.count_type is not None)


def _consequence(element: str, lost: PlyProperty) -> str:
    """What MeshLab makes of some properties that it does not keep."""
    if (element, str(lost)) == ("vertex", "float intensity"):
        return ", which replaces the colours by shades of grey"
    if (element, str(lost)) == ("vertex", "float confidence"):
        return ", which is read as the vertex scalar with wrong values"
    return ""
