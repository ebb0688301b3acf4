"""LAS and LAZ files by slices: every dimension of a point stays as it is, scales and offsets too."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.las import chunks, header_of, opened

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
