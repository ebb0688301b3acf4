"""The lowest modes of a mesh, by us and by scipy's one-shot shift-invert.

    python benchmarks/spectral.py [--rounds N]

The mesh is that of benchmarks/diffusion.py. Timed in one process, in turn, from the matrices to the modes: 500 modes at 10,000
vertices and 100 modes at 100,000 by `lowest_eigenpairs` and by `scipy.sparse.linalg.eigsh` with sigma just below 0 and everything
else at its default; medians. Ends with 1 unless ours is 4 times as fast at 10,000 vertices and at least as fast at 100,000, with
the same eigenvalues and all residuals below 1e-8.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
from diffusion import make_mesh
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import eigsh

from pymeshfair.filters.spectral.eigenpairs import lowest_eigenpairs
from pymeshfair.filters.spectral.problem import SpectralProblem, spectral_problem

Pairs = tuple[NDArray[np.float64], NDArray[np.float64]]

#: vertices, modes and how many times as fast as one-shot shift-invert we have to be
CASES = ((10_000, 500, 4.0), (100_000, 100, 1.0))
RESIDUAL = 1e-8
AGREEMENT = 1e-7


def by_scipy(problem: SpectralProblem, count: int) -> Pairs:
    """ARPACK with SuperLU's factors of S - sigma M, sigma just below 0."""
    mass = sparse.csc_matrix(sparse.diags_array(problem.mass))
    kappa, modes = eigsh(sparse.csc_matrix(problem.dirichlet), count, mass, sigma=-1e-2 / problem.mass.sum())
    return np.asarray(kappa), np.asarray(modes)


def residual(problem: SpectralProblem, pairs: Pairs) -> float:
    """The largest |S v - kappa M v| in the norm of M^-1 as a share of kappa."""
    kappa, modes = pairs
    rest = (problem.dirichlet @ modes - problem.mass[:, None] * modes * kappa) / np.sqrt(problem.mass)[:, None]
    size = np.sqrt((modes * modes * problem.mass[:, None]).sum(axis=0))
    return float((np.linalg.norm(rest, axis=0) / size / np.maximum(kappa, kappa[1])).max())


def timed(solve: Callable[[SpectralProblem, int], Pairs], problem: SpectralProblem, count: int) -> tuple[float, Pairs]:
    """Seconds, and the modes."""
    start = time.perf_counter()
    pairs = solve(problem, count)
    return time.perf_counter() - start, pairs


def main() -> int:
    """Times all and tells whether the floors hold."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    lowest_eigenpairs(spectral_problem(*make_mesh(2_500, "loop")), 20)  # compiles
    held = True
    for n_vertices, count, floor in CASES:
        problem = spectral_problem(*make_mesh(n_vertices, "loop"))
        ours, theirs = [], []
        for _ in range(arguments.rounds):
            seconds, pairs = timed(lowest_eigenpairs, problem, count)
            ours.append(seconds)
            seconds, peers = timed(by_scipy, problem, count)
            theirs.append(seconds)
        ratio = statistics.median(theirs) / statistics.median(ours)
        worst = residual(problem, pairs)
        apart = float(np.abs(pairs[0][1:] / peers[0][1:] - 1.0).max())
        print(
            f"{n_vertices:>7} vertices, {count} modes: {statistics.median(ours):.2f} s, eigsh {statistics.median(theirs):.2f} s, "
            f"{ratio:.2f} times as fast; residual {worst:.1e} (eigsh {residual(problem, peers):.1e}), apart {apart:.1e}",
            flush=True,
        )
        held = held and ratio >= floor and worst <= RESIDUAL and apart <= AGREEMENT
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
