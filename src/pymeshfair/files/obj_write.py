"""Writes OBJ files, with materials, groups and objects of the OBJ file that a mesh comes from."""

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from ..filters.mesh import Floats, Longs
from ..mesh_data import MeshData
from .obj import MOST_MATERIALS, ObjDocument
from .outputs import Writing
from .polygons import numbered, outlines
from .tokens import rows, runs

#: for each colour level a share of six digits: 255 times it gives the level, whether rounded or truncated
_SHARES = np.ceil(np.arange(256) / 255 * 1e6) / 1e6


def write_obj(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write a mesh."""
    document = mesh.document(ObjDocument)
    own = None if len(mesh.faces) else mesh.vertex_attributes.get("normals")
    normals = mesh.vertex_normals if mesh.keeps_normals else np.empty((0, 3)) if own is None else own
    if document is not None and document.materials.lines:
        writing.materials.append(document.materials.text(writing.textures))
    notes = [f"what cannot be written anew is left out: {'; '.join(document.lost)}"] if document and document.lost else []
    uses, names = _materials(mesh, document, writing, notes)
    if writing.materials:
        target.write(b"mtllib %s\n" % writing.material_file.encode("utf-8", "surrogateescape"))
    columns = list(mesh.vertices.T)
    if (colors := mesh.vertex_attributes.get("colors")) is not None:
        columns += [_SHARES[level] for level in colors.T[:3]]
    target.writelines(rows("v" + " %r" * len(columns), columns))
    pairs, of_wedges = _texture_coordinates(mesh)
    for keyword, table in (("vt", pairs), ("vn", normals)):
        if len(table):
            target.writelines(rows(keyword + " %r" * table.shape[1], list(table.T)))
    if len(mesh.faces):
        target.writelines(_faces(mesh, document, of_wedges, uses, names, notes))
    if len(mesh.edges):
        target.writelines(rows("l %r %r", list(mesh.edges.T + 1)))
    return tuple(notes)


def _texture_coordinates(mesh: MeshData) -> tuple[Floats, Longs | None]:
    """(k, 2) texture coordinates, and (m, 3) their index at each corner, -1 for none."""
    wedges = mesh.face_attributes.get("wedge_texture_coordinates")
    if wedges is None:
        of_vertices = mesh.vertex_attributes.get("texture_coordinates")
        return (np.empty((0, 2)), None) if of_vertices is None else (of_vertices, mesh.faces.astype(np.int64))
    textured = np.ones(len(wedges), np.bool_)
    if (numbers := mesh.face_attributes.get("texture")) is not None:
        textured = (numbers >= 0) | wedges.any(axis=(1, 2))
    pairs = wedges[textured].reshape(-1, 2)
    firsts, indices = numbered(pairs)
    of_corners = np.full((len(wedges), 3), -1, np.int64)
    of_corners[textured] = indices.reshape(-1, 3)
    return pairs[firsts], of_corners


def _materials(mesh: MeshData, document: ObjDocument | None, writing: Writing, notes: list[str]) -> tuple[Longs, list[bytes]]:
    """(m,) the material of each face, -1 for none, and the ``usemtl`` lines; new materials are added to the material file."""
    m = len(mesh.faces)
    colors, numbers = mesh.face_attributes.get("colors"), mesh.face_attributes.get("texture")
    looks = np.full((m, 4), -1, np.int64)  # texture, red, green, blue
    if numbers is not None:
        looks[:, 0] = numbers
    if colors is not None:
        looks[:, 1:] = colors[:, :3]
    index = np.full(m, -1)
    names = document.names if document is not None else ()
    if document is not None and names:
        ids = np.arange(m) if mesh.face_ids is None else mesh.face_ids
        before, read = document.material_of_face[ids], document.mesh
        same = ids >= 0
        for name, value in (("colors", colors), ("texture", numbers)):
            old = read.face_attributes.get(name)
            if value is not None and old is not None:
                same &= (value == old[ids]).reshape(m, -1).all(axis=1)
            else:
                same &= value is old
        index[same] = before[same]
    new = (index < 0) & (looks >= 0).any(axis=1)
    firsts, kinds = numbered(looks[new])
    if len(firsts) + len(names) > MOST_MATERIALS:
        notes.append(f"colours of faces are left out: they need {len(firsts):,} materials; {MOST_MATERIALS:,} are the most")
        looks[:, 1:] = -1
        new = (index < 0) & (looks >= 0).any(axis=1)
        firsts, kinds = numbered(looks[new])
    lines = [b"usemtl %s\n" % name.encode("utf-8", "surrogateescape") for name in names]
    taken, number = set(names), 0
    for row in looks[new][firsts].tolist():
        while (name := f"material_{number}") in taken:
            number += 1
        taken.add(name)
        lines.append(b"usemtl %s\n" % name.encode())
        definition = [f"newmtl {name}"]
        if row[1] >= 0:
            definition.append("Kd " + " ".join(repr(x) for x in _SHARES[row[1:]].tolist()))
        if 0 <= row[0] < len(mesh.textures):
            texture = mesh.textures[row[0]].name
            definition.append(f"map_Kd {writing.textures.get(texture, texture)}")
        writing.materials.append("".join(f"{line}\n" for line in definition).encode("utf-8", "surrogateescape"))
    index[new] = len(names) + kinds
    return index, lines


def _faces(
    mesh: MeshData,
    document: ObjDocument | None,
    of_wedges: Longs | None,
    uses: Longs,
    names: list[bytes],
    notes: list[str],
) -> Iterator[bytes]:
    """The lines of the faces, with a line before each change of material, group or object."""
    shape = outlines(mesh.faces, mesh.face_attributes.get("polygon"))
    notes += shape.notes
    of_normals = mesh.faces if mesh.keeps_normals else None
    corners = [index.ravel()[shape.places] + 1 for index in (mesh.faces, of_wedges, of_normals) if index is not None]
    form = "%d" if len(corners) == 1 else "%d//%d" if of_wedges is None else "/".join(["%d"] * len(corners))
    each = [form % row for row in zip(*(c.tolist() for c in corners), strict=True)]
    if of_wedges is not None and (of_wedges < 0).any():
        for k in np.flatnonzero(corners[1] == 0).tolist():
            each[k] = each[k].replace("/0", "/" if of_normals is not None else "", 1)
    lines = [f"f {' '.join(run)}\n" for run in runs(each, shape.lengths)]
    ids = shape.triangles if mesh.face_ids is None else mesh.face_ids[shape.triangles]
    states = uses[shape.triangles][:, None]  # last the material, before it the groups and objects
    if document is not None:
        states = np.concatenate([np.where(ids[:, None] < 0, -1, document.states[ids]), states], axis=1)
    starts = np.flatnonzero(np.append(True, (states[1:] != states[:-1]).any(axis=1)))
    current = [-1] * states.shape[1]
    for start, end in zip(starts.tolist(), [*starts[1:].tolist(), len(lines)], strict=True):
        state = states[start].tolist()
        for k, (now, was) in enumerate(zip(state, current, strict=True), 1):
            if now >= 0 and now != was:
                yield names[now] if document is None or k == len(state) else document.tokens.line(now) + b"\n"
        current = state
        yield "".join(lines[start:end]).encode("ascii")
