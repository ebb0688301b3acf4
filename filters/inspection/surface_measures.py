"""What a surface is, in numbers: its size, its topology, how rough it is and how well shaped its triangles are.

Everything is linear in the mesh but for the sorting of edges at a vertex, and is computed about the middle of the mesh, so that
one far from the origin (UTM, ECEF) loses no digits that its coordinates have.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components as connected_parts

from ..geometry import edge_lengths
from ..mesh import check_edges, check_mesh
from ..neighbours import nearest_neighbours
from ..topology import connected_components, edge_face_counts, face_adjacency, referenced_vertices

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True)
class SurfaceMeasures:
    """The measures of one mesh; lengths in mesh units, areas and volumes in their square and cube, angles in degrees.

    A measure is None where it is not defined: the volume of a mesh with a border, the edges of a point cloud. A face that names
    a vertex twice counts in `faces` and `degenerate_faces` and nowhere else. Edges of polylines are measured in meshes without
    faces; beside faces they are references alone.

    Attributes:
        vertices: all of them.
        faces: all of them.
        edges: pairs of vertices that a face joins, or in a mesh without faces an edge of a polyline, each once.
        unreferenced_vertices: vertices that no face and no edge uses.
        degenerate_faces: faces of no area: a vertex named twice, coincident vertices, three vertices on a line. They are left
            out of `roughness` and count as 0 in `triangle_quality`.
        border_edges: edges with exactly one face.
        non_manifold_edges: edges with more than two faces.
        non_manifold_vertices: vertices of a non-manifold edge, and those whose faces form more than one fan, such as the tip
            where two cones touch.
        components: parts that no face connects, or in a mesh without faces no edge; vertices without a face or edge are none.
        closed: there are faces and every edge has two.
        oriented: at every edge with two faces they run along it in opposite directions, so that they agree on the outside.
        euler_characteristic: vertices of those edges - edges + faces.
        genus: the number of handles, all components together: components - euler_characteristic / 2. Only for closed, oriented
            meshes without non-manifold vertices.
        diagonal: of the bounding box of all vertices.
        area: of all faces.
        volume: sum of det(a, b, c) / 6 over the faces, positive if they are counter-clockwise seen from outside. Only for closed,
            oriented meshes.
        mean_edge: the mean length of the edges.
        roughness: the mean angle between the normals of two faces that share an edge: 0 for a plane, larger is rougher. Which
            way the faces are oriented does not matter.
        triangle_quality: the mean of l / (sqrt(3) R) over the faces, l the shortest edge and R the circumradius: 1 if all are
            equilateral, towards 0 for slivers.
        mean_spacing: the mean distance from a point to its nearest neighbour; only for two points or more and neither face nor
            edge.
    """

    vertices: int
    faces: int
    edges: int
    unreferenced_vertices: int
    degenerate_faces: int
    border_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    components: int
    closed: bool
    oriented: bool
    euler_characteristic: int
    genus: int | None
    diagonal: float
    area: float
    volume: float | None
    mean_edge: float | None
    roughness: float | None
    triangle_quality: float | None
    mean_spacing: float | None


def surface_measures(vertices: ArrayLike, faces: ArrayLike, *, edges: ArrayLike = ()) -> SurfaceMeasures:
    """Measure a triangle mesh, or if there are no faces polylines, or a point cloud.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) indices of vertices.
        edges: (e, 2) indices of vertices, the edges of polylines. One from a vertex to itself makes that vertex a used one and
            counts for nothing else.

    Raises:
        FilterInputError: a coordinate that is not finite, or an index that names no vertex.
    """
    points, triangles = check_mesh(vertices, faces)
    n_vertices, n_faces = len(points), len(triangles)
    points, scale = _centred(points)

    a, b, c = triangles.T
    proper = triangles[(a != b) & (b != c) & (c != a)]
    pairs, face_counts = edge_face_counts(proper)
    used = referenced_vertices(proper, n_vertices)
    components = connected_components(proper, n_vertices)[1]
    neighbours, shared = face_adjacency(proper)

    border, crowded = int((face_counts == 1).sum()), int((face_counts > 2).sum())
    pinched = _fans(proper, neighbours, shared, n_vertices) > 1
    pinched[pairs[face_counts > 2]] = True
    closed = len(proper) > 0 and border == 0 and crowded == 0

    segments = check_edges(edges, n_vertices)
    if n_faces == 0:
        ordered = np.sort(segments[segments[:, 0] != segments[:, 1]], axis=1)
        pairs = np.unique(ordered, axis=0)
        used[pairs] = True
        components = _components_of_curves(pairs, used)
    euler = int(used.sum()) - len(pairs) + len(proper)
    used[segments] = True

    normals, doubled, quality = _measure_faces(points, proper)
    angles, agree = _measure_edges(proper, normals, neighbours, shared)
    oriented = bool(agree.all())
    lengths = edge_lengths(points, pairs)
    return SurfaceMeasures(
        vertices=n_vertices,
        faces=n_faces,
        edges=len(pairs),
        unreferenced_vertices=n_vertices - int(used.sum()),
        degenerate_faces=n_faces - int((doubled > 0).sum()),
        border_edges=border,
        non_manifold_edges=crowded,
        non_manifold_vertices=int(pinched.sum()),
        components=components,
        closed=closed,
        oriented=oriented,
        euler_characteristic=euler,
        genus=components - euler // 2 if closed and oriented and not pinched.any() else None,
        diagonal=float(np.linalg.norm(np.ptp(points, axis=0))) * scale if n_vertices else 0.0,
        area=float(doubled.sum()) / 2 * scale * scale,
        volume=_volume(points, proper, normals) * scale * scale * scale if closed and oriented else None,
        mean_edge=float(lengths.mean()) * scale if len(lengths) else None,
        roughness=_roughness(angles),
        triangle_quality=float(quality.sum()) / n_faces if n_faces else None,
        mean_spacing=float(nearest_neighbours(points, 1)[0].mean()) * scale
        if n_faces == len(segments) == 0 and n_vertices > 1
        else None,
    )


def _components_of_curves(pairs: Ints, used: Bools) -> int:
    """The number of parts that the edges connect; vertices that are not `used` are none."""
    if not len(pairs):
        return 0
    graph = csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(used), len(used)))
    return int(connected_parts(graph, directed=False)[0]) - int((~used).sum())


def _centred(points: Floats) -> tuple[Floats, float]:
    """The points about the centre of their box, divided by a scale that brings the box to about 1; and that scale.

    The scale is a power of two, so that dividing by it rounds nothing, and no product of lengths overflows or vanishes.
    """
    if not len(points):
        return points, 1.0
    low, high = points.min(axis=0), points.max(axis=0)
    scale = math.ldexp(1.0, math.frexp(float((high - low).max()))[1])
    return (points - (low / 2 + high / 2)) / scale, scale


def _fans(faces: Ints, neighbours: Ints, shared: Ints, n_vertices: int) -> Ints:
    """(n,) the number of fans that the faces of a vertex form, linked through edges with two faces."""
    fans: Ints = np.bincount(_first_corners(faces, neighbours, shared), minlength=n_vertices).astype(np.int32)
    return fans


@njit(cache=True)
def _first_corners(faces: Ints, neighbours: Ints, shared: Ints) -> Ints:
    """For every fan its vertex. Union-find over the corners 3 f + k of the faces."""
    parent = np.arange(3 * faces.shape[0])
    for p in range(neighbours.shape[0]):
        for vertex in shared[p]:
            i = _root(parent, _corner(faces, neighbours[p, 0], vertex))
            j = _root(parent, _corner(faces, neighbours[p, 1], vertex))
            parent[max(i, j)] = min(i, j)
    vertices = np.empty(3 * faces.shape[0], dtype=np.int32)
    found = 0
    for i in range(parent.shape[0]):
        if parent[i] == i:
            vertices[found] = faces[i // 3, i % 3]
            found += 1
    return vertices[:found].copy()


@njit(cache=True)
def _corner(faces: Ints, face: int, vertex: int) -> int:
    for k in range(2):
        if faces[face, k] == vertex:
            return int(3 * face + k)
    return int(3 * face + 2)


@njit(cache=True)
def _root(parent: NDArray[np.int64], i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True)
def _measure_faces(points: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """The normals of the faces, twice their area long; twice their areas; and their quality, 0 where the area is 0."""
    normals = np.empty((faces.shape[0], 3))
    doubled = np.empty(faces.shape[0])
    quality = np.zeros(faces.shape[0])
    for f in range(faces.shape[0]):
        a, b, c = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        wx, wy, wz = c[0] - b[0], c[1] - b[1], c[2] - b[2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        normals[f, 0], normals[f, 1], normals[f, 2] = nx, ny, nz
        doubled[f] = math.sqrt(nx * nx + ny * ny + nz * nz)
        p = math.sqrt(ux * ux + uy * uy + uz * uz)
        q = math.sqrt(vx * vx + vy * vy + vz * vz)
        r = math.sqrt(wx * wx + wy * wy + wz * wz)
        if doubled[f] > 0:
            # R = p q r / (4 A) and doubled = 2 A.
            quality[f] = min(1.0, 2 / math.sqrt(3) * doubled[f] / (p * q * r / min(p, q, r)))
    return normals, doubled, quality


@njit(cache=True)
def _measure_edges(faces: Ints, normals: Floats, neighbours: Ints, shared: Ints) -> tuple[Floats, Bools]:
    """For two faces that share an edge the angle between their normals, NaN if one has no area; and whether they agree.

    They agree if they run along the edge in opposite directions; if not, one of them is turned over for the angle.
    """
    angles = np.empty(neighbours.shape[0])
    agree = np.empty(neighbours.shape[0], dtype=np.bool_)
    for p in range(neighbours.shape[0]):
        f, g = neighbours[p]
        u, v = shared[p]
        agree[p] = _runs_along(faces, f, u, v) != _runs_along(faces, g, u, v)
        sign = 1.0 if agree[p] else -1.0
        ax, ay, az = normals[f]
        bx, by, bz = normals[g]
        cosine = sign * (ax * bx + ay * by + az * bz)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        # The arc tangent keeps the digits of small angles that the arc cosine loses.
        angles[p] = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), cosine)
        if (ax == 0 and ay == 0 and az == 0) or (bx == 0 and by == 0 and bz == 0):
            angles[p] = np.nan
    return angles, agree


@njit(cache=True)
def _runs_along(faces: Ints, face: int, start: int, end: int) -> bool:
    k = 0 if faces[face, 0] == start else 1 if faces[face, 1] == start else 2
    return bool(faces[face, k] == start and faces[face, (k + 1) % 3] == end)


def _volume(points: Floats, faces: Ints, normals: Floats) -> float:
    """Sum of det(a, b, c) / 6 = a . ((b - a) x (c - a)) / 6."""
    return float(np.einsum("ij,ij->i", points[faces[:, 0]], normals).sum()) / 6


def _roughness(angles: Floats) -> float | None:
    counted = angles[np.isfinite(angles)]
    return math.degrees(float(counted.mean())) if len(counted) else None
