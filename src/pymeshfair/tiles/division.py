"""Divides points that do not fit into memory among buckets that do, by place, as the upper levels of a k-d tree would.

Pivots are medians of a sample, so that the division follows the density. A bucket that gets too many points all the same is
divided again; points at one place, which nothing divides, are cut by their number. No result depends on any of that.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled

Floats: TypeAlias = NDArray[np.float64]
Longs: TypeAlias = NDArray[np.int64]
#: gives (n, 3) coordinates and (n,) numbers, a slice at a time; may be called more than once
Slices: TypeAlias = Callable[[], Iterable[tuple[Floats, Longs]]]

#: points of the sample for each bucket, and at most in all
_SAMPLED, _LARGEST_SAMPLE = 4096, 1 << 19
#: buckets that are written at a time, each through a file that is open only to be appended to
MOST_BUCKETS = 512
#: a row of a bucket: the coordinates, and the number
ROW = np.dtype([("place", "<f8", 3), ("number", "<i8")])


@dataclass(frozen=True)
class Bucket:
    """Points that fit into memory, in a file of rows of `ROW`, by ascending number."""

    path: Path  # of the file
    count: int  # points
    whole: Path | None = None  # of a bucket that was cut by number; its parts may share places

    def read(self) -> tuple[Floats, Longs]:
        """The coordinates and the numbers."""
        rows = np.fromfile(self.path, ROW)
        assert len(rows) == self.count, f"{self.path}: {len(rows)} of {self.count} points"
        return np.ascontiguousarray(rows["place"]), np.ascontiguousarray(rows["number"])


def divide(slices: Slices, count: int, folder: Path, *, most: int, name: str = "bucket") -> list[Bucket]:
    """The points, given by ascending number, in buckets of at most `most` each; neighbours in the list are near in space."""
    wanted = min(MOST_BUCKETS, 1 << max(0, int(np.ceil(np.log2(1.15 * count / most)))))
    axes, pivots, leaves = _pivots(_sample(slices, count, wanted), wanted)
    paths = [folder / f"{name}-{leaf}" for leaf in range(leaves)]
    for path in paths:  # of a process that was killed here
        path.unlink(missing_ok=True)
    counts = np.zeros(leaves, np.int64)
    for places, numbers in slices():
        chosen = np.empty(len(places), np.int32)
        _assign(places, axes, pivots, chosen)
        order = np.argsort(chosen, kind="stable")
        rows = np.empty(len(places), ROW)
        rows["place"], rows["number"] = places[order], numbers[order]
        ends = np.cumsum(np.bincount(chosen, minlength=leaves))
        for leaf, (first, last) in enumerate(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True)):
            if last > first:
                with paths[leaf].open("ab") as file:
                    file.write(rows[first:last].tobytes())
        counts += np.bincount(chosen, minlength=leaves)
    buckets: list[Bucket] = []
    for path, held in zip(paths, counts.tolist(), strict=True):
        buckets += _small_enough(Bucket(path, held), folder, most, divisible=leaves > 1)
    return buckets


def _small_enough(bucket: Bucket, folder: Path, most: int, *, divisible: bool) -> list[Bucket]:
    if bucket.count <= most:
        return [bucket] if bucket.count else []

    def slices() -> Iterable[tuple[Floats, Longs]]:
        for first in range(0, bucket.count, most):
            rows = np.fromfile(bucket.path, ROW, most, offset=first * ROW.itemsize)
            yield np.ascontiguousarray(rows["place"]), np.ascontiguousarray(rows["number"])

    if divisible:
        parts = divide(slices, bucket.count, folder, most=most, name=bucket.path.name)
    else:
        parts = []
        for number, (places, numbers) in enumerate(slices()):
            rows = np.empty(len(places), ROW)
            rows["place"], rows["number"] = places, numbers
            parts.append(Bucket(bucket.path.with_name(f"{bucket.path.name}-{number}"), len(rows), bucket.path))
            parts[-1].path.write_bytes(rows.tobytes())
    bucket.path.unlink()
    return parts


def _sample(slices: Slices, count: int, buckets: int) -> Floats:
    """Every so many-th point."""
    step = max(1, count // min(buckets * _SAMPLED, _LARGEST_SAMPLE))
    parts, skipped = [np.empty((0, 3))], 0
    for places, _ in slices():
        parts.append(places[skipped::step].copy())
        skipped = (skipped - len(places)) % step
    return np.concatenate(parts)


def _pivots(sample: Floats, wanted: int) -> tuple[NDArray[np.int32], Floats, int]:
    """A tree of cuts across the longest side: from node i to 2 i where a coordinate is below the pivot, else to 2 i + 1.

    Returns:
        The axis of each node, or minus one minus the number of the leaf that it is; the pivots; the number of leaves.
    """
    axes, pivots = np.zeros(2 * wanted, np.int32), np.zeros(2 * wanted)
    leaves = 0
    stack: list[tuple[int, Floats]] = [(1, sample)]
    while stack:
        node, points = stack.pop()
        axis = int(np.argmax(np.ptp(points, axis=0)))
        values = np.sort(points[:, axis])
        pivot = values[len(values) // 2]
        if pivot == values[0]:  # so many coincide that none is below the median: cut above them
            pivot = values[np.searchsorted(values, pivot, "right") % len(values)]
        if node >= wanted or pivot == values[0]:
            axes[node] = -1 - leaves
            leaves += 1
            continue
        axes[node], pivots[node] = axis, pivot
        below = points[:, axis] < pivot
        stack += [(2 * node + 1, points[~below]), (2 * node, points[below])]
    return axes, pivots, leaves


@compiled
def _assign(places: Any, axes: Any, pivots: Any, chosen: Any) -> None:
    for p in range(places.shape[0]):
        node = 1
        while axes[node] >= 0:
            node = 2 * node if places[p, axes[node]] < pivots[node] else 2 * node + 1
        chosen[p] = -1 - axes[node]
