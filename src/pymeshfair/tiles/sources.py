"""Clouds in files, by slices: PLY; LAS and LAZ, where every dimension of a point, scales and offsets stay as they are."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..files.e57 import doubts_of, e57_pieces, e57_survey
from ..files.errors import ContentsError
from ..files.formats import extension
from ..files.las import chunks, header_of, opened, write_las_pieces
from ..files.ply import SCALAR
from ..files.ply_header import PlyElement, PlyProperty, header_bytes
from ..files.ply_write import write_ply
from ..mesh_data import MeshData
from .ply_slices import PlySlices

#: a dimension of its own for the probability
_SCALAR = "outlier_probability"


@dataclass(frozen=True)
class LasCloud:
    """The points of a LAS or LAZ file; see `pymeshfair.tiles.sources.Source`."""

    path: Path

    @property
    def row(self) -> int:
        """See `Source`."""
        with opened(self.path) as reader:
            return int(reader.header.point_format.size)

    def __len__(self) -> int:
        with opened(self.path) as reader:
            return int(reader.header.point_count)

    def _chunks(self, size: int) -> Iterator[Any]:
        with opened(self.path) as reader:
            yield from chunks(reader, size)

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """See `Source`."""
        for chunk in self._chunks(size):
            yield np.stack([np.asarray(chunk[axis], dtype=np.float64) for axis in "xyz"], axis=1)

    def write(
        self,
        target: Path,
        count: int,
        marks: Iterable[tuple[NDArray[np.bool_], NDArray[np.float64] | None]],
        size: int,
        *,
        scalars: bool,
    ) -> None:
        """See `Source`; the probability becomes a dimension of its own."""
        import laspy

        with opened(self.path) as reader:
            header, records = header_of(reader.header, reader.evlrs)
        if scalars and _SCALAR not in header.point_format.dimension_names:
            header.add_extra_dim(laspy.ExtraBytesParams(_SCALAR, "float64"))
        with target.open("wb") as file:
            with laspy.open(file, "w", header=header, closefd=False, do_compress=target.suffix.lower() == ".laz") as writer:
                for chunk, (left, values) in zip(self._chunks(size), marks, strict=True):
                    made = laspy.ScaleAwarePointRecord.zeros(int(left.sum()), header=header)
                    for name in chunk.array.dtype.names:
                        made.array[name] = chunk.array[name][left]
                    if values is not None:
                        made.array[_SCALAR] = values[left]
                    writer.write_points(made)
                if records:
                    writer.write_evlrs(records)
            file.flush()
            os.fsync(file.fileno())


#: the line of a header that says how many points there are, when that is known at last
_COUNT = b"element vertex %020d\n"
#: what can be read and written as a cloud by tiles
CLOUD_FORMATS = ("ply", "las", "laz")
#: for every slice of a cloud which points are kept, and their scalars if there are any
Marks: TypeAlias = Iterable[tuple[NDArray[np.bool_], "NDArray[np.float64] | None"]]


class Source(Protocol):
    """A cloud in a file.

    Whatever is read raises `ContentsError` where it does not fit.
    """

    @property
    def row(self) -> int:
        """Bytes of a point in memory."""

    def __len__(self) -> int:
        """How many points it has."""

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """(m, 3) coordinates, so many at a time."""

    def write(self, target: Path, count: int, marks: Marks, size: int, *, scalars: bool) -> None:
        """Write some of the points to another file, as they are, and a scalar of each if there are any.

        Args:
            target: the file.
            count: how many points are to be written.
            marks: for every slice of `size` points which of them, and their scalars.
            size: of the slices.
            scalars: whether there are any.
        """


class PlyCloud(PlySlices):
    """The vertices of a binary PLY file without faces."""

    @property
    def row(self) -> int:
        """See `Source`."""
        return self.vertices.dtype.itemsize

    def check(self) -> None:
        """Refuse what holds more than points.

        Raises:
            ContentsError: it does.
        """
        self.vertices  # noqa: B018 - is checked
        others = [e for e in self.header.elements if e.name != "vertex" and e.count]
        if others:
            raise ContentsError(f"it has {others[0].count:,} of {others[0].name!r}; by tiles outliers are found in clouds alone")

    def write(self, target: Path, count: int, marks: Marks, size: int, *, scalars: bool) -> None:
        """See `Source`."""
        kept = tuple(p for p in self.vertices.element.properties if p.name != SCALAR or not scalars)
        more = (PlyProperty(SCALAR, "double"),) if scalars else ()
        element = PlyElement("vertex", count, (*kept, *more))
        with target.open("wb") as file:
            file.write(header_bytes(self.header, (element,)))
            names = [p.name for p in kept]
            order = self.vertices.dtype["x"].byteorder
            added = [(p.name, ">f8" if order == ">" else "<f8") for p in more]
            made = np.dtype([*((n, self.vertices.dtype[n]) for n in names), *added])
            for rows, (left, values) in zip(self.rows(size), marks, strict=True):
                new = np.empty(int(left.sum()), made)
                for name in names:
                    new[name] = rows[name][left]
                if values is not None:
                    new[SCALAR] = values[left]
                file.write(new.tobytes())
            file.flush()
            os.fsync(file.fileno())


@dataclass(frozen=True)
class E57Cloud:
    """The points of an E57 file, which becomes a PLY or LAS file first, whichever the output is."""

    path: Path

    @property
    def row(self) -> int:
        """Bytes of a point of that file, and of the output."""
        return 2 * (24 + sum(values.itemsize * values.size // len(values) for values in self._first().vertex_attributes.values()))

    def __len__(self) -> int:
        return e57_survey(self.path)[0]

    def _first(self) -> MeshData:
        return next(e57_pieces(self.path, 1000))

    def rewrite(self, target: Path, size: int) -> tuple[str, ...]:
        """Write a file without compression, so many points at a time, with what `run` gives them; what to know about it.

        Args:
            target: with the extension "ply" or "las".
            size: points that are read at a time.
        """
        with target.open("wb") as file:
            if extension(target) == "las":
                notes = write_las_pieces(lambda: e57_pieces(self.path, size), file)
            else:
                notes = self._write_ply(file, size)
        declared, doubts = e57_survey(self.path)
        return (*doubts_of(declared - len(file_cloud(target))), *doubts, *notes)

    def _write_ply(self, file: BinaryIO, size: int) -> tuple[str, ...]:
        count, place = 0, 0
        for piece in e57_pieces(self.path, size):
            written = BytesIO()
            write_ply(piece, written)
            header, end, rows = written.getvalue().partition(b"end_header\n")
            if not place:
                before, _, after = header.partition(b"element vertex %d\n" % len(piece.vertices))
                file.write(before)
                place = file.tell()
                file.write(_COUNT % 0 + after + end)
            file.write(rows)
            count += len(piece.vertices)
        file.seek(place)
        file.write(_COUNT % count)
        return ()


def open_cloud(path: Path) -> Source | E57Cloud:
    """The cloud in a file.

    Raises:
        ContentsError: it cannot be read by slices.
    """
    if extension(path) == "e57":
        e57 = E57Cloud(path)
        len(e57)  # it can be opened
        return e57
    return file_cloud(path)


def file_cloud(path: Path) -> Source:
    """The cloud in a file that is read by slices as it is; raises as `open_cloud`."""
    if extension(path) == "ply":
        cloud = PlyCloud(path)
        cloud.check()
        return cloud
    las = LasCloud(path)
    len(las)  # it can be opened
    return las
