"""Random holes cut into the bunny and closed, by us and by MeshLab's meshing_close_holes.

    python benchmarks/holes.py [--holes N] [--energy ENERGY] [--verbose]

Every hole is cut by itself: all faces that touch a random vertex's ring of random size, or a ball of random radius around it. The
mean distance is that of points spread evenly on the new faces to the surface that was removed; that of points on the removed
surface to the new faces is printed too, which is large where an ear was cut off that no rim tells of. Ends with 1 unless every
hole is closed, the meshes stay manifold, and our mean distance over all holes is under half of MeshLab's.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import NamedTuple

import igl
import numpy as np
import pymeshlab
from numpy.typing import NDArray

from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.holes import HoleEnergy, close_holes
from pymeshfair.filters.topology import border_edges, non_manifold_edges

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

SHARE = 0.5
LARGEST_RING = 12


class Cut(NamedTuple):
    """A mesh with a hole, and what was there."""

    vertices: Floats
    faces: Ints
    removed: Ints
    size: str


class Closed(NamedTuple):
    """A hole closed: the border and non-manifold edges that are left, the mean distances to the old surface and back."""

    seconds: float
    border: int
    non_manifold: int
    there: float
    back: float


def bunny() -> tuple[Floats, Ints]:
    """The one that the pymeshlab wheel carries, 28,088 vertices."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "bunny.obj"))
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def cut(vertices: Floats, faces: Ints, seed: int) -> Cut:
    """A hole around a random vertex: a ring of 1 to 12, or a ball of 1 to 12 mean edges."""
    rng = np.random.default_rng(seed)
    middle = int(rng.integers(len(vertices)))
    inside = np.zeros(len(vertices), dtype=np.bool_)
    inside[middle] = True
    if rng.random() < 0.5:
        rings = int(rng.integers(1, LARGEST_RING + 1))
        size = f"ring {rings}"
        for _ in range(rings - 1):
            inside[faces[inside[faces].any(axis=1)]] = True
    else:
        radius = rng.uniform(1.0, LARGEST_RING)
        size = f"radius {radius:.1f}"
        near = np.linalg.norm(vertices - vertices[middle], axis=1) < radius * mean_edge_length(vertices, faces)
        # The part of the ball that hangs together with the vertex, not the other side of an ear.
        while True:
            grown = inside.copy()
            grown[faces[inside[faces].any(axis=1)]] = True
            grown &= near
            if (grown <= inside).all():
                break
            inside |= grown
    gone = inside[faces].any(axis=1)
    return Cut(vertices, np.ascontiguousarray(faces[~gone]), faces[gone], size)


def ours(hole: Cut, energy: HoleEnergy) -> Closed:
    """Closed by `close_holes`."""
    start = time.perf_counter()
    filling = close_holes(hole.vertices, hole.faces, max_edges=2_000, energy=energy)
    seconds = time.perf_counter() - start
    return judged(hole, np.concatenate([hole.vertices, filling.new_vertices]), filling.new_faces, seconds)


def meshlabs(hole: Cut) -> Closed:
    """Closed by MeshLab with its defaults, holes of any size."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(hole.vertices, hole.faces))
    start = time.perf_counter()
    meshes.meshing_close_holes(maxholesize=2_000)
    seconds = time.perf_counter() - start
    mesh = meshes.current_mesh()
    return judged(hole, mesh.vertex_matrix(), np.asarray(mesh.face_matrix()[len(hole.faces) :], dtype=np.int32), seconds)


def judged(hole: Cut, vertices: Floats, new: Ints, seconds: float) -> Closed:
    """The hole with its new faces."""
    if len(new) == 0:
        return Closed(seconds, len(border_edges(hole.faces)), 0, np.inf, np.inf)
    whole = np.concatenate([hole.faces, new])
    there = mean_distance(spread(vertices, new), hole.vertices, hole.removed)
    back = mean_distance(spread(hole.vertices, hole.removed), vertices, new)
    return Closed(seconds, len(border_edges(whole)), len(non_manifold_edges(whole)), there, back)


def spread(vertices: Floats, faces: Ints, count: int = 3_000) -> tuple[Floats, Floats]:
    """Points on the triangles, and the area that each stands for."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    steps = max(1, int(np.ceil(np.sqrt(count / len(faces)))))
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij"))
    up = i + j < steps
    down = i + j < steps - 1
    u = np.concatenate([i[up] + 1 / 3, i[down] + 2 / 3]) / steps
    v = np.concatenate([j[up] + 1 / 3, j[down] + 2 / 3]) / steps
    points = a[:, None] + u[:, None] * (b - a)[:, None] + v[:, None] * (c - a)[:, None]
    return points.reshape(-1, 3), np.repeat(areas / len(u), len(u))


def mean_distance(points: tuple[Floats, Floats], vertices: Floats, faces: Ints) -> float:
    """The mean distance to the triangles, by area."""
    own, index = np.unique(faces, return_inverse=True)
    squares = igl.point_mesh_squared_distance(points[0], vertices[own], index.reshape(-1, 3).astype(np.int64))[0]
    return float(np.average(np.sqrt(np.maximum(squares, 0.0)), weights=points[1]))


def main() -> int:
    """Cuts, closes, measures and tells whether the floors hold."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--holes", type=int, default=200)
    parser.add_argument("--energy", default="thin_plate", choices=["none", "membrane", "thin_plate", "minimum_variation"])
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    vertices, faces = bunny()
    edge = mean_edge_length(vertices, faces)
    pairs = []
    for seed in range(arguments.holes):
        hole = cut(vertices, faces, seed)
        pairs.append((ours(hole, arguments.energy), meshlabs(hole)))
        if arguments.verbose:
            own, other = pairs[-1]
            print(
                f"{seed:4} {hole.size:12} {len(border_edges(hole.faces)):4} edges: {own.there / edge:.3f} {own.back / edge:.3f} "
                f"edges away, MeshLab {other.there / edge:.3f} {other.back / edge:.3f}; {own.border} {own.non_manifold}",
                flush=True,
            )
    left = sum(own.border > 0 for own, _ in pairs)
    broken = sum(own.non_manifold > 0 for own, _ in pairs)
    compared = [(own, other) for own, other in pairs if np.isfinite(other.there) and np.isfinite(own.there)]
    shares = []
    for side in ("there", "back"):
        means = [float(np.mean([getattr(pair[k], side) for pair in compared])) / edge for k in range(2)]
        each = np.array([getattr(own, side) / max(getattr(other, side), 1e-12) for own, other in compared])
        shares.append(means[0] / means[1])
        print(
            f"{side:5}: {means[0]:.4f} edges, MeshLab {means[1]:.4f}: {shares[-1]:.3f} of it; of the holes one by one "
            f"{np.median(each):.3f} in the median, above {SHARE} at {int((each > SHARE).sum())} of {len(each)}"
        )
    seconds = [float(np.median([pair[k].seconds for pair in pairs])) for k in range(2)]
    open_there, broken_there = (sum(getattr(other, name) > 0 for _, other in pairs) for name in ("border", "non_manifold"))
    print(
        f"{left} of {len(pairs)} left open, MeshLab {open_there}; not manifold {broken}, MeshLab {broken_there}; "
        f"seconds each {seconds[0]:.3f}, MeshLab {seconds[1]:.3f}"
    )
    return 0 if left == 0 and broken == 0 and shares[0] < SHARE else 1


if __name__ == "__main__":
    sys.exit(main())
