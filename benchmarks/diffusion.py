"""Taubin and explicit cotangent smoothing against MeshLab's own filters, alternately in one process.

    python benchmarks/diffusion.py [VERTICES] [--rounds N] [--order loop|random|place] [--threads N]

The mesh is pymeshlab's bunny, decimated and subdivided by Loop's scheme to about VERTICES (1,000,000 by default), its vertices
shifted by noise of 15 % of the mean edge, in the order in which subdivision leaves them, in random order, or in order of place.
Both sides are timed on arrays in memory: ours from vertices and faces to new vertices, with everything that it builds; MeshLab's
from a loaded mesh, by its filter alone. Ends with 1 if the ratio of the medians by the clock is below its floor; on a busy
machine the processor time tells more.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.diffusion.explicit import explicit_smoothing, taubin_fairing
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.mesh import order_by_place

Mesh = tuple[NDArray[np.float64], NDArray[np.int32]]


@dataclass(frozen=True)
class Contest:
    """One technique on both sides.

    Attributes:
        name: what is timed.
        ours: takes vertices and faces.
        filter_name: MeshLab's filter.
        parameters: what MeshLab's filter is given.
        floor: the least ratio of MeshLab's median time to ours; None for one that is only shown.
    """

    name: str
    ours: Callable[..., NDArray[np.float64]]
    filter_name: str
    parameters: dict[str, Any]
    floor: float | None


CONTESTS = (
    Contest("Taubin, 10 pairs", taubin_fairing, "apply_coord_taubin_smoothing", {"stepsmoothnum": 10}, 3.0),
    Contest(
        "explicit cotangent, 10 steps",
        lambda v, f: explicit_smoothing(v, f, operator="cotangent"),
        "apply_coord_laplacian_smoothing",
        {"stepsmoothnum": 10, "cotangentweight": True},
        3.0,
    ),
    Contest(
        "explicit uniform, 10 steps",
        explicit_smoothing,
        "apply_coord_laplacian_smoothing",
        {"stepsmoothnum": 10, "cotangentweight": False},
        None,
    ),
)


def make_mesh(n_vertices: int, order: str) -> Mesh:
    """A noisy closed mesh of about that many vertices."""
    path = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "bunny.obj"
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    levels = max(0, math.ceil(math.log(n_vertices / 28_000, 4)))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=round(2 * n_vertices / 4**levels))
    if levels:
        meshes.meshing_surface_subdivision_loop(iterations=levels, threshold=pymeshlab.PureValue(0))
    mesh = meshes.current_mesh()
    vertices, faces = np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)
    rng = np.random.default_rng(1)
    vertices = vertices + rng.normal(0.0, 0.15 * mean_edge_length(vertices, faces), vertices.shape)
    if order == "loop":
        return vertices, faces
    permutation = order_by_place(vertices, faces) if order == "place" else rng.permutation(len(vertices)).astype(np.int32)
    new = np.empty_like(permutation)
    new[permutation] = np.arange(len(permutation), dtype=np.int32)
    faces = new[faces]
    faces = faces[np.argsort(faces.min(axis=1), kind="stable")] if order == "place" else faces[rng.permutation(len(faces))]
    return np.ascontiguousarray(vertices[permutation]), np.ascontiguousarray(faces)


def seconds(work: Callable[[], object]) -> tuple[float, float]:
    """How long one call takes by the clock, and how much processor time."""
    start, used = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - start, time.process_time() - used


def compare(contest: Contest, mesh: Mesh, rounds: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The median seconds of ours and of MeshLab's, taken in turn; the first of ours, which may compile, does not count."""
    vertices, faces = mesh
    contest.ours(vertices, faces)
    ours, theirs = [], []
    for _ in range(rounds):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
        theirs.append(seconds(lambda meshes=meshes: meshes.apply_filter(contest.filter_name, **contest.parameters)))  # type: ignore[misc]
        ours.append(seconds(lambda: contest.ours(vertices, faces)))
    return np.median(ours, axis=0), np.median(theirs, axis=0)


def main() -> int:
    """Run the contests, print the table, and return 1 if a floor is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("vertices", type=int, nargs="?", default=1_000_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--order", choices=("loop", "random", "place"), default="loop")
    parser.add_argument("--threads", type=int, default=allowed_threads())
    options = parser.parse_args()
    set_threads(options.threads)
    mesh = make_mesh(options.vertices, options.order)
    print(f"{len(mesh[0]):,} vertices, {len(mesh[1]):,} faces, {options.order} order, {options.threads} threads, ", end="")
    print(f"medians of {options.rounds} rounds, in brackets processor time")
    print(f"{'':30} {'ours':>17} {'MeshLab':>17} {'ratio':>7} {'floor':>7}")
    missed = False
    for contest in CONTESTS:
        (ours, ours_cpu), (theirs, theirs_cpu) = compare(contest, mesh, options.rounds)
        ratio = theirs / ours
        below = contest.floor is not None and ratio < contest.floor
        missed |= below
        floor = "" if contest.floor is None else f"{contest.floor:.1f}x" + (" MISSED" if below else "")
        times = f"{ours:6.3f}s ({ours_cpu:5.2f} s) {theirs:6.3f}s ({theirs_cpu:5.2f} s)"
        print(f"{contest.name:30} {times} {ratio:6.1f}x {floor:>7}")
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
