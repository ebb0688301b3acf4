"""LAS and LAZ files by slices, through laspy: every dimension of a point stays as it is, scales and offsets too."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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

        with _opened(self.path) as reader:
            header = copy.deepcopy(reader.header)
            if scalars and _SCALAR not in header.point_format.dimension_names:
                header.add_extra_dim(laspy.ExtraBytesParams(_SCALAR, "float64"))
            evlrs = reader.evlrs
        with target.open("xb") as file:
            with laspy.open(file, "w", header=header, closefd=False, do_compress=target.suffix.lower() == ".laz") as writer:
                for chunk, (left, values) in zip(self._chunks(size), marks, strict=True):
                    made = laspy.ScaleAwarePointRecord.zeros(int(left.sum()), header=header)
                    for name in chunk.array.dtype.names:
                        made.array[name] = chunk.array[name][left]
                    if values is not None:
                        made.array[_SCALAR] = values[left]
                    writer.write_points(made)
                if evlrs:
                    writer.write_evlrs(evlrs)
            file.flush()
            os.fsync(file.fileno())


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
