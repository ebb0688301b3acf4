"""Named small meshes for the tests: vertices (n, 3) float64, faces (m, 3) int32, counter-clockwise seen from outside."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]
Mesh: TypeAlias = tuple[Floats, Ints]

# ------------------------------------------------------------------------------------------------------------------- closed


def tetrahedron() -> Mesh:
    """The regular one with edges of length 2 sqrt 2, around the origin."""
    vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    return _mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def cube(subdivisions: int = 0) -> Mesh:
    """The unit cube with a corner at the origin, its 12 triangles each cut in four so many times."""
    vertices = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    mesh = _mesh(vertices, [triangle for a, b, c, d in quads for triangle in ([a, b, c], [a, c, d])])
    for _ in range(subdivisions):
        mesh = subdivided(*mesh)
    return mesh


def icosphere(subdivisions: int, radius: float = 1.0) -> Mesh:
    """A sphere of 10 * 4^subdivisions + 2 vertices; the first 12, the icosahedron's, have valence 5 and all others 6."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [[s, t * golden, 0] for t in (1, -1) for s in (-1, 1)]
    vertices = np.array([np.roll(c, k) for k in range(3) for c in corners], dtype=np.float64)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    near = np.linalg.norm(vertices[:, None] - vertices, axis=2) < 1.1  # the edges are 1.05 long, the diagonals 1.70 and more
    faces = np.array([t for t in itertools.combinations(range(12), 3) if near[np.ix_(t, t)].all()])
    faces = _outward(vertices, faces)
    for _ in range(subdivisions):
        vertices, faces = subdivided(vertices, faces)
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return vertices * radius, faces


def torus(around: int = 24, along: int = 12, major: float = 2.0, minor: float = 0.7) -> Mesh:
    """A torus about the z axis: `around` times `along` vertices, all of valence 6."""
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(along) / along, indexing="ij")
    ring = major + minor * np.cos(v)
    vertices = np.column_stack([(ring * np.cos(u)).ravel(), (ring * np.sin(u)).ravel(), (minor * np.sin(v)).ravel()])
    i, j = np.meshgrid(np.arange(around), np.arange(along), indexing="ij")
    a, b = i * along + j, (i + 1) % around * along + j
    c, d = (i + 1) % around * along + (j + 1) % along, i * along + (j + 1) % along
    return _mesh(vertices, np.concatenate([_triangles(a, b, c), _triangles(a, c, d)]))


def two_spheres() -> Mesh:
    """Two components that share nothing, 5 units apart."""
    vertices, faces = icosphere(2)
    return _mesh(np.concatenate([vertices, vertices + np.array([5.0, 0.0, 0.0])]), np.concatenate([faces, faces + len(vertices)]))


# --------------------------------------------------------------------------------------------------------------------- open


def single_triangle() -> Mesh:
    """A triangle with a right angle at the origin and sides 3, 4, 5."""
    return _mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]])


def grid(rows: int = 8, columns: int = 9, spacing: float = 1.0) -> Mesh:
    """A flat rectangle of rows x columns squares in the plane z = 0, each cut by the same diagonal."""
    y, x = np.meshgrid(np.arange(rows + 1.0), np.arange(columns + 1.0), indexing="ij")
    vertices = spacing * np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = i * (columns + 1) + j
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return _mesh(vertices, np.concatenate([_triangles(a, b, c), _triangles(a, c, d)]))


def irregular_grid(rows: int = 8, columns: int = 9, seed: int = 0, amount: float = 0.35) -> Mesh:
    """As `grid`, its interior vertices shifted in the plane, with obtuse triangles and negative cotangent weights."""
    vertices, faces = grid(rows, columns)
    inside = (vertices[:, 0] % columns > 0) & (vertices[:, 1] % rows > 0)
    vertices[inside, :2] += np.random.default_rng(seed).uniform(-amount, amount, (int(inside.sum()), 2))
    return vertices, faces


def tube(around: int = 16, along: int = 6, radius: float = 1.0, length: float = 3.0) -> Mesh:
    """An open cylinder about the z axis: two border loops of `around` edges."""
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    heights = np.repeat(np.linspace(0.0, length, along + 1), around)
    vertices = np.column_stack([np.tile(circle, (along + 1, 1)), heights])
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = b + around, a + around
    return _mesh(vertices, np.concatenate([_triangles(a, b, c), _triangles(a, c, d)]))


def moebius_strip(segments: int = 12) -> Mesh:
    """A band with a half twist: one border loop, no orientation."""
    angle = 2 * np.pi * np.arange(segments) / segments
    middle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(segments)])
    across = np.column_stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)])
    vertices = np.concatenate([middle - 0.3 * across, middle + 0.3 * across])
    low, high = np.arange(segments), np.arange(segments) + segments
    next_low, next_high = np.append(low[1:], high[0]), np.append(high[1:], low[0])
    return _mesh(vertices, np.concatenate([_triangles(low, next_low, next_high), _triangles(low, next_high, high)]))


# ------------------------------------------------------------------------------------------------------------- not manifold


def bow_tie() -> Mesh:
    """Two triangles that share vertex 0 and no edge."""
    return _mesh([[0, 0, 0], [1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0.5]], [[0, 2, 1], [0, 3, 4]])


def book(pages: int = 3) -> Mesh:
    """`pages` triangles that share the edge (0, 1) like the pages of a book."""
    angle = 2 * np.pi * np.arange(pages) / pages
    leaves = np.column_stack([np.cos(angle), np.sin(angle), np.full(pages, 0.5)])
    return _mesh(np.concatenate([[[0, 0, 0], [0, 0, 1]], leaves]), [[0, 1, 2 + k] for k in range(pages)])


def wheel(spokes: int) -> Mesh:
    """A flat disc of `spokes` triangles round the hub, vertex 0."""
    angle = 2 * np.pi * np.arange(spokes) / spokes
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(spokes)])
    return _mesh(np.concatenate([[[0, 0, 0]], rim]), [[0, 1 + k, 1 + (k + 1) % spokes] for k in range(spokes)])


# ------------------------------------------------------------------------------------------------------------------- clouds


def spiral(count: int) -> Floats:
    """A spiral of points evenly around the unit sphere."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angles = np.arange(count) * np.pi * (1.0 + 5.0**0.5)
    around = np.sqrt(1.0 - z**2)
    return np.column_stack([around * np.cos(angles), around * np.sin(angles), z])


# ------------------------------------------------------------------------------------------------------------------ awkward


def with_caps(height: float, count: int = 20) -> Mesh:
    """A sphere some of whose triangles are split by a vertex at `height`, in edge lengths, above the middle of an edge."""
    vertices, faces = icosphere(3)
    chosen = np.arange(0, len(faces), len(faces) // count)
    a, b, c = faces[chosen].T
    middle = (vertices[a] + vertices[b]) / 2
    new = np.arange(len(chosen)) + len(vertices)
    added = middle + height * (vertices[c] - middle)
    split = np.concatenate([_triangles(a, b, new), _triangles(b, c, new), _triangles(c, a, new)])
    return _mesh(np.concatenate([vertices, added]), np.concatenate([np.delete(faces, chosen, axis=0), split]))


def with_needles(length: float, count: int = 20) -> Mesh:
    """A sphere with some edges shrunk to `length` times their length, 0 included."""
    vertices, faces = icosphere(3)
    chosen = faces[:: len(faces) // count]
    _, first = np.unique(chosen, return_index=True)
    lonely = np.isin(np.arange(chosen.size), first).reshape(chosen.shape).all(axis=1)
    kept, moved = chosen[lonely, 0], chosen[lonely, 1]
    vertices[moved] = vertices[kept] + length * (vertices[moved] - vertices[kept])
    return vertices, faces


def _isolated() -> Mesh:
    vertices, faces = icosphere(2)
    return np.concatenate([[[9.0, 9.0, 9.0]], vertices, [[-0.0, 7.0, 7.0]]]), faces + np.int32(1)


def _all_on_a_line() -> Mesh:
    vertices, faces = grid(3, 3)
    return vertices @ np.array([[1.0, 0, 0], [0.3, 0, 0], [0, 0, 0]]), faces


AWKWARD: dict[str, Callable[[], Mesh]] = {
    "caps": lambda: with_caps(1e-3),
    "thin caps": lambda: with_caps(1e-8),
    "caps without area": lambda: with_caps(0.0),
    "edges without length": lambda: with_needles(0.0),
    "needles": lambda: with_needles(1e-9),
    "duplicate faces": lambda: _mesh(icosphere(2)[0], np.concatenate([icosphere(2)[1]] * 2)),
    "some duplicate faces": lambda: _mesh(icosphere(2)[0], np.concatenate([icosphere(2)[1], icosphere(2)[1][::7, ::-1]])),
    "faces that name a vertex twice": lambda: _mesh(
        icosphere(2)[0], np.concatenate([icosphere(2)[1], [[0, 0, 5], [3, 8, 3], [7, 7, 7]]])
    ),
    "isolated vertices": _isolated,
    "only faces that name a vertex twice": lambda: _mesh(grid(2, 2)[0], [[0, 0, 1], [4, 4, 4]]),
    "three pages": book,
    "ten pages": lambda: book(10),
    "bow tie": bow_tie,
    "large hub": lambda: wheel(200),
    "moebius strip": moebius_strip,
    "two components": two_spheres,
    "one triangle": single_triangle,
    "all on one line": _all_on_a_line,
    "all in one point": lambda: _mesh(np.full_like(icosphere(1)[0], 2.5), icosphere(1)[1]),
    "1e30": lambda: icosphere(2, 1e30),
    "1e-30": lambda: icosphere(2, 1e-30),
    "1e150": lambda: icosphere(2, 1e150),
    "geo-referenced": lambda: _mesh(icosphere(2)[0] + np.array([5e5, 5.5e6, 300.0]), icosphere(2)[1]),
    "empty": lambda: (np.empty((0, 3)), np.empty((0, 3), dtype=np.int32)),
}

# ------------------------------------------------------------------------------------------------------------------ helpers


def subdivided(vertices: Floats, faces: Ints) -> Mesh:
    """Every triangle cut in four at the middles of its edges."""
    corners = np.sort(np.stack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]], axis=1).reshape(-1, 2), axis=1)
    edges, index = np.unique(corners, axis=0, return_inverse=True)
    ab, bc, ca = (index.reshape(-1, 3) + len(vertices)).T
    a, b, c = faces.T
    children = [_triangles(a, ab, ca), _triangles(ab, b, bc), _triangles(ca, bc, c), _triangles(ab, bc, ca)]
    return _mesh(np.concatenate([vertices, vertices[edges].mean(axis=1)]), np.stack(children, axis=1).reshape(-1, 3))


def noisy(mesh: Mesh, amount: float, seed: int = 0) -> Mesh:
    """The mesh with every coordinate shifted by a normal deviate of `amount`, in mesh units."""
    vertices, faces = mesh
    return vertices + np.random.default_rng(seed).normal(0.0, amount, vertices.shape), faces


def renumbered(mesh: Mesh, seed: int = 0) -> tuple[Floats, Ints, NDArray[np.int64]]:
    """The mesh with its vertices and faces in random order, and the old number of each new vertex."""
    vertices, faces = mesh
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(vertices))
    place = np.empty(len(order), dtype=np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    return vertices[order], place[faces][rng.permutation(len(faces))], order


def rotation(seed: int = 0) -> Floats:
    """A random rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q * np.sign(np.linalg.det(q)))


def volume(vertices: Floats, faces: Ints) -> float:
    """The volume inside a closed surface, positive if its faces look outwards."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def area(vertices: Floats, faces: Ints) -> float:
    """The area of the surface."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def diagonal(vertices: Floats) -> float:
    """The diagonal of the bounding box."""
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def sample_path(name: str) -> Path:
    """The path of a mesh that the pymeshlab wheel carries, such as ``bunny.obj`` or ``rangemaps/face000.ply``."""
    import pymeshlab

    return Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / name


@functools.cache
def sample(name: str) -> Mesh:
    """A mesh that the pymeshlab wheel carries, as MeshLab reads it; do not write into it."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(sample_path(name)))
    mesh = meshes.current_mesh()
    vertices, faces = np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)
    vertices.flags.writeable = faces.flags.writeable = False
    return vertices, faces


def _mesh(vertices: object, faces: object) -> Mesh:
    return np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.int32)


def _triangles(a: NDArray[np.integer], b: NDArray[np.integer], c: NDArray[np.integer]) -> NDArray[np.integer]:
    return np.column_stack([a.ravel(), b.ravel(), c.ravel()])


def _outward(vertices: Floats, faces: NDArray[np.integer]) -> Ints:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", a, np.cross(b, c)) < 0
    outward = np.where(inward[:, None], faces[:, ::-1], faces)
    return np.ascontiguousarray(outward, dtype=np.int32)
