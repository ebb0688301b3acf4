"""Region fairing and energy smoothing: what they take, against CGAL and libigl, and how far they are from libigl's.

    python benchmarks/fairing.py [FREE ...] [--rounds N] [--large FREE] [--energy VERTICES] [--without-cgal]

Everything is timed on arrays in memory. For every number of FREE vertices (10,000 by default), a patch of that many in the middle
of a bent irregular sheet of ten times as many is faired at order 1, 2 and 3, by us (extraction of the region included), by
libigl's `harmonic` on the same patch, and at order 2 by CGAL's `fair` (the call alone, without building its polyhedron). Then how
the time depends on the mesh around the patch; every order on --large free vertices (100,000); and an energy smoothing of
--energy vertices (100,000). Ends with 1 if CGAL is less than twice as slow at order 2.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any, TypeAlias

import igl
import numpy as np
from diffusion import make_mesh
from numpy.typing import NDArray

from pymeshfair.filters.fairing.bilaplacian import bilaplacian_smoothing
from pymeshfair.filters.fairing.region import ENERGIES, fair_region
from pymeshfair.filters.geometry import mean_edge_length

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]

SLOWER = 2.0


def sheet(n_vertices: int) -> tuple[Floats, Ints]:
    """A bent irregular sheet of about that many vertices over the unit square."""
    side = round(n_vertices**0.5)
    y, x = np.meshgrid(np.arange(float(side)), np.arange(float(side)), indexing="ij")
    shifts = np.random.default_rng(0).uniform(-0.2, 0.2, (side * side, 2))
    flat = (np.column_stack([x.ravel(), y.ravel()]) + shifts) / (side - 1)
    heights = 0.3 * np.sin(3 * flat[:, 0]) * np.cos(2 * flat[:, 1])
    i, j = np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij")
    a = (i * side + j).ravel()
    faces = np.concatenate([np.column_stack([a, a + 1, a + side + 1]), np.column_stack([a, a + side + 1, a + side])])
    return np.column_stack([flat, heights]), faces.astype(np.int32)


def middle(vertices: Floats, count: int) -> NDArray[np.bool_]:
    """The `count` vertices nearest to the middle of the sheet, in the greatest norm: a square."""
    order = np.argsort(np.abs(vertices[:, :2] - 0.5).max(axis=1), kind="stable")
    chosen = np.zeros(len(vertices), dtype=np.bool_)
    chosen[order[:count]] = True
    return chosen


def cropped(vertices: Floats, faces: Ints, free: NDArray[np.bool_]) -> tuple[Floats, Ints, NDArray[np.bool_]]:
    """The patch with four rings around it, which is all that others are given."""
    near = free.copy()
    for _ in range(4):
        near[faces[near[faces].any(axis=1)]] = True
    number = np.cumsum(near) - 1
    return vertices[near], number[faces[near[faces].all(axis=1)]].astype(np.int32), free[near]


def seconds(rounds: int, run: Callable[[], object]) -> float:
    """The median of `rounds` runs."""
    taken = []
    for _ in range(rounds):
        start = time.perf_counter()
        run()
        taken.append(time.perf_counter() - start)
    return statistics.median(taken)


def polyhedron_of(vertices: Floats, faces: Ints, free: NDArray[np.bool_]) -> tuple[Any, Any, list[Any]]:
    """CGAL's module of polygon meshes, the mesh as its polyhedron, and the handles of the free vertices."""
    import importlib

    kernel: Any = importlib.import_module("CGAL.CGAL_Kernel")
    polyhedra: Any = importlib.import_module("CGAL.CGAL_Polyhedron_3")
    processing: Any = importlib.import_module("CGAL.CGAL_Polygon_mesh_processing")
    points = processing.Point_3_Vector()
    for p in vertices:
        points.append(kernel.Point_3(*map(float, p)))
    polygons = processing.Polygon_Vector()
    for face in faces:
        polygon = processing.Int_Vector()
        for corner in face:
            polygon.append(int(corner))
        polygons.append(polygon)
    polyhedron = polyhedra.Polyhedron_3()
    processing.polygon_soup_to_polygon_mesh(points, polygons, polyhedron)
    return processing, polyhedron, [handle for handle, is_free in zip(polyhedron.vertices(), free, strict=True) if is_free]


def against_cgal(
    vertices: Floats, faces: Ints, free: NDArray[np.bool_], rounds: int, ours: Callable[[], object]
) -> tuple[float, float]:
    """CGAL's `fair` with its continuity 1, order 2, and ours, in turn: the median seconds of the calls."""
    taken, own = [], []
    for _ in range(rounds):
        processing, polyhedron, chosen = polyhedron_of(vertices, faces, free)
        start = time.perf_counter()
        processing.fair(polyhedron, chosen, 1)
        taken.append(time.perf_counter() - start)
        own.append(seconds(1, ours))
    return statistics.median(taken), statistics.median(own)


def compare(count: int, rounds: int, with_cgal: bool) -> bool:
    """Times all routes on a patch; whether CGAL is slow enough at order 2 and nothing is inexact."""
    vertices, faces = sheet(10 * count)
    free = middle(vertices, count)
    patch = cropped(vertices, faces, free)
    fixed = np.flatnonzero(~patch[2])
    print(f"{count:,} free vertices in a mesh of {len(vertices):,}, seconds (median of {rounds})")
    good = True
    for order, energy in enumerate(ENERGIES, start=1):
        result = fair_region(vertices, faces, free, energy=energy)
        ours = seconds(rounds, lambda energy=energy: fair_region(vertices, faces, free, energy=energy))  # type: ignore[misc]
        boundary = patch[0][fixed]

        def libigl(order: int = order, boundary: Floats = boundary) -> Any:
            return igl.harmonic(patch[0], patch[1].astype(np.int64), fixed.astype(np.int64), boundary, order)

        theirs = seconds(rounds, libigl)
        apart = np.abs(result.vertices[free] - libigl()[patch[2]]).max() / np.linalg.norm(np.ptp(patch[0], axis=0))
        line = f"  order {order}: ours {ours:7.3f}   libigl {theirs:7.3f} ({theirs / ours:4.1f} x, differs by {apart:.0e})"
        if order == 2 and with_cgal:
            cgal, own = against_cgal(*patch, rounds, lambda energy=energy: fair_region(vertices, faces, free, energy=energy))  # type: ignore[misc]
            line += f"   CGAL {cgal:7.3f} ({cgal / own:4.1f} x ours in turn, {own:.3f})"
            good = good and cgal >= SLOWER * own
        print(line)
    return good


def time_surroundings(count: int, rounds: int) -> None:
    """How a thin plate's time depends on the mesh around it."""
    for factor in (2, 10, 100):
        vertices, faces = sheet(factor * count)
        free = middle(vertices, count)
        taken = seconds(rounds, lambda v=vertices, f=faces, m=free: fair_region(v, f, m))  # type: ignore[misc]
        print(f"  {count:,} free vertices in {len(vertices):>9,}: {taken:7.3f} s")


def large_patch(count: int) -> None:
    """How long a large patch takes."""
    vertices, faces = sheet(round(1.3 * count))
    free = middle(vertices, count)
    for energy in ENERGIES:
        taken = seconds(1, lambda energy=energy: fair_region(vertices, faces, free, energy=energy))  # type: ignore[misc]
        print(f"  {energy:<18}{taken:7.2f} s")


def time_energy(n_vertices: int, rounds: int) -> None:
    """Energy smoothing of a whole noisy mesh."""
    vertices, faces = make_mesh(n_vertices, "loop")
    edge = mean_edge_length(vertices, faces)
    for length in (2.0, 6.0, 20.0, 200.0):
        taken = seconds(rounds, lambda length=length: bilaplacian_smoothing(vertices, faces, detail_size=length * edge))  # type: ignore[misc]
        print(f"  energy smoothing of {len(vertices):,} vertices, detail size {length:g} edges: {taken:.2f} s")


def main() -> int:
    """Runs all parts; 1 if a floor is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("free", nargs="*", type=int, default=[10_000])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--large", type=int, default=100_000, help="0: leave out")
    parser.add_argument("--energy", type=int, default=100_000, help="0: leave out")
    parser.add_argument("--without-cgal", action="store_true")
    options = parser.parse_args()
    fair_region(*sheet(400), middle(sheet(400)[0], 50))
    good = True
    for count in options.free:
        good = compare(count, options.rounds, not options.without_cgal) and good
        time_surroundings(count, options.rounds)
    if options.large:
        large_patch(options.large)
    if options.energy:
        time_energy(options.energy, 1)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
