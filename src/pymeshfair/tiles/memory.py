"""How much a tile may hold: the model of what a task takes, measured by ``benchmarks/scale.py model``."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import ParameterError

#: bytes of the command, with dask where there is a scheduler, and of a worker with its libraries and compiled kernels
COMMAND, WORKER = 160_000_000, 280_000_000
#: below that, a worker does not get along; it is better to have fewer
LEAST = 60_000_000
#: of what a worker may take, so that the model may be wrong by that
SHARE = 0.85


@dataclass(frozen=True)
class Budget:
    """What there is.

    Attributes:
        workers: processes.
        threads: of each.
        tile: bytes that a tile may take in each.
    """

    workers: int
    threads: int
    tile: int


def budget(memory: int, processors: int) -> Budget:
    """Workers and their shares of some bytes of memory.

    Raises:
        ParameterError: it is too little.
    """
    for workers in range(processors, 0, -1):
        each = (memory - COMMAND) // workers - WORKER
        if each >= LEAST:
            return Budget(workers, max(1, processors // workers), int(SHARE * each))
    least = (COMMAND + WORKER + LEAST) / 1e6
    raise ParameterError(
        f"{memory / 1e6:.0f} MB are too little to work by tiles, of which libraries take most; give {least:.0f}MB"
    )


def cloud_points(tile: int, neighbors: int) -> int:
    """Points of a tile in which LoOP searches for so many neighbours.

    Measured were 209 bytes each for 20 of them; the rest is for those that ask around, which are up to a tenth.
    """
    return max(4 * neighbors, int(tile / (180 + 9 * neighbors)))


def surface_vertices(tile: int, each: int, rings: int) -> int:
    """Vertices of a tile of a mesh, besides those in the rings around it.

    A tile of v vertices has about 4 sqrt(v) in every ring around it.

    Args:
        tile: bytes that it may take.
        each: bytes of a vertex, those of the rings too.
        rings: how many rings there are.
    """
    return max(64, int((math.sqrt(4 * rings * rings + tile / each) - 2 * rings) ** 2))


def slice_rows(tile: int, row: int) -> int:
    """Rows of a file that are in memory at a time."""
    return max(1 << 12, int(tile / (6 * row + 150)))
