"""Writes PLY files: with header, elements, types and comments of the PLY file that a mesh comes from, else in double precision.

What has not changed is written as it was, byte for byte. Rows of deleted elements are left out; in a row of an added element
properties without a value are 0.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..mesh_data import MeshData
from ..mesh_data.mesh_data import FACE_ATTRIBUTES, VERTEX_ATTRIBUTES
from .equal_rows import are_equal
from .ply import (
    ALPHA,
    COLOR,
    CORNERS,
    EDGE,
    NORMAL,
    PLACE,
    RADIUS,
    SCALAR,
    TEXTURE,
    TEXTURE_NUMBER,
    WEDGES,
    PlyDocument,
    colors_of,
    meant,
    texture_names,
)
from .ply_header import KINDS, PlyElement, PlyProperty, header_bytes, parse_header
from .ply_tables import Array, Lists, Table, indices_of_runs, row_type
from .polygons import outlines
from .saving import Writing
from .texts import patched, runs, words

_EMPTY = b"ply\nformat binary_little_endian 1.0\nend_header\n"
#: a share of the mean edge by which rounding to the type of the file may move a vertex
_ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of an element as they are to be written."""

    element: PlyElement  # for the header
    columns: Mapping[str, Array | Lists]  # by property
    source: Table | None = None  # the table that they come from, if only the `changed` properties differ from it
    changed: frozenset[str] = frozenset()  # the properties that differ


def write_ply(mesh: MeshData, target: BinaryIO, writing: Writing | None = None) -> tuple[str, ...]:
    """Write a mesh without a matrix; the differences from the file that it comes from, in words.

    Without `writing` coordinates have the type that they have in that file.
    """
    resolution, textures = (None, None) if writing is None else (writing.resolution, writing.textures)
    document = mesh.source.document if mesh.source is not None else None
    if not isinstance(document, PlyDocument):
        document = _plain_document(mesh)
    notes: list[str] = []
    rows = [_vertex_rows(mesh, document, resolution, notes)]
    rows += _face_rows(mesh, document, notes)
    rows += _edge_rows(mesh, document)
    written = {row.element.name: row for row in rows}
    elements: list[PlyElement] = []
    for element in document.header.elements:
        if element.name in ("vertex", "face", "edge"):
            if element.name in written:
                elements.append(written[element.name].element)
        elif element.name in ("tristrips", "range_grid") and document.has_other_faces:
            if "face" not in written or written["face"].element.count == 0:
                elements.append(element)
        elif mesh.vertex_ids is None or not any(p.name.startswith("vert") for p in element.properties):
            elements.append(element)
        else:
            notes.append(f"element {element.name!r} ({element.count:,}), which names vertices by their numbers, is left out")
    named = {e.name for e in document.header.elements}
    elements += [row.element for row in rows if row.element.name not in named]
    target.write(header_bytes(document.header, elements, textures))
    as_it_was = False
    for element in elements:
        row = written.get(element.name, _Rows(element, {}, document.tables.get(element.name)))
        if document.header.format == "ascii":
            as_it_was = _write_text(target, row, document)
        else:
            _write_binary(target, row, document)
    if as_it_was or document.header.format != "ascii":
        target.write(document.tail)
    return tuple(notes)


def _plain_document(mesh: MeshData) -> PlyDocument:
    """A file without elements, to be extended."""
    comments = b"".join(b"comment TextureFile %s\n" % t.name.encode("utf-8", "surrogateescape") for t in mesh.textures)
    header = parse_header(_EMPTY.replace(b"end_header", comments + b"end_header"))
    return PlyDocument(header, {}, np.empty(0, np.uint8))


# ----------------------------------------------------------------------------------------------------------------- vertices


def _vertex_rows(mesh: MeshData, document: PlyDocument, resolution: Callable[[], float] | None, notes: list[str]) -> _Rows:
    attributes = mesh.vertex_attributes
    table = document.tables.get("vertex")
    values: dict[str, Array] = dict(zip(PLACE, mesh.vertices.T, strict=True))
    if mesh.keeps_normals or (not len(mesh.faces) and "normals" in attributes):
        values |= zip(NORMAL, mesh.vertex_normals.T, strict=True)
    if (scalars := attributes.get("scalars")) is not None:
        values[SCALAR] = scalars
    if (radii := attributes.get("radii")) is not None:
        values[RADIUS] = radii
    if (places := attributes.get("texture_coordinates")) is not None:
        values |= zip((table and texture_names(table)) or TEXTURE[0], places.T, strict=True)
    rows = _rows(mesh, "vertex", table, mesh.vertex_ids, values)
    if table is None or (rows.source is None and mesh.vertex_ids is None):
        return rows
    narrow = [p for p in table.element.properties if p.name in PLACE and p.type != "double"]
    moves = [np.abs(mesh.vertices[:, PLACE.index(p.name)] - rows.columns[p.name]).max(initial=0.0) for p in narrow]
    apart = max([0.0, *moves])  # by the types of the file
    if apart > 0.0 and resolution is not None and apart > _ROUNDING * resolution():
        notes.append(f"coordinates are written as double, as {narrow[0].type} would round them")
        properties = tuple(replace(p, type="double") if p.name in PLACE else p for p in rows.element.properties)
        columns = {**rows.columns, **dict(zip(PLACE, mesh.vertices.T, strict=True))}
        rows = _Rows(replace(rows.element, properties=properties), columns)
    return rows


def _rows(
    mesh: MeshData,
    element: str,
    table: Table | None,
    ids: NDArray[np.int64] | None,
    values: Mapping[str, Array],
) -> _Rows:
    """The rows of vertices or faces: those of the file by their ids, with these values and the custom attributes of the mesh."""
    attributes = mesh.vertex_attributes if element == "vertex" else mesh.face_attributes
    values = {**values, **_custom(attributes, VERTEX_ATTRIBUTES if element == "vertex" else FACE_ATTRIBUTES)}
    n = len(mesh.vertices if element == "vertex" else mesh.faces) if ids is None else len(ids)
    columns: dict[str, Array | Lists] = {}
    properties: list[PlyProperty] = []
    changed: set[str] = set()
    meanings = set() if table is None else meant(table)
    before: Mapping[str, Array | Lists] = {} if table is None else table.columns
    for p in () if table is None else table.element.properties:
        if p.name in meanings and p.name not in values and p.name not in (*COLOR, ALPHA, *CORNERS, WEDGES, TEXTURE_NUMBER):
            continue  # a step has removed it
        if p.name in (*COLOR, ALPHA) and p.name in meanings and "colors" not in attributes:
            continue
        base = _chosen(before[p.name], ids)
        if not isinstance(base, Lists) and p.name in values:
            cast = _cast(values[p.name], p.type)
            if not np.array_equal(base, cast, equal_nan=cast.dtype.kind == "f"):
                base = cast
                changed.add(p.name)
        columns[p.name] = base
        properties.append(p)
    for name, value in values.items():
        if name not in columns:
            columns[name] = value
            small = "uchar" if value.dtype.itemsize == 1 else "uint"
            own = {"b": "uchar", "i": "int", "u": small}.get(value.dtype.kind, "double")
            properties.append(PlyProperty(name, own))
    colors = attributes.get("colors")
    if colors is not None:
        changed |= _put_colors(colors, table, ids, columns, properties)
    new = PlyElement(element, n, tuple(properties))
    same = table is not None and ids is None and new == table.element
    return _Rows(new, columns, table if same else None, frozenset(changed))


def _chosen(column: Array | Lists, ids: NDArray[np.int64] | None) -> Array | Lists:
    """The rows of a column by their ids; 0, or an empty list, for -1."""
    if ids is None:
        return column
    if isinstance(column, Lists):
        return column.chosen(ids)
    if not len(column):
        return np.zeros(len(ids), column.dtype)
    values = column[ids]
    values[ids < 0] = 0
    return values


def _cast(values: Array, type_: str) -> Array:
    kind = np.dtype(KINDS[type_])
    if kind.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.rint(values), limits.min, limits.max).astype(kind)


def _custom(attributes: Mapping[str, Array], known: frozenset[str]) -> dict[str, Array]:
    """The custom attributes by the name of a property; a vector as three numbers."""
    columns: dict[str, Array] = {}
    for name, values in attributes.items():
        if name in known:
            continue
        if values.ndim == 1:
            columns[name] = values
        else:
            columns |= {f"{name}_{axis}": values[:, k] for k, axis in enumerate("xyzw"[: values.shape[1]])}
    return columns


def _put_colors(
    colors: NDArray[np.uint8],
    table: Table | None,
    ids: NDArray[np.int64] | None,
    columns: dict[str, Array | Lists],
    properties: list[PlyProperty],
) -> set[str]:
    """Add colours to the columns, unless they are those of the file already; the properties that have changed."""
    before = None if table is None else colors_of(table)
    if before is not None and np.array_equal(_chosen(before, ids), colors):
        return set()
    changed = set()
    channels = (*COLOR, ALPHA) if table is None or ALPHA in columns or (colors[:, 3] != 255).any() else COLOR
    for k, name in enumerate(channels):
        column = columns.get(name)
        if column is None or isinstance(column, Lists):
            columns[name] = colors[:, k]
            properties.append(PlyProperty(name, "uchar"))
            continue
        kind = column.dtype
        if kind.kind == "f":
            top = 1.0 if not len(column) or np.nanmax(column) <= 1.0 else 255.0
        else:
            top = 255 if kind.itemsize == 1 or column.max(initial=0) <= 255 else np.iinfo(kind).max
        scaled = colors[:, k] / 255.0 * top
        columns[name] = (scaled if kind.kind == "f" else np.rint(scaled)).astype(kind)
        changed.add(name)
    return changed


# -------------------------------------------------------------------------------------------------------------------- faces


def _face_rows(mesh: MeshData, document: PlyDocument, notes: list[str]) -> list[_Rows]:
    table = document.tables.get("face")
    corners = next((name for name in CORNERS if table is not None and table.lists(name) is not None), CORNERS[0])
    unchanged = mesh.face_ids is None and mesh.vertex_ids is None
    if document.has_other_faces:
        own = {name for name in mesh.face_attributes if name not in ("selection", "normals")}
        if unchanged and not own:
            return [] if table is None else [_Rows(table.element, table.columns, table)]
        table = None
    if not len(mesh.faces):
        if table is None:
            return []
        as_it_was = not table.element.count or table.lists(corners) is None  # rows that name no vertices
        return [_Rows(table.element, table.columns, table) if as_it_was else _without_rows(table)]
    wedges = mesh.face_attributes.get("wedge_texture_coordinates")
    values: dict[str, Array] = {}
    if (scalars := mesh.face_attributes.get("scalars")) is not None:
        values[SCALAR] = scalars
    if (numbers := mesh.face_attributes.get("texture")) is not None and len(mesh.textures) > 1:
        values[TEXTURE_NUMBER] = numbers
    if table is None:
        corner_vertices = mesh.faces.reshape(-1)
        polygon = mesh.face_attributes.get("polygon")
        if polygon is not None and wedges is not None and (polygon >= 0).any():
            notes.append("polygons are written as triangles: MeshLab opens none with texture coordinates at the corners of faces")
            polygon = None
        shape = outlines(mesh.faces, polygon)
        notes += shape.notes
        first = shape.triangles
        rows = _rows(_with_faces(mesh, first), "face", None, None, {name: value[first] for name, value in values.items()})
        lists: dict[str, Lists] = {CORNERS[0]: Lists(corner_vertices[shape.places], shape.lengths)}
        if wedges is not None:
            lists[WEDGES] = Lists(wedges.reshape(-1, 2)[shape.places].reshape(-1), 2 * shape.lengths)
        properties = (
            PlyProperty(CORNERS[0], "int", "uchar"),
            *([PlyProperty(WEDGES, "float", "uchar")] if wedges is not None else []),
        )
        element = replace(rows.element, properties=(*properties, *rows.element.properties))
        return [_Rows(element, {**lists, **rows.columns})]
    if unchanged and are_equal(wedges, document.wedges):
        return [_rows_of_same_faces(mesh, table, document, values)]
    return [_rows_of_known_faces(mesh, table, document, corners, values, wedges, notes)]


def _with_faces(mesh: MeshData, numbers: NDArray[np.int64]) -> MeshData:
    attributes = {name: values[numbers] for name, values in mesh.face_attributes.items()}
    return replace(mesh, faces=mesh.faces[numbers], face_attributes=attributes)


def _without_rows(table: Table) -> _Rows:
    none = np.empty(0, np.int64)
    return _Rows(replace(table.element, count=0), {name: _chosen(column, none) for name, column in table.columns.items()})


def _rows_of_same_faces(mesh: MeshData, table: Table, document: PlyDocument, values: dict[str, Array]) -> _Rows:
    """The rows of a file's faces if no corner has changed; a polygon takes single numbers from its first triangle."""
    if document.row_of_face is not None:
        first = np.flatnonzero(np.diff(document.row_of_face, prepend=-1))
        values = {name: value[first] for name, value in values.items()}
        mesh = _with_faces(mesh, first)
    return _rows(mesh, "face", table, None, values)


def _rows_of_known_faces(
    mesh: MeshData,
    table: Table,
    document: PlyDocument,
    corners: str,
    values: dict[str, Array],
    wedges: Array | None,
    notes: list[str],
) -> _Rows:
    """The rows of a file's faces that are left, polygons whole where all their triangles are, then those of added ones."""
    lists = table.lists(corners)
    assert lists is not None
    ids = np.arange(len(mesh.faces)) if mesh.face_ids is None else mesh.face_ids
    row_of_face = np.arange(table.element.count) if document.row_of_face is None else document.row_of_face
    row = np.where(ids < 0, -1, row_of_face[ids])
    whole = np.bincount(row[row >= 0], minlength=table.element.count) == lists.lengths - 2
    own_wedges = table.lists(WEDGES)
    same_wedges = own_wedges is None and wedges is None
    if own_wedges is not None and wedges is not None and document.wedges is not None:
        same_wedges = are_equal(document.wedges[ids[ids >= 0]], wedges[ids >= 0])
    if not same_wedges:
        whole &= lists.lengths == 3
    inside = (row >= 0) & whole[np.maximum(row, 0)]
    first = np.ones(len(row), np.bool_)  # one row a polygon, in the place of its first triangle
    order = np.flatnonzero(inside)
    _, firsts = np.unique(row[order], return_index=True)
    first[order] = False
    first[order[firsts]] = True
    if (broken := np.unique(row[(row >= 0) & ~inside & (lists.lengths[np.maximum(row, 0)] > 3)])).size:
        notes.append(f"{len(broken):,} polygons that lost a part of theirs are written as triangles")
    kept = np.flatnonzero(first)
    row, inside = row[kept], inside[kept]
    shown = {name: value[kept] for name, value in values.items()}
    rows = _rows(_with_faces(mesh, kept), "face", table, row, shown)
    columns = dict(rows.columns)
    columns[corners] = _corners(mesh, lists, row, inside, kept)
    properties = list(rows.element.properties)
    if wedges is None:
        columns.pop(WEDGES, None)
        properties = [p for p in properties if p.name != WEDGES or not p.count_type]
    elif not same_wedges or own_wedges is None or (~inside).any():
        columns[WEDGES] = _mixed(columns.get(WEDGES), wedges[kept], inside if same_wedges else np.zeros(len(kept), np.bool_))
        if own_wedges is None:
            properties.append(PlyProperty(WEDGES, "float", "uchar"))
    properties = [_wide_enough(p, columns[p.name]) for p in properties]
    return _Rows(PlyElement("face", len(kept), tuple(properties)), columns)


def _corners(mesh: MeshData, lists: Lists, row: NDArray[np.int64], inside: NDArray[np.bool_], kept: NDArray[np.int64]) -> Lists:
    """The corners of polygons by the new numbers of the vertices; those of triangles as the mesh has them."""
    mixed = _mixed(lists.chosen(row), mesh.faces[kept], inside)
    if mesh.vertex_ids is None:
        return mixed
    assert mesh.source is not None
    number = np.full(mesh.source.vertices, -1, np.int64)
    old = np.flatnonzero(mesh.vertex_ids >= 0)
    number[mesh.vertex_ids[old]] = old
    of_old = np.repeat(inside, mixed.lengths)
    values = mixed.values.astype(np.int64)
    values[of_old] = number[values[of_old]]
    return Lists(values, mixed.lengths)


def _mixed(before: Array | Lists | None, triangles: Array, inside: NDArray[np.bool_]) -> Lists:
    """The lists of some rows, and of the others what their triangles have."""
    width = int(np.prod(triangles.shape[1:]))
    flat = triangles.reshape(len(triangles), width)
    if not isinstance(before, Lists) or not inside.any():
        return Lists(flat.reshape(-1), np.full(len(flat), width, np.int64))
    lengths = np.where(inside, before.lengths, width)
    values = np.empty(int(lengths.sum()), np.result_type(before.values, flat))
    starts = np.cumsum(lengths) - lengths
    old = indices_of_runs(starts[inside], lengths[inside])
    values[old] = before.chosen(np.flatnonzero(inside)).values
    values[indices_of_runs(starts[~inside], lengths[~inside])] = flat[~inside].reshape(-1)
    return Lists(values, lengths)


def _wide_enough(p: PlyProperty, column: Array | Lists) -> PlyProperty:
    """The property with types that hold its numbers: those of corners may have become too many for a small type."""
    if not isinstance(column, Lists) or KINDS[p.type][0] == "f":
        return p
    if len(column.values) and column.values.max() > np.iinfo(KINDS[p.type]).max:
        p = replace(p, type="int")
    if p.count_type and KINDS[p.count_type][0] != "f" and column.lengths.max(initial=0) > np.iinfo(KINDS[p.count_type]).max:
        p = replace(p, count_type="int")
    return p


# -------------------------------------------------------------------------------------------------------------------- edges


def _edge_rows(mesh: MeshData, document: PlyDocument) -> list[_Rows]:
    table = document.tables.get("edge")
    if table is not None and mesh.edge_ids is None and mesh.vertex_ids is None:
        return [_Rows(table.element, table.columns, table)]
    if not len(mesh.edges):
        return [] if table is None else [_without_rows(table)]
    ends = dict(zip(EDGE, mesh.edges.T, strict=True))
    if table is None:
        return [_Rows(PlyElement("edge", len(mesh.edges), tuple(PlyProperty(name, "int") for name in EDGE)), ends)]
    ids = np.arange(len(mesh.edges)) if mesh.edge_ids is None else mesh.edge_ids
    columns = {name: ends[name] if name in ends else _chosen(column, ids) for name, column in table.columns.items()}
    return [_Rows(replace(table.element, count=len(mesh.edges)), columns)]


# ------------------------------------------------------------------------------------------------------------------- output


def _write_binary(target: BinaryIO, row: _Rows, document: PlyDocument) -> None:
    """Write the rows of an element of a binary file."""
    if row.source is not None and not row.changed:
        start, end = row.source.bytes
        target.write(document.data[start:end].data)
        return
    order = document.header.byte_order
    element = row.element
    widths: dict[str, int] = {}
    for p in element.properties:
        column = row.columns[p.name]
        if isinstance(column, Lists):
            width = column.width
            if width is None and element.count:
                target.write(_packed(row, order))
                return
            widths[p.name] = width or 0
    rows = np.zeros(element.count, row_type(element, order, widths))
    for p in element.properties:
        column = row.columns[p.name]
        if isinstance(column, Lists):
            rows[f"{p.name} count"] = column.lengths
            with np.errstate(over="ignore"):
                rows[p.name] = column.values.reshape(element.count, widths[p.name])
        else:
            rows[p.name] = column
    target.write(rows.tobytes())


def _packed(row: _Rows, order: str) -> bytes:
    """The rows of an element whose lists differ in length."""
    n = row.element.count
    fields: list[tuple[NDArray[np.uint8], NDArray[np.int64]]] = []  # the bytes of a field of all rows, and how many each row has
    for p in row.element.properties:
        column, kind = row.columns[p.name], np.dtype(order + KINDS[p.type])
        if isinstance(column, Lists):
            counts = column.lengths.astype(np.dtype(order + KINDS[p.count_type or "int"]))
            fields.append((counts.view(np.uint8), np.full(n, counts.dtype.itemsize)))
            fields.append((np.ascontiguousarray(column.values.astype(kind)).view(np.uint8), column.lengths * kind.itemsize))
        else:
            fields.append((np.ascontiguousarray(column.astype(kind)).view(np.uint8), np.full(n, kind.itemsize)))
    sizes = np.sum([lengths for _, lengths in fields], axis=0)
    starts = np.cumsum(sizes) - sizes
    buffer = np.empty(int(sizes.sum()), np.uint8)
    for data, lengths in fields:
        buffer[indices_of_runs(starts, lengths)] = data
        starts = starts + lengths
    return buffer.tobytes()


def _write_text(target: BinaryIO, row: _Rows, document: PlyDocument) -> bool:
    """Write the rows of an element of a text; whether they are as they were, but for changed words."""
    if row.source is not None and document.tokens is not None and row.source.lines is not None:
        names = [p.name for p in row.element.properties]
        lists = [k for k, p in enumerate(row.element.properties) if p.count_type]
        changed = sorted(names.index(name) for name in row.changed)
        if not changed or not lists or changed[-1] < lists[0]:
            target.write(_patched(row, document, changed))
            return True
    target.writelines(_lines(row))
    return False


def _patched(row: _Rows, document: PlyDocument, changed: list[int]) -> bytes:
    """The text of an element with other words where numbers have changed."""
    tokens, table = document.tokens, row.source
    assert tokens is not None
    assert table is not None
    assert table.lines is not None
    if not len(table.lines):
        return b""
    begin = int(tokens.starts[table.lines[0]])
    last = int(table.lines[-1])
    end = int(tokens.starts[last + 1]) if last + 1 < len(tokens.starts) else len(tokens.text)
    text = tokens.text[begin:end].tobytes()
    if not changed:
        return text
    spans = tokens.spans(table.lines, changed).reshape(-1, 2) - begin
    properties = [row.element.properties[k] for k in changed]
    columns = [_words(np.asarray(row.columns[p.name]), p.type) for p in properties]
    differs = np.stack([np.asarray(row.columns[p.name]) != np.asarray(table.columns[p.name]) for p in properties], axis=1)
    other = differs.reshape(-1)
    each = [word for line in zip(*columns, strict=True) for word in line]
    return patched(text, spans[other], [each[k] for k in np.flatnonzero(other).tolist()])


def _words(values: Array, type_: str) -> list[bytes]:
    """Numbers as words that are read as the same numbers."""
    return words(values.astype(KINDS[type_]))


def _lines(row: _Rows) -> Iterator[bytes]:
    columns: list[list[bytes]] = []
    for p in row.element.properties:
        column = row.columns[p.name]
        if not isinstance(column, Lists):
            columns.append(_words(column, p.type))
            continue
        each = runs(_words(column.values, p.type), column.lengths)
        columns.append([b" ".join((b"%d" % len(run), *run)) for run in each])
    for line in zip(*columns, strict=True):
        yield b" ".join(line) + b"\n"
