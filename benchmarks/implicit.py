"""One step of implicit fairing, by its own floor and against the routes that Python users take now.

    python benchmarks/implicit.py [VERTICES] [--peers VERTICES] [--rounds N] [--edges 0.5 1 3 10 100] [--threads N]

The mesh is that of benchmarks/diffusion.py. Everything is timed on arrays in memory: from vertices and faces to new vertices,
with all that is built on the way. First our step of (E mean edges)^2 on VERTICES (1,000,000 by default) for every E of --edges;
then, on a mesh of --peers vertices (100,000), a step of one edge by us, by trimesh's implicit Laplacian smoothing and by libigl's
matrices with scipy's spsolve, in turn in one process. Ends with 1 if the median step of one edge on the large mesh takes 3 s or
more, if ours is slower than a peer, or if it is not the solution that libigl's route gives.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from typing import Any

import igl
import numpy as np
import trimesh
from diffusion import Mesh, make_mesh, seconds
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.diffusion.implicit import implicit_fairing
from pymeshfair.filters.geometry import mean_edge_length

FLOOR = 3.0
#: what our step may differ by from a direct solution, as a share of the diagonal
AGREEMENT = 1e-8


def by_us(mesh: Mesh, time_step: float) -> NDArray[np.float64]:
    """The step, with everything at its default."""
    return implicit_fairing(*mesh, time_step=time_step)


def by_libigl(mesh: Mesh, time_step: float) -> NDArray[np.float64]:
    """The same equations: libigl's cotangent and Voronoi mass matrices, scipy's SuperLU."""
    vertices, faces = mesh
    mass = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI)
    matrix = sparse.csc_matrix(mass - time_step * igl.cotmatrix(vertices, faces))
    return np.asarray(spsolve(matrix, mass @ vertices))


def by_trimesh(mesh: Mesh, time_step: float) -> NDArray[np.float64]:
    """An implicit step of 1 of trimesh's umbrella operator: another operator, the same kind of system."""
    surface = trimesh.Trimesh(*mesh, process=False)
    smooth: Any = trimesh.smoothing.filter_laplacian
    smooth(surface, lamb=1.0, iterations=1, implicit_time_integration=True, volume_constraint=False)
    return np.asarray(surface.vertices)


def time_ours(n_vertices: int, edges: list[float], rounds: int) -> bool:
    """Times our step on a large mesh; whether the step of one edge is below the floor."""
    mesh = make_mesh(n_vertices, "loop")
    unit = mean_edge_length(*mesh) ** 2
    by_us(make_mesh(2000, "loop"), unit)
    fast = True
    print(f"{len(mesh[0]):,} vertices, seconds (fastest and median of {rounds})")
    for length in edges:
        by_us(mesh, length**2 * unit)
        taken = [seconds(lambda length=length: by_us(mesh, length**2 * unit))[0] for _ in range(rounds)]  # type: ignore[misc]
        print(f"  ours, a step of {length:g} edges  {min(taken):8.2f} {statistics.median(taken):8.2f}")
        fast = fast and (length != 1.0 or statistics.median(taken) < FLOOR)
    return fast


def compare(n_vertices: int, rounds: int) -> bool:
    """Times all routes in turn on a smaller mesh; whether ours is the fastest and gives what libigl's route gives."""
    mesh = make_mesh(n_vertices, "loop")
    unit = mean_edge_length(*mesh) ** 2
    routes = {"ours": by_us, "libigl, scipy spsolve": by_libigl, "trimesh": by_trimesh}
    taken: dict[str, list[float]] = {name: [] for name in routes}
    difference = np.abs(by_us(mesh, unit) - by_libigl(mesh, unit)).max() / np.linalg.norm(np.ptp(mesh[0], axis=0))
    for _ in range(rounds):
        for name, route in routes.items():
            taken[name].append(seconds(lambda route=route: route(mesh, unit))[0])  # type: ignore[misc]
    medians = {name: statistics.median(times) for name, times in taken.items()}
    print(f"{len(mesh[0]):,} vertices, a step of one edge, seconds (median of {rounds})")
    for name, median in medians.items():
        print(f"  {name:<24}{median:8.3f}  {median / medians['ours']:6.1f} times ours")
    print(f"  ours differs from libigl's by {difference:.1e} of the diagonal")
    return min(medians.values()) == medians["ours"] and bool(difference < AGREEMENT)


def main() -> int:
    """Runs both parts; 1 if a floor is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("vertices", nargs="?", type=int, default=1_000_000)
    parser.add_argument("--peers", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--edges", type=float, nargs="+", default=[1.0, 10.0, 100.0])
    parser.add_argument("--threads", type=int, default=allowed_threads())
    options = parser.parse_args()
    set_threads(options.threads)
    fast = time_ours(options.vertices, options.edges, options.rounds)
    right = compare(options.peers, options.rounds)
    return 0 if fast and right else 1


if __name__ == "__main__":
    sys.exit(main())
