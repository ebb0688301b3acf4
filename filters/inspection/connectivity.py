"""Measures of faces and edges that do not depend on coordinates."""

from dataclasses import dataclass

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Bools, Ints
from ..topology import connected_components, corner_at, faces_by_edge, listed_edges, proper_faces, referenced_vertices, root_of
from .face_measures import faces_agree


@compiled(nogil=True)
def fan_counts(faces: Ints, neighbours: Ints, shared: Ints, n_vertices: int) -> Ints:
    """(n,) the number of fans that the faces of a vertex form, linked through edges with two faces.

    By union-find over the corners 3 f + k of the faces.
    """
    parent, fans = np.arange(3 * faces.shape[0]).astype(np.int32), np.zeros(n_vertices, dtype=np.int32)
    for p in range(neighbours.shape[0]):
        for vertex in shared[p]:
            f, g = neighbours[p]
            i = root_of(parent, 3 * f + corner_at(faces, f, vertex))
            j = root_of(parent, 3 * g + corner_at(faces, g, vertex))
            parent[max(i, j)] = min(i, j)
    for i in range(parent.shape[0]):
        if parent[i] == i:
            fans[faces[i // 3, i % 3]] += 1
    return fans


@dataclass(frozen=True, eq=False)
class Connectivity:
    """The connectivity of a mesh."""

    n_vertices: int  # how many there are
    faces: Ints  # (m, 3) all faces
    segments: Ints  # (e, 2) edges of polylines
    proper: Ints  # (p, 3) the faces that name three different vertices
    pairs: Ints  # (k, 2) pairs of vertices that a face joins, or in a mesh without faces an edge, each once
    neighbours: Ints  # (q, 2) the faces of `proper` that share an edge with exactly two
    agree: Bools  # (q,) whether these faces run along the edge in opposite directions
    used: int  # how many vertices a proper face, or in a mesh without faces an edge, uses
    unreferenced: int  # how many no face and no edge uses
    border: int  # how many edges have exactly one face
    crowded: int  # how many have more than two
    pinched: int  # how many vertices have such an edge, or faces that form more than one fan
    components: int  # parts that faces connect, or in a mesh without faces edges

    @property
    def closed(self) -> bool:
        """Whether there are faces and every edge has two."""
        return len(self.proper) > 0 and self.border == 0 and self.crowded == 0

    @property
    def oriented(self) -> bool:
        """Whether all faces that share an edge with exactly two agree on the outside."""
        return bool(self.agree.all())

    @property
    def euler(self) -> int:
        """Vertices of the edges - edges + faces."""
        return self.used - len(self.pairs) + len(self.proper)

    def is_of(self, n_vertices: int, faces: Ints, segments: Ints) -> bool:
        """Whether another mesh is connected in the same way."""
        return n_vertices == self.n_vertices and np.array_equal(faces, self.faces) and np.array_equal(segments, self.segments)


def connectivity(n_vertices: int, faces: Ints, segments: Ints) -> Connectivity:
    """The connectivity of vertices by (m, 3) faces and (e, 2) edges, both int32."""
    all_proper = proper_faces(faces)
    proper = faces if all_proper.all() else faces[all_proper]
    by_edge = faces_by_edge(proper)
    pairs, face_counts = listed_edges(*by_edge)
    shared, neighbours = listed_edges(*by_edge, 2, 2, columns=2)
    if len(shared) == len(pairs):
        pairs = shared  # kept once
    face_counts = face_counts.ravel()
    used = referenced_vertices(proper, n_vertices)
    components = connected_components(proper, n_vertices)[1]
    pinched = fan_counts(proper, neighbours, shared, n_vertices) > 1
    pinched[pairs[face_counts > 2]] = True
    if len(faces) == 0 and len(segments):
        ordered = np.sort(segments[segments[:, 0] != segments[:, 1]], axis=1)
        pairs = np.unique(ordered, axis=0)
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
        faces_agree(proper, neighbours, shared),
        used=count,
        unreferenced=n_vertices - int(used.sum()),
        border=int((face_counts == 1).sum()),
        crowded=int((face_counts > 2).sum()),
        pinched=int(pinched.sum()),
        components=components,
    )
