"""Point clouds in files, by slices: PLY, E57, LAS and LAZ (all dimensions, scales and offsets are kept)."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, ClassVar, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..files.e57 import doubts_of, e57_pieces, e57_survey
from ..files.errors import ContentsError
from ..files.formats import extension
from ..files.las import NORMAL, chunks, header_of, las_unit, opened, write_las_pieces
from ..files.ply import SCALAR
from ..files.ply_header import PlyElement, PlyProperty
from ..files.ply_write import write_ply
from ..files.writing import to_disk
from .ply_slices import PlySlices

#: the header line with the number of points; of fixed width, so that the final number can overwrite it
_COUNT = b"element vertex %020d\n"
#: formats of clouds that tiles can read and write
CLOUD_FORMATS = ("ply", "las", "laz")
#: for every slice of a cloud the points to keep (a mask), and by its name in the file what all its points get
Marks: TypeAlias = Iterable[tuple[NDArray[np.bool_], dict[str, NDArray[np.float64]]]]


class Source(Protocol):
    """A cloud in a file; reading raises `ContentsError` if the file is not as its header declares."""

    names: ClassVar[Mapping[str, tuple[str, ...]]]  # of what points may get: "scalars", which are probabilities, and "normals"

    @property
    def row(self) -> int:
        """Bytes of a point in memory."""

    def __len__(self) -> int:
        """The number of points."""

    @property
    def unit(self) -> str | None:
        """The unit of its coordinates, None if the file says none."""

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """(m, 3) coordinates, `size` points at a time."""

    def write(self, target: Path, count: int, marks: Marks, size: int, *, added: tuple[str, ...]) -> None:
        """Write `count` of the points to another file, unchanged but for what is added."""


@dataclass(frozen=True)
class LasCloud:
    """The points of a LAS or LAZ file; see `pymeshfair.tiles.sources.Source`."""

    path: Path
    names: ClassVar[Mapping[str, tuple[str, ...]]] = {"scalars": ("outlier_probability",), "normals": NORMAL}

    @property
    def row(self) -> int:
        with opened(self.path) as reader:
            return int(reader.header.point_format.size)

    def __len__(self) -> int:
        with opened(self.path) as reader:
            return int(reader.header.point_count)

    @property
    def unit(self) -> str | None:
        """That of its coordinate reference system."""
        return las_unit(self.path)

    def _chunks(self, size: int) -> Iterator[Any]:
        with opened(self.path) as reader:
            yield from chunks(reader, size)

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        for chunk in self._chunks(size):
            yield np.stack([np.asarray(chunk[axis], dtype=np.float64) for axis in "xyz"], axis=1)

    def write(self, target: Path, count: int, marks: Marks, size: int, *, added: tuple[str, ...]) -> None:
        """See `Source`; what is added becomes dimensions of its own."""
        import laspy

        with opened(self.path) as reader:
            header, records = header_of(reader.header, reader.evlrs)
        for name in added:
            if name not in header.point_format.dimension_names:
                header.add_extra_dim(laspy.ExtraBytesParams(name, "float64"))
        with target.open("wb") as file:
            with laspy.open(file, "w", header=header, closefd=False, do_compress=target.suffix.lower() == ".laz") as writer:
                for chunk, (kept, values) in zip(self._chunks(size), marks, strict=True):
                    points = laspy.ScaleAwarePointRecord.zeros(int(kept.sum()), header=header)
                    for name in chunk.array.dtype.names:
                        points.array[name] = chunk.array[name][kept]
                    for name, numbers in values.items():
                        points[name] = numbers[kept]
                    writer.write_points(points)
                if records:
                    writer.write_evlrs(records)
            to_disk(file)


class PlyCloud(PlySlices):
    """The vertices of a binary PLY file without faces."""

    unit = None
    names: ClassVar[Mapping[str, tuple[str, ...]]] = {"scalars": (SCALAR,), "normals": ("nx", "ny", "nz")}

    @property
    def row(self) -> int:
        return self.vertices.dtype.itemsize

    def check(self) -> None:
        """Refuse files with more than vertices."""
        self.vertices  # noqa: B018 - checks them
        others = [e for e in self.header.elements if e.name != "vertex" and e.count]
        if others:
            raise ContentsError(f"it has {others[0].count:,} of {others[0].name!r}; by tiles outliers are found in clouds alone")

    def write(self, target: Path, count: int, marks: Marks, size: int, *, added: tuple[str, ...]) -> None:
        old = tuple(p for p in self.vertices.element.properties if p.name not in added)
        element = PlyElement("vertex", count, (*old, *(PlyProperty(name, "double") for name in added)))
        columns = (
            {p.name: rows[p.name][kept] for p in old} | {name: numbers[kept] for name, numbers in values.items()}
            for rows, (kept, values) in zip(self.vertices.slices(size), marks, strict=True)
        )
        self.rewrite(target, [element], columns, size)


@dataclass(frozen=True)
class E57Cloud:
    """The points of an E57 file, which becomes a PLY or LAS file first, whichever the output is."""

    path: Path
    unit = "m"

    @property
    def row(self) -> int:
        """Bytes of a point of that file, and of the output."""
        attributes = next(e57_pieces(self.path, 1000)).vertex_attributes.values()
        return 2 * (24 + sum(values.itemsize * math.prod(values.shape[1:]) for values in attributes))

    def __len__(self) -> int:
        return e57_survey(self.path)[0]

    def rewrite(self, target: Path, size: int) -> tuple[str, ...]:
        """Write a .ply or .las file without compression, with what `run` gives the points, `size` at a time; notes about it."""
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
        ContentsError: it cannot be read by slices, or has no point.
    """
    cloud = E57Cloud(path) if extension(path) == "e57" else file_cloud(path)
    if not len(cloud):  # which raises if it cannot be opened
        raise ContentsError("no vertex could be read from it")
    return cloud


def file_cloud(path: Path) -> Source:
    """The cloud in a file that is read by slices as it is; raises as `open_cloud`."""
    if extension(path) == "ply":
        cloud = PlyCloud(path)
        cloud.check()
        return cloud
    las = LasCloud(path)
    len(las)  # raises if it cannot be opened
    return las
