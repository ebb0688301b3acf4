"""LoOP against MeshLab's outlier filter: ``python benchmarks/outliers.py [--points 1000000] [--neighbors 32] [--rounds 5]``.

Both get the same points and compare each with as many others, on all cores, alternately in one process; ours is timed from the
array of points to the array of probabilities. Exits with 1 if the median of ours is slower in either order of the points.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from pymeshfair.filters.outliers.local_outlier_probability import local_outlier_probability

#: ours may not take longer than this share of MeshLab's time
FLOOR = 1.0


def scanned_torus(count: int) -> NDArray[np.float64]:
    """About `count` points of a torus, row by row as a scanner gives them, with noise of 0.15 spacings and 0.1 % stray points."""
    random = np.random.default_rng(0)
    side = round(count**0.5)
    u, v = np.meshgrid(*[np.linspace(0.0, 2.0 * np.pi, side, endpoint=False)] * 2, indexing="ij")
    radius = 1.0 + 0.5 * np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), 0.5 * np.sin(v)], axis=-1).reshape(-1, 3)
    points += random.normal(scale=0.15 * np.pi / side, size=points.shape)
    stray = random.choice(len(points), len(points) // 1000, replace=False)
    points[stray] = random.uniform(-1.5, 1.5, (len(stray), 3))
    return points


def seconds(work: Callable[[], object]) -> float:
    """The wall time of a call."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def compare(points: NDArray[np.float64], neighbors: int, rounds: int) -> tuple[list[float], list[float]]:
    """Seconds of each round of MeshLab and of ours."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))

    def meshlab() -> None:
        meshes.compute_selection_point_cloud_outliers(knearest=neighbors + 1)  # MeshLab counts the point itself

    def ours() -> None:
        local_outlier_probability(points, neighbors=neighbors)

    local_outlier_probability(points[: 50 * neighbors], neighbors=neighbors)  # compiles
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):
        times[0].append(seconds(meshlab))
        times[1].append(seconds(ours))
    return times


def main() -> int:
    """Print a line for each order of the points."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--neighbors", type=int, default=32)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    scan = scanned_torus(options.points)
    print(f"LoOP, {len(scan):,} points, {options.neighbors} neighbours, median seconds of {options.rounds} rounds")
    slower = False
    for order, points in (("random", np.random.default_rng(1).permutation(scan)), ("scan", scan)):
        meshlab, ours = (statistics.median(times) for times in compare(points, options.neighbors, options.rounds))
        slower |= ours > FLOOR * meshlab
        print(f"{order:>6} order: pymeshlab {meshlab:6.2f}   ours {ours:6.2f}   {meshlab / ours:.2f}x as fast")
    return int(slower)


if __name__ == "__main__":
    sys.exit(main())
