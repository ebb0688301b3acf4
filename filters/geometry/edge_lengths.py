"""Lengths of edges and of other vectors."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..mesh import Floats, Ints
from ..topology import edges

#: between these lengths their squares are ordinary numbers
_SQUARED = 1e-140, 1e140


def mean_edge_length(vertices: Floats, faces_or_edges: Ints) -> float:
    """The mean length of the edges, each counted once, in mesh units; 0 if there are none.

    Args:
        vertices: (n, 3) coordinates.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges.
    """
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    if len(pairs) == 0:
        return 0.0
    return float(edge_lengths(vertices, pairs).mean())


def edge_lengths(vertices: Floats, pairs: Ints) -> Floats:
    """(e,) the length of each of the (e, 2) edges, of whatever size."""
    lengths = np.empty(len(pairs))
    points, ends = np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(pairs, dtype=np.int32)
    over_range(_measure, len(pairs), points, ends, lengths)
    if len(pairs) and not _SQUARED[0] < lengths.max() < _SQUARED[1]:
        return vector_lengths(vertices[pairs[:, 1]] - vertices[pairs[:, 0]])
    return lengths


@compiled(nogil=True)
def _measure(vertices: Floats, pairs: Ints, lengths: Floats, first: int, last: int) -> None:
    for e in range(first, last):
        a, b = pairs[e, 0], pairs[e, 1]
        x, y, z = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
        lengths[e] = math.sqrt(x * x + y * y + z * z)


def vector_lengths(vectors: Floats) -> Floats:
    """(n,) the length of each of (n, 3) vectors, of whatever size: no square leaves the range of numbers."""
    with np.errstate(over="ignore", under="ignore"):
        lengths = np.asarray(np.linalg.norm(vectors, axis=1))
    if len(vectors) and not _SQUARED[0] < lengths.max() < _SQUARED[1]:
        exponent = int(np.frexp(np.abs(vectors).max())[1])
        return np.asarray(np.ldexp(np.linalg.norm(np.ldexp(vectors, -exponent), axis=1), exponent))
    return lengths
