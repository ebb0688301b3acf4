"""Noisy meshes whose truth is known, of shapes that everyone has, in two halves that share no shape.

`looked_at` may be looked at while constants are chosen. `unseen` is for the last run alone: what is tuned on it tells nothing any
more. Shapes are pymeshlab's samples, generated parts and surfaces, and scans smoothed to be a truth if their folder is given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import igl
import numpy as np
import pymeshlab
import trimesh
from denoising_findings import chest
from denoising_metrics import Floats, Ints, NoisyPair, used_alone
from numpy.typing import NDArray

from pymeshfair.filters.denoising.noise_level import ring_means, smooth_normals
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import edges

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
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
    return lambda v, f, r: _raised(v, f, r.normal(size=len(v)) * level * (r.random(len(v)) < share))


def all_directions(level: float, share: float = 1.0) -> Noise:
    """A share of the vertices is off along every axis, by a normally distributed length of `level` mean edges."""
    return lambda v, f, r: v + r.normal(size=v.shape) * level * mean_edge_length(v, f) * (r.random((len(v), 1)) < share)


def uniform(reach: float) -> Noise:
    """Evenly distributed in a cube of twice `reach` mean edges."""
    return lambda v, f, r: v + r.uniform(-reach, reach, size=v.shape) * mean_edge_length(v, f)


def uneven(levels: Callable[[Floats], Floats]) -> Noise:
    """Along the normals, of so many mean edges as `levels` says of places scaled to a box from 0 to 1."""
    return lambda v, f, r: _raised(v, f, r.normal(size=len(v)) * levels((v - v.min(axis=0)) / np.ptp(v, axis=0)))


def _raised(v: Floats, f: Ints, heights: Floats) -> Floats:
    """The vertices moved along their normals, by heights in mean edges."""
    return v + (heights * mean_edge_length(v, f))[:, None] * smooth_normals(v, f)


def averaged(level: float, times: int) -> Noise:
    """Along the normals, and averaged `times` over a vertex and its neighbours, which then share it; of `level` mean edges."""

    def displaced(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
        heights, means = r.normal(size=len(v)), ring_means(edges(f), len(v))
        for _ in range(times):
            heights = (heights + 6.0 * (means @ heights)) / 7.0
        return _raised(v, f, heights * (level / heights.std()))

    return displaced


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
#: q: rounded along a slanting one, o, r: along the normals, averaged once or twice over neighbours, so shared; the number is in
#: tenths of mean edges
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
    "o2": averaged(0.2, times=1),
    "r3": averaged(0.3, times=2),
    **{f"q{10 * step:g}": rounded(step) for step in (0.3, 0.6)},
    **{f"s{10 * level:g}": all_directions(level, share=0.3) for level in (0.2, 0.4, 0.8)},
}


def read_mesh(path: Path) -> tuple[Floats, Ints]:
    """Vertices and faces of any file that MeshLab reads."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def taken(path: Path, *, faces: int = 0, edge: float = 0.0, smooth: int = 0) -> tuple[Floats, Ints]:
    """A file, with fewer faces, or meshed anew with edges of a percentage of its size, and smoothed."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    meshes.meshing_merge_close_vertices()
    meshes.meshing_repair_non_manifold_edges()
    if smooth:
        meshes.apply_coord_taubin_smoothing(stepsmoothnum=smooth)
    if 0 < faces < meshes.current_mesh().face_number():
        meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=faces, preservenormal=True)
    return remeshed(meshes, edge)


def remeshed(meshes: pymeshlab.MeshSet, edge: float = 1.0) -> tuple[Floats, Ints]:
    """Vertices and faces, with edges of the given percentage of the diagonal; creases of 30 degrees stay."""
    if edge > 0.0:
        meshes.meshing_isotropic_explicit_remeshing(iterations=10, targetlen=pymeshlab.PercentageValue(edge), featuredeg=30)
    meshes.meshing_remove_unreferenced_vertices()
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix().copy(), mesh.face_matrix().astype(np.int32)


def in_order(meshes: pymeshlab.MeshSet) -> pymeshlab.MeshSet:
    """The current mesh alone, its vertices and faces sorted: MeshLab's booleans list them in another order from run to run.

    Coordinates are rounded to nine digits, since their last ones differ too; what is meshed anew would be another mesh.
    """
    mesh = meshes.current_mesh()
    vertices, number = np.unique(np.round(mesh.vertex_matrix(), 9) + 0.0, axis=0, return_inverse=True)
    faces = np.array([np.roll(corners, -corners.argmin()) for corners in number.ravel()[mesh.face_matrix()]])
    ordered = pymeshlab.MeshSet()
    ordered.add_mesh(pymeshlab.Mesh(vertices, faces[np.lexsort(faces.T[::-1])]))
    return ordered


def mesh_set(*meshes: tuple[Floats, Ints]) -> pymeshlab.MeshSet:
    """A set of MeshLab's with these meshes."""
    made = pymeshlab.MeshSet()
    for vertices, faces in meshes:
        made.add_mesh(pymeshlab.Mesh(vertices, faces))
    return made


def created(solid: trimesh.Trimesh) -> tuple[Floats, Ints]:
    """Vertices and faces of one of trimesh's solids."""
    return np.asarray(solid.vertices), np.asarray(solid.faces, dtype=np.int32)


def part(even: bool) -> tuple[Floats, Ints]:
    """A box with a peg and a hole, meshed evenly, or with triangles of many sizes."""
    peg, hole = (trimesh.creation.cylinder(radius=r, height=1.4, sections=64) for r in (0.25, 0.3))
    peg.apply_translation((-0.5, 0.0, 0.4))
    hole.apply_translation((0.4, 0.0, 0.0))
    meshes = mesh_set(*map(created, (trimesh.creation.box((2.0, 1.2, 0.6)), peg, hole)))
    meshes.generate_boolean_union(first_mesh=0, second_mesh=1)
    meshes.generate_boolean_difference(first_mesh=3, second_mesh=2)
    meshes = in_order(meshes)
    vertices, faces = remeshed(meshes, 1.6 if even else 0.9)
    if even:
        return vertices, faces
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=12000, optimalplacement=True, planarquadric=True)
    return remeshed(meshes, 0.0)


def lens() -> tuple[Floats, Ints]:
    """A ball with two flat ends: round and flat parts that meet at sharp edges."""
    ball, box = trimesh.creation.icosphere(subdivisions=5), trimesh.creation.box((1.2, 3.0, 3.0))
    meshes = mesh_set(created(ball), created(box))
    meshes.generate_boolean_intersection(first_mesh=0, second_mesh=1)
    return remeshed(in_order(meshes), 1.5)


def dodecahedron() -> tuple[Floats, Ints]:
    """Twelve planes."""
    meshes = pymeshlab.MeshSet()
    meshes.create_dodecahedron()
    return remeshed(meshes, 1.5)


def torus() -> tuple[Floats, Ints]:
    """Round everywhere, its faces in rows."""
    meshes = pymeshlab.MeshSet()
    meshes.create_torus(hradius=3, vradius=1, hsubdiv=120, vsubdiv=60)
    return remeshed(meshes, 0.0)


def gear() -> tuple[Floats, Ints]:
    """A wheel of fourteen teeth with a bore."""
    turn = np.linspace(0.0, 2.0 * np.pi, 14, endpoint=False)
    tooth = np.array([(0.0, 0.8), (0.14, 0.8), (0.2, 1.0), (0.3, 1.0), (0.36, 0.8)])
    around = (turn[:, None] + tooth[:, 0] * 2.0 * np.pi / 14 / 0.45).ravel()
    outline = np.column_stack([np.cos(around), np.sin(around)]) * np.tile(tooth[:, 1], 14)[:, None]
    count = len(outline)
    top, bottom = (np.column_stack([outline, np.full(count, z)]) for z in (0.2, -0.2))
    points = np.concatenate([top, bottom, [[0, 0, 0.2], [0, 0, -0.2]]])
    faces = []
    for k in range(count):
        n = (k + 1) % count
        faces += [[k, n, 2 * count], [count + n, count + k, 2 * count + 1], [n, k, count + k], [n, count + k, count + n]]
    bore = trimesh.creation.cylinder(radius=0.35, height=1.0, sections=64)
    meshes = mesh_set((points, np.array(faces)), created(bore))
    meshes.generate_boolean_difference(first_mesh=0, second_mesh=1)
    return remeshed(meshes, 1.3)


def level_set(value: Callable[[Floats, Floats, Floats], Floats], n: int, edge: float) -> tuple[Floats, Ints]:
    """Where a function is 0, in the cube from -1 to 1, meshed anew evenly."""
    axis = np.linspace(-1.0, 1.0, n)
    z, y, x = (a.ravel() for a in np.meshgrid(axis, axis, axis, indexing="ij"))
    vertices, faces, *_ = igl.marching_cubes(value(x, y, z), np.column_stack([x, y, z]), n, n, n, 0.0)
    meshes = mesh_set((vertices, faces))
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
    rng, n = np.random.default_rng(9), 75
    x, y = (a + rng.uniform(-0.3, 0.3, size=a.shape) / n for a in _plan(n))
    z = np.zeros_like(x)
    for octave in range(1, 5):
        for _ in range(4):
            direction, phase = rng.normal(size=2), rng.uniform(0, 6.28)
            z += 0.12 * 0.45**octave * np.sin(2**octave * 3.0 * (direction[0] * x + direction[1] * y) + phase)
    return _sheet(x, y, z)


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
    meshes = mesh_set(created(trimesh.creation.box((2.0, 1.0, 1.0))))
    rng = np.random.default_rng(21)
    for _ in range(6):
        move = trimesh.transformations.random_rotation_matrix(rng.random(3))
        move[:3, 3] = rng.normal(size=3)
        move[:3, 3] *= 1.25 / np.linalg.norm(move[:3, 3]) * np.array([1.4, 1.0, 1.0])
        meshes.add_mesh(pymeshlab.Mesh(*created(trimesh.creation.box((1.1, 1.1, 1.1), transform=move))))
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
    x, y = _plan(n)
    top, sheet = _sheet(x, y, 0.1 * np.sin(6.0 * x) * np.sin(5.0 * y))
    at = np.arange(n * n, dtype=np.int32).reshape(n, n)
    rim = np.concatenate([at[0, :], at[1:, -1], at[-1, -2::-1], at[-2:0:-1, 0]])
    following, below = np.roll(rim, -1), n * n
    sides = [np.column_stack([rim, rim + below, following]), np.column_stack([following, rim + below, following + below])]
    faces = np.concatenate([sheet, sheet[:, ::-1] + below, *sides])
    return np.concatenate([top, top - [0.0, 0.0, 1.5 / n]]), faces.astype(np.int32)


def emblems() -> tuple[Floats, Ints]:
    """Squares, discs and rhombs with sloped sides on gentle waves, on an even grid with a border."""
    x, y = _plan(85)
    z = 0.05 * np.sin(3.0 * x) * np.cos(2.0 * y)
    for i in range(3):
        for j in range(3):
            across, along = np.abs(x - 0.2 - 0.3 * i), np.abs(y - 0.2 - 0.3 * j)
            away = (np.maximum(across, along), np.hypot(across, along), across + along)[(i + j) % 3]
            z += np.clip((0.1 - away) * 4.0, 0.0, 0.05)
    return _sheet(x, y, z)


def depth_map(height: Callable[[Floats, Floats], Floats], n: int) -> tuple[Floats, Ints]:
    """A perspective depth map of n^2 points without noise; jumps of depth are cut out."""
    distance, reach = 3.0, 1.25 / 3.0
    slope = np.linspace(-reach, reach, n)
    x, y = np.meshgrid(slope, slope)
    depth = np.full_like(x, distance)
    for _ in range(50):
        depth = 0.5 * depth + 0.5 * (distance - height(x * depth, y * depth))
    pixel = 2 * reach / n * distance
    faces = between_rows(np.arange(n * n).reshape(n, n))
    faces = faces[np.ptp(depth.ravel()[faces], axis=1) < 4 * pixel]
    vertices, faces = used_alone(faces, np.column_stack([(x * depth).ravel(), (y * depth).ravel(), -depth.ravel()]))
    return vertices, faces


def between_rows(numbers: NDArray[np.integer[Any]]) -> Ints:
    """The triangles between the rows of vertices that an array of their numbers has."""
    at = numbers.astype(np.int32)
    return halved(at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:])


def halved(a: Ints, b: Ints, c: Ints, d: Ints) -> Ints:
    """(2 k, 3) triangles of k quadrilaterals, given by their corners in order."""
    halves = [np.column_stack([p.ravel() for p in corners]) for corners in ((a, b, c), (a, c, d))]
    return np.concatenate(halves).astype(np.int32)


def _plan(n: int) -> list[Floats]:
    """The x and y of n rows of n points in the unit square."""
    return list(np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n)))


def _sheet(x: Floats, y: Floats, z: Floats) -> tuple[Floats, Ints]:
    """The surface through n rows of n points."""
    at = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    return points, halved(at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1])


def _ring(n: int, m: int) -> Ints:
    """The triangles of n closed rows of m vertices, the last row joined to the first."""
    return between_rows(np.pad(np.arange(n * m).reshape(n, m), (0, 1), mode="wrap"))


def smooth_bone() -> tuple[Floats, Ints]:
    """The bone, meshed anew, after ten of Taubin's steps."""
    meshes = mesh_set(taken(SAMPLES / "bone.ply", edge=1.1))
    meshes.apply_coord_taubin_smoothing(stepsmoothnum=10)
    return remeshed(meshes, 0.0)


def looked_at(scans: Path | None) -> tuple[Shape, ...]:
    """The half that constants may be found on."""
    shapes = (
        Shape("bunny10k", "n0.5 n1 n2 n3 n5 a3 i5 s2 s4 s8", lambda: taken(SAMPLES / "bunny10k_textured.obj")),
        Shape("cow", "n1 n3 a2 u4 i10", lambda: taken(SAMPLES / "cow.obj", edge=1.2)),
        Shape("bracket", "n0.5 n1 n2 n3 n5 a2 a3 i5 i10 u4 s4 r3", lambda: part(True)),
        Shape("uneven", "n2 n3 i8", lambda: part(False)),
        Shape("lens", "n1 n2 n3 a2 i10 o2 r3", lens),
        Shape("torus", "n0.3 n1 n3 u4 i8 o2 r3", torus),
        Shape("blobs", "n0.3 n1 n2 n5 a1 i10 s4 r3", blobs),
        Shape("terrain", "n1 n3 a2 i5 i10 s2 s4", terrain),
        Shape("turned", "n0.5 n2 h3 g4 x2", turned),
        Shape("plate", "n0.5 n2 h3 g4 x2 o2", plate),
        Shape("emblems", "n0.5 n2 h3 g4 x2 q6 r3", emblems),
    )
    return (*shapes, *_scans(scans, (("rabbit.obj", 16000, "n0.5 n2 n3 a3 i8 s2 s4 s8 q3 r3"),)))


def unseen(scans: Path | None) -> tuple[Shape, ...]:
    """The half that only the last run sees."""
    shapes = (
        Shape("bone", "n0.5 n2 n5 a2 i5", lambda: taken(SAMPLES / "bone.ply", edge=1.1)),
        Shape("bone_smooth", "n0.5 n2 n5 a2 i5 h3 x2 q6 o2 r3", smooth_bone),
        Shape("airplane", "n1 n2 n3 i10 s4 h3 x2 q3 r3", lambda: taken(SAMPLES / "airplane.obj", edge=0.9)),
        Shape("chest", "n0.5 n1 n3 a3 i8 s8 g4 x2 r3", lambda: (chest(30).truth, chest(30).faces)),
        Shape("dodecahedron", "n0.3 n2 n5 a3 i5 h3 q6", dodecahedron),
        Shape("gear", "n0.5 n1 n2 n3 n6 a2 i5 u4 h3 g4 x2 r3", gear),
        Shape("gyroid", "n0.3 n1 n3 a1 a3 i10 s2 g4 x2 o2 r3", gyroid),
        Shape("knot", "n1 n3 n5 a2 i8 s4 h3 x2 o2 r3", knot),
        Shape("house", "n0.5 n1 n2 n5 a3 i10 s2 h3 g4 x2 r3", house),
    )
    figures = (("angel.obj", 24000, "n0.5 n2 n3 a2 i5 s2 h3 x2 q3 r3"), ("iron.ply", 20000, "n1 n2 a3 i8 s4 g4"))
    return (*shapes, *_scans(scans, figures))


def _scans(folder: Path | None, wanted: Sequence[tuple[str, int, str]]) -> tuple[Shape, ...]:
    if folder is None:
        return ()
    return tuple(
        Shape(Path(file).stem, noises, partial(taken, folder / file, faces=faces, smooth=10)) for file, faces, noises in wanted
    )


def coarser(make: Maker, faces: int) -> tuple[Floats, Ints]:
    """A shape meshed anew with about so many faces; as it is if it has hardly more."""
    vertices, triangles = make()
    if len(triangles) <= 1.3 * faces:
        return vertices, triangles
    meshes = mesh_set((vertices, triangles))
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
