"""The uniform (umbrella) operator: all neighbours weigh the same."""

import numpy as np

from ..mesh import Ints
from ..topology import one_rings
from .laplacian import Laplacian, assemble_stiffness


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
