"""Reads and writes files by slices: binary PLY, and clouds in LAS and LAZ with all dimensions, scales and offsets. Reads E57."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..files.e57 import doubts_of, e57_pieces, e57_survey
from ..files.errors import ContentsError
from ..files.formats import extension
from ..files.las import NORMAL, chunks, header_of, is_declared, las_unit, opened, write_las_pieces
from ..files.outputs import without_extras
from ..files.ply import CORNERS, PLACE, SCALAR
from ..files.ply_tables import KINDS, PlyElement, PlyHeader, PlyProperty, header_bytes, read_header, row_type, row_type_at
from ..files.ply_write import write_ply
from ..files.writing import to_disk
from .cells import Ranges, Results

#: formats of clouds that tiles can read and write
CLOUD_FORMATS = ("ply", "las", "laz")
#: for each slice of a cloud: the mask of its points to keep, and by column name, new values for all points of the slice
Marks: TypeAlias = Iterable[tuple[NDArray[np.bool_], dict[str, NDArray[np.float64]]]]


@dataclass(frozen=True)
class SlicedTable:
    """The rows of one element of a PLY file, all of the same size."""

    path: Path
    element: PlyElement  # its declaration in the header
    dtype: np.dtype[Any]  # the type of a row
    offset: int  # the position of its first row in the file, in bytes

    def read(self, first: int, last: int) -> NDArray[Any]:
        rows = np.fromfile(self.path, self.dtype, last - first, offset=self.offset + first * self.dtype.itemsize)
        if len(rows) < last - first:
            raise ContentsError(f"it ends within its element {self.element.name!r}")
        for p in self.element.properties:
            if p.count_type is not None:
                length = self.dtype[p.name].shape[0]
                wrong = rows[f"{p.name} count"] != length
                if wrong.any():
                    raise ContentsError(
                        f"the list {p.name!r} of its {self.element.name} {first + int(wrong.argmax()) + 1:,} has another length "
                        f"than {length}; by tiles, all faces must be triangles: triangulate the mesh, or drop --tiles"
                    )
        return rows

    def slices(self, size: int) -> Iterator[NDArray[Any]]:
        for first in range(0, self.element.count, size):
            yield self.read(first, min(first + size, self.element.count))


@dataclass(frozen=True)
class PlyFile:
    """A binary PLY file in which all rows of an element have the same size; reading other files raises `ContentsError`."""

    path: Path
    is_converted: bool = False  # from another format: new properties then follow x, y and z, as in a run in one piece
    unit = None
    names: ClassVar[Mapping[str, tuple[str, ...]]] = {"normals": ("nx", "ny", "nz"), "scalars": (SCALAR,)}  # see `LasCloud`

    @cached_property
    def header(self) -> PlyHeader:
        header = read_header(self.path)
        if header.format == "ascii":
            raise ContentsError("it is a text file; by tiles a PLY file must be binary")
        return replace(header, text=header.text.partition(b"element")[0] + b"end_header\n") if self.is_converted else header

    @cached_property
    def tables(self) -> dict[str, SlicedTable]:
        tables, offset, data = {}, self.header.size, np.asarray(np.memmap(self.path, np.uint8, "r"))
        for element in self.header.elements:
            dtype = row_type_at(data, offset, element, self.header.byte_order)
            tables[element.name] = SlicedTable(self.path, element, dtype, offset)
            offset += element.count * dtype.itemsize
        if len(data) < offset:
            raise ContentsError(f"it has {len(data):,} bytes, of the {offset:,} that its header declares")
        return tables

    @cached_property
    def vertices(self) -> SlicedTable:
        table = self.tables.get("vertex")
        if table is None or not set(PLACE) <= {p.name for p in table.element.properties} or not table.element.count:
            raise ContentsError("it has no vertices with x, y and z")
        if any(p.count_type is not None for p in table.element.properties):
            raise ContentsError("its vertices have lists; by tiles they must have single numbers")
        return table

    @property
    def row(self) -> int:
        """Returns the size of a vertex in bytes."""
        return self.vertices.dtype.itemsize

    def __len__(self) -> int:
        return self.vertices.element.count

    def has(self, values: str) -> bool:
        """Returns whether the vertices have these values, a key of `names`."""
        return set(self.names[values]) <= {p.name for p in self.vertices.element.properties}

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """Yields (m, 3) coordinates of the vertices, `size` at a time."""
        for rows in self.vertices.slices(size):
            yield np.stack([rows[axis].astype(np.float64) for axis in PLACE], axis=1)

    def check_others(self, names: Sequence[str], words: str) -> None:
        """Refuses elements with other names; `words` end the message."""
        others = [e for e in self.header.elements if e.name not in names and e.count]
        if others:
            raise ContentsError(f"it has {others[0].count:,} rows of element {others[0].name!r}; {words}")

    def write(self, target: Path, count: int, marks: Marks, size: int, *, added: tuple[str, ...]) -> None:
        """Writes the `count` vertices that `marks` keep; properties in `added` get new values, and integer ones become double."""
        whole = [p for p in self.vertices.element.properties if p.name in added and KINDS[p.type][0] != "f"]
        old = [replace(p, type="double") if p in whole else p for p in self.vertices.element.properties]
        new = [PlyProperty(name, "double") for name in added if name not in (self.vertices.dtype.names or ())]
        place = len(PLACE) if self.is_converted else len(old)
        element = PlyElement("vertex", count, (*old[:place], *new, *old[place:]))
        columns = (
            {p.name: rows[p.name][kept] for p in old} | {name: numbers[kept] for name, numbers in values.items()}
            for rows, (kept, values) in zip(self.vertices.slices(size), marks, strict=True)
        )
        self.rewrite(target, [element], columns, size)

    def rewrite(
        self, target: Path, elements: Sequence[PlyElement], vertices: Iterable[Mapping[str, NDArray[Any]]], size: int
    ) -> None:
        """Writes the file with new declarations of its elements and new columns of vertices, given by slices; keeps the rest."""
        with target.open("wb") as file:
            file.write(header_bytes(self.header, elements))
            for element in elements:
                if element.name != "vertex":
                    file.writelines(rows.tobytes() for rows in self.tables[element.name].slices(size))
                    continue
                kind = row_type(element, self.header.byte_order, {})
                for columns in vertices:
                    new = np.empty(len(columns["x"]), kind)
                    for name, values in columns.items():
                        new[name] = values
                    file.write(new.tobytes())
            to_disk(file)


class MeshFile(PlyFile):
    """A binary PLY file of triangles."""

    @cached_property
    def faces_table(self) -> SlicedTable:
        self.vertices  # noqa: B018 - checks the vertices
        table = self.tables.get("face")
        if table is None or not table.element.count or not _lists_of_corners(table):
            raise ContentsError("it has no faces; by tiles, vertices are moved only in triangle meshes")
        corners = table.dtype[_lists_of_corners(table)[0]].shape[0]
        if corners != 3:
            raise ContentsError(f"its first face has {corners} corners; by tiles, all faces must be triangles")
        self.check_others(("vertex", "face"), "by tiles, a mesh may have only vertices and faces")
        return table

    def faces(self, size: int) -> Iterator[NDArray[Any]]:
        """Yields (m, 3) vertex indices, `size` faces at a time."""
        name = _lists_of_corners(self.faces_table)[0]
        for rows in self.faces_table.slices(size):
            yield rows[name].astype(np.int64)

    def write_points(self, results: Results, tiles: Ranges, target: Path, size: int) -> None:
        """Writes the mesh with new coordinates in double precision, and with the normals of the results where they are not NaN.

        If no vertex has moved, all normals stay, as in one piece.
        """
        names = (*PLACE, *self.names["normals"])[: results.values.width]
        properties = self.vertices.element.properties
        other = tuple(replace(p, type="double") if p.name in PLACE else p for p in properties)
        elements = [replace(e, properties=other) if e.name == "vertex" else e for e in self.header.elements]
        points_and_results = zip(self.points(size), results.in_order(tiles, size), strict=True)
        moved = any((points != block[:, :3]).any() for points, block in points_and_results)
        vertices = (
            {p.name: rows[p.name] for p in properties}
            | {n: np.where(np.isnan(new) | (not moved), rows[n], new) for n, new in zip(names, block.T, strict=True)}
            for rows, block in zip(self.vertices.slices(size), results.in_order(tiles, size), strict=True)
        )
        self.rewrite(target, elements, vertices, size)


def _lists_of_corners(table: SlicedTable) -> list[str]:
    return [p.name for p in table.element.properties if p.name in CORNERS and p.count_type]


@dataclass(frozen=True)
class LasCloud:
    """The points of a LAS or LAZ file; reading raises `ContentsError` if the file contradicts its header."""

    path: Path
    #: the dimensions that store new values: outlier probabilities and normals
    names: ClassVar[Mapping[str, tuple[str, ...]]] = {"scalars": ("scalars",), "normals": NORMAL}

    @property
    def row(self) -> int:
        with opened(self.path) as reader:
            return int(reader.header.point_format.size)

    def __len__(self) -> int:
        with opened(self.path) as reader:
            return int(reader.header.point_count)

    @property
    def unit(self) -> str | None:
        """Returns the unit of the coordinate reference system; None without one."""
        with opened(self.path) as reader:
            return las_unit(reader.header, reader.evlrs)

    def has(self, values: str) -> bool:
        with opened(self.path) as reader:
            return set(self.names[values]) <= set(reader.header.point_format.dimension_names)

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        with opened(self.path) as reader:
            for chunk in chunks(reader, size):
                yield np.stack([np.asarray(chunk[axis], dtype=np.float64) for axis in "xyz"], axis=1)

    def write(self, target: Path, count: int, marks: Marks, size: int, *, added: tuple[str, ...]) -> None:
        """Writes to another file the `count` points that `marks` keep, with new values of the dimensions in `added`."""
        import laspy

        with opened(self.path) as reader:
            header, records = header_of(reader.header, reader.evlrs)
        for name in added:
            if not is_declared(header, name, np.array([1 / 3])):  # it also removes a dimension `name` that holds integers
                header.add_extra_dim(laspy.ExtraBytesParams(name, "float64"))
        with opened(self.path) as reader, target.open("wb") as file:
            with laspy.open(file, "w", header=header, closefd=False, do_compress=target.suffix.lower() == ".laz") as writer:
                for chunk, (kept, values) in zip(chunks(reader, size), marks, strict=True):
                    points = laspy.ScaleAwarePointRecord.zeros(int(kept.sum()), header=header)
                    for name in set(chunk.array.dtype.names) - set(added):
                        points.array[name] = chunk.array[name][kept]
                    for name, numbers in values.items():
                        points[name] = numbers[kept]
                    writer.write_points(points)
                if records:
                    writer.write_evlrs(records)
            to_disk(file)


#: a cloud in a file that can be read by slices
Source: TypeAlias = LasCloud | PlyFile


@dataclass(frozen=True)
class E57Cloud:
    """The points of an E57 file, which is first rewritten in the format of the output, PLY or LAS."""

    path: Path
    unit = "m"

    @property
    def row(self) -> int:
        """Returns roughly how many bytes a point takes in the rewritten file and the output together."""
        attributes = next(e57_pieces(self.path, 1000)).vertex_attributes.values()
        return 2 * (24 + sum(values.itemsize * math.prod(values.shape[1:]) for values in attributes))

    def __len__(self) -> int:
        return e57_survey(self.path)[0]

    def rewrite(self, target: Path, size: int, output: Path) -> list[str]:
        """Writes a .ply or .las file uncompressed, `size` points at a time; returns warnings for the run that writes `output`."""
        notes: tuple[str, ...] = ()
        with target.open("wb") as file:
            if extension(target) == "las":
                notes = write_las_pieces(lambda: e57_pieces(self.path, size), file)
            else:
                self._write_ply(file, size)
        declared, doubts, extras = e57_survey(self.path)
        doubts = (*doubts_of(declared - len(open_cloud(target))), *doubts)
        lost = [without_extras(output, self.path, extras)] if extras else []
        return [*(f"{self.path.name}: {doubt}" for doubt in doubts), *lost, *(f"{output.name}: {note}" for note in notes)]

    def _write_ply(self, file: BinaryIO, size: int) -> None:
        count, count_line = 0, b"element vertex %020d\n"  # of fixed width, so that the final count can overwrite it
        for piece in e57_pieces(self.path, size):
            written = BytesIO()
            write_ply(piece, written)
            header, end, rows = written.getvalue().partition(b"end_header\n")
            if not file.tell():
                header = header.replace(b"element vertex %d\n" % len(piece.vertices), count_line % 0)
                offset = header.index(count_line % 0)
                file.write(header + end)
            file.write(rows)
            count += len(piece.vertices)
        file.seek(offset)
        file.write(count_line % count)


def open_cloud(path: Path) -> Source | E57Cloud:
    """Opens the cloud in a file; raises `ContentsError` if it has no point or has faces, or cannot be read by slices."""
    kinds: dict[str, type[Source | E57Cloud]] = {"e57": E57Cloud, "ply": PlyFile}
    cloud = kinds.get(extension(path), LasCloud)(path)
    if not len(cloud):
        raise ContentsError("no vertex could be read from it")
    if isinstance(cloud, PlyFile):
        cloud.check_others(("vertex",), "by tiles, the recipe takes only clouds")
    return cloud
