"""Noisy meshes whose truth is known, of shapes that everyone has, in two halves that share no shape.

`LOOKED_AT` may be looked at while constants are chosen. `UNSEEN` is for the last run alone: what is tuned on it tells nothing any
more. Shapes are pymeshlab's samples, generated parts and surfaces, and scans smoothed to be a truth if their folder is given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import igl
import numpy as np
import pymeshlab
import trimesh
from denoising_holdouts import (
    SAMPLES,
    between_rows,
    chest_mesh,
    dodecahedron,
    halved,
    in_order,
    lens,
    part,
    remeshed,
    taken,
    torus,
)
from denoising_metrics import Floats, Ints, NoisyPair

from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.geometry import mean_edge_length

#: the noise of a mesh: vertices, faces and random numbers to the displaced vertices
Noise = Callable[[Floats, Ints, np.random.Generator], Floats]
#: makes vertices and faces
Maker = Callable[[], tuple[Floats, Ints]]


class Shape(NamedTuple):
    """A shape, the names of the noises that it gets, and how it is made."""

    name: str
    noises: str
    make: Maker


def along_normals(level: float, share: float = 1.0) -> Noise:
    """A share of the vertices is off along the normals, by a normally distributed height of `level` mean edges."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        return _raised(v, f, r.normal(size=len(v)) * level * (r.random(len(v)) < share))

    return displaced


def all_directions(level: float, share: float = 1.0) -> Noise:
    """A share of the vertices is off along every axis, by a normally distributed length of `level` mean edges."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        moves = r.normal(size=v.shape) * level * mean_edge_length(v, f)
        return v + moves * (r.random(len(v)) < share)[:, None]

    return displaced


def uniform(reach: float) -> Noise:
    """Evenly distributed in a cube of twice `reach` mean edges."""
    return lambda v, f, r: v + r.uniform(-reach, reach, size=v.shape) * mean_edge_length(v, f)


def uneven(levels: Callable[[Floats], Floats]) -> Noise:
    """Along the normals, of so many mean edges as `levels` says of places scaled to a box from 0 to 1."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        return _raised(v, f, r.normal(size=len(v)) * levels((v - v.min(axis=0)) / np.ptp(v, axis=0)))

    return displaced


def _raised(v: Floats, f: Ints, heights: Floats) -> Floats:
    """The vertices moved along their normals, by heights in mean edges."""
    return v + (heights * mean_edge_length(v, f))[:, None] * smooth_normals(v, f)


def along_an_axis(level: float) -> Noise:
    """Along z alone, as of a scanner that looks down: nothing on what is parallel to its view."""
    return lambda v, f, r: v + np.outer(r.normal(size=len(v)) * level * mean_edge_length(v, f), [0.0, 0.0, 1.0])


def rounded(step: float) -> Noise:
    """Every vertex is rounded along one slanting axis to steps of so many mean edges, as depths of a camera are."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        axis = np.array([0.2, 0.3, 0.93]) / np.linalg.norm([0.2, 0.3, 0.93])
        heights, length, phase = v @ axis, step * mean_edge_length(v, f), r.random()
        return v + np.outer((np.round(heights / length + phase) - phase) * length - heights, axis)

    return displaced


#: n: along the normals, a: in all directions, u: evenly in all directions, i: impulses along the normals, s: in all directions on
#: three in ten vertices, h: along the normals, a sixth of it on one half, g: growing from 0 to it along x, x: along an axis,
#: q: rounded along a slanting one; the number is in tenths of mean edges
NOISES: dict[str, Noise] = {
    **{f"n{10 * level:g}": along_normals(level) for level in (0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 0.6)},
    **{f"a{10 * level:g}": all_directions(level) for level in (0.1, 0.2, 0.3)},
    "u4": uniform(0.4),
    "i5": along_normals(0.5, share=0.2),
    "i10": along_normals(1.0, share=0.05),
    "i8": along_normals(0.8, share=0.5),
    "h3": uneven(lambda p: np.where(p[:, 1] > np.median(p[:, 1]), 0.3, 0.05)),
    "g4": uneven(lambda p: 0.4 * p[:, 0]),
    "x2": along_an_axis(0.2),
    **{f"q{10 * step:g}": rounded(step) for step in (0.3, 0.6)},
    **{f"s{10 * level:g}": all_directions(level, share=0.3) for level in (0.2, 0.4, 0.8)},
}


def gear() -> tuple[Floats, Ints]:
    """A wheel of fourteen teeth with a bore."""
    turn = np.linspace(0.0, 2.0 * np.pi, 14, endpoint=False)
    around, radius = [], []
    for angle in turn:
        for part_of_tooth, r in ((0.0, 0.8), (0.14, 0.8), (0.2, 1.0), (0.3, 1.0), (0.36, 0.8)):
            around.append(angle + part_of_tooth * 2.0 * np.pi / 14 / 0.45)
            radius.append(r)
    outline = np.column_stack([np.cos(around), np.sin(around)]) * np.array(radius)[:, None]
    meshes = pymeshlab.MeshSet()
    count = len(outline)
    top, bottom = (np.column_stack([outline, np.full(count, z)]) for z in (0.2, -0.2))
    points = np.concatenate([top, bottom, [[0, 0, 0.2], [0, 0, -0.2]]])
    faces = []
    for k in range(count):
        n = (k + 1) % count
        faces += [[k, n, 2 * count], [count + n, count + k, 2 * count + 1], [n, k, count + k], [n, count + k, count + n]]
    bore = trimesh.creation.cylinder(radius=0.35, height=1.0, sections=64)
    meshes.add_mesh(pymeshlab.Mesh(points, np.array(faces)))
    meshes.add_mesh(pymeshlab.Mesh(bore.vertices, bore.faces))
    meshes.generate_boolean_difference(first_mesh=0, second_mesh=1)
    return remeshed(meshes, 1.3)


def level_set(value: Callable[[Floats, Floats, Floats], Floats], n: int, edge: float) -> tuple[Floats, Ints]:
    """Where a function is 0, in the cube from -1 to 1, meshed anew evenly."""
    axis = np.linspace(-1.0, 1.0, n)
    z, y, x = (a.ravel() for a in np.meshgrid(axis, axis, axis, indexing="ij"))
    vertices, faces, *_ = igl.marching_cubes(value(x, y, z), np.column_stack([x, y, z]), n, n, n, 0.0)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_isotropic_explicit_remeshing(iterations=8, targetlen=pymeshlab.PercentageValue(edge), featuredeg=180)
    return remeshed(meshes, 0.0)


def gyroid() -> tuple[Floats, Ints]:
    """Saddles everywhere, and an open border: part of a minimal surface."""
    return level_set(
        lambda x, y, z: np.sin(4 * x) * np.cos(4 * y) + np.sin(4 * y) * np.cos(4 * z) + np.sin(4 * z) * np.cos(4 * x), 60, 1.4
    )


def blobs() -> tuple[Floats, Ints]:
    """Balls of several sizes that run into each other: round, with narrow valleys."""
    rng = np.random.default_rng(5)
    centres, sizes = rng.uniform(-0.55, 0.55, size=(14, 3)), rng.uniform(0.1, 0.3, size=14)

    def value(x: Floats, y: Floats, z: Floats) -> Floats:
        balls = zip(centres, sizes, strict=True)
        heights = [np.exp(-2.5 * (((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / s**2 - 1.0)) for (a, b, c), s in balls]
        return np.asarray(1.0 - np.sum(heights, axis=0))

    return level_set(value, 70, 1.2)


def terrain() -> tuple[Floats, Ints]:
    """Rough at all scales, on an irregular net of points with a border."""
    rng = np.random.default_rng(9)
    n = 75
    x, y = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n))
    x, y = (a + rng.uniform(-0.3, 0.3, size=a.shape) / n for a in (x, y))
    z = np.zeros_like(x)
    for octave in range(1, 5):
        for _ in range(4):
            direction, phase = rng.normal(size=2), rng.uniform(0, 6.28)
            z += 0.12 * 0.45**octave * np.sin(2**octave * 3.0 * (direction[0] * x + direction[1] * y) + phase)
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), _sheet(n)


def knot() -> tuple[Floats, Ints]:
    """A tube along a trefoil, its faces in rows and longer along it than across."""
    n, m = 260, 22
    t = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    middle = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    along = np.roll(middle, -1, axis=0) - np.roll(middle, 1, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    first = np.cross(along, np.cross(np.gradient(along, axis=0), along))
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(along, first)
    s = np.linspace(0.0, 2.0 * np.pi, m, endpoint=False)
    ring = np.cos(s)[None, :, None] * first[:, None, :] + np.sin(s)[None, :, None] * second[:, None, :]
    points = (middle[:, None, :] + 0.5 * ring).reshape(-1, 3)
    return points, _ring(n, m)


def house() -> tuple[Floats, Ints]:
    """A block of oblique planes, some of them nearly flush, cut from a box by planes."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*_box((2.0, 1.0, 1.0), np.eye(4))))
    rng = np.random.default_rng(21)
    for _ in range(6):
        move = trimesh.transformations.random_rotation_matrix(rng.random(3))
        move[:3, 3] = rng.normal(size=3)
        move[:3, 3] *= 1.25 / np.linalg.norm(move[:3, 3]) * np.array([1.4, 1.0, 1.0])
        meshes.add_mesh(pymeshlab.Mesh(*_box((1.1, 1.1, 1.1), move)))
        meshes.generate_boolean_difference(first_mesh=meshes.mesh_number() - 2, second_mesh=meshes.mesh_number() - 1)
    return remeshed(in_order(meshes), 1.5)


def turned() -> tuple[Floats, Ints]:
    """A turned part with steps, grooves and cones, its faces in rows and longer across them."""
    profile = np.array(
        [(0.3, 0.0), (1.0, 0.0), (1.0, 0.4), (0.7, 0.5), (0.7, 1.2), (0.9, 1.3), (0.9, 1.6), (0.5, 1.8), (0.5, 2.2), (0.3, 2.2)]
    )
    outline = []
    for start, end in pairwise(profile):
        pieces = max(2, int(np.linalg.norm(end - start) / 0.06))
        outline += [start + (end - start) * k / pieces for k in range(pieces)]
    radius, height = np.array(outline).T
    angles = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)[:, None]
    points = np.stack([radius * np.cos(angles), radius * np.sin(angles), np.broadcast_to(height, (90, len(height)))], axis=2)
    return points.reshape(-1, 3), _ring(90, len(height))


def plate() -> tuple[Floats, Ints]:
    """A curved sheet of one and a half edges' thickness."""
    n = 60
    x, y = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n))
    top = np.column_stack([x.ravel(), y.ravel(), (0.1 * np.sin(6.0 * x) * np.sin(5.0 * y)).ravel()])
    at, sheet = np.arange(n * n, dtype=np.int32).reshape(n, n), _sheet(n)
    rim = np.concatenate([at[0, :], at[1:, -1], at[-1, -2::-1], at[-2:0:-1, 0]])
    following, below = np.roll(rim, -1), n * n
    sides = [np.column_stack([rim, rim + below, following]), np.column_stack([following, rim + below, following + below])]
    faces = np.concatenate([sheet, sheet[:, ::-1] + below, *sides])
    return np.concatenate([top, top - [0.0, 0.0, 1.5 / n]]), faces.astype(np.int32)


def emblems() -> tuple[Floats, Ints]:
    """Squares, discs and rhombs with sloped sides on gentle waves, on an even grid with a border."""
    n = 85
    x, y = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n))
    z = 0.05 * np.sin(3.0 * x) * np.cos(2.0 * y)
    for i in range(3):
        for j in range(3):
            across, along = np.abs(x - 0.2 - 0.3 * i), np.abs(y - 0.2 - 0.3 * j)
            away = (np.maximum(across, along), np.hypot(across, along), across + along)[(i + j) % 3]
            z += np.clip((0.1 - away) * 4.0, 0.0, 0.05)
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), _sheet(n)


def _sheet(n: int) -> Ints:
    """The triangles of n rows of n vertices."""
    at = np.arange(n * n, dtype=np.int32).reshape(n, n)
    return halved(at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1])


def _ring(n: int, m: int) -> Ints:
    """The triangles of n closed rows of m vertices, the last row joined to the first."""
    at = np.arange(n * m, dtype=np.int32).reshape(n, m)
    following, beside = np.roll(at, -1, axis=0), np.roll(at, -1, axis=1)
    return halved(at, following, np.roll(following, -1, axis=1), beside)


def _box(size: tuple[float, float, float], move: Floats) -> tuple[Floats, Ints]:
    box = trimesh.creation.box(size, transform=move)
    return np.asarray(box.vertices), np.asarray(box.faces, dtype=np.int32)


def looked_at(scans: Path | None) -> tuple[Shape, ...]:
    """The half that constants may be found on."""
    shapes = (
        Shape("bunny10k", "n0.5 n1 n2 n3 n5 a3 i5 s2 s4 s8", lambda: taken(SAMPLES / "bunny10k_textured.obj")),
        Shape("cow", "n1 n3 a2 u4 i10", lambda: taken(SAMPLES / "cow.obj", edge=1.2)),
        Shape("bracket", "n0.5 n1 n2 n3 n5 a2 a3 i5 i10 u4 s4", lambda: part(True)),
        Shape("uneven", "n2 n3 i8", lambda: part(False)),
        Shape("lens", "n1 n2 n3 a2 i10", lens),
        Shape("torus", "n0.3 n1 n3 u4 i8", torus),
        Shape("blobs", "n0.3 n1 n2 n5 a1 i10 s4", blobs),
        Shape("terrain", "n1 n3 a2 i5 i10 s2 s4", terrain),
        Shape("turned", "n0.5 n2 h3 g4 x2", turned),
        Shape("plate", "n0.5 n2 h3 g4 x2", plate),
        Shape("emblems", "n0.5 n2 h3 g4 x2 q6", emblems),
    )
    return (*shapes, *_scans(scans, (("rabbit.obj", 16000, "n0.5 n2 n3 a3 i8 s2 s4 s8 q3"),)))


def unseen(scans: Path | None) -> tuple[Shape, ...]:
    """The half that only the last run sees."""
    shapes = (
        Shape("bone", "n0.5 n2 n5 a2 i5", lambda: taken(SAMPLES / "bone.ply", edge=1.1)),
        Shape(
            "bone_smooth", "n0.5 n2 n5 a2 i5 h3 x2 q6", lambda: _with_steps(*taken(SAMPLES / "bone.ply", edge=1.1), "taubin", 10)
        ),
        Shape("airplane", "n1 n2 n3 i10 s4 h3 x2 q3", lambda: taken(SAMPLES / "airplane.obj", edge=0.9)),
        Shape("chest", "n0.5 n1 n3 a3 i8 s8 g4 x2", chest_mesh),
        Shape("dodecahedron", "n0.3 n2 n5 a3 i5 h3 q6", dodecahedron),
        Shape("gear", "n0.5 n1 n2 n3 n6 a2 i5 u4 h3 g4 x2", gear),
        Shape("gyroid", "n0.3 n1 n3 a1 a3 i10 s2 g4 x2", gyroid),
        Shape("knot", "n1 n3 n5 a2 i8 s4 h3 x2", knot),
        Shape("house", "n0.5 n1 n2 n5 a3 i10 s2 h3 g4 x2", house),
    )
    figures = (("angel.obj", 24000, "n0.5 n2 n3 a2 i5 s2 h3 x2 q3"), ("iron.ply", 20000, "n1 n2 a3 i8 s4 g4"))
    return (*shapes, *_scans(scans, figures))


def _scans(folder: Path | None, wanted: Sequence[tuple[str, int, str]]) -> tuple[Shape, ...]:
    if folder is None:
        return ()
    return tuple(
        Shape(Path(file).stem, noises, partial(taken, folder / file, faces=faces, smooth=10)) for file, faces, noises in wanted
    )


def smoothed_scans(folder: Path | None) -> Iterator[tuple[str, Maker]]:
    """The scans of a folder, whole and with at most 20,000 faces, after some steps of MeshLab's smoothing."""
    if folder is None:
        return
    for file in ("rabbit.obj", "angel.obj", "iron.ply"):
        for faces in (0, 20_000):
            of = "" if faces == 0 else " decimated"
            for name, counts in (("laplacian", (1, 3, 10)), ("taubin", (5, 10, 30))):
                for count in counts:
                    yield f"{Path(file).stem}{of} {name} {count}", partial(_smoothed, folder / file, faces, name, count)


def _smoothed(path: Path, faces: int, name: str, count: int) -> tuple[Floats, Ints]:
    return _with_steps(*taken(path, faces=faces), name, count)


def _with_steps(vertices: Floats, faces: Ints, name: str, count: int) -> tuple[Floats, Ints]:
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.apply_filter(f"apply_coord_{name}_smoothing", stepsmoothnum=count)
    return remeshed(meshes, 0.0)


def coarser(make: Maker, faces: int) -> tuple[Floats, Ints]:
    """A shape meshed anew with about so many faces; as it is if it has hardly more."""
    vertices, triangles = make()
    if len(triangles) <= 1.3 * faces:
        return vertices, triangles
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles))
    edge = mean_edge_length(vertices, triangles) * np.sqrt(len(triangles) / faces)
    meshes.meshing_isotropic_explicit_remeshing(iterations=8, targetlen=pymeshlab.PureValue(edge), featuredeg=30)
    return remeshed(meshes, 0.0)


def made(shapes: Sequence[Shape], only: Sequence[str] = ()) -> Iterator[NoisyPair]:
    """The pairs of the shapes, those whose name holds one of the given texts, if any are given."""
    for shape in shapes:
        names = [n for n in shape.noises.split() if not only or any(text in f"{shape.name}_{n}" for text in only)]
        if names:
            truth, faces = shape.make()
            for name in names:
                noisy = NOISES[name](truth, faces, np.random.default_rng(7))
                yield NoisyPair(f"{shape.name}_{name}", noisy, truth, faces)


__all__ = ["NOISES", "NoisyPair", "Shape", "between_rows", "coarser", "looked_at", "made", "smoothed_scans", "unseen"]
