"""The scale-dependent umbrella operator of Fujiwara."""

from ..mesh import Floats, Ints
from ..topology import one_rings
from .inverse_length import floored_lengths
from .laplacian import Laplacian, assemble_stiffness, ring_sums


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
