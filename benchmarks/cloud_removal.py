"""Far points removed and good points lost: `remove_outliers` against statistical outlier removal.

    python benchmarks/cloud_removal.py [--points 20000]

Surfaces of `cloud_pairs` with noise of 0.1 or 0.5 spacings, 1 % or 5 % of uniform outliers in a box 1.5 times as large, and a
clump of 200 points beside the surface. Far points are outliers over 3 spacings from the surface. Statistical outlier removal
keeps the points whose mean distance to k neighbours is at most mean + m standard deviations of that of all points, as its
three programs define it: CloudCompare k = 6, m = 1; PDAL k = 8, m = 2; Open3D has no default, its tutorial takes k = 20, the
point itself among them, m = 2. "tuned" is the best of k = 6, 8, 12, 20, 30, 50 and m = 0.5, 1, 2, 3, 5 for each case, with
the truth in view: the least sum of both shares.
"""

from __future__ import annotations

import argparse

import numpy as np
from cloud_pairs import SURFACES, Bools, Floats, ball, spacing_of
from scipy.spatial import cKDTree

from pymeshfair.filters.outliers import local_outlier_probability, stray_points

#: by name: noise in spacings, share of outliers, points of the clump
CASES = {
    "noise 0.1": (0.1, 0.01, 0),
    "noise 0.5": (0.5, 0.01, 0),
    "outliers 5 %": (0.1, 0.05, 0),
    "clump of 200": (0.1, 0.01, 200),
    "all three": (0.5, 0.05, 200),
}
#: neighbours and standard deviations of each program
PROGRAMS = {"CloudCompare": (6, 1.0), "PDAL": (8, 2.0), "Open3D": (19, 2.0)}
#: the gyroid takes minutes to be sampled
NAMES = [name for name in SURFACES if name != "gyroid"]
TUNED = [(k, m) for k in (6, 8, 12, 20, 30, 50) for m in (0.5, 1.0, 2.0, 3.0, 5.0)]


def made(name: str, noise: float, share: float, clump: int, count: int) -> tuple[Floats, Bools, Bools]:
    """Points, which are good, and which are far."""
    rng = np.random.default_rng(0)
    points = SURFACES[name][0](rng, count)
    spacing = spacing_of(points)
    truth = cKDTree(SURFACES[name][0](np.random.default_rng(99), 10 * count))
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.75 * float((high - low).max())
    outliers = rng.uniform(middle - half, middle + half, (int(share * count), 3))
    direction = ball(rng, 1)[0]
    direction /= np.linalg.norm(direction)
    more = middle + 0.9 * half * direction + rng.normal(size=(clump, 3)) * 0.03 * half
    every = np.concatenate([points + rng.normal(size=points.shape) * noise * spacing, outliers, more])
    good = np.arange(len(every)) < count
    return every, good, ~good & (truth.query(every)[0] > 3.0 * spacing)


def ours(points: Floats) -> Bools:
    """Which points the recipe `remove_outliers` removes."""
    removed = stray_points(points, neighbors=16, sparseness=1.5, smallest_part=100)
    left = np.flatnonzero(~removed)
    removed[left[local_outlier_probability(points[left], neighbors=20, extent=4.0) > 0.99]] = True
    return removed


def statistical(distances: Floats, k: int, m: float) -> Bools:
    """Which points are removed, by the (n, 50) distances to their neighbours."""
    means = distances[:, :k].mean(axis=1)
    return np.asarray(means > means.mean() + m * means.std())


def main() -> None:
    """A row for each case, with the means over the surfaces."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=20_000)
    count = parser.parse_args().points
    names = ["remove_outliers", *PROGRAMS, "tuned"]
    print("| far points left, % / good points lost, % | " + " | ".join(names) + " |\n|---|" + "---:|" * len(names))
    for case, (noise, share, clump) in CASES.items():
        rows = []
        for name in NAMES:
            points, good, far = made(name, noise, share, clump, count)
            distances = cKDTree(points).query(points, 51)[0][:, 1:]

            def shares(removed: Bools, good: Bools = good, far: Bools = far) -> tuple[float, float]:
                return 100.0 * float((far & ~removed).sum() / far.sum()), 100.0 * float((good & removed).sum() / good.sum())

            programs = [shares(statistical(distances, k, m)) for k, m in PROGRAMS.values()]
            tuned = min((shares(statistical(distances, k, m)) for k, m in TUNED), key=sum)
            rows.append([shares(ours(points)), *programs, tuned])
        means = np.mean(rows, axis=0)
        print(f"| {case} | " + " | ".join(f"{left:.2f} / {lost:.2f}" for left, lost in means) + " |", flush=True)


if __name__ == "__main__":
    main()
