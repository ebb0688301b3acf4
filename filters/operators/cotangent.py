"""The cotangent operators: linear finite elements on the triangles."""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled
from ..execution import threads_for
from ..libraries import sparse
from ..mesh import Floats, Ints, scaled_to_unit
from ..topology import ring_ends
from .cotangent_rows import NEVER_ZERO, SMALLEST_AREA, count_entries, fill_rows, sum_sizes
from .laplacian import Laplacian, csr_of_rows, row_starts


def cotangent_stiffness(vertices: Floats, faces: Ints) -> sparse.csr_matrix:
    """C, (n, n): C_ij = (cot a_ij + cot b_ij) / 2 over the angles opposite the edge, C_ii = -sum_j C_ij [pinkall1993].

    The sign is that of ``igl.cotmatrix``. Symmetric to the bit, rows that sum to 0, negative semidefinite also where obtuse
    angles make a weight negative. An edge adds up the cotangents of all its faces, however many. The result does not depend
    on the size or place of the mesh.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    return _assembled(vertices, faces, np.empty(0))


def cotangent_laplacian(vertices: Floats, faces: Ints) -> Laplacian:
    """The normalised operator: L p_i = sum_j w_ij (p_j - p_i) / sum_j |w_ij| with w the weights of `cotangent_stiffness`.

    Where no weight is negative this is the weighted mean of the one-ring minus p_i. Obtuse angles can make weights negative;
    dividing by the sum of the w_ij themselves, which stays positive but may get small, would then amplify some modes at any
    step. Divided by the sum of their sizes the eigenvalues lie in [-2, 0], a step of up to 1 is stable, no such step increases
    the area of a closed surface, and a flat mesh still keeps its interior vertices.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    stiffness = cotangent_stiffness(vertices, faces)
    sums = np.empty(len(vertices))
    with threads_for(len(vertices)):
        sum_sizes(stiffness.indptr, stiffness.indices, stiffness.data, sums)
    return Laplacian(stiffness, sums)


def laplace_beltrami(vertices: Floats, faces: Ints) -> Laplacian:
    """L p_i = 1 / (2 A_i) sum_j (cot a_ij + cot b_ij) (p_j - p_i), A_i the mixed Voronoi area [meyer2003].

    L p is the mean curvature vector 2 H n, pointing inwards on a sphere, where it tends to -2 p / r^2: on subdivided icosahedra
    with an error of the order of the edge length at the worst vertices, of its 1.4th power in the mean square, and none at the
    vertices of valence 5, whose neighbours are symmetric. Barycentric areas would be 15 % off there on every level. Its unit is
    one over a squared length, so a step counts in squared mesh units.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    areas = np.empty(len(vertices))
    stiffness = _assembled(vertices, faces, areas)
    _, scale = scaled_to_unit(vertices)
    return Laplacian(stiffness, areas / scale / scale)


def _assembled(vertices: Floats, faces: Ints, areas: Floats) -> sparse.csr_matrix:
    """The stiffness; the areas are written on the way, for the mesh of ordinary size, if there is room for them."""
    n = len(vertices)
    points, _ = scaled_to_unit(vertices)
    end_offsets, ends = ring_ends(faces, n)
    sizes = np.zeros(n + 1, dtype=np.int64)
    with threads_for(n):
        count_entries(end_offsets, ends, sizes)
        starts = row_starts(np.cumsum(sizes))
        columns, data = np.empty(starts[-1], dtype=starts.dtype), np.empty(starts[-1])
        fill_rows(points, end_offsets, ends, starts, columns, data, areas)
    return csr_of_rows(starts, columns, data)


@compiled
def halved_cotangents(
    ux: float, uy: float, uz: float, uu: float, vx: float, vy: float, vz: float, vv: float
) -> tuple[float, float]:
    """Half the cotangents at u and at v of the triangle (0, u, v), given also the squared lengths of u and v."""
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    smallest = SMALLEST_AREA * (uu + vv + (dx * dx + dy * dy + dz * dz)) + NEVER_ZERO
    half = 0.5 / max(math.sqrt(cx * cx + cy * cy + cz * cz), smallest)
    return -(ux * dx + uy * dy + uz * dz) * half, (vx * dx + vy * dy + vz * dz) * half
