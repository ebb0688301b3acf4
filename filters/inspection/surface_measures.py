"""Measures of a surface: size, topology, roughness, triangle quality; also accurate far from the origin (UTM coordinates)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..execution import over_range
from ..geometry import cross_product, edge_lengths, looking_away, squared_length
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, check_edges, check_mesh, normalised_mesh
from ..neighbours import nearest_neighbours
from ..topology import connected_components, corner_at, faces_by_edge, listed_edges, proper_faces, referenced_vertices, root_of
from .curvature import at_vertices


@dataclass(frozen=True)
class SurfaceMeasures:
    """The measures of one mesh; lengths in mesh units, areas and volumes in their square and cube, angles in degrees.

    A measure is None if it is not defined, such as the volume of a mesh with a border. A face that names a vertex twice counts
    only in `faces`, `degenerate_faces` and, as 0, in `triangle_quality`. Edges of polylines are measured in meshes without faces;
    in other meshes they only count as references to their vertices.
    """

    vertices: int  # number of all vertices
    faces: int  # number of all faces
    edges: int  # number of face edges, or of polyline edges in a mesh without faces, each once
    unreferenced_vertices: int  # vertices that no face and no edge uses
    degenerate_faces: int  # faces without area, left out of `roughness`, and counted as 0 in `triangle_quality`
    folded_faces: int  # faces whose normals point away from the mean normals at their vertices
    border_edges: int  # edges with exactly one face
    non_manifold_edges: int  # edges with more than two faces
    non_manifold_vertices: int  # vertices of a non-manifold edge, or whose faces form several fans, as where two cones touch
    components: int  # connected components of the faces, or of the edges in a mesh without faces; isolated vertices do not count
    closed: bool  # there are faces, and every edge has two of them
    oriented: bool  # coherently oriented: the two faces of each inner edge traverse it in opposite directions
    euler_characteristic: int  # (number of vertices with an edge) - edges + faces
    genus: int | None  # components - euler_characteristic / 2; only of closed, oriented meshes with manifold vertices
    diagonal: float  # diagonal of the bounding box of all vertices
    area: float
    volume: float | None  # sum of det(a, b, c) / 6, above 0 if faces look outwards; only of closed, oriented meshes
    mean_edge: float | None
    roughness: float | None  # mean angle between the normals of adjacent faces, whatever their orientation: 0 for a plane
    triangle_quality: float | None  # mean of `triangle_shapes`: 1 if all are equilateral, near 0 for slivers
    mean_spacing: float | None  # mean distance from the nearest neighbour; only of clouds of two or more points


@dataclass(frozen=True, eq=False)
class Connectivity:
    """The connectivity of a mesh; fields without a comment are as in `SurfaceMeasures`."""

    n_vertices: int  # number of all vertices
    faces: Ints  # (m, 3) all faces
    segments: Ints  # (e, 2) edges of polylines
    proper: Ints  # (p, 3) the faces that name three different vertices
    pairs: Ints  # (k, 2) the edges of the faces, or of the polylines in a mesh without faces, each once
    neighbours: Ints  # (q, 2) the two `proper` faces of each edge with exactly two faces
    oriented: bool  # whether the two faces of every such edge are coherently oriented
    used: int  # number of vertices in a proper face, or in an edge of a mesh without faces
    unreferenced: int  # number of vertices in no proper face and no edge
    border: int  # number of border edges
    non_manifold_edges: int
    non_manifold_vertices: int
    components: int

    def is_of(self, n_vertices: int, faces: Ints, segments: Ints) -> bool:
        return n_vertices == self.n_vertices and np.array_equal(faces, self.faces) and np.array_equal(segments, self.segments)


def connectivity(n_vertices: int, faces: Ints, segments: Ints) -> Connectivity:
    """Returns the connectivity of (m, 3) int32 faces and (e, 2) int32 polyline edges."""
    all_proper = proper_faces(faces)
    proper = faces if all_proper.all() else faces[all_proper]
    by_edge = faces_by_edge(proper)
    pairs, face_counts = listed_edges(*by_edge)
    shared, neighbours = listed_edges(*by_edge, 2, 2, columns=2)
    if len(shared) == len(pairs):
        pairs = shared  # saves the memory of a second copy
    face_counts = face_counts.ravel()
    used = referenced_vertices(proper, n_vertices)
    components = connected_components(proper, n_vertices)[1]
    fans, oriented = _fans(proper, neighbours, shared, n_vertices)
    non_manifold = fans > 1
    non_manifold[pairs[face_counts > 2]] = True
    if len(faces) == 0 and len(segments):
        pairs = np.unique(np.sort(segments[segments[:, 0] != segments[:, 1]], axis=1), axis=0)
        used[pairs] = True
        graph = sparse.csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n_vertices, n_vertices))
        components = int(sparse.csgraph.connected_components(graph, directed=False)[0]) - int((~used).sum())
    count = int(used.sum())
    used[segments] = True
    return Connectivity(
        n_vertices,
        faces,
        segments,
        proper,
        pairs,
        neighbours,
        bool(oriented),
        used=count,
        unreferenced=n_vertices - int(used.sum()),
        border=int((face_counts == 1).sum()),
        non_manifold_edges=int((face_counts > 2).sum()),
        non_manifold_vertices=int(non_manifold.sum()),
        components=components,
    )


@compiled(nogil=True)
def _fans(faces: Ints, neighbours: Ints, shared: Ints, n_vertices: int) -> tuple[Ints, bool]:
    """(n,) the number of fans (faces linked by edges with two faces) at each vertex; whether linked faces are oriented alike."""
    parent, fans = np.arange(3 * faces.shape[0]).astype(np.int32), np.zeros(n_vertices, dtype=np.int32)
    oriented = True
    for p in range(neighbours.shape[0]):
        f, g = neighbours[p]
        u, v = shared[p]
        at_f, at_g = (corner_at(faces, f, u), corner_at(faces, f, v)), (corner_at(faces, g, u), corner_at(faces, g, v))
        oriented &= ((at_f[0] + 1) % 3 == at_f[1]) != ((at_g[0] + 1) % 3 == at_g[1])
        for k in range(2):
            i, j = root_of(parent, 3 * f + at_f[k]), root_of(parent, 3 * g + at_g[k])
            parent[max(i, j)] = min(i, j)
    for i in range(parent.shape[0]):
        if parent[i] == i:
            fans[faces[i // 3, i % 3]] += 1
    return fans, oriented


def surface_measures(vertices: ArrayLike, faces: ArrayLike, *, edges: ArrayLike = ()) -> SurfaceMeasures:
    """Measures a triangle mesh, polylines of (e, 2) edges (no faces) or a point cloud (no faces and no edges).

    An edge from a vertex to itself only marks the vertex as referenced.

    Raises:
        FilterInputError: a coordinate that is not finite, or an index that names no vertex.
    """
    return measures_and_connectivity(vertices, faces, edges=edges)[0]


def measures_and_connectivity(
    vertices: ArrayLike, faces: ArrayLike, *, edges: ArrayLike = (), former: Connectivity | None = None
) -> tuple[SurfaceMeasures, Connectivity]:
    """Returns `surface_measures` and the connectivity; an equal `former` is reused, which saves half of the time."""
    points, triangles = check_mesh(vertices, faces)
    n_vertices, n_faces = len(points), len(triangles)
    segments = check_edges(edges, n_vertices)
    mesh = normalised_mesh(points, triangles if n_faces else segments)
    unit, diagonal = 1.0 / mesh.scale, box_diagonal(points)
    points = mesh.points if len(mesh) == n_vertices else at_vertices(mesh, mesh.points)
    topology = former
    if topology is None or not topology.is_of(n_vertices, triangles, segments):
        topology = connectivity(n_vertices, triangles, segments)
    proper, pairs = topology.proper, topology.pairs
    lengths = edge_lengths(points, pairs)
    mean_edge = float(lengths.mean()) * unit if len(lengths) else None
    normals, doubled, quality = face_measures(points, proper)
    area, degenerate, shape = float(doubled.sum()) / 2, n_faces - int((doubled > 0).sum()), float(quality.sum())
    del doubled, quality, lengths  # lowers the peak memory for scans of millions of vertices
    closed = len(proper) > 0 and topology.border == topology.non_manifold_edges == 0
    volume = genus = None
    euler = topology.used - len(pairs) + len(proper)
    if closed and topology.oriented:
        # a . ((b - a) x (c - a)) is det(a, b, c)
        volume = float(np.einsum("ij,ij->i", points[proper[:, 0]], normals).sum()) / 6 * unit * unit * unit
        genus = None if topology.non_manifold_vertices else topology.components - euler // 2
    angles = dihedral_angles(normals, proper, topology.neighbours)
    angles = angles[np.isfinite(angles)]
    is_cloud = n_faces == len(segments) == 0 and n_vertices > 1
    measures = SurfaceMeasures(
        vertices=n_vertices,
        faces=n_faces,
        edges=len(pairs),
        unreferenced_vertices=topology.unreferenced,
        degenerate_faces=degenerate,
        folded_faces=int(looking_away(normals, proper, n_vertices).sum()),
        border_edges=topology.border,
        non_manifold_edges=topology.non_manifold_edges,
        non_manifold_vertices=topology.non_manifold_vertices,
        components=topology.components,
        closed=closed,
        oriented=topology.oriented,
        euler_characteristic=euler,
        genus=genus,
        diagonal=diagonal,
        area=area * unit * unit,
        volume=volume,
        mean_edge=mean_edge,
        roughness=math.degrees(float(angles.mean())) if len(angles) else None,
        triangle_quality=shape / n_faces if n_faces else None,
        mean_spacing=float(nearest_neighbours(points, 1)[0].mean()) * unit if is_cloud else None,
    )
    return measures, topology


def inward_faces(vertices: ArrayLike, faces: ArrayLike) -> Bools:
    """(m,) which faces of a closed, oriented mesh look inwards: just in front of them the mesh's winding number is below 0.

    All faces of a component are judged by one place on them. A ray along +z counts how often other components surround the place.
    """
    points, triangles = check_mesh(vertices, faces)
    labels, count = connected_components(triangles, len(points))
    parts = labels[triangles[:, 0]] % (count + 1)  # faces that name a vertex twice may have no component
    corners = points[triangles] - points[triangles[:1, :1]]
    inward = np.bincount(parts, np.linalg.det(corners), minlength=count + 1) < 0.0
    low, high = (np.ascontiguousarray(ends.T) for ends in (corners.min(axis=1), corners.max(axis=1)))
    for part, first in zip(*np.unique(parts, return_index=True), strict=True) if inward.any() else ():
        place = np.array([0.2764, 0.3317, 0.3919]) @ corners[first]  # not the centroid: edges of regular meshes may lie above it
        beside = (low[0] < place[0]) & (high[0] > place[0]) & (low[1] < place[1]) & (high[1] > place[1])
        others = np.flatnonzero(beside & (high[2] > place[2]) & (parts != part))
        x, y, z = (corners[others] - place).transpose(2, 0, 1)
        sides = x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)
        sign = np.where((sides > 0.0).all(axis=1), 1, np.where((sides < 0.0).all(axis=1), -1, 0))
        is_above = sign * (sides * np.roll(z, 1, axis=1)).sum(axis=1) > 0.0
        inward[part] = sign[is_above].sum() < inward[part]
    return np.asarray(inward[parts])


def box_diagonal(points: Floats) -> float:
    """The diagonal of the bounding box of all points, without overflow."""
    cloud = normalised_mesh(points, np.empty((0, 3), np.int32))
    return cloud.diagonal / cloud.scale


def face_measures(points: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """(m, 3) face normals whose lengths are twice the areas, (m,) twice the areas, and (m,) `triangle_shapes`, 0 without area."""
    normals, doubled, quality = np.empty((len(faces), 3)), np.empty(len(faces)), np.zeros(len(faces))
    over_range(_measure, len(faces), points, faces, normals, doubled, quality)
    return normals, doubled, quality


def dihedral_angles(normals: Floats, faces: Ints, neighbours: Ints) -> Floats:
    """(q,) the angles between the normals of (q, 2) adjacent faces, as if coherently oriented; NaN if a normal is 0."""
    angles = np.empty(len(neighbours))
    over_range(_measure_pairs, len(neighbours), normals, faces, neighbours, angles)
    return angles


@compiled(nogil=True)
def _measure(points: Floats, faces: Ints, normals: Floats, doubled: Floats, quality: Floats, first: int, last: int) -> None:
    for f in range(first, last):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        nx, ny, nz = cross_product(points, a, b, c)
        normals[f, 0], normals[f, 1], normals[f, 2] = nx, ny, nz
        doubled[f] = math.sqrt(nx * nx + ny * ny + nz * nz)
        p = math.sqrt(squared_length(points, a, b))
        q = math.sqrt(squared_length(points, a, c))
        r = math.sqrt(squared_length(points, b, c))
        if doubled[f] > 0:
            # `triangle_shapes`, with the circumradius R = p q r / (4 A) and `doubled` = 2 A.
            quality[f] = min(1.0, 2 / math.sqrt(3) * doubled[f] / (p * q * r / min(p, q, r)))


@compiled(nogil=True)
def _measure_pairs(normals: Floats, faces: Ints, neighbours: Ints, angles: Floats, first: int, last: int) -> None:
    for p in range(first, last):
        f, g = neighbours[p]
        sign = -1.0
        for k in range(3):
            for j in range(3):
                if faces[f, k] == faces[g, (j + 1) % 3] and faces[f, (k + 1) % 3] == faces[g, j]:
                    sign = 1.0  # coherently oriented: the faces traverse their edge in opposite directions
        ax, ay, az = normals[f]
        bx, by, bz = normals[g]
        cosine = sign * (ax * bx + ay * by + az * bz)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        # For small angles the arc tangent is accurate, the arc cosine is not.
        angles[p] = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), cosine)
        if (ax == 0 and ay == 0 and az == 0) or (bx == 0 and by == 0 and bz == 0):
            angles[p] = np.nan
