"""LAS and LAZ files by slices, through laspy: every dimension of a point stays as it is, scales and offsets too."""

from __future__ import annotations

import copy
import io
import os
import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import RunError
from ..files.errors import ContentsError

#: a dimension of its own for the probability
_SCALAR = "outlier_probability"


@dataclass(frozen=True)
class LasCloud:
    """The points of a LAS or LAZ file; see `pymeshfair.tiles.sources.Source`."""

    path: Path

    @property
    def row(self) -> int:
        """See `Source`."""
        with _opened(self.path) as reader:
            return int(reader.header.point_format.size)

    def __len__(self) -> int:
        with _opened(self.path) as reader:
            return int(reader.header.point_count)

    def check(self) -> None:
        """Refuse what could not be written again, by writing it without points into memory.

        Raises:
            ContentsError: it could not, or the file cannot be read.
        """
        with _opened(self.path) as reader:
            if any(record.user_id == "copc" for record in reader.header.vlrs):
                raise ContentsError(
                    "it is a COPC file, whose index cannot be written: make a plain .laz file of it, for example by "
                    "`pdal translate IN.copc.laz OUT.laz`"
                )
        import laspy

        try:
            self._write(io.BytesIO(), iter(()), is_compressed=self.path.suffix.lower() == ".laz")
        except (laspy.errors.LaspyException, NotImplementedError, ValueError, TypeError, struct.error) as error:
            raise ContentsError(f"its head could not be written again; laspy says: {error}") from error

    def _chunks(self, size: int) -> Iterator[Any]:
        with _opened(self.path) as reader:
            declared, read = int(reader.header.point_count), 0
            for chunk in reader.chunk_iterator(size):
                read += len(chunk)
                yield chunk
            if read < declared:
                raise ContentsError(f"it ends after {read:,} of the {declared:,} points of its header")

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """See `Source`."""
        for chunk in self._chunks(size):
            yield np.stack([np.asarray(chunk[axis], dtype=np.float64) for axis in "xyz"], axis=1)

    def write(self, target: Path, count: int, marks: Iterable[tuple[NDArray[np.bool_], NDArray[np.float64]]], size: int) -> None:
        """See `Source`; the probability becomes a dimension of its own."""
        with target.open("xb") as file:
            chunks = zip(self._chunks(size), marks, strict=True)
            self._write(file, chunks, is_compressed=target.suffix.lower() == ".laz")
            file.flush()
            os.fsync(file.fileno())

    def _write(self, file: BinaryIO, chunks: Iterator[tuple[Any, tuple[Any, Any]]], *, is_compressed: bool) -> None:
        import laspy

        with _opened(self.path) as reader:
            header = copy.deepcopy(reader.header)
            if _SCALAR not in header.point_format.dimension_names:
                header.add_extra_dim(laspy.ExtraBytesParams(_SCALAR, "float64"))
            evlrs = reader.evlrs
        with laspy.open(file, "w", header=header, closefd=False, do_compress=is_compressed) as writer:
            for chunk, (left, scalars) in chunks:
                made = laspy.ScaleAwarePointRecord.zeros(int(left.sum()), header=header)
                for name in chunk.array.dtype.names:
                    made.array[name] = chunk.array[name][left]
                made.array[_SCALAR] = scalars[left]
                writer.write_points(made)
            if evlrs:
                writer.write_evlrs(evlrs)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The reader of a file."""
    try:
        import laspy
    except ImportError as error:
        raise RunError(
            "LAS and LAZ files need the package laspy; install pymeshfair with its extra: python -m pip install 'pymeshfair[las]'"
        ) from error
    try:
        with laspy.open(path) as reader:
            yield reader
    except (laspy.errors.LaspyException, ValueError) as error:  # ValueError: a buffer that ends within a point
        raise ContentsError(f"laspy says: {error}") from error
