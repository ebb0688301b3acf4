"""Tiles done in this process, in an order of choice, for the tests."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymeshfair.declaration import Length
from pymeshfair.filters.execution import ignore_progress
from pymeshfair.tiles.plan import DUPLICATES, LOOP, POINT_NORMALS, STRAYS, SURPLUS, PlannedStep
from tests.running.runs import ply_bytes, xyz


class Here:
    """A pool of workers that is this process; each batch of tasks in the order of a seed, some of them twice."""

    def __init__(self, seed: int = 0) -> None:
        self._random = np.random.default_rng(seed)

    def run(self, task: Callable[..., Any], *arguments: Any) -> Any:
        return task(*arguments)

    def map(
        self, task: Callable[..., Any], tasks: Sequence[tuple[Any, ...]], progress: Callable[[float], None] = ignore_progress
    ) -> list[Any]:
        results: dict[int, Any] = {}
        for number in self._random.permutation(len(tasks)).tolist():
            results[number] = task(*tasks[number])
            if task.__name__ in ("find", "mark_later", "link", "join", "connect", "finish", "fit", "orient") and number % 3 == 0:
                task(*tasks[number])  # as after the loss of a worker
        progress(1.0)
        return [results[number] for number in range(len(tasks))]


def loop(step: int, neighbors: int, extent: float, threshold: float) -> PlannedStep:
    """Delete the outliers of LoOP."""
    return PlannedStep(step, LOOP, {"neighbors": neighbors, "extent": extent, "threshold": threshold}, deletes=True)


def strays(step: int, neighbors: int, sparseness: float, smallest_part: int) -> PlannedStep:
    """Delete stray points."""
    values = {"neighbors": neighbors, "sparseness": sparseness, "smallest_part": smallest_part}
    return PlannedStep(step, STRAYS, values, deletes=True)


def surplus(step: int, side: float) -> PlannedStep:
    """Delete all but the first in each cell of a grid."""
    return PlannedStep(step, SURPLUS, {"side": Length(side)}, deletes=True)


def normals(step: int, k: int, iterations: int, view: tuple[float, float, float] | None = None) -> PlannedStep:
    """Give the points normals."""
    values = {"k": k, "smoothiter": iterations, "flipflag": view is not None, "viewpos": view or (0.0, 0.0, 0.0)}
    return PlannedStep(step, POINT_NORMALS, values, deletes=False)


def duplicates(step: int) -> PlannedStep:
    """Delete all but the first of coincident points."""
    return PlannedStep(step, DUPLICATES, {}, deletes=True)


def write_cloud(path: Path, points: NDArray[np.float64]) -> Path:
    """A binary PLY file of points, each with its number."""
    rows = np.empty(len(points), [("place", "<f8", 3), ("number", "<i4")])
    rows["place"], rows["number"] = points, np.arange(len(points))
    lines = ["ply", "format binary_little_endian 1.0", "comment of a scanner", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"] + ["property int number", "end_header", ""]
    path.write_bytes("\n".join(lines).encode() + rows.tobytes())
    return path


def write_mesh(path: Path, vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> Path:
    """A binary PLY file of triangles."""
    path.write_bytes(ply_bytes(xyz(vertices), faces.tolist()))
    return path


def children_of(process: int) -> list[int]:
    """The processes that a process has started, and those that they have."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(words[1]) == process and words[0] != "Z":
            found += [int(path.parent.name), *children_of(int(path.parent.name))]
    return found


def kill(process: int) -> None:
    """As ``kill -9`` does."""
    os.kill(process, signal.SIGKILL)
