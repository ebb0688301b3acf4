"""A sample of a large mesh: patches grown from faces that lie anywhere."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..geometry import edge_lengths, mean_edge_length
from ..mesh import Floats, Ints, Longs
from ..topology import VertexFaces, referenced_vertices, vertex_faces

# Larger meshes are sampled by so many patches of about so many faces: ten large ones have misled, since shapes differ from place
# to place.
_WHOLE, _PATCHES, _FACES = 20_000, 40, 450
# Random numbers are the fractions of so many times a length of the geometry.
_MULTIPLE = 1013.0


class Sample(NamedTuple):
    """A mesh to try filters on, its mean edge 1.

    Attributes:
        points: (k, 3) coordinates around 0.
        faces: (l, 3) triangles, by the numbers of these.
        origin: (k,) which vertices of the mesh they are; one of several patches appears several times.
    """

    points: Floats
    faces: Ints
    origin: Ints


def sample_of(vertices: Floats, faces: Ints, edge: float | None = None, *, patches: int = _PATCHES, size: int = _FACES) -> Sample:
    """All of a mesh of up to 20,000 faces, or else 40 patches of about 450 faces each, or as is said.

    A patch is whole rings around a face. The faces are those with the least random numbers, made of their perimeters over the
    mean edge: renumbering, moving, turning and scaling the mesh changes none of them by more than rounding.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        edge: their mean edge, if it is known.
        patches: how many patches are taken of a larger one.
        size: the faces of each, at least.
    """
    if len(faces) <= _WHOLE:
        chosen, origin = faces, np.arange(len(vertices), dtype=np.int32)
        used = np.flatnonzero(referenced_vertices(faces, len(vertices)))
    else:
        chosen, origin = _grown(vertices, faces, edge or mean_edge_length(vertices, faces), patches, size)
        used = origin.astype(np.int64)
    middle = vertices[used].mean(axis=0) if len(used) else np.zeros(3)
    unit = mean_edge_length(vertices[origin], chosen)
    # A mesh without a size is not to be scaled.
    return Sample((vertices[origin] - middle) / (unit or 1.0), np.ascontiguousarray(chosen), origin)


def _grown(vertices: Floats, faces: Ints, edge: float, patches: int, size: int) -> tuple[Ints, Ints]:
    """The faces of the patches, by numbers of their own, and the vertex that each of these numbers stands for."""
    at_vertices = vertex_faces(faces, len(vertices))
    first, second, third = (edge_lengths(vertices, faces[:, ends]) for ends in ([0, 1], [1, 2], [2, 0]))
    numbers = ((first + second + third) / edge * _MULTIPLE) % 1.0
    # The faces with the least numbers, of equal ones the first.
    low = np.flatnonzero(numbers <= np.partition(numbers, patches - 1)[patches - 1])
    seeds = low[np.argsort(numbers[low], kind="stable")][:patches]
    marks = np.full(len(faces), -1, dtype=np.int32)
    parts, origins, count = [], [], 0
    for number, seed in enumerate(seeds):
        part = faces[np.sort(_rings_around(faces, at_vertices, seed, size, number, marks))]
        origin, local = np.unique(part, return_inverse=True)
        parts.append(local.reshape(-1, 3).astype(np.int32) + np.int32(count))
        origins.append(origin.astype(np.int32))
        count += len(origin)
    return np.concatenate(parts), np.concatenate(origins)


@compiled
def _rings_around(faces: Ints, at_vertices: VertexFaces, seed: int, least: int, number: int, marks: Ints) -> Longs:
    """The face and whole rings of faces around it, until they are as many as said; `marks` differ from `number` before."""
    found = [seed]
    marks[seed] = number
    start, stop = 0, 1
    while start < stop and stop < least:
        for at in range(start, stop):
            for i in faces[found[at]]:
                for f in at_vertices.rows[at_vertices.offsets[i] : at_vertices.offsets[i + 1], 0]:
                    if marks[f] != number:
                        marks[f] = number
                        found.append(int(f))
        start, stop = stop, len(found)
    return np.array(found)
