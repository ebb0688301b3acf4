"""The OBJ file as an input: what it declares, what it names, and what MeshLab is given of it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .announced import Announced, unended
from .as_binary import are_plain_triangles, mesh_as_ply
from .given import Given, find_textures
from .obj import ObjContents, read_obj
from .obj_materials import Materials, find_material_files, format_materials, read_materials
from .obj_values import ObjError
from .references import References, shown

#: what MeshLab drops without a word
_LOST = (
    *("groups", "objects", "smoothing groups", "point elements", "parameter space vertices", "curves", "surfaces"),
    *("uses of maps", "map files", "display attributes"),
)
_MATERIALS = "materials.mtl"
_LEVELS = "the colours of its vertices go up to 255: they are taken for levels of 255, not for shares from 0.0 to 1.0"


def inspect_obj(path: Path, references: References, given: Given) -> Announced:
    """Read an OBJ file and its materials; what it declares.

    Raises:
        ObjError: it is no OBJ file, or lies.
        InputError: it names what must not be opened.
    """
    contents = read_obj(path)
    lost = [f"{what} ({n:,})" for what in _LOST if (n := contents.counts[what])] + contents.notes
    names = list(dict.fromkeys(contents.material_files))
    uses = contents.counts["uses of materials"]
    if not names and uses:  # what some programs write, and MeshLab looks for
        names = [path.with_suffix(".mtl").name]
    files, missing = find_material_files(names, references)
    lost += [f"the material file {Path(name).name}, which does not exist" for name in missing if contents.material_files]
    if uses and not files:
        lost.append(f"uses of materials ({uses:,}), as there is no material file")
    materials = Materials()
    for file in files:
        found = read_materials(file, path)
        if found.ignored:
            lost.append(f"{', '.join(found.ignored)} of the material file {file.name}")
        materials.materials += found.materials
    if files and (unknown := _used(contents.text) - {m.name for m in materials.materials}):
        lost.append(f"uses of the material {shown(min(unknown))}, which its material files do not have")
    textures = find_textures(materials.textures, references)
    if contents.bare_faces and contents.counts["texture coordinates"] and contents.bare_faces < contents.counts["faces"]:
        lost.append(f"that {contents.bare_faces:,} of its faces have no texture coordinates: they get the first ones")
    if contents.partly_bare_faces:
        lost.append(f"that {contents.partly_bare_faces:,} of its faces have texture coordinates at some corners alone")
    reading = None if names or uses else given.offer(".ply", _binary(contents))
    if reading is None and contents.levels:
        raise ObjError("its colours go up to 255, which MeshLab reads only partly; divide them by 255")
    if reading is None and (names or contents.altered or contents.changes or uses):
        named = {t.name: t for t in textures}
        if materials.materials:
            given.write_beside(_MATERIALS, format_materials(materials.materials, named.__getitem__))
        given.link(textures)
        reading = given.write(_normalised(contents, with_materials=bool(materials.materials)))
    return Announced(
        vertices=contents.counts["vertices"],
        faces=contents.counts["faces"],
        triangles=contents.triangles,
        normals=contents.counts["normals"] > 0,
        not_kept=tuple(lost),
        doubts=(*unended(contents.text), *((_LEVELS,) if contents.levels else ())),
        side_files=(*files, *(t.file for t in textures if t.file)),
        textures=textures,
        points=contents.points,
        reading=reading,
    )


def _used(text: bytes) -> set[str]:
    """The materials that faces use."""
    names = set(re.findall(rb"(?m)^usemtl[ \t]+(.*?)[ \t\r]*$", text))
    return {" ".join(name.decode("utf-8", "surrogateescape").split()) for name in names}


def _binary(contents: ObjContents) -> list[bytes] | None:
    """The mesh as the parts of a PLY file, if it is made of triangles, with colours of vertices or without, and nothing else."""
    counts = contents.counts
    if counts["texture coordinates"] or counts["normals"] or counts["polylines"] or not contents.exact or not contents.corners:
        return None
    faces, extra = np.concatenate(contents.corners), np.concatenate(contents.colours)
    if not are_plain_triangles(contents.points, faces) or extra.shape[1] not in (0, 3):
        return None
    levels = extra if contents.levels else np.rint(255 * extra)
    return mesh_as_ply(contents.points, faces, levels.astype(np.uint8) if extra.shape[1] else None)


def _normalised(contents: ObjContents, *, with_materials: bool) -> bytes:
    """The text with its changed lines, and with our material file in place of its own."""
    text = contents.text
    if contents.changes:
        lines = text.split(b"\n")
        for number, line in contents.changes.items():
            lines[number - 1] = line
        text = b"\n".join(lines)
    unwanted = rb"mtllib" if with_materials else rb"mtllib|usemtl"
    text = re.sub(rb"(?m)^(?:" + unwanted + rb")(?:[ \t].*)?$", b"", text)
    return (b"mtllib %s\n" % _MATERIALS.encode() if with_materials else b"") + text
