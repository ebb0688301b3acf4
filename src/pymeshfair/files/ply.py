"""Reads PLY files, binary in either byte order or text: all elements, with properties of all types of the format."""

import mmap
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..filters.mesh import Floats, Ints, Longs
from ..mesh_data import MeshData, Source, Texture
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import Reading, References, unended
from .ply_tables import Lists, PlyHeader, Table, binary_tables, read_header, text_tables
from .polygons import triangulated
from .tokens import Tokens

CORNERS = ("vertex_indices", "vertex_index")  # the two names that a face's list of corners may have
PLACE, NORMAL, COLOR = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue")
ALPHA, SCALAR, RADIUS = "alpha", "quality", "radius"
TEXTURE = (("texture_u", "texture_v"), ("s", "t"))
WEDGES, TEXTURE_NUMBER = "texcoord", "texnumber"
EDGE = ("vertex1", "vertex2")
#: groups of properties by element: a complete group becomes an attribute of `MeshData`; for others see `PlyDocument.custom`
_GROUPS = {"vertex": (PLACE, NORMAL, COLOR, (SCALAR,), (RADIUS,)), "face": (COLOR, (SCALAR,), (TEXTURE_NUMBER,)), "edge": (EDGE,)}


@dataclass(frozen=True, eq=False)
class PlyDocument:
    """The parts of a PLY file that the writer needs."""

    header: PlyHeader
    tables: Mapping[str, Table]  # the rows of its elements
    data: NDArray[np.uint8]  # its bytes
    tokens: Tokens | None = None  # the tokens after the header, if the file is a text
    row_of_face: Ints | None = None  # (m,) each triangle's row of ``face``; None if equal to its number, or if `has_other_faces`
    has_other_faces: bool = False  # whether triangles come from strips or a grid, and not from rows of ``face``
    wedges: Array | None = None  # (m, 3, 2) texture coordinates of triangle corners, or None
    polygon: Array | None = None  # (m,) the attribute ``polygon`` of its triangles, or None
    faces: Ints | None = None  # (m, 3) its triangles

    def custom(self, element: str) -> dict[str, Array]:
        """Returns, by name, the scalar properties of vertices, triangles or edges that are custom attributes."""
        table = self.tables.get(element)
        if table is None or (element == "face" and self.has_other_faces):
            return {}
        standard, rows = standard_properties(table), self.row_of_face if element == "face" else None
        custom = {name: c for name, c in table.columns.items() if name not in standard and not isinstance(c, Lists)}
        return custom if rows is None else {name: c[rows] for name, c in custom.items()}


def read_ply(path: Path, references: References) -> Reading:
    """Reads a PLY file."""
    header = read_header(path)
    if "vertex" not in [element.name for element in header.elements]:
        raise ContentsError("it has no element 'vertex'")
    with path.open("rb") as file:
        data = np.frombuffer(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ), np.uint8)
    tokens: Tokens | None = None
    doubts: tuple[str, ...] = ()
    if header.format == "ascii":
        tables, tokens = text_tables(data[header.size :].tobytes(), header)
        doubts = unended(data[-1:].tobytes())
    else:
        tables = binary_tables(data, header)
    vertex, face = tables["vertex"], tables.get("face")
    vertices = _vectors(vertex, PLACE)
    if vertices is None:
        raise ContentsError("its vertices have no numbers x, y and z")
    rows: Ints | slice = slice(None)
    attributes: dict[str, Array] = {}
    if has_rows := face is not None and face.element.count > 0 and any(name in face.columns for name in CORNERS):
        faces, rows, attributes = _faces_of_rows(face, vertices, len(header.textures))
    else:
        faces = _other_faces(tables, header, len(vertices))
        if face is not None and face.element.count:
            doubts += (f"its {face.element.count:,} rows of 'face' have no list 'vertex_indices' and are not read",)
    row_of_face = None if isinstance(rows, slice) else rows
    wedges, polygon = attributes.get("wedge_texture_coordinates"), attributes.get("polygon")
    document = PlyDocument(header, tables, data, tokens, row_of_face, len(faces) > 0 and not has_rows, wedges, polygon, faces)
    read = {"normals": _vectors(vertex, NORMAL), "colors": colors_of(vertex)}
    read["texture_coordinates"] = _vectors(vertex, texture_names(vertex) or ("",))
    for name, attribute in ((SCALAR, "scalars"), (RADIUS, "radii")):
        read[attribute] = None if (column := vertex.numbers(name)) is None else column.astype(np.float64)
    vertex_attributes = {name: values for name, values in read.items() if values is not None}
    mesh = MeshData(
        vertices=vertices,
        faces=faces,
        edges=_edges(tables.get("edge"), len(vertices)),
        vertex_attributes=vertex_attributes,
        face_attributes=attributes,
        keeps_normals="normals" in vertex_attributes,
        textures=tuple(Texture(name, references.find_image(name)) for name in header.textures),
        source=Source(path, "ply", document, tuple(_extras(document))),
    )
    return Reading(mesh, doubts)


def standard_properties(table: Table) -> set[str]:
    """Returns the properties of an element that become standard attributes of `MeshData`."""
    groups = [group for group in _GROUPS.get(table.element.name, ()) if all(table.numbers(name) is not None for name in group)]
    names = {name for group in groups for name in group}
    if COLOR in groups and table.numbers(ALPHA) is not None:
        names.add(ALPHA)
    if table.element.name == "vertex":
        names |= {*(texture_names(table) or ())}
    elif table.element.name == "face":
        names |= {name for name in (*CORNERS, WEDGES) if table.lists(name) is not None}
    return names


def _vectors(table: Table, names: tuple[str, ...]) -> Floats | None:
    columns = [column for name in names if (column := table.numbers(name)) is not None]
    return np.stack(columns, axis=1, dtype=np.float64) if len(columns) == len(names) else None


def colors_of(table: Table) -> NDArray[np.uint8] | None:
    """Returns (n, 4) colours of an element as levels from 0 to 255; None without colours.

    A channel of floats has shares from 0 to 1, or levels up to 255 if a value is above 1. A channel of integers has levels up to
    255, or up to the largest number of its type if a value is above 255.
    """
    channels = [table.numbers(name) for name in (*COLOR, ALPHA)]
    if any(c is None for c in channels[:3]):
        return None
    colors = np.full((table.element.count, 4), 255, np.uint8)
    for k, (name, channel) in enumerate(zip((*COLOR, ALPHA), channels, strict=True)):
        if channel is None or not len(channel):
            continue
        if channel.dtype.itemsize == 1:
            colors[:, k] = np.maximum(channel, 0)
        else:
            colors[:, k] = np.rint(255.0 * np.nan_to_num(np.clip(channel / top_level(table, name), 0.0, 1.0)))
    return colors


def top_level(table: Table, name: str) -> float:
    """Returns the value of full intensity in a colour channel; red, green and blue of one type share it."""
    own = np.asarray(table.columns[name])
    colors = [c for color in COLOR if name != ALPHA and (c := table.numbers(color)) is not None]
    channel = np.concatenate([own, *(c for c in colors if c.dtype == own.dtype)])
    if channel.dtype.kind == "f":
        return 1.0 if not len(channel) or np.nanmax(channel) <= 1.0 else 255.0
    return 255.0 if channel.dtype.itemsize == 1 or channel.max(initial=0) <= 255 else float(np.iinfo(channel.dtype).max)


def texture_names(table: Table) -> tuple[str, str] | None:
    """Returns the names of the texture coordinates of vertices, or None."""
    return next((pair for pair in TEXTURE if all(table.numbers(name) is not None for name in pair)), None)


def _faces_of_rows(table: Table, vertices: Floats, textures: int) -> tuple[Ints, Ints | slice, dict[str, Array]]:
    named = [name for name in CORNERS if table.lists(name) is not None]
    if len(named) > 1:
        raise ContentsError(f"its faces have their corners twice, as {' and as '.join(map(repr, named))}")
    if not named or (lists := table.lists(named[0])) is None:
        raise ContentsError("the corners of its faces are no lists")
    if lists.lengths.min() < 3:
        k = int(np.argmin(lists.lengths))
        raise ContentsError(f"its face {k + 1:,} has {lists.lengths[k]} vertices")
    corners = _checked(lists.values, len(vertices), "face")
    places, rows, of_polygons = triangulated(vertices, corners, lists.lengths)
    faces = (corners.reshape(-1, 3) if isinstance(rows, slice) else corners[places]).astype(np.int32)
    attributes: dict[str, Array] = {}
    if (colors := colors_of(table)) is not None:
        attributes["colors"] = colors[rows]
    if (scalars := table.numbers(SCALAR)) is not None:
        attributes["scalars"] = scalars.astype(np.float64)[rows]
    attributes |= of_polygons
    if (pairs := table.lists(WEDGES)) is not None:
        if (wrong := pairs.lengths != 2 * lists.lengths).any():
            k = int(np.argmax(wrong))
            what = f"{pairs.lengths[k]} values for {lists.lengths[k]} corners"
            raise ContentsError(f"the list 'texcoord' of its face {k + 1:,} has {what}")
        attributes["wedge_texture_coordinates"] = pairs.values.astype(np.float64).reshape(-1, 2)[places]
    if (numbers := table.numbers(TEXTURE_NUMBER)) is not None:
        if (wrong := ~((numbers >= -1) & (numbers < max(textures, 1)))).any():
            k = int(np.argmax(wrong))
            raise ContentsError(f"its face {k + 1:,} has the texture {numbers[k]:.0f}, counted from 0; there are {textures}")
        attributes["texture"] = numbers.astype(np.int32)[rows]
    elif pairs is not None and textures:
        attributes["texture"] = np.zeros(len(faces), np.int32)
    return faces, rows, attributes


def _checked(values: Array, count: int, what: str, least: int = 0) -> Longs:
    """Returns indices of vertices as integers; refuses fractions and indices out of range."""
    if values.dtype.kind == "f" and (values != np.rint(values)).any():
        raise ContentsError(f"a {what} of it names a vertex by a number that is not whole")
    if values.size and not (values.min() >= least and values.max() < count):
        raise ContentsError(f"a {what} of it names a vertex that is not among its {count:,}")
    return values.astype(np.int64)


def _other_faces(tables: Mapping[str, Table], header: PlyHeader, count: int) -> Ints:
    for element, triangles in (("tristrips", _of_strips), ("range_grid", _of_grid)):
        if (table := tables.get(element)) is not None and table.element.count and (lists := table.lists(CORNERS[0])):
            what = element.removeprefix("tri").removeprefix("range_").removesuffix("s")
            return triangles(header, Lists(_checked(lists.values, count, what, least=-1), lists.lengths))
    return np.empty((0, 3), np.int32)


def _of_strips(header: PlyHeader, lists: Lists) -> Ints:
    """Returns the triangles of strips that are separated by -1; every second triangle of a strip is reversed."""
    values, place = lists.values, np.arange(len(lists.values))
    breaks, begins = values < 0, np.isin(place, lists.starts)
    opening = np.maximum.accumulate(np.where(breaks, place + 1, np.where(begins, place, 0)))
    triples = np.stack([values[:-2], values[1:-1], values[2:]], axis=1)
    odd = (place - opening)[:-2] % 2 == 1
    triples[odd] = triples[odd][:, [1, 0, 2]]
    return np.asarray(triples[(opening[:-2] == opening[2:]) & ~breaks[:-2]], np.int32)


def _of_grid(header: PlyHeader, lists: Lists) -> Ints:
    """Returns the triangles of a range image: two in a cell with four measured corners, one in a cell with three."""
    comments = [comment.split() for comment in header.comments]
    sizes = {w[0]: int(w[1]) for w in comments if len(w) == 2 and w[0] in ("num_cols", "num_rows") and w[1].isdigit()}
    columns, rows = sizes.get("num_cols", 0), sizes.get("num_rows", 0)
    if columns * rows != len(lists.lengths):
        raise ContentsError(f"it has a grid of {len(lists.lengths):,} places, which do not fit num_cols and num_rows")
    if lists.lengths.max() > 1:
        raise ContentsError("a place of its grid has several vertices")
    grid: Longs = np.full(len(lists.lengths), -1, np.int64)
    grid[lists.lengths > 0] = lists.values
    grid = grid.reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1], grid[1:, 1:]))
    third, fourth = np.where(d < 0, c, -1), np.where(a < 0, b, -1)  # first corner of the triangle in a cell without d or a
    triangles = np.array([(d, c, a), (a, b, d), (third, a, b), (fourth, d, c)]).transpose(2, 0, 1)
    return triangles[(triangles >= 0).all(axis=2)].astype(np.int32)


def _edges(table: Table | None, count: int) -> Ints:
    pairs = None if table is None else _vectors(table, EDGE)
    if pairs is None:
        return np.empty((0, 2), np.int32)
    if (wrong := ~((pairs >= 0) & (pairs < count) & (pairs == np.rint(pairs))).all(axis=1)).any():
        raise ContentsError(f"its edge {int(np.argmax(wrong)) + 1:,} ends at a vertex that is not among its {count:,}")
    return pairs.astype(np.int32)


def _extras(document: PlyDocument) -> list[str]:
    extras: list[str] = []
    for element in document.header.elements:
        if element.count and element.name in ("vertex", "face", "edge"):
            standard = standard_properties(document.tables[element.name])
            extras += [f"{element.name} property {str(p)!r}" for p in element.properties if p.name not in standard]
        elif element.count and not (document.has_other_faces and element.name in ("tristrips", "range_grid")):
            extras.append(f"element {element.name!r} ({element.count:,})")
    comments = [c for c in document.header.comments if c and c != "VCGLIB generated" and not c.lower().startswith("texturefile")]
    if comments:
        extras.append(f"comment {comments[0][:60]!r}" + (f" and {len(comments) - 1} more" if len(comments) > 1 else ""))
    return extras
