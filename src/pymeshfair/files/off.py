"""Reads and writes OFF files: the colours, normals and texture coordinates of their vertices, the colours of their polygons."""

from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..filters.mesh import Floats, Ints, Longs
from ..mesh_data import MeshData, Source
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import Reading, References, shown, unended
from .outputs import Writing
from .polygons import outlines, triangulated
from .tokens import INTEGER, REAL, Tokens, at_line, joined, numbers_of, refuse, rows, runs, tokenise

#: the prefixes of ``OFF``: texture coordinates, colours and normals
_PREFIXES = ("", "C", "N", "CN", "NC", "ST", "STC", "STN", "STCN", "STNC")


def read_off(path: Path, references: References) -> Reading:
    """Read an OFF file."""
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        raise ContentsError("it is binary; OFF files are read as texts alone")
    tokens = tokenise(joined(data))
    keyword = tokens.line(0).split()[0].decode("latin-1") if len(tokens.numbers) else "nothing"
    prefix = keyword.removesuffix("OFF")
    if prefix == keyword or prefix not in _PREFIXES:
        raise ContentsError(f"it begins with {shown(keyword, 20)}, and not with OFF, COFF, NOFF, STOFF or their like")
    line, n, m = _declared(tokens)
    vertices, attributes = _vertices(tokens, np.arange(line, line + n), prefix)
    faces, edges, face_attributes = _faces(tokens, np.arange(line + n, line + n + m), vertices)
    mesh = MeshData(
        vertices=vertices,
        faces=faces,
        edges=edges,
        vertex_attributes=attributes,
        face_attributes=face_attributes,
        keeps_normals="normals" in attributes and len(faces) > 0,
        source=Source(path, "off", extras=("comments",) if b"#" in data else ()),
    )
    return Reading(mesh, unended(data))


def _declared(tokens: Tokens) -> tuple[int, int, int]:
    """The line of the first vertex, and how many vertices and faces there are."""
    start = 1 if tokens.lengths[0] == 1 else 0
    first, end = int(tokens.first[start]) + (not start), int(tokens.first[min(start + 1, len(tokens.numbers))])
    counts = tokens.values[first:end]
    if len(counts) not in (2, 3) or (tokens.kinds[first:end] != INTEGER).any() or (counts < 0).any():
        raise ContentsError("it does not say how many vertices and faces it has")
    n, m = (int(min(count, 1 << 53)) for count in counts[:2].tolist())
    line, follow = start + 1, len(tokens.numbers) - start - 1
    if follow < n + m:
        raise ContentsError(f"it declares {n:,} vertices and {m:,} faces, but {follow:,} lines follow")
    if follow > n + m:
        raise at_line(tokens, line + n + m, f"is one more than the {n:,} vertices and {m:,} faces that it declares")
    return line, n, m


def _vertices(tokens: Tokens, lines: Longs, prefix: str) -> tuple[Floats, dict[str, Array]]:
    if not len(lines):
        return np.empty((0, 3)), {}
    lengths = tokens.lengths[lines]
    least = 3 + 3 * ("N" in prefix) + 2 * ("ST" in prefix)
    allowed = (least + 3, least + 4) if "C" in prefix else (least,)
    width = int(lengths[0]) if lengths[0] in allowed else allowed[0]
    refuse(tokens, lines, lengths != width, f"has {{}} values and not {width}", lengths)
    values = numbers_of(tokens, lines, 0, width)
    attributes: dict[str, Array] = {}
    normal, color = 3, 3 + 3 * ("N" in prefix)
    if "C" in prefix:
        size = width - least
        if "N" in prefix and _are_colors_first(tokens, lines, size):
            normal, color = 3 + size, 3
        attributes["colors"] = _colors(tokens, lines, np.full(len(lines), color), size)
    if "N" in prefix:
        attributes["normals"] = values[:, normal : normal + 3]
    if "ST" in prefix:
        attributes["texture_coordinates"] = values[:, -2:]
    return values[:, :3], attributes


def _are_colors_first(tokens: Tokens, lines: Longs, size: int) -> bool:
    """Whether colours stand before normals, as MeshLab writes and does not read them."""
    kinds = tokens.kinds[tokens.first[lines][:, None] + np.arange(3, 6 + size)]
    return bool((kinds[:, :size] == INTEGER).all() and (kinds[:, size:] == REAL).any())


def _colors(tokens: Tokens, lines: Longs, skipped: Longs, size: int) -> NDArray[np.uint8]:
    """(l, 4) the colours on lines behind some words: whole numbers up to 255, or others up to 1."""
    places = (tokens.first[lines] + skipped)[:, None] + np.arange(size)
    kinds, values = tokens.kinds[places], tokens.values[places]
    for wrong, why in (
        (~np.isin(kinds, (INTEGER, REAL)), "has a colour that is no number"),
        (kinds != kinds[:, :1], "has a colour of whole numbers and others; write all with a point"),
        ((values < 0) | (values > np.where(kinds == INTEGER, 255, 1)), "has a colour beyond 0 to 255, or 0.0 to 1.0"),
    ):
        refuse(tokens, lines, wrong.any(axis=1), why)
    colors = np.full((len(lines), 4), 255, np.uint8)
    colors[:, :size] = np.rint(np.where(kinds == INTEGER, values, 255 * values))
    return colors


def _faces(tokens: Tokens, lines: Longs, vertices: Floats) -> tuple[Ints, Ints, dict[str, Array]]:
    """The triangles, the edges, which are faces of two vertices, and the attributes of the triangles."""
    lengths, first = tokens.lengths[lines], tokens.first[lines]
    declared = tokens.values[first]
    whole = (tokens.kinds[first] == INTEGER) & (declared >= 2) & (declared <= lengths - 1)
    refuse(tokens, lines, ~whole, "is no face: the number of its vertices and as many indices")
    counts = declared.astype(np.int64)
    sizes = lengths - 1 - counts
    if (wrong := ~np.isin(sizes, (0, 3, 4))).any():
        k = int(np.argmax(wrong))
        what = "a colour by its number in a list, which the file does not have" if sizes[k] == 1 else "more than a colour"
        raise at_line(tokens, int(lines[k]), f"has {what}")
    of_face = np.repeat(np.arange(len(lines)), counts)
    places = np.arange(len(of_face)) + np.repeat(first + 1 - (np.cumsum(counts) - counts), counts)
    corners = tokens.values[places]
    wrong = (tokens.kinds[places] != INTEGER) | (corners < 0) | (corners >= len(vertices))
    if wrong.any():
        raise at_line(tokens, int(lines[of_face[np.argmax(wrong)]]), f"names a vertex that is none of its {len(vertices):,}")
    corners = corners.astype(np.int32)
    colors = np.full((len(lines), 4), 255, np.uint8)
    for size in (3, 4):
        chosen = np.flatnonzero(sizes == size)
        colors[chosen] = _colors(tokens, lines[chosen], 1 + counts[chosen], size)
    of_edge = counts[of_face] == 2
    polygons = counts[counts > 2]
    corners_of_faces = corners[~of_edge]
    triangles, of_polygon, of_polygons = triangulated(vertices, corners_of_faces, polygons)
    attributes: dict[str, Array] = {}
    if sizes[counts > 2].any():
        attributes["colors"] = colors[counts > 2][of_polygon]
    attributes |= of_polygons
    return corners_of_faces[triangles], corners[of_edge].reshape(-1, 2), attributes


def write_off(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write a mesh: normals before colours, as MeshLab reads them, and colours as levels up to 255."""
    attributes = mesh.vertex_attributes
    columns, prefix = list(mesh.vertices.T), ""
    if mesh.keeps_normals or (not len(mesh.faces) and "normals" in attributes):
        columns += list(mesh.vertex_normals.T)
        prefix = "N"
    if (colors := attributes.get("colors")) is not None:
        columns += list(colors.T)
        prefix = f"C{prefix}"
    if (pairs := attributes.get("texture_coordinates")) is not None:
        columns += list(pairs.T)
        prefix = f"ST{prefix}"
    shape = outlines(mesh.faces, mesh.face_attributes.get("polygon"))
    corners = [str(v) for v in mesh.faces.ravel()[shape.places].tolist()]
    count = len(shape.lengths) + len(mesh.edges)
    target.write(f"{prefix}OFF\n{len(mesh.vertices)} {count} 0\n".encode("ascii"))
    target.writelines(rows(" ".join(["%r"] * len(columns)), columns))
    lines = [f"{len(run)} {' '.join(run)}" for run in runs(corners, shape.lengths)]
    if (colors := mesh.face_attributes.get("colors")) is not None:
        lines = [f"{line} %d %d %d %d" % tuple(c) for line, c in zip(lines, colors[shape.triangles].tolist(), strict=True)]
    lines += [f"2 {a} {b}" for a, b in mesh.edges.tolist()]
    target.write("".join(f"{line}\n" for line in lines).encode("ascii"))
    return shape.notes
