"""Noisy point clouds whose true surface is known, of shapes in two halves that share none.

`LOOKED_AT` may be looked at while constants are chosen. `UNSEEN` is for the last run alone. Surfaces are the zeros of a function,
which over the length of its gradient is the distance near the surface, or meshes of scans, whose vertices are the clouds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import igl
import numpy as np
import pymeshlab
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
#: (n,) how far (n, 3) points are from the surface
Distance = Callable[[Floats], Floats]

POINTS = 8000


class CloudPair(NamedTuple):
    """A noisy cloud, its spacing, which of its points were measured rather than strewn, and the distance to the true surface."""

    name: str
    points: Floats
    spacing: float
    measured: Bools
    distance: Distance

    def error(self, points: Floats) -> float:
        """The root mean square distance of measured points to the surface, in spacings."""
        return float(np.sqrt(np.mean(self.distance(points[self.measured]) ** 2))) / self.spacing


def spacing_of(points: Floats) -> float:
    """The median distance to the six nearest points."""
    return float(np.median(cKDTree(points).query(points, 7)[0][:, 1:].mean(axis=1)))


def ball(rng: np.random.Generator, n: int) -> Floats:
    """Points on the unit sphere."""
    p = rng.normal(size=(n, 3))
    return np.asarray(p / np.linalg.norm(p, axis=1, keepdims=True))


def box(rng: np.random.Generator, n: int) -> Floats:
    """Points on the sides of a box."""
    half = np.array([1.0, 0.7, 0.5])
    areas = np.repeat([half[1] * half[2], half[0] * half[2], half[0] * half[1]], 2)
    side = rng.choice(6, n, p=areas / areas.sum())
    p = rng.uniform(-1.0, 1.0, (n, 3)) * half
    p[np.arange(n), side // 2] = half[side // 2] * (2.0 * (side % 2) - 1.0)
    return np.asarray(p)


def of_box(p: Floats) -> Floats:
    """The distance to that box."""
    q = np.abs(p) - [1.0, 0.7, 0.5]
    return np.asarray(np.linalg.norm(np.maximum(q, 0.0), axis=1) - np.minimum(q.max(axis=1), 0.0))


def land(rng: np.random.Generator, n: int) -> Floats:
    """Points on waves of two lengths."""
    p = rng.uniform(-1.0, 1.0, (n, 3))
    p[:, 2] = height(p)
    return p


def height(p: Floats) -> Floats:
    """Of the waves."""
    return np.asarray(0.12 * np.sin(5.0 * p[:, 0]) * np.cos(4.0 * p[:, 1]) + 0.03 * np.sin(17.0 * (p[:, 0] + p[:, 1])))


def torus(rng: np.random.Generator, n: int) -> Floats:
    """Points on a ring."""
    v = rng.uniform(0.0, 2.0 * np.pi, 4 * n)
    v = v[rng.random(4 * n) * 1.4 < 1.0 + 0.4 * np.cos(v)][:n]
    u = rng.uniform(0.0, 2.0 * np.pi, len(v))
    radius = 1.0 + 0.4 * np.cos(v)
    return np.column_stack([radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v)])


def projected(value: Callable[[Floats], Floats], half: float) -> Callable[[np.random.Generator, int], Floats]:
    """Points of a cube brought to the zeros of a function by Newton's steps, thinned where these make them dense."""

    def points(rng: np.random.Generator, n: int) -> Floats:
        near = rng.uniform(-half, half, (200 * n, 3))
        near = near[np.abs(first_order(value)(near)) < 0.01]
        for _ in range(4):
            g = gradient(value, near)
            near = near - (value(near) / (g**2).sum(axis=1))[:, None] * g
        return np.asarray(rng.permutation(near)[:n])

    return points


def gradient(value: Callable[[Floats], Floats], p: Floats) -> Floats:
    """By differences."""
    return np.column_stack([(value(p + step) - value(p - step)) / 2e-5 for step in 1e-5 * np.eye(3)])


def first_order(value: Callable[[Floats], Floats]) -> Distance:
    """The distance to the zeros of a function, near them."""
    return lambda p: np.asarray(np.abs(value(p)) / np.linalg.norm(gradient(value, p), axis=1))


def gyroid(p: Floats) -> Floats:
    """Schoen's."""
    x, y, z = 4.0 * p.T
    return np.asarray(np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x))


def can(rng: np.random.Generator, n: int) -> Floats:
    """Points on a cylinder with lids."""
    p = rng.uniform(-1.0, 1.0, (4 * n, 3))
    p = p[np.linalg.norm(p[:, :2], axis=1) < 1.0][:n]
    side = rng.random(len(p)) < 0.5
    p[side, :2] /= np.linalg.norm(p[side, :2], axis=1, keepdims=True)
    p[~side, 2] = np.sign(p[~side, 2])
    return np.asarray(0.6 * p)


def of_can(p: Floats) -> Floats:
    """The distance to it."""
    q = np.column_stack([np.linalg.norm(p[:, :2], axis=1), np.abs(p[:, 2])]) - 0.6
    return np.asarray(np.linalg.norm(np.maximum(q, 0.0), axis=1) - np.minimum(q.max(axis=1), 0.0))


def stairs(rng: np.random.Generator, n: int) -> Floats:
    """Points on four steps."""
    across, along = rng.uniform(0.0, 4.0, n), rng.uniform(-1.0, 1.0, n)
    flat = rng.random(n) < 0.6
    step = np.floor(across)
    part = across - step
    return np.column_stack([0.45 * (step + np.where(flat, part, 0.0)), along, 0.3 * (step + np.where(flat, 0.0, part - 1.0))])


def of_stairs(p: Floats) -> Floats:
    """The distance to them."""
    found = np.full(len(p), np.inf)
    for k in range(4):
        x, z = 0.45 * k, 0.3 * k
        treads = np.hypot(p[:, 0] - np.clip(p[:, 0], x, x + 0.45), p[:, 2] - z)
        risers = np.hypot(p[:, 0] - x, p[:, 2] - np.clip(p[:, 2], z - 0.3, z))
        found = np.minimum(found, np.minimum(treads, risers))
    return found


Surface = tuple[Callable[[np.random.Generator, int], Floats], Distance]
#: how points of a surface are strewn evenly, and how far points are from it
SURFACES: Mapping[str, Surface] = {
    "ball": (ball, lambda p: np.abs(np.linalg.norm(p, axis=1) - 1.0)),
    "box": (box, of_box),
    "land": (land, first_order(lambda p: p[:, 2] - height(p))),
    "torus": (torus, lambda p: np.abs(np.hypot(np.hypot(p[:, 0], p[:, 1]) - 1.0, p[:, 2]) - 0.4)),
    "can": (can, of_can),
    "stairs": (stairs, of_stairs),
    "gyroid": (projected(gyroid, 1.0), first_order(gyroid)),
}
#: the noise in tenths of spacings; d, u: density falls to an eighth, noise to a tenth from end to end; o: 2 % of outliers
NOISES = ("0", "1", "2", "4", "6", "d3", "o3", "u3")
LOOKED_AT, UNSEEN = ("ball", "box", "land", "angel"), ("torus", "can", "stairs", "gyroid", "rabbit", "iron")


def scan(file: Path) -> tuple[Floats, Distance]:
    """The vertices of a scan around its first one that are as many as a cloud has, and the distance to its surface."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(file))
    vertices, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    near = np.argsort(np.linalg.norm(vertices - vertices[len(vertices) // 2], axis=1))[:POINTS]
    return vertices[near], lambda p: np.sqrt(igl.point_mesh_squared_distance(p, vertices, faces)[0])


def with_outliers(points: Floats, rng: np.random.Generator, spacing: float) -> tuple[Floats, Bools]:
    """The points and 2 % more within ten spacings; which are the points."""
    more = points[rng.integers(len(points), size=len(points) // 50)]
    more = more + ball(rng, len(more)) * rng.uniform(1.0, 10.0, (len(more), 1)) * spacing
    order = rng.permutation(len(points) + len(more))
    return np.concatenate([points, more])[order], order < len(points)


def clouds(names: Sequence[str], noises: Sequence[str] = NOISES, *, scans: Path | None = None) -> Iterator[CloudPair]:
    """Every shape with every noise; scans only if their folder is given."""
    for name in names:
        if name not in SURFACES and (scans is None or not list(scans.glob(f"{name}.*"))):
            continue
        for number, noise in enumerate(noises):
            rng = np.random.default_rng([len(name), ord(name[0]), number])
            if name in SURFACES:
                strewn, distance = SURFACES[name]
                points = strewn(rng, POINTS)
            else:
                points, distance = scan(next(scans.glob(f"{name}.*")))  # type: ignore[union-attr]
            place = (points[:, 0] - points[:, 0].min()) / np.ptp(points[:, 0])
            if noise.startswith("d"):
                points = points[rng.random(len(points)) < 8.0**-place]
            spacing = spacing_of(points)
            noise_of = float(noise.lstrip("duo")) / 10.0 * spacing * (10.0**-place if noise.startswith("u") else 1.0)
            noisy = points + rng.normal(size=points.shape) * np.reshape(noise_of, (-1, 1))
            kept = np.ones(len(noisy), dtype=np.bool_)
            if noise.startswith("o"):
                noisy, kept = with_outliers(noisy, rng, spacing)
            yield CloudPair(f"{name}_{noise}", noisy, spacing, kept, distance)
