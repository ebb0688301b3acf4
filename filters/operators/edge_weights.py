"""Operators with weights of edges alone: uniform (umbrella), inverse length, scale dependent."""

import numpy as np

from ..mesh import Floats, Ints
from ..topology import OneRings, one_rings
from .laplacian import Laplacian, assemble_stiffness, ring_lengths, ring_sums

#: An edge shorter than this share of the mean edge has the weight of that length, which keeps weights finite. Coordinates of 32
#: bits do not resolve shorter edges.
SHORTEST_EDGE = 1e-6


def uniform_laplacian(faces_or_edges: Ints, n_vertices: int) -> Laplacian:
    """L p_i = mean of the one-ring minus p_i: w_ij = 1, mass the number of neighbours [taubin1995].

    The eigenvalues lie in [-2, 0] for any mesh, so a step of up to 1 is stable. It does not depend on coordinates: it also evens
    out the triangulation, and so moves the vertices of a flat but irregular mesh.

    Args:
        faces_or_edges: (m, 3) triangles, or (e, 2) edges.
        n_vertices: n.
    """
    rings = one_rings(faces_or_edges, n_vertices)
    return Laplacian(assemble_stiffness(rings, np.ones(len(rings.neighbours))), np.diff(rings.offsets).astype(np.float64))


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


def scale_dependent_laplacian(vertices: Floats, faces_or_edges: Ints) -> Laplacian:
    """L p_i = (2 / E_i) sum_j (p_j - p_i) / e_ij with e_ij = |p_j - p_i| and E_i = sum_j e_ij [fujiwara1995, desbrun1999].

    In the form M^-1 C: w_ij = 1 / e_ij, mass E_i / 2. Along a polyline it is the second derivative by arc length. Its unit is one
    over a squared length, so a step counts in squared mesh units and is stable up to half the square of the shortest edge or
    somewhat more. Edges shorter than 1e-6 of the mean edge count as that long.

    Args:
        vertices: (n, 3) coordinates.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges.
    """
    rings = one_rings(faces_or_edges, len(vertices))
    lengths = floored_lengths(vertices, rings)
    return Laplacian(assemble_stiffness(rings, 1.0 / lengths), ring_sums(rings, lengths) / 2.0)
