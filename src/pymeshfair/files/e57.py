"""Reads E57 files, through pye57: the points of all scans at the places that their poses say, with every field of a point."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh_data import MeshData, Source
from ..mesh_data.mesh_data import VERTEX_ATTRIBUTES
from .errors import ContentsError
from .formats import MISSING_PYE57
from .reading import Reading
from .references import References

_PLACE = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERE = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_COLOR = ("colorRed", "colorGreen", "colorBlue")
#: fields that are not 0 where nothing was measured
_INVALID = ("cartesianInvalidState", "sphericalInvalidState")
#: the attribute that says in which of several scans a point is
_SCAN = "scan"


def read_e57(path: Path, references: References) -> Reading:
    """Read an E57 file; coordinates are in metres, as the format says.

    Raises:
        ContentsError: it is none, is damaged, or pye57 is missing.
        OSError: it cannot be read.
    """
    with _opened(path) as file:
        count = int(file.scan_count)
        scans = [(file.get_header(index), _fields(file, index)) for index in range(count)]
        scans = [(header, fields) for header, fields in scans if fields]
        extras = _extras(file, [header for header, _ in scans])
        parts = [_placed(header, fields) for header, fields in scans]
        colors = [_colors(header, fields) for header, fields in scans]
    if not parts:
        raise ContentsError("it holds no points")
    measured = [~np.any([fields[name] != 0 for name in _INVALID if name in fields], axis=0) for _, fields in scans]
    measured = [np.broadcast_to(kept, len(part)) for kept, part in zip(measured, parts, strict=True)]
    missing = sum(int(np.count_nonzero(~kept)) for kept in measured)
    doubts = [f"{missing:,} points at which nothing was measured are left out"] if missing else []
    attributes: dict[str, NDArray[Any]] = {}
    if any(levels is not None for levels in colors):
        white = [np.full((len(part), 4), 255, np.uint8) if c is None else c for part, c in zip(parts, colors, strict=True)]
        attributes["colors"] = np.concatenate([c[kept] for c, kept in zip(white, measured, strict=True)])
    names = dict.fromkeys(name for _, fields in scans for name in fields if name not in (*_PLACE, *_SPHERE, *_COLOR, *_INVALID))
    for name in names:
        if lacking := sum(name not in fields for _, fields in scans):
            doubts.append(f"{lacking:,} of its {len(scans):,} scans have no field {name!r}, which is 0 there")
        columns = [fields.get(name, np.zeros(len(part))) for (_, fields), part in zip(scans, parts, strict=True)]
        column = np.concatenate([c[kept] for c, kept in zip(columns, measured, strict=True)])
        key = name.replace(":", "_")
        attributes[f"{key}_" if key in VERTEX_ATTRIBUTES else key] = column
    if len(scans) > 1:
        attributes[_SCAN] = np.repeat(np.arange(len(scans), dtype=np.int32), [int(kept.sum()) for kept in measured])
    vertices = np.concatenate([part[kept] for part, kept in zip(parts, measured, strict=True)])
    mesh = MeshData(vertices=vertices, vertex_attributes=attributes, unit="m", source=Source(path, "e57", extras=tuple(extras)))
    return Reading(mesh, tuple(doubts))


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    try:
        import pye57
        from pye57.libe57 import E57Exception
    except ImportError as error:
        raise ContentsError(MISSING_PYE57) from error
    try:
        with pye57.E57(str(path)) as file:
            yield file
    except (E57Exception, RuntimeError, KeyError, ValueError) as error:
        raise ContentsError(f"pye57 says: {str(error).strip().splitlines()[0] if str(error).strip() else error!r}") from error


def _fields(file: Any, index: int) -> dict[str, NDArray[Any]]:
    """All fields of the points of a scan; those whose kind is a whole number in a type of whole numbers."""
    from pye57 import libe57

    header = file.get_header(index)
    count = int(header.point_count)
    if not count:
        return {}
    prototype = libe57.StructureNode(header.points.prototype())
    kinds = {name: prototype.get(name).type() for name in header.point_fields}
    texts = {name for name, kind in kinds.items() if kind == libe57.NodeType.E57_STRING}
    columns = {name: np.zeros(count) for name in kinds if name not in texts}
    buffers = libe57.VectorSourceDestBuffer()
    for name, column in columns.items():
        buffers.append(libe57.SourceDestBuffer(file.image_file, name, column, count, True, True))
    reader = header.points.reader(buffers)
    read = reader.read()
    reader.close()
    if read < count:
        raise ContentsError(f"a scan of it ends after {read:,} of its {count:,} points")
    for name, column in columns.items():
        whole = kinds[name] == libe57.NodeType.E57_INTEGER and name not in _COLOR
        if whole and column.min() >= np.iinfo(np.int32).min and column.max() <= np.iinfo(np.int32).max:
            columns[name] = column.astype(np.int32)
    return columns


def _placed(header: Any, fields: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    """(n, 3) coordinates where the pose of a scan puts them."""
    if set(_PLACE) <= fields.keys():
        places = np.stack([fields[name] for name in _PLACE], axis=1)
    elif set(_SPHERE) <= fields.keys():
        distance, azimuth, elevation = (fields[name] for name in _SPHERE)
        flat = distance * np.cos(elevation)
        places = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)], axis=1)
    else:
        raise ContentsError(f"a scan of it has points without places; their fields are {', '.join(fields)}")
    if not header.has_pose():
        return places
    placed: NDArray[np.float64] = places @ np.asarray(header.rotation_matrix).T + np.asarray(header.translation)
    return placed


def _colors(header: Any, fields: dict[str, NDArray[Any]]) -> NDArray[np.uint8] | None:
    """(n, 4) colours of 8 bits, from those between the limits that a scan states."""
    if not set(_COLOR) <= fields.keys():
        return None
    levels = np.full((len(fields[_COLOR[0]]), 4), 255, np.uint8)
    for k, name in enumerate(_COLOR):
        least, most = 0.0, 255.0 if fields[name].max() <= 255 else 65535.0
        if all(header.node.isDefined(f"colorLimits/{name}{end}") for end in ("Minimum", "Maximum")):
            least, most = (float(header.node["colorLimits"][f"{name}{end}"].value()) for end in ("Minimum", "Maximum"))
        levels[:, k] = np.clip(np.rint((fields[name] - least) * (255.0 / (most - least or 1.0))), 0, 255)
    return levels


def _extras(file: Any, headers: list[Any]) -> list[str]:
    """What else the file holds that no mesh has."""
    root = file.image_file.root()
    poses = sum(bool(header.has_pose()) for header in headers)
    extras = [f"the scanner's places ({poses:,})"] if poses else []
    if root.isDefined("coordinateMetadata") and root["coordinateMetadata"].value().strip():
        extras.append("its coordinate reference system")
    pictures = root["images2D"].childCount() if root.isDefined("images2D") else 0
    return [*extras, *([f"its pictures ({pictures:,})"] if pictures else [])]
