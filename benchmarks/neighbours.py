"""The nearest neighbours of all points, by our k-d tree, scipy's and pykdtree's: the source of a table in docs/solvers.md.

    python benchmarks/neighbours.py [--points N] [--neighbors K] [--rounds N]

Seconds of processor time on all cores, the least of the rounds, from an array of points to k neighbours of each. The points are
those of benchmarks/outliers.py in random order. Then points of a regular lattice in two orders show whether the neighbours of a
point depend on the order where distances are equal. Ends with 1 if a library is faster, or if our neighbours depend on the order
in another way than by the index.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from outliers import scanned_torus
from scipy.spatial import cKDTree

from pymeshfair.filters.neighbours import nearest_neighbours

Points = NDArray[np.float64]
Indices = NDArray[np.int64]


def by_us(points: Points, k: int) -> Indices:
    """Ours, which leaves the point itself out."""
    return nearest_neighbours(points, k)[1].astype(np.int64)


def by_scipy(points: Points, k: int) -> Indices:
    """Scipy's, on all cores, with the point itself dropped."""
    return np.asarray(cKDTree(points).query(points, k + 1, workers=-1)[1][:, 1:], dtype=np.int64)


def by_pykdtree(points: Points, k: int) -> Indices:
    """Pykdtree's, on all cores, with the point itself dropped."""
    from pykdtree.kdtree import KDTree

    return np.asarray(KDTree(points).query(points, k=k + 1)[1][:, 1:], dtype=np.int64)


WAYS: dict[str, Callable[[Points, int], Indices]] = {"ours": by_us, "scipy": by_scipy, "pykdtree": by_pykdtree}


def ties_by_index(way: Callable[[Points, int], Indices]) -> float:
    """The share of the points of a lattice whose neighbours are the nearest by distance, then by index."""
    lattice = np.stack(np.meshgrid(*[np.arange(12.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    lattice = np.random.default_rng(0).permutation(lattice)
    squared = ((lattice[:, None] - lattice) ** 2).sum(axis=2)
    np.fill_diagonal(squared, np.inf)
    expected = np.argsort(squared, axis=1, kind="stable")[:, :10]
    return float((way(lattice, 10) == expected).all(axis=1).mean())


def main() -> int:
    """Prints a line for each; 1 if ours is not the fastest or does not order ties."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--neighbors", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    points = np.random.default_rng(1).permutation(scanned_torus(options.points))
    by_us(points[: 50 * options.neighbors], options.neighbors)  # compiles
    taken: dict[str, list[float]] = {name: [] for name in WAYS}
    for _ in range(options.rounds):
        for name, way in WAYS.items():
            start = time.process_time()
            way(points, options.neighbors)
            taken[name].append(time.process_time() - start)
    print(f"{len(points):,} points, {options.neighbors} neighbours")
    for name, way in WAYS.items():
        ratio = min(taken[name]) / min(taken["ours"])
        print(
            f"  {name:<9}{min(taken[name]):7.2f} s  {ratio:.2f} times ours; ties by index at {ties_by_index(way):.0%} of points"
        )
    return int(min(map(min, taken.values())) < min(taken["ours"]) or ties_by_index(by_us) < 1.0)


if __name__ == "__main__":
    sys.exit(main())
