"""A low pass without eigenvectors: against the eigenvectors that it saves, and on a large mesh.

    python benchmarks/spectral_filters.py [VERTICES] [--large VERTICES] [--modes 100] [--rounds N] [--rational]

The meshes are those of benchmarks/diffusion.py. On the first (100,000 vertices by default) the low pass whose cutoff is the
frequency of mode --modes by Weyl's law is timed in turn with the computation of that many modes, in one process. On the second
(1,000,000) it is run in a process of its own, at the same cutoff, and its peak of memory measured. --rational times that route as
well. Ends with 1 if the low pass is not 4 times as fast as the modes, or takes 60 s or 2 GB on the large mesh.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import resource
import statistics
import sys
import time
from unittest import mock

from diffusion import make_mesh

from pymeshfair.filters.spectral import eigenvector_free
from pymeshfair.filters.spectral.eigenpairs import lowest_eigenpairs
from pymeshfair.filters.spectral.eigenvector_free import Filtered, filter_without_eigenvectors
from pymeshfair.filters.spectral.problem import Response, SpectralProblem, low_pass, spectral_problem

FASTER, SECONDS, GIGABYTES = 4.0, 60.0, 2.0


def at_mode(problem: SpectralProblem, modes: int) -> Response:
    """The low pass that halves the mode of that number by Weyl's law, kappa = 4 pi modes / area."""
    return low_pass(math.sqrt(math.pi * float(problem.mass.sum()) / modes))


def compare(n_vertices: int, modes: int, rounds: int, rational: bool) -> bool:
    """Times the low pass and the modes in turn; whether the former is fast enough."""
    vertices, faces = make_mesh(n_vertices, "loop")
    problem = spectral_problem(vertices, faces)
    response = at_mode(problem, modes)
    points = vertices[problem.vertices]

    def without() -> tuple[float, Filtered]:
        start = time.perf_counter()
        filtered = filter_without_eigenvectors(problem, points, response)
        return time.perf_counter() - start, filtered

    small = spectral_problem(*make_mesh(2000, "loop"))
    filter_without_eigenvectors(small, small.mass, response)
    lowest_eigenpairs(small, 20)
    quick, slow = [], []
    print(f"{len(vertices):,} vertices, medians of {rounds}")
    for _ in range(rounds):
        taken, filtered = without()
        quick.append(taken)
        start = time.perf_counter()
        lowest_eigenpairs(problem, modes)
        slow.append(time.perf_counter() - start)
    print(f"  low pass          {statistics.median(quick):8.2f} s  {filtered.route} of degree {filtered.degree}")
    print(f"  {modes} modes         {statistics.median(slow):8.2f} s")
    if rational:
        with mock.patch.object(eigenvector_free, "MOST_PRODUCTS", 0):
            taken, filtered = without()
        print(f"  low pass          {taken:8.2f} s  {filtered.route} of degree {filtered.degree}")
    ratio = statistics.median(slow) / statistics.median(quick)
    print(f"  {ratio:.1f} times as fast; at least {FASTER:g} wanted")
    return ratio >= FASTER


def large(n_vertices: int, modes: int) -> bool:
    """Times one low pass from vertices and faces to new vertices; whether time and memory suffice."""
    vertices, faces = make_mesh(n_vertices, "loop")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
    start = time.perf_counter()
    problem = spectral_problem(vertices, faces)
    filtered = filter_without_eigenvectors(problem, vertices[problem.vertices], at_mode(problem, modes))
    taken = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
    print(
        f"{len(vertices):,} vertices: {taken:.1f} s, {peak:.2f} GB at most ({before:.2f} for making the mesh); "
        f"{filtered.route} of degree {filtered.degree}"
    )
    return taken < SECONDS and peak < GIGABYTES


def _large_in_child(n_vertices: int, modes: int) -> None:
    sys.exit(0 if large(n_vertices, modes) else 1)


def main() -> int:
    """Runs both parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("vertices", nargs="?", type=int, default=100_000)
    parser.add_argument("--large", type=int, default=1_000_000, help="0 to leave it out")
    parser.add_argument("--modes", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--rational", action="store_true")
    given = parser.parse_args()
    good = compare(given.vertices, given.modes, given.rounds, given.rational) if given.vertices else True
    if given.large:
        child = multiprocessing.get_context("spawn").Process(target=_large_in_child, args=(given.large, given.modes))
        child.start()
        child.join()
        good = child.exitcode == 0 and good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
