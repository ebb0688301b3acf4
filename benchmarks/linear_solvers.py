"""Our sparse solvers against those of scipy and pyamg; the source of the tables in docs/solvers.md.

    python benchmarks/linear_solvers.py [--vertices N] [--rounds N]

Seconds of processor time on one thread, the least of the rounds, set-up + solve for three right-hand sides. First implicit steps
of (c mean edges)^2 for several c, on the mesh of benchmarks/diffusion.py, to an error of 1e-10 in the energy norm: conjugate
gradients by us with the diagonal and with multigrid, by scipy with the diagonal, by pyamg's smoothed aggregation, and Cholesky's
factors. Then, on a subdivided icosahedron, factors of a shifted operator by us and by SuperLU, and solves with them for
eight columns. Ends with 1 if a library is faster than the hand-written part that stands in its place.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pyamg
import trimesh
from diffusion import make_mesh
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import cg, splu
from threadpoolctl import threadpool_limits

from pymeshfair.filters.compilation import set_threads
from pymeshfair.filters.execution import ignore_progress
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.linear_solvers import Cholesky, Fronts, ShiftedFactors, conjugate_gradients, preconditioned_norm
from pymeshfair.filters.linear_solvers.conjugate_gradients import SmoothedAggregation
from pymeshfair.filters.operators import laplace_beltrami

Array = NDArray[np.float64]
#: The error in the energy norm, as a share of the solution's.
TOLERANCE = 1e-10
#: Subdivisions of an icosahedron and the order of SuperLU that is tried there; the first takes quadratic time on it.
ORDERS = ((5, "MMD_AT_PLUS_A"), (6, "COLAMD"))
LENGTHS = (1.0, 3.0, 10.0, 1e4)
#: Iterations after which a method counts as failed.
LIMIT = 3000


def seconds(work: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of a call, and its result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def by_us(matrix: sparse.csr_matrix, b: Array, multigrid: bool) -> tuple[float, float, int]:
    """Set-up, solve and iterations of our conjugate gradients."""
    prepared, cycle = seconds(lambda: SmoothedAggregation(matrix) if multigrid else None)
    target = TOLERANCE * preconditioned_norm(matrix, b, cycle)
    taken, found = seconds(lambda: conjugate_gradients(matrix, b, target=target, max_iterations=LIMIT, precondition=cycle))
    return prepared, taken, found.iterations if found.norm <= target else LIMIT


def by_scipy(matrix: sparse.csr_matrix, b: Array) -> tuple[float, float, int]:
    """Scipy's conjugate gradients with the diagonal, column by column."""
    diagonal = sparse.diags_array(1.0 / matrix.diagonal())
    steps = [0]

    def count(_: Array) -> None:
        steps[0] += 1

    def solve() -> None:
        for column in b.T:
            cg(matrix, column, rtol=TOLERANCE, maxiter=LIMIT, M=diagonal, callback=count)

    return 0.0, seconds(solve)[0], steps[0] // 3


def by_pyamg(matrix: sparse.csr_matrix, b: Array) -> tuple[float, float, int]:
    """Pyamg's smoothed aggregation as preconditioner of its conjugate gradients, column by column."""
    prepared, levels = seconds(lambda: pyamg.smoothed_aggregation_solver(sparse.csr_matrix(matrix)))
    steps: list[int] = []

    def solve() -> None:
        for column in b.T:
            residuals: list[float] = []
            levels.solve(column, tol=TOLERANCE, maxiter=LIMIT, accel="cg", residuals=residuals)
            steps.append(len(residuals) - 1)

    return prepared, seconds(solve)[0], max(steps)


def by_factors(matrix: sparse.csr_matrix, b: Array) -> tuple[float, float, int]:
    """Cholesky's factors with one step of refinement."""
    prepared, factors = seconds(lambda: Cholesky(matrix))

    def solve() -> Array:
        x = factors.solve(b)
        return np.asarray(x + factors.solve(b - matrix @ x))

    return prepared, seconds(solve)[0], 0


def compare_steps(n_vertices: int, rounds: int) -> bool:
    """Prints a line for every length; whether no library is faster than ours."""
    vertices, faces = make_mesh(n_vertices, "loop")
    laplacian, unit = laplace_beltrami(vertices, faces), mean_edge_length(vertices, faces)
    ways: dict[str, Callable[[sparse.csr_matrix, Array], tuple[float, float, int]]] = {
        "jacobi": lambda matrix, b: by_us(matrix, b, multigrid=False),
        "multigrid": lambda matrix, b: by_us(matrix, b, multigrid=True),
        "scipy cg": by_scipy,
        "pyamg": by_pyamg,
        "cholesky": by_factors,
    }
    held = True
    print(f"{len(vertices):,} vertices: set-up + solve (iterations)")
    for length in LENGTHS:
        t = (length * unit) ** 2
        matrix = sparse.csr_matrix((sparse.diags_array(laplacian.mass) - t * laplacian.stiffness) / (1.0 + t))
        b = t / (1.0 + t) * (laplacian.stiffness @ vertices)
        best = {name: min((way(matrix, b) for _ in range(rounds)), key=sum) for name, way in ways.items()}
        cells = [f"{name} {made:.2f} + {solved:.3f} ({count})" for name, (made, solved, count) in best.items()]
        print(f"  c = {length:<6g} " + "   ".join(cells), flush=True)
        total = {name: sum(found[:2]) for name, found in best.items()}
        held = held and total["jacobi"] < total["scipy cg"] and total["multigrid"] < total["pyamg"]
    return held


def compare_orders(level: int, theirs: str) -> bool:
    """Prints the times of factors by our order and one of SuperLU's, and of solves with them; whether ours are faster."""
    sphere = trimesh.creation.icosphere(level)
    laplacian = laplace_beltrami(np.asarray(sphere.vertices), np.asarray(sphere.faces, dtype=np.int32))
    matrix = sparse.csc_matrix(-laplacian.stiffness)
    shift = 1e-3 * float(matrix.diagonal().mean())
    shifted = sparse.csc_matrix(matrix - shift * sparse.eye_array(matrix.shape[0]))
    making, factors = seconds(lambda: ShiftedFactors(matrix, Fronts.of(matrix), shift, ignore_progress, 0.0))
    made, peer = seconds(lambda: splu(shifted, permc_spec=theirs, diag_pivot_thresh=0.0))
    columns = np.asfortranarray(np.random.default_rng(0).normal(size=(matrix.shape[0], 8)))
    ours = min(seconds(lambda: factors.solve(columns))[0] for _ in range(5))
    superlu = min(seconds(lambda: peer.solve(columns))[0] for _ in range(5))
    print(
        f"{matrix.shape[0]:,} vertices of a subdivided icosahedron: factors {making:.2f}, a solve for eight columns {ours:.3f}; "
        f"SuperLU's in the order {theirs} {made:.2f}, a solve {superlu:.3f}",
        flush=True,
    )
    return making < made and ours < superlu


def main() -> int:
    """Runs both parts; 1 if a library is faster."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--vertices", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    set_threads(1)
    with threadpool_limits(limits=1):
        compare_steps(2000, 1)  # compiles
        compare_orders(3, "COLAMD")
        steps = compare_steps(options.vertices, options.rounds)
        orders = [compare_orders(level, order) for level, order in ORDERS]
    return 0 if steps and all(orders) else 1


if __name__ == "__main__":
    sys.exit(main())
