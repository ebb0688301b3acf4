"""Whether held-out points should choose the neighbours of LoOP.

    python benchmarks/cloud_outliers.py [--half looked_at|unseen]

Surfaces of `cloud_pairs` with noise of 0.1 spacings are littered with outliers that are known: single ones, clumps of 3, 10 and
30, and a haze. Prints for every kind the mean F1 of the points above a probability of 0.5, with 20 neighbours, with those that
are chosen, and with the best of six numbers. Chosen is the number without whose outliers the other points are best predicted: the
clipped error of `scores_of` over all points that any of the numbers calls regular.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np
from cloud_pairs import LOOKED_AT, SURFACES, UNSEEN, Bools, Floats, ball, spacing_of

from pymeshfair.filters.choosing.clouds import CloudSample
from pymeshfair.filters.denoising import normals_of
from pymeshfair.filters.evidence import height_residuals, scores_of
from pymeshfair.filters.neighbours import nearest_neighbours
from pymeshfair.filters.outliers import local_outlier_probability

NEIGHBORS = (10, 14, 20, 28, 40, 56)
FIXED, POINTS, ABOVE = 20, 6000, 0.5
KINDS = ("single", "clumps of 3", "clumps of 10", "clumps of 30", "haze")


def littered(points: Floats, kind: str, rng: np.random.Generator, spacing: float) -> tuple[Floats, Bools]:
    """The points and 2 to 3 % of outliers, and which are these."""
    count = len(points) // 50
    if kind == "haze":
        low, high = points.min(axis=0), points.max(axis=0)
        more = rng.uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (len(points) // 30, 3))
    else:
        size = 1 if kind == "single" else int(kind.split()[-1])
        places = points[rng.integers(len(points), size=count // size)]
        places = places + ball(rng, len(places)) * rng.uniform(2.0, 12.0, (len(places), 1)) * spacing
        more = np.repeat(places, size, axis=0)
        more = more + rng.normal(size=more.shape) * (0.5 * spacing if size > 1 else 0.0)
    return np.concatenate([points, more]), np.arange(len(points) + len(more)) >= len(points)


def f1(selected: Bools, wrong: Bools) -> float:
    """The harmonic mean of precision and recall."""
    both = int(np.count_nonzero(selected)) + int(np.count_nonzero(wrong))
    return 2.0 * int(np.count_nonzero(selected & wrong)) / max(1, both)


def chosen(points: Floats, spacing: float, selections: list[Bools]) -> int:
    """Which of the selections leaves points that are best predicted."""
    local = points / spacing
    normals = normals_of(local, nearest_neighbours(local, FIXED)[1])
    sample = CloudSample(local, np.ones(len(local), dtype=np.bool_), normals)
    deviations = [height_residuals(local, sample.rings, normals, selected) for selected in selections]
    return scores_of(np.array(deviations)[:, ~np.all(selections, axis=0)]).best


def rows(names: tuple[str, ...], kind: str) -> Iterator[tuple[float, float, float]]:
    """F1 with the fixed number, the chosen one and the best, on every surface."""
    for name in names:
        rng = np.random.default_rng([len(name), ord(name[0]), KINDS.index(kind)])
        points = SURFACES[name][0](rng, POINTS)
        spacing = spacing_of(points)
        points, wrong = littered(points + rng.normal(size=points.shape) * 0.1 * spacing, kind, rng, spacing)
        selections = [local_outlier_probability(points, neighbors=k) > ABOVE for k in NEIGHBORS]
        scores = [f1(selected, wrong) for selected in selections]
        yield scores[NEIGHBORS.index(FIXED)], scores[chosen(points, spacing, selections)], max(scores)


def main() -> None:
    """Print a line for each kind of outliers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--half", choices=("looked_at", "unseen"), default="unseen")
    names = tuple(name for name in (LOOKED_AT if parser.parse_args().half == "looked_at" else UNSEEN) if name in SURFACES)
    print("mean F1 of     20 neighbours   chosen   best of six")
    means = []
    for kind in KINDS:
        means.append(np.mean(list(rows(names, kind)), axis=0))
        print("{:<20}{:7.2f}{:9.2f}{:14.2f}".format(kind, *means[-1]))
    print("{:<20}{:7.2f}{:9.2f}{:14.2f}".format("mean", *np.mean(means, axis=0)))


if __name__ == "__main__":
    main()
