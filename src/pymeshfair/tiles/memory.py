"""Sizes of tiles by memory, and the disk space of a run: models, measured by ``benchmarks/scale.py``."""

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
    """Workers and their memory."""

    workers: int  # processes
    threads: int  # of each
    tile: int  # bytes that a tile may take in each


def budget(memory: int, processors: int) -> Budget:
    """Workers and their shares of some bytes of memory."""
    for workers in range(processors, 0, -1):
        each = (memory - COMMAND) // workers - WORKER
        if each >= LEAST:
            return Budget(workers, max(1, processors // workers), int(SHARE * each))
    least = (COMMAND + WORKER + LEAST) / 1e6
    raise ParameterError(
        f"{memory / 1e6:.0f} MB are too little to work by tiles, as libraries take most of them; give {least:.0f}MB"
    )


def cloud_points(tile: int, neighbors: int) -> int:
    """Points of a tile in which LoOP searches for so many neighbours.

    Measured were 209 bytes each for 20 of them; the rest is for those that ask around, which are up to a tenth.
    """
    return max(4 * neighbors, int(tile / (180 + 9 * neighbors)))


def points_with_normals(tile: int, neighbors: int) -> int:
    """Points of a tile that get normals from so many neighbours."""
    return max(4 * neighbors, int(tile / (200 + 40 * neighbors)))


def surface_vertices(tile: int, each: int, rings: int) -> int:
    """Vertices of a tile of a mesh, besides those in the rings around it.

    A tile of v vertices has about 4 sqrt(v) in every ring around it.
    """
    return max(64, int((math.sqrt(4 * rings * rings + tile / each) - 2 * rings) ** 2))


def slice_rows(tile: int, row: int) -> int:
    """Rows of a file that are in memory at a time."""
    return max(1 << 12, int(tile / (6 * row + 150)))


def cloud_room(count: int, row: int, loop_neighbors: int, stray_neighbors: int, normal_neighbors: int = 0) -> int:
    """Bytes on the disk of the work on a cloud, the output among them.

    Cells take 32 a point. LoOP adds distances and factors (24), 2 + k for an eighth of the points that look into other tiles, and
    17 for the probability and the choice; stray points add 8 for each link and 53, normals 8 for each link and 113. Measured were
    84 to 87 for LoOP with 20.
    """
    loop = 75 + loop_neighbors if loop_neighbors else 0
    strays = 85 + 8 * stray_neighbors if stray_neighbors else 0
    normals = 145 + 8 * normal_neighbors + (9 if loop else 0) if normal_neighbors else 0
    return count * max(64, loop, strays + (8 if loop else 0), normals, row + 17 + (48 if normals else 0))


def surface_room(vertices: int, faces: int, row: int, *, rounds: bool) -> int:
    """Bytes on the disk of the work on a mesh, the output among them.

    A face takes 20 bytes with each bucket of its corners, as it came and in order: measured were 23 each.
    """
    return max(36 * vertices + 46 * faces, (92 + 48 * rounds + row) * vertices + 23 * faces)
