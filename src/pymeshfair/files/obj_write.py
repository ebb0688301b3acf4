"""Writes OBJ files: the original text with new numbers if the elements are unchanged, else a new text."""

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from ..filters.geometry import unit_vectors, vertex_normals_by_angle
from ..filters.mesh import Floats, Longs
from ..mesh_data import MeshData
from .obj import MOST_MATERIALS, ObjDocument, lines_of
from .outputs import Writing
from .polygons import are_equal, numbered, outlines
from .tokens import changed_words, patched, rows, runs, words

#: for each colour level a share of six digits: 255 times it gives the level, whether rounded or truncated
_SHARES = np.ceil(np.arange(256) / 255 * 1e6) / 1e6
#: the face attributes that an OBJ file holds
_OF_FACES = ("wedge_texture_coordinates", "texture", "colors")


def write_obj(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write a mesh; see the module."""
    document = mesh.document(ObjDocument)
    normals, of_corners = _normals(mesh, document)
    if document is not None and document.materials.lines:
        writing.materials.append(document.materials.text(writing.textures))
    if document is not None and (text := _patched_text(mesh, document, normals, of_corners, writing)) is not None:
        target.write(text)
        return ()
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
        target.writelines(_faces(mesh, document, of_wedges, of_corners, uses, names, notes))
    if len(mesh.edges):
        target.writelines(rows("l %r %r", list(mesh.edges.T + 1)))
    return tuple(notes)


def _normals(mesh: MeshData, document: ObjDocument | None) -> tuple[Floats, Longs | None]:
    """(k, 3) the normals to write, and (m, 3) the index of the normal at each corner; None for a cloud or a mesh without normals.

    If vertices have moved, corners that shared a normal at a vertex get the angle-weighted mean of the normals of their faces, so
    that sharp edges stay sharp.
    """
    own = mesh.vertex_attributes.get("normals")
    if not len(mesh.faces):
        return (np.empty((0, 3)) if own is None else own), None
    if document is None or document.corner_normals is None or document.mesh.keeps_normals != mesh.keeps_normals:
        return (mesh.vertex_normals, mesh.faces.astype(np.int64)) if mesh.keeps_normals else (np.empty((0, 3)), None)
    read = document.mesh
    rows = slice(None) if mesh.vertex_ids is None else mesh.vertex_ids
    still = np.array_equal(mesh.vertices, read.vertices[rows]) and (mesh.vertex_ids is None or (mesh.vertex_ids >= 0).all())
    before = read.vertex_attributes.get("normals")
    if own is not None and mesh.keeps_normals:  # those in a file may have any length
        same = before is not None and np.allclose(unit_vectors(own), unit_vectors(before[rows]), 0.0, 1e-7, equal_nan=True)
        if not same:
            return own, mesh.faces.astype(np.int64)
    named = document.corner_normals if mesh.face_ids is None else document.corner_normals[mesh.face_ids]
    if mesh.face_ids is not None:
        named[mesh.face_ids < 0] = -1
    if still and (named >= 0).all():
        return document.normals, named
    firsts, groups = numbered(np.stack([mesh.faces.ravel(), named.ravel()], axis=1))
    points = mesh.vertices[mesh.faces.ravel()[firsts]]
    groups = groups.reshape(-1, 3)
    return vertex_normals_by_angle(points, groups.astype(np.int32)), groups


def _patched_text(
    mesh: MeshData, document: ObjDocument, normals: Floats, of_corners: Longs | None, writing: Writing
) -> bytes | None:
    """The original text with new numbers and the material file of the output; None if elements or attributes differ."""
    read = document.mesh
    colors, before = mesh.vertex_attributes.get("colors"), read.vertex_attributes.get("colors")
    painted = not are_equal(colors, before)
    if (
        not (mesh.vertex_ids is None and mesh.face_ids is None and mesh.edge_ids is None)
        or not (are_equal(mesh.faces, read.faces) and are_equal(mesh.edges, read.edges))
        or not all(are_equal(mesh.face_attributes.get(name), read.face_attributes.get(name)) for name in _OF_FACES)
        or mesh.keeps_normals != read.keeps_normals
        or (painted and (colors is None or document.width != (3 if before is None else 6)))
        or (line_normals := _line_normals(document, normals, of_corners)) is None
    ):
        return None
    tokens, vertices = document.tokens, lines_of(document.tokens, b"v")
    new, differs = list(mesh.vertices.T), [a != b for a, b in zip(mesh.vertices.T, read.vertices.T, strict=True)]
    cuts = []
    if painted and colors is not None:
        shares = [_SHARES[level] for level in colors.T[:3]]
        if before is not None:
            cuts.append(changed_words(tokens, vertices, [4, 5, 6], shares, [(colors != before).any(axis=1)] * 3))
        else:
            ends = np.repeat(tokens.spans(vertices, [3])[:, 0, 1:], 2, axis=1)  # behind the coordinates
            cuts.append((ends, [b" " + b" ".join(row) for row in zip(*map(words, shares), strict=True)]))
            differs[2] = np.ones(len(vertices), np.bool_)
    cuts.insert(0, changed_words(tokens, vertices, [1, 2, 3], new, differs))
    if line_normals is not document.normals:
        changes = [a != b for a, b in zip(line_normals.T, document.normals.T, strict=True)]
        cuts.append(changed_words(tokens, lines_of(tokens, b"vn"), [1, 2, 3], list(line_normals.T), changes))
    if document.materials.lines:
        libraries = [(int(tokens.starts[k]), len(tokens.line(k))) for k in lines_of(tokens, b"mtllib").tolist()]
        named = b"mtllib " + writing.material_file.encode("utf-8", "surrogateescape")
        places = [(start, start + length) for start, length in libraries] or [(0, 0)]
        cuts.append((np.array(places, np.int64), [named if libraries else named + b"\n", *([b""] * (len(places) - 1))]))
    spans, texts = np.concatenate([where for where, _ in cuts]), [text for _, each in cuts for text in each]
    order = np.argsort(spans[:, 0], kind="stable")
    return patched(document.data, spans[order], [texts[k] for k in order.tolist()])


def _line_normals(document: ObjDocument, normals: Floats, of_corners: Longs | None) -> Floats | None:
    """The normals of the ``vn`` lines; None if a line would need several normals."""
    if of_corners is None or document.corner_normals is None:  # of a cloud
        return normals if len(normals) == len(document.normals) else document.normals
    if normals is document.normals:
        return normals
    pairs = np.stack([document.corner_normals.ravel(), of_corners.ravel()], axis=1)
    firsts, _ = numbered(pairs)
    line, normal = pairs[firsts].T
    line_normals = document.normals.copy()
    line_normals[line] = normals[normal]
    fits = np.allclose(line_normals[line], normals[normal], rtol=0.0, atol=1e-9, equal_nan=True)
    return line_normals if fits and line.min() >= 0 else None


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
    of_normals: Longs | None,
    uses: Longs,
    names: list[bytes],
    notes: list[str],
) -> Iterator[bytes]:
    """The lines of the faces, with a line before each change of material, group or object."""
    shape = outlines(mesh.faces, mesh.face_attributes.get("polygon"))
    notes += shape.notes
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
