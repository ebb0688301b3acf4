"""Made scans for `suggestions.py`: three sets of ten kinds, each a shape without noise, a noise, and its level."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import pymeshlab
import trimesh
from denoising_metrics import Floats, Ints
from denoising_pairs import Noise, along_an_axis, along_normals, between_rows, depth_map, in_order, level_set, remeshed, uniform

from pymeshfair.filters.geometry import mean_edge_length

Mesh = tuple[Floats, Ints]


def made(**filters: dict[str, object]) -> Mesh:
    """What MeshLab's filters make, one after the other."""
    meshes = pymeshlab.MeshSet()
    for name, values in filters.items():
        getattr(meshes, name)(**values)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def ball() -> Mesh:
    """A ball."""
    return made(create_sphere={"radius": 1.0, "subdiv": 4})


def box() -> Mesh:
    """A box of even triangles."""
    cells: dict[str, object] = {"targetlen": pymeshlab.PureValue(0.04), "iterations": 6}
    return made(create_cube={"size": 1.0}, meshing_isotropic_explicit_remeshing=cells)


def bumpy(height: float = 0.03) -> Mesh:
    """A ball with bumps of about ten edges."""
    points, faces = ball()
    x, y, z = 6.0 * points.T
    return points * (1.0 + height * np.sin(x) * np.sin(y) * np.cos(z))[:, None], faces


def doughnut() -> Mesh:
    """A torus."""
    return made(create_torus={"hradius": 2.0, "vradius": 0.7, "hsubdiv": 90, "vsubdiv": 30})


def sheet(rows: int, columns: int, height: Callable[[Floats, Floats], Floats]) -> Mesh:
    """Heights over a grid."""
    x, y = np.meshgrid(np.arange(float(rows)), np.arange(float(columns)), indexing="ij")
    return np.stack([x, y, height(x, y)], -1).reshape(-1, 3), between_rows(np.arange(x.size).reshape(x.shape))


def hills(steps: float = 0.0) -> Mesh:
    """A sheet with hills, or with steps of some height."""
    wave = 0.0 if steps else 3.0
    return sheet(55, 50, lambda x, y: wave * np.sin(x / 9.0) * np.cos(y / 8.0) + steps * (x > 25) + steps * (y > 30))


def turned(radius: Floats, along: Floats) -> Mesh:
    """Ninety points around the z axis at each height, open at both ends."""
    around = np.arange(90)[:, None] * np.pi / 45
    points = np.stack(np.broadcast_arrays(radius * np.cos(around), radius * np.sin(around), along), -1).reshape(-1, 3)
    index = np.arange(90 * len(along)).reshape(90, -1)
    return points, between_rows(np.concatenate([index, index[:1]]))


def vase() -> Mesh:
    """A vase without a bottom."""
    along = np.linspace(0.0, 3.0, 55)
    return turned(0.6 + 0.3 * np.sin(1.3 * along) + 0.15 * np.cos(4.0 * along), along)


def knot() -> Mesh:
    """A tube along a torus knot of five turns."""
    t, around = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 321), np.linspace(0.0, 2.0 * np.pi, 21), indexing="ij")
    out = np.stack([np.cos(2.0 * t), np.sin(2.0 * t), 0.0 * t], -1)
    middle = (2.0 + 0.8 * np.cos(5.0 * t))[..., None] * out + 0.8 * np.sin(5.0 * t)[..., None] * np.array([0.0, 0.0, 1.0])
    tangent = np.gradient(middle, axis=0)
    across = np.cross(tangent, out)
    sides = [side / np.linalg.norm(side, axis=-1, keepdims=True) for side in (across, np.cross(tangent, across))]
    points = middle + 0.28 * (np.cos(around)[..., None] * sides[0] + np.sin(around)[..., None] * sides[1])
    index = np.arange(320 * 20).reshape(320, 20)
    index = np.concatenate([index, index[:1]])
    return points[:-1, :-1].reshape(-1, 3), between_rows(np.concatenate([index, index[:, :1]], axis=1))[:, ::-1]


def hand() -> Mesh:
    """A palm with five fingers that run into it."""
    bones = [((0.0, -0.7, 0.0), (0.0, -0.3, 0.0), 0.3), ((-0.2, -0.5, 0.0), (-0.75, 0.1, 0.1), 0.1)]
    bones += [((x, -0.3, 0.0), (1.8 * x, y, 0.1), 0.09) for x, y in ((-0.24, 0.55), (-0.08, 0.75), (0.08, 0.7), (0.24, 0.45))]

    def value(x: Floats, y: Floats, z: Floats) -> Floats:
        points, near = np.stack([x, y, z], -1), np.zeros_like(x)
        for start, end, thick in bones:
            along = np.subtract(end, start)
            share = np.clip((points - start) @ along / (along @ along), 0.0, 1.0)
            near += np.exp(-12.0 * (np.linalg.norm(points - start - share[:, None] * along, axis=1) - thick))
        return np.asarray(1.0 - near)

    return level_set(value, 70, 1.2)


def stairs() -> Mesh:
    """Five steps."""
    steps = [trimesh.creation.box(bounds=[[0.3 * k, 0.0, 0.0], [1.5, 1.0, 0.25 * (k + 1)]]) for k in range(5)]
    return joined(steps, "union")


def pipe() -> Mesh:
    """A pipe with six holes in its wall."""
    bores = [trimesh.creation.cylinder(radius=0.8, height=5.0, sections=90)]
    for k in range(6):
        bore = trimesh.creation.cylinder(radius=0.25, height=1.5, sections=40)
        turn = trimesh.transformations.rotation_matrix(0.5 * np.pi, [np.cos(k), np.sin(k), 0.0])  # type: ignore[no-untyped-call]
        bore.apply_transform(turn)
        bore.apply_translation([-np.sin(k) * 0.9, np.cos(k) * 0.9, 0.5 * k - 1.25])
        bores.append(bore)
    return joined([trimesh.creation.cylinder(radius=1.0, height=4.0, sections=90), *bores], "difference")


def joined(parts: Sequence[trimesh.Trimesh], how: str) -> Mesh:
    """Parts united, or all others cut out of the first, meshed anew evenly."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(parts[0].vertices, parts[0].faces))
    for part in parts[1:]:
        meshes.add_mesh(pymeshlab.Mesh(part.vertices, part.faces))
        last = meshes.mesh_number() - 1
        getattr(meshes, f"generate_boolean_{how}")(first_mesh=last - 1, second_mesh=last)
    return remeshed(in_order(meshes), 1.4)


def coin() -> Mesh:
    """A coin with a rim and a star on it, a little worn."""

    def value(x: Floats, y: Floats, z: Floats) -> Floats:
        r, star = np.hypot(x, y), 0.45 + 0.15 * np.cos(5.0 * np.arctan2(y, x))
        half = 0.12 + 0.02 * np.tanh(20.0 * (star - r)) + 0.03 * np.tanh(25.0 * (r - 0.8))
        return ((r / 0.95) ** 12 + (z / half) ** 12) ** (1.0 / 12.0) - 1.0

    return level_set(value, 120, 1.0)


def land() -> Mesh:
    """Land whose waves are the lower the shorter they are, by the power 2.5."""
    n, rng = 70, np.random.default_rng(38)
    length = np.hypot(*np.meshgrid(np.fft.fftfreq(n) * n, np.fft.fftfreq(n) * n))
    heights = np.fft.ifft2(np.fft.fft2(rng.normal(size=(n, n))) / np.maximum(length, 1.0) ** 2.5).real
    return sheet(n, n, lambda x, y: 4.0 * heights / heights.std())


def seen(height: Callable[[Floats, Floats], Floats], pixels: int) -> Mesh:
    """Heights as a camera sees them, cut where the depth jumps."""
    truth, faces = depth_map(height, pixels)
    return truth, faces[:, ::-1]


def still_life() -> Mesh:
    """A ball before a wall and a box before both."""

    def height(x: Floats, y: Floats) -> Floats:
        ball = np.sqrt(np.maximum(0.2 - (x + 0.3) ** 2 - (y - 0.1) ** 2, 0.0))
        return np.maximum(ball, np.where((abs(x - 0.5) < 0.25) & (abs(y + 0.2) < 0.4), 0.5 + 0.5 * (x - 0.5), 0.1 * y))

    return seen(height, 80)


def pillars() -> Mesh:
    """Three pillars before a hollow wall."""

    def height(x: Floats, y: Floats) -> Floats:
        fronts = [np.sqrt(np.maximum(r**2 - (x - at) ** 2, 0.0)) + 0.1 for at, r in ((-0.55, 0.2), (0.0, 0.3), (0.6, 0.15))]
        return np.where(y < 0.5, np.max([0.3 * x**2 + 0.2 * y**2, *fronts], axis=0), 0.3 * x**2 + 0.2 * y**2)

    return seen(height, 90)


def nut() -> Mesh:
    """A nut with six sides."""
    parts = [trimesh.creation.cylinder(radius=r, height=h, sections=n) for r, h, n in ((1.0, 0.8, 6), (0.5, 2.0, 60))]
    return joined(parts, "difference")


def cross() -> Mesh:
    """Three bars across each other."""
    return joined([trimesh.creation.box(np.roll([2.0, 0.5, 0.6], k)) for k in range(3)], "union")


def noisy(level: float, share: float = 1.0) -> Noise:
    """Noise in all directions, in mean edges, on a share of the vertices."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        hit = r.random(len(v)) < share
        return v + r.normal(scale=level * mean_edge_length(v, f), size=v.shape) * hit[:, None]

    return displaced


def shared(level: float, own: float = 0.0) -> Noise:
    """Noise along the view from the origin, in mean edges, that neighbours share, and some, over that, that they do not."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        away, corners = r.normal(size=len(v)), f.ravel()
        for _ in range(2):
            sums = np.bincount(corners, np.repeat(away[f].mean(axis=1), 3), len(v))
            away = sums / np.bincount(corners, minlength=len(v))
        depth, unit = np.linalg.norm(v, axis=1), away.std()
        away = away + own * unit * r.normal(size=len(v))
        return np.asarray(v * (1.0 + level * mean_edge_length(v, f) * away / unit / depth)[:, None])

    return displaced


def cloudy(level: float, one_in: int = 50) -> Noise:
    """Noise in all directions, and one point in so many anywhere in the bounding box."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        return np.concatenate([noisy(level)(v, f, r), r.uniform(v.min(axis=0), v.max(axis=0), (len(v) // one_in, 3))])

    return displaced


def heavy_tailed(level: float) -> Noise:
    """Noise in all directions, of Student's distribution with four degrees of freedom."""
    return lambda v, f, r: v + level * np.sqrt(0.5) * mean_edge_length(v, f) * r.standard_t(4, size=v.shape)


def louder(level: float) -> Noise:
    """Noise in all directions, along x from a third of the level to all of it."""
    return lambda v, f, r: v + (noisy(level)(v, f, r) - v) * (1.0 + 2.0 * (v[:, :1] - v[:, 0].min()) / np.ptp(v[:, 0])) / 3.0


def rounded(level: float) -> Noise:
    """Coordinates rounded to steps of the level."""
    return lambda v, f, r: np.round(v / (level * mean_edge_length(v, f))) * level * mean_edge_length(v, f)


#: surfaces given by formulas
FORMULAS: dict[str, Callable[[], Mesh]] = {
    "Schwarz's P": partial(level_set, lambda x, y, z: np.cos(3.5 * x) + np.cos(3.5 * y) + np.cos(3.5 * z), 50, 1.5),
    "cushion": partial(level_set, lambda x, y, z: x**4 + y**4 + (1.5 * z) ** 4 - 0.5, 50, 1.3),
    "star fruit": partial(
        level_set, lambda x, y, z: np.hypot(x, y) / (1.0 + 0.2 * np.cos(5.0 * np.arctan2(y, x))) ** 2 + z**2 - 0.6, 60, 1.1
    ),
    "tangle": partial(level_set, lambda x, y, z: 6.76 * (x**4 + y**4 + z**4) - 5.0 * (x**2 + y**2 + z**2) + 1.75, 70, 1.1),
    "capsule": partial(level_set, lambda x, y, z: np.hypot(np.hypot(x, y), np.maximum(abs(z) - 0.5, 0.0)) - 0.4, 50, 1.2),
}

#: by name: the truth, the noise of a level and a share, the level in mean edges
Kinds = dict[str, tuple[Callable[[], Mesh], Callable[[float], Noise], float]]
FIRST: Kinds = {
    "ball, noise": (ball, noisy, 0.3),
    "box, noise": (box, noisy, 0.25),
    "bumps, no noise": (bumpy, noisy, 0.0),
    "bumps, noise": (bumpy, noisy, 0.2),
    "torus, weak noise": (doughnut, noisy, 0.1),
    "range map of hills, noise": (hills, noisy, 0.2),
    "range map of steps, noise": (lambda: hills(8.0), noisy, 0.15),
    "range map of hills, no noise": (hills, noisy, 0.0),
    "open tube, noise": (lambda: turned(np.ones(40), 0.07 * np.arange(40.0)), noisy, 0.2),
    "box, impulses": (box, partial(noisy, share=0.2), 0.6),
}
SECOND: Kinds = {
    "vase, noise": (vase, along_normals, 0.25),
    "knot, weak noise": (knot, noisy, 0.12),
    "Schwarz surface, no noise": (FORMULAS["Schwarz's P"], noisy, 0.0),
    "hand, even noise": (hand, uniform, 0.35),
    "stairs, noise": (stairs, along_normals, 0.2),
    "coin, weak noise": (coin, along_normals, 0.08),
    "land, noise of heights": (land, along_an_axis, 0.2),
    "range map of a camera, shared noise": (still_life, shared, 0.2),
    "cloud of a cushion, stray points": (FORMULAS["cushion"], cloudy, 0.3),
    "pipe, impulses": (pipe, partial(along_normals, share=0.15), 0.7),
}
THIRD: Kinds = {
    "star fruit, heavy tails": (FORMULAS["star fruit"], heavy_tailed, 0.2),
    "nut, noise": (nut, noisy, 0.3),
    "catenoid, no noise": (lambda: turned(np.cosh(np.linspace(-1.2, 1.2, 40)), np.linspace(-1.2, 1.2, 40)), noisy, 0.0),
    "saddle, noise of heights": (
        lambda: sheet(60, 60, lambda x, y: (x - 30) * (y - 25) / 60 + abs(x - y) / 9),
        along_an_axis,
        0.25,
    ),
    "capsule, uneven noise": (FORMULAS["capsule"], louder, 0.3),
    "tangle, weak noise": (FORMULAS["tangle"], along_normals, 0.1),
    "range map of pillars, shared and own noise": (pillars, partial(shared, own=0.3), 0.15),
    "cloud of a star fruit, more stray points": (FORMULAS["star fruit"], partial(cloudy, one_in=20), 0.15),
    "cross, impulses": (cross, partial(noisy, share=0.1), 0.8),
    "tangle, rounded": (FORMULAS["tangle"], rounded, 0.4),
}
SETS = {"first": FIRST, "second": SECOND, "third": THIRD}
