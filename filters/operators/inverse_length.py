"""The inverse-length operator: near neighbours weigh more."""

import numpy as np

from ..mesh import Floats, Ints
from ..topology import OneRings, one_rings
from .laplacian import Laplacian, assemble_stiffness, ring_lengths, ring_sums

#: An edge shorter than this share of the mean edge has the weight of that length, which keeps weights finite. Coordinates of 32
#: bits do not resolve shorter edges.
SHORTEST_EDGE = 1e-6


def inverse_length_laplacian(vertices: Floats, faces_or_edges: Ints) -> Laplacian:
    """L p_i = sum_j w_ij (p_j - p_i) / sum_j w_ij with w_ij = 1 / |p_j - p_i|; mass sum_j w_ij [desbrun1999].

    A straight polyline keeps its vertices, however unevenly they lie. The eigenvalues lie in [-2, 0], so a step of up to 1 is
    stable. Edges shorter than 1e-6 of the mean edge get the weight of that length.

    Args:
        vertices: (n, 3) coordinates.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges.
    """
    rings = one_rings(faces_or_edges, len(vertices))
    weights = 1.0 / floored_lengths(vertices, rings)
    return Laplacian(assemble_stiffness(rings, weights), ring_sums(rings, weights))


def floored_lengths(vertices: Floats, rings: OneRings) -> Floats:
    """(2 e,) the length to each neighbour, at least `SHORTEST_EDGE` of their mean, and 1 if all vertices coincide."""
    lengths = ring_lengths(vertices, rings)
    mean = float(lengths.mean()) if len(lengths) else 0.0
    return np.maximum(lengths, SHORTEST_EDGE * mean) if mean > 0.0 else np.ones_like(lengths)
