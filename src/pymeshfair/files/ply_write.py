"""Writes PLY files: with the header, elements, types and comments of the source if it is a PLY file.

For other sources real numbers are written as double, but texture coordinates of corners as float.

Unchanged contents are written byte for byte. Rows of deleted elements are left out. If a polygon loses triangles, its other
triangles form a polygon if possible, perhaps with another first corner. In new rows, properties without a value are 0.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..filters.mesh import Longs
from ..mesh_data import MeshData
from ..mesh_data.mesh_data import FACE_ATTRIBUTES, VERTEX_ATTRIBUTES, Array, source_ids
from . import ply, ply_tables
from .outputs import Writing
from .ply import PlyDocument
from .ply_tables import KINDS, Column, Lists, PlyElement, PlyProperty, Table
from .polygons import are_equal, outlines
from .tokens import changed_words, patched, runs, words

_HEAD = b"ply\nformat binary_little_endian 1.0\nend_header\n"
#: coordinates keep the types of the source file if rounding to these types moves them by at most this share of the mean edge
_ROUNDING = 1e-3


def write_ply(mesh: MeshData, target: BinaryIO, writing: Writing | None = None) -> tuple[str, ...]:
    """Writes a mesh, whose `matrix` must be None. If `writing` is None, coordinates keep the type of the source file."""
    if (document := mesh.document(PlyDocument)) is None:
        document = PlyDocument(ply_tables.parse_header(_HEAD), {}, np.empty(0, np.uint8))
    notes: list[str] = []
    tables = (_vertex_rows(mesh, document, writing, notes), _face_rows(mesh, document, notes), _edge_rows(mesh, document))
    written = {table.element.name: table for table in tables if table is not None}
    elements: dict[str, PlyElement] = {}
    renumbered = [what for what, ids in (("vertices", mesh.vertex_ids), ("faces", mesh.face_ids)) if ids is not None]
    for element in document.header.elements:
        name = element.name
        stale = [what for what in renumbered if any(p.name.startswith(what[:4]) for p in element.properties)]
        if name in written or name in ("face", "edge"):
            elements |= {name: written[name].element} if name in written else {}
        elif name in ("tristrips", "range_grid") and document.has_other_faces:
            elements |= {} if not len(mesh.faces) or ("face" in written and written["face"].element.count) else {name: element}
        elif not stale:
            elements[name] = element
        else:
            notes.append(f"element {name!r} ({element.count:,}), which names {' and '.join(stale)} by their numbers, is left out")
    elements |= {name: table.element for name, table in written.items()}
    textures = [t.name if writing is None else writing.textures.get(t.name, t.name) for t in mesh.textures]
    target.write(ply_tables.header_bytes(document.header, list(elements.values()), textures))
    is_text, kept_bytes, last = document.header.format == "ascii", None, b"\n"
    for name in elements:
        table = written.get(name) or document.tables[name]
        if (kept_bytes := _file_bytes(table, document)) is not None:
            target.write(kept_bytes)
            last = bytes(kept_bytes[-1:]) or last
        elif is_text:
            target.write(b"" if last.isspace() else b"\n")  # the source file may end without a line end
            target.writelines(_lines(table))
            last = b"\n"
        else:
            _write_binary(target, table, document.header.byte_order)
    if kept_bytes is not None or not is_text:
        end = max((table.bytes[1] for table in document.tables.values() if table.bytes), default=0)
        target.write(document.data[end:].data)  # the tail: line ends, and padding by some programs
    return tuple(notes)


def _vertex_rows(mesh: MeshData, document: PlyDocument, writing: Writing | None, notes: list[str]) -> Table:
    attributes = mesh.vertex_attributes
    table = document.tables.get("vertex")
    values: dict[str, Column] = dict(zip(ply.PLACE, mesh.vertices.T, strict=True))
    if mesh.writes_normals:
        values |= zip(ply.NORMAL, mesh.vertex_normals.T, strict=True)
    values |= {name: attributes[key] for name, key in ((ply.SCALAR, "scalars"), (ply.RADIUS, "radii")) if key in attributes}
    if (places := attributes.get("texture_coordinates")) is not None:
        values |= zip((table and ply.texture_names(table)) or ply.TEXTURE[0], places.T, strict=True)
    values |= _custom(attributes, VERTEX_ATTRIBUTES, values, table, notes)
    rows = _rows("vertex", table, mesh.vertex_ids, values, attributes.get("colors"))
    if table is None:
        return rows
    narrow = [p for p in table.element.properties if p.name in ply.PLACE and p.type != "double"]
    moves = [np.abs(mesh.vertices[:, ply.PLACE.index(p.name)] - rows.columns[p.name]).max(initial=0.0) for p in narrow]
    rounding = max([0.0, *moves])  # the largest rounding error in the types of the file
    if rounding > 0.0 and writing is not None and rounding > _ROUNDING * writing.resolution():
        notes.append(f"coordinates are written as double, as {narrow[0].type} would round them")
        properties = tuple(replace(p, type="double") if p.name in ply.PLACE else p for p in rows.element.properties)
        columns = {**rows.columns, **dict(zip(ply.PLACE, mesh.vertices.T, strict=True))}
        rows = Table(replace(rows.element, properties=properties), columns)
    return rows


def _face_rows(mesh: MeshData, document: PlyDocument, notes: list[str]) -> Table | None:
    table = document.tables.get("face")
    corners = next((name for name in ply.CORNERS if table is not None and table.lists(name) is not None), ply.CORNERS[0])
    unchanged = mesh.face_ids is None and mesh.vertex_ids is None and are_equal(mesh.faces, document.faces)
    if document.has_other_faces:
        if unchanged and not mesh.face_attributes.keys() - {"selection", "normals"}:
            return table
        table = None
    if not len(mesh.faces):
        names_no_vertices = table is None or not table.element.count or table.lists(corners) is None
        return table if names_no_vertices else _without_rows(table)
    wedges = mesh.face_attributes.get("wedge_texture_coordinates")
    values: dict[str, Column] = {}
    row: Longs | None = None
    polygon = mesh.face_attributes.get("polygon")
    unlike_rows = FACE_ATTRIBUTES - {"colors", "scalars", "texture"}
    of_triangles = [values for name, values in mesh.face_attributes.items() if name not in unlike_rows]
    # A polygon takes its attributes from its first triangle.
    chosen = None if document.row_of_face is None else np.flatnonzero(np.diff(document.row_of_face, prepend=-1))
    if (table is not None and unchanged and are_equal(wedges, document.wedges) and are_equal(polygon, document.polygon)) and (
        chosen is None or all(are_equal(v[chosen][document.row_of_face], v) for v in of_triangles)
    ):
        values |= {name: table.columns[name] for name in (corners, ply.WEDGES) if name in table.columns}
    else:
        ids = source_ids(mesh.face_ids, len(mesh.faces))
        if polygon is not None and wedges is not None and (polygon >= 0).any():
            polygon, what = None, "MeshLab opens no polygons with texture coordinates at their corners"
            notes.append(f"polygons are written as triangles: {what}")
        shape = outlines(mesh.faces, polygon, of_triangles)
        notes += shape.notes
        chosen = shape.triangles
        if table is not None:
            row = ids[chosen]
            if document.row_of_face is not None:
                row = np.where(row < 0, -1, document.row_of_face[row])
        values[corners] = Lists(mesh.faces.ravel()[shape.places], shape.lengths)
        if wedges is not None:
            values[ply.WEDGES] = Lists(wedges.reshape(-1, 2)[shape.places].ravel(), 2 * shape.lengths)
    of_rows = {name: v if chosen is None else v[chosen] for name, v in mesh.face_attributes.items()}
    if "scalars" in of_rows:
        values[ply.SCALAR] = of_rows["scalars"]
    is_numbered = table is not None and ply.TEXTURE_NUMBER in table.columns
    if "texture" in of_rows and (is_numbered or len(mesh.textures) > 1 or (of_rows["texture"] < 0).any()):
        values[ply.TEXTURE_NUMBER] = of_rows["texture"]
    values |= _custom(of_rows, FACE_ATTRIBUTES, values, table, notes)
    return _rows("face", table, row, values, of_rows.get("colors"))


def _edge_rows(mesh: MeshData, document: PlyDocument) -> Table | None:
    table = document.tables.get("edge")
    if table is not None and mesh.edge_ids is None and mesh.vertex_ids is None:
        return table
    if not len(mesh.edges):
        return _without_rows(table)
    return _rows("edge", table, source_ids(mesh.edge_ids, len(mesh.edges)), dict(zip(ply.EDGE, mesh.edges.T, strict=True)))


def _without_rows(table: Table | None) -> Table | None:
    if table is None:
        return None
    none = np.empty(0, np.int64)
    return Table(replace(table.element, count=0), {name: _chosen(column, none) for name, column in table.columns.items()})


def _rows(
    element: str, table: Table | None, ids: Longs | None, values: Mapping[str, Column], colors: NDArray[np.uint8] | None = None
) -> Table:
    """Returns the rows `ids` of an element's table in the source file, with the new `values` and `colors`."""
    channels = {} if colors is None else _channels(colors, table, ids)
    values = {**values, **channels}
    columns: dict[str, Column] = {}
    properties: list[PlyProperty] = []
    changed: set[str] = set()
    standard = set() if table is None else ply.standard_properties(table)
    before: Mapping[str, Column] = {} if table is None else table.columns
    for p in () if table is None else table.element.properties:
        if p.name in standard and p.name not in values:
            continue  # a step has removed it
        base = _chosen(before[p.name], ids)
        value = values.get(p.name, base)
        if value is not base and isinstance(value, Lists) == isinstance(base, Lists):
            p = p if p.name in (*ply.PLACE, *channels) else _wide_enough(p, value)
            value = value if isinstance(value, Lists) else _cast(value, p.type)
            if not (all(map(are_equal, base, value)) if isinstance(value, Lists) else are_equal(np.asarray(base), value)):
                base = value
                changed.add(p.name)
        columns[p.name] = base
        properties.append(p)
    for name, value in values.items():
        if name not in columns:
            columns[name] = value
            new = PlyProperty(name, "float" if name == ply.WEDGES else "int", "uchar")
            if not isinstance(value, Lists):
                types = {"b": "uchar", "i": "int", "u": "uchar" if value.dtype.itemsize == 1 else "uint"}
                new = PlyProperty(name, types.get(value.dtype.kind, "double"))
            properties.append(_wide_enough(new, value))
    first = next(iter(columns.values()))
    rows = PlyElement(element, len(first.lengths if isinstance(first, Lists) else first), tuple(properties))
    if table is not None and ids is None and rows == table.element:
        return replace(table, columns=columns, changed=frozenset(changed))
    return Table(rows, columns)


def _chosen(column: Column, ids: Longs | None) -> Column:
    """Returns the rows of a column with these ids; id -1 gives 0 or an empty list."""
    if ids is None:
        return column
    if isinstance(column, Lists):
        return column.chosen(ids)
    if not len(column):
        return np.zeros((len(ids), *column.shape[1:]), column.dtype)
    values = column[ids]
    values[ids < 0] = 0
    return values


def _cast(values: Array, type_: str) -> Array:
    kind = np.dtype(KINDS[type_])
    if kind.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.rint(values, dtype=np.float64), limits.min, limits.max).astype(kind)


def _custom(
    attributes: Mapping[str, Array], standard: frozenset[str], other: Mapping[str, Column], table: Table | None, notes: list[str]
) -> dict[str, Array]:
    """Returns the custom attributes by property name; changes names that PLY forbids; a vector becomes a property per axis."""
    taken = {*other, *((*ply.COLOR, ply.ALPHA) if "colors" in attributes else ())}
    columns: dict[str, Array] = {}
    for name in (name for name in attributes if name not in standard):
        values = attributes[name]
        scalars = {name: values} if values.ndim == 1 else {f"{name}_{axis}": c for axis, c in zip("xyzw", values.T, strict=False)}
        for old, column in scalars.items():
            new = old if table is not None and old in table.columns else re.sub("[^!-~]+", "_", old)
            while new in taken or new in columns:
                new += "_"
            if new != old:
                notes.append(f"the attribute {old!r} is written as {new!r}: names in PLY are unique ASCII without blanks")
            if column.dtype.kind in "iu" and max(-int(column.min(initial=0)), int(column.max(initial=0))) > 2**53:
                notes.append(f"the whole numbers of {new!r} are written as double, which rounds those above 2^53")
            columns[new] = column
    return columns


def _channels(colors: NDArray[np.uint8], table: Table | None, ids: Longs | None) -> dict[str, Array]:
    """Returns columns scaled as in the file. Rows of unchanged colour keep the numbers of the file; new channels are bytes."""
    if table is None:
        return dict(zip((*ply.COLOR, ply.ALPHA), colors.T, strict=True))
    names = (*ply.COLOR, ply.ALPHA) if ply.ALPHA in table.columns or (colors[:, 3] != 255).any() else ply.COLOR
    columns: dict[str, Array] = dict(zip(names, colors.T, strict=False))
    former = {name: np.asarray(_chosen(column, ids)) for name in names if (column := table.numbers(name)) is not None}
    # Levels of type float that are all at most 1 would be read as shares, so shares are written.
    is_dark = min(colors[:, :3].max(initial=0), colors[:, 3].max(initial=0)) <= 1
    for p in (p for p in table.element.properties if p.name in former):
        top = 1.0 if is_dark and KINDS[p.type][0] == "f" else ply.top_level(table, p.name)
        columns[p.name] = _cast(columns[p.name] / 255.0 * top, p.type)
    if (before := ply.colors_of(table)) is not None:
        same = (np.asarray(_chosen(before, ids)) == colors).all(axis=1)
        kept = {name: np.where(same, former[name], column) if name in former else column for name, column in columns.items()}
        # If only dark colours remain, they may be read in another range.
        if are_equal(ply.colors_of(Table(replace(table.element, count=len(colors)), kept)), colors):
            return kept
    return columns


def _wide_enough(p: PlyProperty, column: Column) -> PlyProperty:
    """Returns the property with types that hold its values; a vertex number of a corner may exceed a small type."""
    if not isinstance(column, Lists):
        return p if KINDS[p.type][0] == "f" or (_cast(column, p.type) == column).all() else replace(p, type="double")
    if KINDS[p.type][0] != "f" and len(column.values) and column.values.max() > np.iinfo(KINDS[p.type]).max:
        p = replace(p, type="int")
    if p.count_type and KINDS[p.count_type][0] != "f" and column.lengths.max(initial=0) > np.iinfo(KINDS[p.count_type]).max:
        p = replace(p, count_type="int")
    return p


def _write_binary(target: BinaryIO, table: Table, order: str) -> None:
    element = table.element
    widths = {name: column.width for name, column in table.columns.items() if isinstance(column, Lists)}
    if element.count and None in widths.values():
        target.write(_packed(table, order))
        return
    rows = np.zeros(element.count, ply_tables.row_type(element, order, {name: width or 0 for name, width in widths.items()}))
    for name, column in table.columns.items():
        if isinstance(column, Lists):
            rows[f"{name} count"] = column.lengths
            with np.errstate(over="ignore"):
                rows[name] = column.values.reshape(rows[name].shape)
        else:
            rows[name] = column
    target.write(rows.tobytes())


def _packed(table: Table, order: str) -> bytes:
    n = table.element.count
    fields: list[tuple[NDArray[np.uint8], Longs]] = []  # by field: the bytes of all rows, and the byte count of each row
    for p in table.element.properties:
        column, kind = table.columns[p.name], np.dtype(order + KINDS[p.type])
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
        buffer[ply_tables.indices_of_runs(starts, lengths)] = data
        starts = starts + lengths
    return buffer.tobytes()


def _file_bytes(table: Table, document: PlyDocument) -> bytes | memoryview | None:
    """Returns the rows as in the source file; in text, changed numbers are replaced. None if rows must be written anew."""
    if table.bytes is None:
        return None
    start, end = table.bytes
    data, tokens, properties = document.data[start:end], document.tokens, table.element.properties
    if not table.changed:
        return data.data
    columns = [k for k, p in enumerate(properties) if p.name in table.changed]
    if tokens is None or table.lines is None or any(p.count_type for p in properties[: columns[-1] + 1]):
        return None
    before, names = document.tables[table.element.name].columns, [properties[k].name for k in columns]
    new = [np.asarray(table.columns[name]) for name in names]
    differs = [a != np.asarray(before[name]) for a, name in zip(new, names, strict=True)]
    spans, new_words = changed_words(tokens, table.lines, columns, new, differs)
    return patched(data.tobytes(), spans - (start - document.header.size), new_words)


def _lines(table: Table) -> Iterator[bytes]:
    columns: list[list[bytes]] = []
    for p in table.element.properties:
        column = table.columns[p.name]
        column_words = words((column.values if isinstance(column, Lists) else column).astype(KINDS[p.type]))
        if isinstance(column, Lists):
            column_words = [b" ".join((b"%d" % len(run), *run)) for run in runs(column_words, column.lengths)]
        columns.append(column_words)
    for line in zip(*columns, strict=True):
        yield b" ".join(line) + b"\n"
