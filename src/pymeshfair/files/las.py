"""Reads and writes LAS and LAZ files through laspy; dimensions become attributes, most with the same name."""

from __future__ import annotations

import copy
import logging
import re
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..filters.mesh import Floats
from ..mesh_data import MeshData, Source
from ..mesh_data.mesh_data import VERTEX_ATTRIBUTES, Array
from .errors import ContentsError
from .formats import MISSING_LASPY
from .inputs import Reading, References
from .outputs import WORTH_A_WARNING, Writing

_PLACE, _COLOR = ("X", "Y", "Z"), ("red", "green", "blue")
NORMAL = ("NormalX", "NormalY", "NormalZ")
_NUMBERS = ("scalars", "radii")  # attributes of `MeshData` that are stored in dimensions of the same names
_SHORTEST_HEADER, _LONGEST_HEADER = 227, 375  # bytes: the header of LAS 1.0, and the most that are read of a longer one
_CHUNK = 1 << 20  # the number of points read or written at a time
_COLORED = {0: 2, 1: 3, 4: 5, 6: 7}  # by a point format without colours, the one with the same fields and with colours
#: names of units in coordinate reference systems, and their numbers in GeoTIFF keys
_UNITS = {"metre": "m", "meter": "m", "m": "m", "foot": "ft", "feet": "ft", "foot_us": "ft", "us survey foot": "ft", "ft": "ft"}
_UNIT_KEY, _UNIT_CODES = 3076, {9001: "m", 9002: "ft", 9003: "ft"}


@dataclass(frozen=True, eq=False)
class LasDocument:
    """What the writer needs of a LAS file: header, extended records and (n, 3) 16-bit colours."""

    header: Any
    records: Any
    deep: NDArray[np.uint16] | None


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Opens a file; turns the errors of laspy into `ContentsError`."""
    laspy, errors = _laspy()
    _check_records(path)
    try:
        with laspy.open(path) as reader:
            yield reader
    except ContentsError:
        raise
    except errors as error:
        raise ContentsError(f"laspy says: {error}") from error
    except BaseException as error:
        if type(error).__name__ != "PanicException":  # lazrs raises this class, which is no Exception and cannot be imported
            raise
        raise ContentsError(f"lazrs cannot decompress it: {error}") from None


def _check_records(path: Path) -> None:
    """Refuses a header with more variable length records than fit in the file, since laspy would allocate all of them."""
    with path.open("rb") as file:
        header = file.read(_LONGEST_HEADER)
    if len(header) < _SHORTEST_HEADER or not header.startswith(b"LASF"):
        return  # laspy refuses it
    begin, points, count = struct.unpack_from("<HII", header, 94)
    room = [(count, points - begin, 54)]
    if header[24:26] >= b"\x01\x04" and len(header) >= 247:
        start, extended_count = struct.unpack_from("<QI", header, 235)
        room.append((extended_count, path.stat().st_size - start, 60))
    for declared, space, least in room:
        if declared * least > max(space, 0):
            what = f"{declared:,} variable length records, and there is room for {max(space, 0) // least:,}"
            raise ContentsError(f"its header declares {what}")


def _laspy() -> tuple[Any, tuple[type[Exception], ...]]:
    try:
        import laspy
        from lazrs import LazrsError
    except ImportError as error:
        raise ContentsError(MISSING_LASPY) from error
    logging.getLogger("laspy").addHandler(logging.NullHandler())  # laspy also raises what it logs
    return laspy, (laspy.errors.LaspyException, LazrsError, OverflowError, ValueError)  # ValueError: the file ends within a point


def chunks(reader: Any, size: int) -> Iterator[Any]:
    """Yields the points of a reader in pieces; refuses a file with fewer points than declared."""
    declared, read = int(reader.header.point_count), 0
    for chunk in reader.chunk_iterator(size):
        read += len(chunk)
        yield chunk
    if read < declared:
        raise ContentsError(f"it ends after {read:,} of the {declared:,} points of its header")


def read_las(path: Path, references: References) -> Reading:
    """Reads a LAS, LAZ or COPC file."""
    with opened(path) as reader:
        header = copy.deepcopy(reader.header)
        names = [name for name in header.point_format.dimension_names if name not in _PLACE]
        parts: dict[str, list[Any]] = {name: [] for name in ("x", "y", "z", *names)}
        for chunk in chunks(reader, _CHUNK):
            for name, values in parts.items():
                values.append(np.array(chunk[name]))
        records = reader.evlrs
    columns = {name: np.concatenate(values) if values else np.empty(0) for name, values in parts.items()}
    vertices = np.stack([columns.pop(axis) for axis in "xyz"], axis=1)
    deep = None
    attributes: dict[str, Array] = {}
    if set(_COLOR) <= columns.keys():
        deep = np.stack([columns.pop(name) for name in _COLOR], axis=1)
        attributes["colors"] = _levels(deep)
    if set(NORMAL) <= columns.keys():
        attributes["normals"] = np.stack([columns.pop(name) for name in NORMAL], axis=1).astype(np.float64)
    for name, column in columns.items():
        attributes[f"{name}_" if name in VERTEX_ATTRIBUTES - set(_NUMBERS) else name] = column
    remaining = [r for r in (*header.vlrs, *(records or ())) if r.user_id not in ("copc", "laszip encoded")]
    system = [r for r in remaining if r.user_id == "LASF_Projection"]
    others = len(remaining) - len(system) - sum(r.user_id == "LASF_Spec" and r.record_id == 4 for r in remaining)
    extras = ["its coordinate reference system"] if system else []
    extras += [f"records of its header ({others:,})"] if others else []
    source = Source(path, "las", LasDocument(header, records, deep), tuple(extras))
    return Reading(MeshData(vertices=vertices, vertex_attributes=attributes, unit=las_unit(header, records), source=source))


def _levels(deep: NDArray[np.uint16]) -> NDArray[np.uint8]:
    levels = np.full((len(deep), 4), 255, np.uint8)
    levels[:, :3] = deep if deep.max(initial=0) <= 255 else np.rint(deep * (255 / 65535))
    return levels


def las_unit(header: Any, records: Any) -> str | None:
    """Returns the unit of length in the coordinate reference system, or None without a known unit."""
    for record in (*header.vlrs, *(records or ())):
        if (text := getattr(record, "string", None)) and re.match(r"\s*(COMPD|PROJ|BOUND|COMPOUND)", text):
            # The text may have units of angles and of heights, too: the first known unit of length counts. In WKT 2 the unit
            # of the ellipsoid comes before the units of the coordinates.
            for name in re.findall(r'(?:LENGTH)?UNIT\["([^"]+)"', text.partition("CS[Cartesian")[2] or text, re.IGNORECASE):
                if unit := _UNITS.get(name.lower().replace("u.s.", "us")):
                    return unit
        for key in getattr(record, "geo_keys", ()):
            if key.id == _UNIT_KEY:
                return _UNIT_CODES.get(key.value_offset)
    return None


def write_las(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Writes the vertices of a mesh, with the header of their LAS file if they have one."""
    return write_las_pieces(lambda: iter((mesh,)), target, mesh.document(LasDocument), writing)


_Stored: TypeAlias = dict[str, tuple[str, float]]  # by column, the dimension that stores it, and the factor for its numbers
#: of each scalar column and each axis: minimum, maximum, and whether all numbers are whole
_Ranges: TypeAlias = dict[str | int, tuple[float, float, bool]]


def write_las_pieces(
    pieces: Callable[[], Iterator[MeshData]],
    target: BinaryIO,
    document: LasDocument | None = None,
    writing: Writing | None = None,
) -> tuple[str, ...]:
    """Writes a cloud in pieces with equal attributes; `pieces` is called twice: to measure, and to write.

    With `writing`, the scale is that of the document (0.01 without one) if it is fine enough, else the largest power of ten that
    is; without `writing`, the finest in 32 bits. Raises `ContentsError` if the format cannot hold the cloud, or laspy is missing.
    """
    laspy, errors = _laspy()
    to_measure = pieces()
    first = next(to_measure)
    first_columns = _columns(first, document)
    ranges: _Ranges = {}
    _widen(ranges, first, first_columns)
    for piece in to_measure:
        _widen(ranges, piece, _columns(piece, document))
    notes: list[str] = []
    header, records = _header(first, document)
    stored = _dimensions(header, first_columns, ranges, notes)
    if 0 in ranges:
        least, most = (np.array([ranges[axis][end] for axis in range(3)]) for end in (0, 1))
        resolution = 0.0 if writing is None else WORTH_A_WARNING * writing.resolution()
        if writing is None or not _suffices(header, first.vertices, least, most, resolution):
            _choose_scale(header, least, most, resolution, notes)
    compress = writing is not None and writing.extension == "laz"
    try:
        with laspy.open(target, "w", header=header, closefd=False, do_compress=compress) as writer:
            for piece in pieces():
                columns = first_columns if piece is first else _columns(piece, document)
                for start in range(0, max(len(piece.vertices), 1), _CHUNK):
                    writer.write_points(_points(header, piece.vertices, columns, stored, slice(start, start + _CHUNK)))
            if records:
                writer.write_evlrs(records)
    except errors as error:
        raise ContentsError(f"laspy says: {error}") from error
    return tuple(notes)


def _points(header: Any, vertices: Floats, columns: dict[str, Array], stored: _Stored, rows: slice) -> Any:
    import laspy

    points = laspy.ScaleAwarePointRecord.zeros(len(vertices[rows]), header=header)
    for k, name in enumerate(_PLACE):
        points.array[name] = np.rint((vertices[rows, k] - header.offsets[k]) / header.scales[k])
    for name, (dimension, factor) in stored.items():
        points[dimension] = columns[name][rows] if factor == 1.0 else np.rint(columns[name][rows] * factor)
    return points


def _widen(ranges: _Ranges, mesh: MeshData, columns: dict[str, Array]) -> None:
    columns_and_axes: list[tuple[str | int, Array]] = [*columns.items(), *enumerate(mesh.vertices.T)]
    for name, values in columns_and_axes:
        if values.ndim == 1 and len(values) and values.dtype.kind in "biuf":
            is_whole = values.dtype.kind != "f" or bool((values == np.rint(values)).all())
            least, most, whole = ranges.get(name, (np.inf, -np.inf, True))
            least, most = float(np.minimum(least, values.min())), float(np.maximum(most, values.max()))
            ranges[name] = least, most, whole and is_whole


def _header(mesh: MeshData, document: LasDocument | None) -> tuple[Any, Any]:
    import laspy

    if document is None:
        header = laspy.LasHeader(point_format=7 if "colors" in mesh.vertex_attributes else 6, version="1.4")
        header.generating_software = "pymeshfair"
        header.creation_date = date(1980, 1, 1)  # fixed, for the same bytes on every day
        return header, None
    header, records = header_of(document.header, document.records)
    if "colors" in mesh.vertex_attributes and "red" not in header.point_format.dimension_names:
        colored = laspy.PointFormat(_COLORED.get(header.point_format.id, header.point_format.id))
        colored.dimensions.extend(header.point_format.extra_dimensions)
        header.set_version_and_point_format(max(header.version, laspy.header.Version(1, 2)), colored)
    return header, records


def header_of(header: Any, records: Any) -> tuple[Any, Any]:
    """Returns copies of a file's header and extended records for a new file, without the octree of COPC."""
    header = copy.deepcopy(header)
    header.vlrs = [r for r in header.vlrs if r.user_id != "copc"]
    return header, None if records is None else type(records)([r for r in records if r.user_id != "copc"])


def _columns(mesh: MeshData, document: LasDocument | None) -> dict[str, Array]:
    """Returns the columns to write by name, without the coordinates; no custom attribute will be read as a channel of colours."""
    columns: dict[str, Array] = {}
    given = mesh.vertex_attributes.keys()
    taken = {c for name, group in (("colors", _COLOR), ("normals", NORMAL)) if name in given or given >= {*group} for c in group}
    for name, values in mesh.vertex_attributes.items():
        if name == "colors":
            deep = values[:, :3].astype(np.uint16) * np.uint16(257)
            if document is not None and document.deep is not None:
                ids = np.arange(len(values)) if mesh.vertex_ids is None else mesh.vertex_ids
                if document.deep.max(initial=0) <= 255:
                    deep //= np.uint16(257)
                same = ids >= 0
                same[same] = (_levels(document.deep)[ids[same]] == values[same]).all(axis=1)
                bits = deep.copy()
                bits[same] = document.deep[ids[same]]
                # If all remaining 16-bit colours are below 256, they would be read as 8-bit colours.
                deep = bits if (_levels(bits)[:, :3] == values[:, :3]).all() else deep
            columns |= zip(_COLOR, deep.T, strict=True)
        elif name == "normals":
            columns |= zip(NORMAL, values.T, strict=True)
        elif name in _NUMBERS or name not in VERTEX_ATTRIBUTES:
            column = name[:-1] if name[:-1] in VERTEX_ATTRIBUTES - set(_NUMBERS) else name
            while column in columns or column in taken:
                column += "_"
            columns[column] = values
    return columns


def _dimensions(header: Any, columns: dict[str, Array], ranges: _Ranges, notes: list[str]) -> _Stored:
    """Chooses or declares a dimension for each column: `name_` if `name` is reserved or cannot hold its numbers."""
    import laspy

    standard = {dimension.name: dimension for dimension in header.point_format.standard_dimensions}
    reserved = {*_PLACE, *"xyz", *(set(header.point_format.dtype().names) - {d.name for d in header.point_format.dimensions})}
    stored: _Stored = {}
    for name, values in columns.items():
        least, most, whole = ranges.get(name, (0.0, 0.0, True))
        stored_name = f"{name}_" if name in reserved else name
        if name in standard and standard[name].kind != laspy.point.dims.DimensionKind.FloatingPoint:
            if name == "intensity" and not whole and least >= 0.0 and most <= 1.0:
                notes.append("its intensity from 0 to 1 is stored as whole numbers from 0 to 65535")
                stored[name] = name, 65535.0
                continue
            if not (whole and standard[name].min <= least and most <= standard[name].max):
                stored_name = f"{name}_"
                what = "numbers" if whole else "fractions"
                notes.append(f"the format's {name!r} cannot hold {what} from {least:g} to {most:g}: they are in {stored_name!r}")
        stored[name] = stored_name, 1.0
        if is_declared(header, stored_name, values):
            continue
        kind = "u1" if values.dtype.kind == "b" else values.dtype.str[1:]
        width = 1 if values.ndim == 1 else values.shape[1]
        if len(stored_name.encode()) > 32 or width > 3 or kind == "f2":
            notes.append(f"the dimension {name[:40]!r}, which the format cannot hold, is left out")
            del stored[name]
            continue
        header.add_extra_dim(laspy.ExtraBytesParams(stored_name, kind if width == 1 else f"{width}{kind}"))
    return stored


def is_declared(header: Any, name: str, values: Array) -> bool:
    """Returns whether the header declares a dimension for these values; removes an integer dimension that would change them."""
    dimension = next((d for d in header.point_format.dimensions if d.name == name), None)
    if dimension is None or dimension.is_standard or dimension.kind.name == "FloatingPoint":
        return dimension is not None
    scales, offsets = (dimension.scales, dimension.offsets) if dimension.is_scaled else (1.0, 0.0)
    steps, limits = np.rint((values - offsets) / scales), np.iinfo(dimension.dtype.base)
    is_held = bool(((steps * scales + offsets == values) & (steps >= limits.min) & (steps <= limits.max)).all())
    if not is_held:
        header.remove_extra_dims([name])
    return is_held


def _suffices(header: Any, vertices: Floats, least: Floats, most: Floats, resolution: float) -> bool:
    reach = np.maximum(np.abs(least - header.offsets), np.abs(most - header.offsets))
    if (reach / header.scales >= 2**31 - 1).any():
        return False
    steps = np.rint((vertices - header.offsets) / header.scales)
    moved = np.abs(steps * header.scales + header.offsets - vertices).max()
    return bool(moved <= max(resolution, 4 * np.spacing(np.abs(vertices).max())))


def _choose_scale(header: Any, least: Floats, most: Floats, resolution: float, notes: list[str]) -> None:
    """Sets the scale, a power of ten: the largest with errors up to `resolution`; for the resolution 0 the finest in 32 bits."""
    extent = float((most - np.floor(least)).max())
    finest = 10.0 ** np.ceil(np.log10(max(extent, 1e-9) / (2**31 - 1)))
    step = 10.0 ** np.floor(np.log10(2 * resolution)) if resolution > 0 else finest
    if step < finest:
        raise ContentsError(
            f"coordinates over a length of {extent:.3g} in steps of {step:.3g} need more than the 32 bits of the format; "
            ".ply keeps every digit"
        )
    header.scales, header.offsets = np.full(3, step), np.floor(least)
    notes.append(f"its scale is {step:g}, and its offset {' '.join(f'{x:g}' for x in header.offsets)}")
