"""Scans drawn from random numbers for `suggestions.py`: ten of these families of shapes, no two alike, and ten noises.

Every number draws one set of ten kinds: one without noise, one with impulses, one rounded, a map of a camera with noise that
neighbours share, a cloud with stray points, and five whose noise is drawn from seven. Levels are drawn too.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh
from denoising_metrics import Floats, Ints
from denoising_pairs import Noise, along_normals, in_order, level_set, mesh_set, remeshed, uniform
from scipy import spatial
from suggestion_scans import Kinds, Mesh, cloudy, heavy_tailed, joined, louder, noisy, rounded, seen, shared, sheet, turned

#: draws a shape
Family = Callable[[np.random.Generator], Mesh]
#: heights over a plane
Heights = Callable[[Floats, Floats], Floats]


def superquadric(r: np.random.Generator) -> Mesh:
    """From an octahedron with round faces to a box with round edges."""
    p, wide = r.uniform(1.3, 9.0), r.uniform(0.45, 0.9, 3)

    def value(x: Floats, y: Floats, z: Floats) -> Floats:
        return np.asarray(abs(x / wide[0]) ** p + abs(y / wide[1]) ** p + abs(z / wide[2]) ** p - 1.0)

    return level_set(value, 50, 1.4)


def blobs(r: np.random.Generator) -> Mesh:
    """Five balls that run into each other, or not."""
    middles, radii = r.uniform(-0.5, 0.5, (5, 3)), r.uniform(0.15, 0.35, 5)

    def value(x: Floats, y: Floats, z: Floats) -> Floats:
        away = np.stack([x, y, z], -1)[:, None] - middles
        return np.asarray(1.0 - np.exp(3.0 * (1.0 - (away**2).sum(-1) / radii**2)).sum(axis=1))

    return level_set(value, 60, 1.3)


def lattice(r: np.random.Generator) -> Mesh:
    """A ball cut out of walls along a gyroid: sharp rims, saddles, many handles."""
    a, b, c = r.uniform(3.5, 5.5, 3)

    def value(x: Floats, y: Floats, z: Floats) -> Floats:
        saddles = np.sin(a * x) * np.cos(b * y) + np.sin(b * y) * np.cos(c * z) + np.sin(c * z) * np.cos(a * x)
        return np.asarray(np.maximum(abs(saddles) - 0.5, 4.0 * (np.sqrt(x**2 + y**2 + z**2) - 0.9)))

    return level_set(value, 80, 1.3)


def scattered_land(r: np.random.Generator) -> Mesh:
    """Hills over points that lie anywhere: open, triangles of all shapes."""
    points, tops = r.uniform(0.0, 60.0, (3500, 2)), r.uniform(0.0, 60.0, (12, 2))
    high, wide = r.uniform(-4.0, 6.0, 12), r.uniform(5.0, 14.0, 12)
    away = ((points[:, None] - tops) ** 2).sum(-1)
    corners = spatial.Delaunay(points).simplices
    sides = np.sort(np.linalg.norm(points[corners] - points[np.roll(corners, 1, axis=1)], axis=2), axis=1)
    kept = corners[sides[:, 2] < 4.0]  # without the long ones at the border
    return used(np.column_stack([points, (high * np.exp(-away / wide**2)).sum(axis=1)]), kept.astype(np.int32))


def roofs(r: np.random.Generator) -> Mesh:
    """The highest of many slanting planes over a grid, cut off at a height: sharp, open."""
    slopes, at = r.uniform(-1.2, 1.2, (9, 2)), r.uniform(0.0, 56.0, (9, 2))

    def heights(x: Floats, y: Floats) -> Floats:
        planes = [s[0] * (x - p[0]) + s[1] * (y - p[1]) for s, p in zip(slopes, at, strict=True)]
        return np.asarray(np.clip(np.sort(planes, axis=0)[4], -8.0, 10.0))

    return sheet(57, 54, heights)


def rings(r: np.random.Generator) -> Mesh:
    """A chain of three rings, which do not touch: three parts."""
    parts = []
    for k in range(3):
        ring = trimesh.creation.torus(1.0, r.uniform(0.15, 0.3), major_sections=70, minor_sections=20)
        ring.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi * k, [1.0, 0.0, 0.0]))  # type: ignore[no-untyped-call]
        ring.apply_translation([1.3 * k, 0.0, 0.0])
        parts.append(ring)
    starts = np.cumsum([0, *(len(ring.vertices) for ring in parts)])
    faces = [ring.faces + start for ring, start in zip(parts, starts, strict=False)]
    return np.concatenate([ring.vertices for ring in parts]), np.concatenate(faces).astype(np.int32)


def crystal(r: np.random.Generator) -> Mesh:
    """The hull of twenty points on a ball, meshed evenly."""
    points = r.normal(size=(20, 3))
    hull = trimesh.Trimesh(points / np.linalg.norm(points, axis=1, keepdims=True)).convex_hull
    return remeshed(in_order(mesh_set((np.array(hull.vertices), np.array(hull.faces, dtype=np.int32)))), 1.5)


def block(r: np.random.Generator) -> Mesh:
    """A block with three bores and a groove."""
    size = r.uniform(1.2, 2.2, 3)
    cuts = [trimesh.creation.cylinder(radius=0.18 * size.min(), height=5.0, sections=50) for _ in range(3)]
    for k, cut in enumerate(cuts):
        cut.apply_translation([(k - 1) * 0.28 * size[0], r.uniform(-0.2, 0.2) * size[1], 0.0])
    groove = trimesh.creation.box([0.2 * size[0], 5.0, 0.5 * size[2]])
    groove.apply_translation([r.uniform(-0.2, 0.2), 0.0, 0.5 * size[2]])
    return joined([trimesh.creation.box(size), *cuts, groove], "difference")


def bowl(r: np.random.Generator) -> Mesh:
    """A turned wall of a drawn profile, open at both ends."""
    along, waves = np.linspace(0.0, 3.2, 60), r.uniform(-0.12, 0.12, 5)
    radius = 0.9 + r.uniform(-0.2, 0.2) * along + sum(a * np.sin((k + 1) * along + k) for k, a in enumerate(waves))
    return turned(np.asarray(radius), along)


def winding_tube(r: np.random.Generator) -> Mesh:
    """A tube along a closed curve of three waves an axis, its thickness varying."""
    t, waves, phases = np.linspace(0.0, 2.0 * np.pi, 301)[:-1], r.uniform(0.3, 1.0, (3, 3)), r.uniform(0.0, 6.3, (3, 3))
    order = np.arange(1, 4)
    middle = 3.0 * (waves[:, :, None] / order[:, None] * np.sin(order[:, None] * t + phases[:, :, None])).sum(axis=1).T

    def value(points: Floats) -> Floats:
        near, at = spatial.cKDTree(middle).query(points)
        return np.asarray(near - 0.45 - 0.1 * np.sin(5.0 * t[at]))

    low, reach = middle.min(axis=0) - 0.8, np.ptp(middle, axis=0).max() + 1.6
    return level_set(lambda x, y, z: value(low + 0.5 * reach * (np.stack([x, y, z], -1) + 1.0)), 90, 1.0)


def helicoid(r: np.random.Generator) -> Mesh:
    """A winding ramp with a wave on it, open."""
    turn, wave = r.uniform(0.03, 0.06), r.uniform(0.2, 0.6)
    points, faces = sheet(120, 28, lambda x, y: wave * np.sin(0.35 * y) + 0.35 * x)
    x, y, z = points.T
    return np.column_stack([(y + 12.0) * np.cos(turn * x), (y + 12.0) * np.sin(turn * x), z]), faces


def lump(r: np.random.Generator) -> Mesh:
    """A coarse ball with its corners moved, subdivided by Loop's rule: smooth, triangles of two sizes."""
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.vertices *= r.uniform(0.55, 1.3, (len(ball.vertices), 1))
    smooth = ball.subdivide_loop(4)
    return np.array(smooth.vertices), np.array(smooth.faces, dtype=np.int32)


def view(r: np.random.Generator) -> Mesh:
    """A camera's map of a drawn scene: round and flat things before a slanting wall, which may be hollow."""
    slant, hollow = r.uniform(-0.3, 0.3, 2), r.uniform(0.0, 0.4)
    places, sizes, boxes = r.uniform(-0.7, 0.7, (4, 2)), r.uniform(0.2, 0.45, 4), r.random(4) < 0.4

    def heights(x: Floats, y: Floats) -> Floats:
        things = [slant[0] * x + slant[1] * y + hollow * (x**2 + y**2)]
        for (a, b), size, is_box in zip(places, sizes, boxes, strict=True):
            round_ = np.sqrt(np.maximum(size**2 - (x - a) ** 2 - (y - b) ** 2, 0.0)) + 0.2
            inside = (abs(x - a) < size) & (abs(y - b) < 0.7 * size) if is_box else round_ > 0.2
            things.append(np.where(inside, 0.4 + slant[1] * (x - a) if is_box else round_, -9.0))
        return np.asarray(np.max(things, axis=0))

    return seen(heights, 75)


def used(points: Floats, faces: Ints) -> Mesh:
    """The vertices that faces have, and these."""
    numbers, corners = np.unique(faces, return_inverse=True)
    return points[numbers], corners.reshape(-1, 3).astype(np.int32)


def along_the_surface(level: float) -> Noise:
    """Along the normals, and twice as much in all directions along the surface."""
    return lambda v, f, r: _across(v, f, noisy(1.5 * level)(v, f, r) - v, 1.0 / 1.5)


def _across(v: Floats, f: Ints, way: Floats, share: float) -> Floats:
    """The vertices moved by that, of which this share along the normals."""
    normals = along_normals(1.0)(v, f, np.random.default_rng(0)) - v
    unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return np.asarray(v + way - (1.0 - share) * np.einsum("ij,ij->i", way, unit)[:, None] * unit)


def in_patches(level: float) -> Noise:
    """Along the normals, from a half of the level to all of it, by waves over the shape."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        waves = np.sin(9.0 * (v - v.min(axis=0)) / np.ptp(v, axis=0).max() + r.uniform(0.0, 6.3, 3)).mean(axis=1)
        return np.asarray(v + (along_normals(level)(v, f, r) - v) * (0.75 + 0.25 * waves)[:, None])

    return displaced


#: shapes with and without a border, sharp and smooth, of one part and of several
FAMILIES: tuple[Family, ...] = (
    superquadric,
    blobs,
    lattice,
    scattered_land,
    roofs,
    rings,
    crystal,
    block,
    bowl,
    winding_tube,
    helicoid,
    lump,
)
#: noises that are drawn, with the least level and the largest, in mean edges
NOISES: dict[str, tuple[Callable[[float], Noise], float, float]] = {
    "noise": (noisy, 0.1, 0.35),
    "noise along normals": (along_normals, 0.08, 0.35),
    "even noise": (uniform, 0.15, 0.45),
    "heavy tails": (heavy_tailed, 0.1, 0.25),
    "louder noise": (louder, 0.2, 0.35),
    "noise in patches": (in_patches, 0.15, 0.35),
    "more noise along the surface": (along_the_surface, 0.1, 0.2),
}


def drawn(number: int) -> Kinds:
    """The ten kinds of a number."""
    r = np.random.default_rng([number, 30])
    shapes = [FAMILIES[k] for k in r.permutation(len(FAMILIES))]
    fixed: dict[str, tuple[Callable[[float], Noise], float, float]] = {
        "no noise": (noisy, 0.0, 0.0),
        "impulses": (partial(noisy, share=r.uniform(0.05, 0.2)), 0.5, 0.9),
        "rounded": (rounded, 0.25, 0.5),
        "stray points": (partial(cloudy, one_in=int(r.integers(20, 80))), 0.1, 0.3),
        "shared noise": (partial(shared, own=r.uniform(0.2, 0.5)), 0.12, 0.25),
    }
    others = {name: NOISES[name] for name in r.permutation(list(NOISES))[:5]}
    kinds: Kinds = {}
    for name, (noise, least, most) in (fixed | others).items():
        family = view if name == "shared noise" else shapes.pop()
        seed = int(r.integers(1 << 30))
        kinds[f"{family.__name__.replace('_', ' ')}, {name}"] = (_of(family, seed), noise, float(r.uniform(least, most)))
    return kinds


def _of(family: Family, seed: int) -> Callable[[], Mesh]:
    return lambda: family(np.random.default_rng(seed))
