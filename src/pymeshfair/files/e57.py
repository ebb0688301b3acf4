"""Reads E57 files through pye57: the points of all scans, transformed by their poses, with their fields."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.mesh import Floats
from ..mesh_data import MeshData, Source
from ..mesh_data.mesh_data import VERTEX_ATTRIBUTES, Array
from .errors import ContentsError
from .formats import MISSING_PYE57
from .inputs import Reading, References

_PLACE = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERE = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_COLOR = ("colorRed", "colorGreen", "colorBlue")
_NORMAL = ("nor:normalX", "nor:normalY", "nor:normalZ")
_INVALID = ("cartesianInvalidState", "sphericalInvalidState")  # fields that mark unmeasured points by values other than 0
_SCAN = "scan"  # the attribute with the scan number of each point, if several scans have points


def read_e57(path: Path, references: References) -> Reading:
    """Reads an E57 file; the format defines coordinates in metres."""
    with _opened(path) as file:
        survey = _Survey(file)
        pieces = list(survey.pieces(None))
        extras = _extras(file, survey.headers)
    attributes = {name: np.concatenate([piece[1][name] for piece in pieces]) for name in pieces[0][1]}
    vertices = np.concatenate([places for places, _ in pieces])
    mesh = MeshData(vertices=vertices, vertex_attributes=attributes, unit="m", source=Source(path, "e57", extras=tuple(extras)))
    return Reading(mesh, doubts_of(survey.declared - len(vertices)) + survey.doubts)


def e57_pieces(path: Path, size: int) -> Iterator[MeshData]:
    """Yields the points of `read_e57` in pieces of at most `size` points, with the same order and attributes."""
    with _opened(path) as file:
        for places, attributes in _Survey(file).pieces(size):
            yield MeshData(vertices=places, vertex_attributes=attributes)


def doubts_of(missing: int) -> tuple[str, ...]:
    """Returns a warning about `missing` unmeasured points if there are any."""
    return (f"{missing:,} points at which nothing was measured are left out",) if missing else ()


def e57_survey(path: Path) -> tuple[int, tuple[str, ...], list[str]]:
    """Returns the declared number of points (measured or not), warnings about fields that some scans lack, and lost contents."""
    with _opened(path) as file:
        survey = _Survey(file)
        return survey.declared, survey.doubts, _extras(file, survey.headers)


class _Survey:
    def __init__(self, file: Any) -> None:
        self._file = file
        headers = [file.get_header(index) for index in range(int(file.scan_count))]
        self.headers = [header for header in headers if int(header.point_count)]
        if not self.headers:
            raise ContentsError("it holds no points")
        self.declared = sum(int(header.point_count) for header in self.headers)
        self._kinds = [_kinds(header) for header in self.headers]
        bare = sum(not set(_COLOR) <= kinds.keys() for kinds in self._kinds)
        self._colored = bare < len(self._kinds)
        self._has_normals = any(set(_NORMAL) <= kinds.keys() for kinds in self._kinds)
        standard = (*_PLACE, *_SPHERE, *_INVALID, *(_COLOR if self._colored else ()))
        names = dict.fromkeys(name for kinds in self._kinds for name in kinds if name not in standard)
        vector = _NORMAL if self._has_normals else ()
        #: for each field that becomes a custom attribute: whether all scans that have it store 32-bit integers
        self._whole = {name: all(kinds.get(name, True) for kinds in self._kinds) for name in names if name not in vector}
        lacking = {name: sum(name not in kinds for kinds in self._kinds) for name in names}
        scans = f"of its {len(self.headers):,} scans have no"
        self.doubts = tuple(f"{n:,} {scans} field {name!r}, which is 0 there" for name, n in lacking.items() if n)
        self.doubts += (f"{bare:,} {scans} colours, and are white",) if bare and self._colored else ()

    def pieces(self, size: int | None) -> Iterator[tuple[Floats, dict[str, Array]]]:
        """Yields coordinates and attributes of the measured points, in pieces of at most `size` points; None: whole scans."""
        for number, (header, kinds) in enumerate(zip(self.headers, self._kinds, strict=True)):
            for fields in _chunks(self._file, header, kinds, size):
                places = _placed(header, fields)
                invalid = [fields[name] != 0 for name in _INVALID if name in fields]
                is_measured = ~np.any(invalid, axis=0) if invalid else np.ones(len(places), np.bool_)
                attributes: dict[str, Array] = {}
                if self._colored:
                    attributes["colors"] = _colors(header, fields, len(places))
                if self._has_normals:
                    normals = np.stack([fields.get(name, np.zeros(len(places))) for name in _NORMAL], axis=1)
                    attributes["normals"] = _turned(header, normals)
                for name, is_whole in self._whole.items():
                    column = fields.get(name, np.zeros(len(places)))
                    key = name.replace(":", "_")
                    attributes[f"{key}_" if key in VERTEX_ATTRIBUTES else key] = column.astype(np.int32) if is_whole else column
                if len(self.headers) > 1:
                    attributes[_SCAN] = np.full(len(places), number, np.int32)
                yield places[is_measured], {name: values[is_measured] for name, values in attributes.items()}


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


def _kinds(header: Any) -> dict[str, bool]:
    """Returns for each field of a scan, except texts, whether its values are 32-bit integers."""
    from pye57 import libe57

    prototype = libe57.StructureNode(header.points.prototype())
    kinds = {}
    for name in header.point_fields:
        node = prototype.get(name)
        if node.type() == libe57.NodeType.E57_INTEGER:
            number, limits = libe57.IntegerNode(node), np.iinfo(np.int32)
            kinds[name] = limits.min <= number.minimum() and number.maximum() <= limits.max
        elif node.type() != libe57.NodeType.E57_STRING:
            kinds[name] = False
    return kinds


def _chunks(file: Any, header: Any, names: Iterable[str], size: int | None) -> Iterator[dict[str, Array]]:
    from pye57 import libe57

    count = int(header.point_count)
    rows = count if size is None else min(size, count)
    columns = {name: np.zeros(rows) for name in names}
    buffers = libe57.VectorSourceDestBuffer()
    for name, column in columns.items():
        buffers.append(libe57.SourceDestBuffer(file.image_file, name, column, rows, True, True))
    reader, done = header.points.reader(buffers), 0
    try:
        while read := int(reader.read()):
            done += read
            yield {name: column[:read].copy() for name, column in columns.items()}
    finally:
        reader.close()
    if done < count:
        raise ContentsError(f"one of its scans ends after {done:,} of its {count:,} points")


def _placed(header: Any, fields: dict[str, Array]) -> Floats:
    if set(_PLACE) <= fields.keys():
        places = np.stack([fields[name] for name in _PLACE], axis=1)
    elif set(_SPHERE) <= fields.keys():
        distance, azimuth, elevation = (fields[name] for name in _SPHERE)
        flat = distance * np.cos(elevation)
        places = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)], axis=1)
    else:
        raise ContentsError(f"one of its scans has points without coordinates; their fields are {', '.join(fields)}")
    return _turned(header, places) + (np.asarray(header.translation) if header.has_pose() else 0.0)


def _turned(header: Any, vectors: Floats) -> Floats:
    return vectors @ np.asarray(header.rotation_matrix).T if header.has_pose() else vectors


def _colors(header: Any, fields: dict[str, Array], count: int) -> NDArray[np.uint8]:
    """Returns (n, 4) 8-bit colours, scaled from the scan's limits, else from 0 to 255 or, if wider, 65535; white without any."""
    from pye57 import libe57

    levels = np.full((count, 4), 255, np.uint8)
    for k, name in enumerate(_COLOR if set(_COLOR) <= fields.keys() else ()):
        field = libe57.StructureNode(header.points.prototype()).get(name)
        is_deep = field.type() == libe57.NodeType.E57_INTEGER and libe57.IntegerNode(field).maximum() > 255
        least, most = 0.0, 65535.0 if is_deep else 255.0
        if all(header.node.isDefined(f"colorLimits/{name}{end}") for end in ("Minimum", "Maximum")):
            least, most = (float(header.node["colorLimits"][f"{name}{end}"].value()) for end in ("Minimum", "Maximum"))
        levels[:, k] = np.clip(np.rint((fields[name] - least) * (255.0 / (most - least or 1.0))), 0, 255)
    return levels


def _extras(file: Any, headers: list[Any]) -> list[str]:
    root = file.image_file.root()
    poses = sum(bool(header.has_pose()) for header in headers)
    extras = [f"the scanner's positions ({poses:,})"] if poses else []
    if root.isDefined("coordinateMetadata") and root["coordinateMetadata"].value().strip():
        extras.append("its coordinate reference system")
    if root.isDefined("images2D") and (pictures := root["images2D"].childCount()):
        extras.append(f"its pictures ({pictures:,})")
    return extras
