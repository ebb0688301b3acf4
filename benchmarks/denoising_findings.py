"""Which kernel keeps edges and which suits smooth shapes, and why normals of faces: ``python benchmarks/denoising_findings.py``.

Reproduces with shapes of its own what [yadav2021] and the courses on it say. A chest, flat and rounded with sharp edges, and a
ball with bumps get normal noise of 0.3 mean edges; every kernel filters their normals in the same schedule, with the scale that
is best for it on that shape. Prints the tables of docs/denoising.md and draws its picture, with ``-o FOLDER``.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from denoising_metrics import Floats, Ints, angles_to_truth
from numpy.typing import NDArray
from scipy import sparse

from pymeshfair.filters.denoising import normal_filtering
from pymeshfair.filters.denoising.face_neighbourhoods import FaceNeighbourhoods, mean_centre_distance
from pymeshfair.filters.denoising.normal_filter import NormalFilter, Weighting, weighted_normals
from pymeshfair.filters.denoising.vertex_update import fit_vertices
from pymeshfair.filters.geometry import (
    AREA,
    CENTRE,
    NORMAL,
    face_normals,
    mean_edge_length,
    mean_normals_at_vertices,
    measure_faces,
    unit_vectors,
)
from pymeshfair.filters.robust import KernelName
from pymeshfair.filters.topology import face_adjacency, one_rings, vertex_faces

NOISE = 0.3
#: what all kernels share
SCHEDULE: dict[str, Any] = {
    "space_sigma": 1.5,
    "neighborhood": "two_ring",
    "normal_iterations": 1,
    "vertex_iterations": 10,
    "outer_iterations": 20,
}
SIGMAS = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0)
#: faces that meet at more than this angle, in degrees, meet at a feature
SHARP = 30.0
#: the table's order and words
GROUPS: dict[str, tuple[KernelName, ...]] = {
    "unbounded": ("l2", "l1"),
    "cut off": ("truncated_l2", "truncated_l1", "tukey", "hampel"),
    "soft": ("huber", "lorentzian", "gaussian"),
}


@dataclass(frozen=True)
class Shape:
    """A shape, its noisy copy, and which of its faces touch a feature."""

    name: str
    truth: Floats
    noisy: Floats
    faces: Ints
    at_features: NDArray[np.bool_]

    @staticmethod
    def of(name: str, truth: Floats, faces: Ints) -> Shape:
        """With noise in all directions whose standard deviation is `NOISE` / sqrt 3 mean edges a coordinate."""
        random = np.random.default_rng(2026)
        amount = NOISE * mean_edge_length(truth, faces) / np.sqrt(3)
        noisy = truth + random.normal(0.0, amount, truth.shape)
        normals, pairs = face_normals(truth, faces), np.asarray(face_adjacency(faces)[0])
        sharp = np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]]) < np.cos(np.radians(SHARP))
        corners = np.intersect1d(faces[pairs[sharp, 0]].ravel(), faces[pairs[sharp, 1]].ravel())
        return Shape(name, truth, noisy, faces, np.asarray(np.isin(faces, corners).any(axis=1)))

    def mad(self, vertices: Floats) -> float:
        """Mean angle to the true normals, degrees."""
        return float(angles_to_truth(vertices, self.truth, self.faces)[0].mean())

    def mad_at_features(self, vertices: Floats) -> float:
        """The same over the faces at features alone."""
        return float(angles_to_truth(vertices, self.truth, self.faces[self.at_features])[0].mean())


def chest(n: int = 24) -> Shape:
    """A box of 6 n^2 squares with an arched lid and a waist: flat and rounded faces that meet at sharp edges."""
    s = np.linspace(-1.0, 1.0, n + 1)
    u, v = (a.ravel() for a in np.meshgrid(s, s, indexing="ij"))
    one = np.ones_like(u)
    sides = [np.column_stack(c) for c in ((one, u, v), (-one, v, u), (v, one, u), (u, -one, v), (u, v, one), (v, u, -one))]
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1
    turned = np.random.default_rng(3).random(len(a)) < 0.5
    first, second = np.where(turned, [a, b, d], [a, b, c]).T, np.where(turned, [b, c, d], [a, c, d]).T
    squares = np.concatenate([first, second])
    points = np.concatenate(sides)
    faces = np.concatenate([squares + k * len(u) for k in range(6)])
    keys, place = np.unique(np.round(points * 1e6).astype(np.int64), axis=0, return_inverse=True)
    points, faces = keys / 1e6, place.ravel()[faces]
    x, y, z = points.T
    lid = np.where(z > 0, z * (1.0 + 0.5 * np.cos(np.pi * x / 2)), z)
    waist = 1.0 - 0.25 * np.cos(np.pi * z / 2)
    return Shape.of("chest", np.column_stack([x, y * waist, lid]), np.ascontiguousarray(faces, dtype=np.int32))


def bumpy_ball(levels: int = 4) -> Shape:
    """A ball with waves of 4 % of its radius, smooth everywhere."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=levels)
    points = np.array(ball.vertices)
    waves = np.sin(6 * points[:, 0]) * np.cos(5 * points[:, 1]) * np.sin(5 * points[:, 2] + 1)
    return Shape.of("ball", points * (1 + 0.06 * waves)[:, None], np.array(ball.faces, dtype=np.int32))


def filtered_by_vertices(
    vertices: Floats, faces: Ints, *, range_kernel: KernelName, range_sigma: float, **schedule: Any
) -> Floats:
    """As `normal_filtering`, but the normals of vertices are filtered; a face gets the mean normal of its corners."""
    n = len(vertices)
    settings = NormalFilter(range_kernel=range_kernel, range_sigma=range_sigma, space_sigma=schedule["space_sigma"])
    near = one_rings(faces, n)
    step = sparse.csr_matrix((np.ones(len(near.neighbours)), near.neighbours, near.offsets), (n, n))
    around = sparse.csr_matrix(step + step @ step)
    around.setdiag(0.0)
    around.eliminate_zeros()
    two_rings, one_ring = (FaceNeighbourhoods(m.indptr.astype(np.int64), m.indices) for m in (around, step))
    for _ in range(schedule["outer_iterations"]):
        table, rows = measure_faces(vertices, faces), np.zeros((n, 8))
        rows[:, AREA] = np.bincount(faces.ravel(), np.repeat(table[:, AREA], 3), n)
        rows[:, NORMAL] = mean_normals_at_vertices(table[:, AREA, None] * table[:, NORMAL], faces, n)
        rows[:, CENTRE] = vertices
        weighting = Weighting.of(settings, mean_centre_distance(rows, one_ring))
        normals = weighted_normals(rows[:, NORMAL].copy(), rows, two_rings, weighting)
        targets, moves = unit_vectors(normals[faces].sum(axis=1)), np.ones(n, np.bool_)
        iterations = schedule["vertex_iterations"]
        vertices = fit_vertices(vertices, faces, vertex_faces(faces, n), targets, iterations=iterations, moves=moves)
    return vertices


def best(shape: Shape, kernel: KernelName, *, by_vertices: bool = False) -> tuple[Floats, float]:
    """The mesh with the least MAD over the scales, and its scale; of "l2" and "l1" the scale changes nothing."""
    run = filtered_by_vertices if by_vertices else normal_filtering
    filtered = (
        (run(shape.noisy, shape.faces, range_kernel=kernel, range_sigma=sigma, **SCHEDULE), sigma)
        for sigma in ((1.0,) if kernel in ("l2", "l1") else SIGMAS)
    )
    return min(filtered, key=lambda found: shape.mad(found[0]))


def draw(path: Path, sharp: Shape, smooth: Shape, shown: dict[KernelName, tuple[Floats, Floats]], by_vertices: Floats) -> None:
    """The chest above, the ball below: noisy, by some kernels, and true."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
    from panels import Panel, draw_panels, save_picture

    from pymeshfair.looking.picture import Appearance

    names: tuple[KernelName, ...] = ("l2", "l1", "tukey", "huber", "lorentzian")
    appearance = Appearance(azimuth=-33.0, elevation=25.0, up="z", width=230, height=230)
    last = (("truncated_l1, normals of vertices", by_vertices), ("truncated_l1", shown["truncated_l1"][1]))
    pictures = []
    for at, shape in enumerate((sharp, smooth)):
        row = [("noisy", shape.noisy), *((name, shown[name][at]) for name in names), last[at], ("truth", shape.truth)]
        pictures.append(draw_panels([Panel(title, vertices, shape.faces) for title, vertices in row], appearance))
    save_picture(path, *pictures)


def main() -> int:
    """Print the tables; draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, help="the folder for the picture")
    options = parser.parse_args()
    sharp, smooth = chest(), bumpy_ball()
    features = f"{sharp.at_features.sum():,} of them at features"
    print(f"chest {len(sharp.faces):,} faces, {features}; ball {len(smooth.faces):,} faces\n")
    print("| kernel | | chest | chest, at features | sigma | ball | sigma |\n|---|---|---:|---:|---:|---:|---:|")
    box, ball = sharp.noisy, smooth.noisy
    print(f"| noisy | | {sharp.mad(box):.2f} | {sharp.mad_at_features(box):.2f} | | {smooth.mad(ball):.2f} | |")
    shown: dict[KernelName, tuple[Floats, Floats]] = {}
    for group, name in ((group, name) for group, names in GROUPS.items() for name in names):
        (box, box_scale), (ball, ball_scale) = best(sharp, name), best(smooth, name)
        shown[name] = box, ball
        on_chest = f"{sharp.mad(box):.2f} | {sharp.mad_at_features(box):.2f} | {box_scale}"
        print(f"| {name} | {group} | {on_chest} | {smooth.mad(ball):.2f} | {ball_scale} |", flush=True)
    print("\n| kernel | normals of | chest | chest, at features |\n|---|---|---:|---:|")
    by_vertices = {}
    for name in ("truncated_l1", "gaussian"):
        by_vertices[name], _ = best(sharp, name, by_vertices=True)
        for words, mesh in (("faces", shown[name][0]), ("vertices", by_vertices[name])):
            print(f"| {name} | {words} | {sharp.mad(mesh):.2f} | {sharp.mad_at_features(mesh):.2f} |", flush=True)
    if options.output:
        draw(options.output / "denoising_kernels.png", sharp, smooth, shown, by_vertices["truncated_l1"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
