"""Coincident points of a cloud by tiles: of the points at one place all but the first go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby

import numpy as np

from ..files.equal_rows import numbered
from .columns import Part
from .division import Bucket
from .workers import Tasks


def coincident(buckets: Sequence[Bucket], tasks: Tasks, progress: Callable[[float], None]) -> tuple[Part, ...]:
    """Of each bucket which points are at the place of one with a smaller number; see `find`."""
    groups = [tuple(group) for _, group in groupby(buckets, lambda bucket: bucket.whole or bucket.path)]
    tasks.map(find, [(group,) for group in groups], progress)
    return tuple(_part(bucket) for bucket in buckets)


def find(buckets: Sequence[Bucket]) -> None:
    """Write down which points are at the place of one before, for buckets that no others share a place with."""
    places = np.empty((0, 3))
    for bucket in buckets:
        here, numbers = bucket.read()
        known, together = len(places), np.concatenate([places, here])
        first, _ = numbered(together)
        later = np.ones(len(here), np.uint8)
        later[first[known:] - known] = 0
        _part(bucket).write(numbers, later)
        places = together[first]


def _part(bucket: Bucket) -> Part:
    return Part(bucket.path.with_name(f"{bucket.path.name}-later"), "u1")
