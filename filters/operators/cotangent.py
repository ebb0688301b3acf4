"""The cotangent operators: linear finite elements on the triangles."""

from __future__ import annotations

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..libraries import sparse
from ..mesh import Floats, Ints, Longs, scaled_to_unit
from ..topology import OneRings, one_rings, position, ring_ends
from .laplacian import Laplacian, assemble_stiffness, ring_sums
from .mass import mixed_voronoi_areas

#: A triangle whose doubled area is below this share of the sum of its squared edges is given that area in the cotangents, which
#: keeps them below 1e10. A triangle of three coincident vertices contributes nothing.
SMALLEST_AREA = 1e-10
_NEVER_ZERO = 1e-300


def cotangent_stiffness(vertices: Floats, faces: Ints) -> sparse.csr_matrix:
    """C, (n, n): C_ij = (cot a_ij + cot b_ij) / 2 over the angles opposite the edge, C_ii = -sum_j C_ij [pinkall1993].

    The sign is that of ``igl.cotmatrix``. Symmetric to the bit, rows that sum to 0, negative semidefinite also where obtuse
    angles make a weight negative. An edge adds up the cotangents of all its faces, however many. The result does not depend
    on the size or place of the mesh.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """
    rings, weights = _ring_weights(vertices, faces)
    return assemble_stiffness(rings, weights)


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
    rings, weights = _ring_weights(vertices, faces)
    return Laplacian(assemble_stiffness(rings, weights), ring_sums(rings, np.abs(weights)))


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
    return Laplacian(cotangent_stiffness(vertices, faces), mixed_voronoi_areas(vertices, faces))


def _ring_weights(vertices: Floats, faces: Ints) -> tuple[OneRings, Floats]:
    rings = one_rings(faces, len(vertices))
    weights = np.zeros(len(rings.neighbours))
    points, _ = scaled_to_unit(vertices)
    with threads_for(len(vertices)):
        _add_cotangents(points, *ring_ends(faces, len(vertices)), rings.offsets, rings.neighbours, weights)
    return rings, weights


@compiled
def halved_cotangents(
    ux: float, uy: float, uz: float, uu: float, vx: float, vy: float, vz: float, vv: float
) -> tuple[float, float]:
    """Half the cotangents at u and at v of the triangle (0, u, v), given also the squared lengths of u and v."""
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    smallest = SMALLEST_AREA * (uu + vv + (dx * dx + dy * dy + dz * dz)) + _NEVER_ZERO
    half = 0.5 / max(math.sqrt(cx * cx + cy * cy + cz * cz), smallest)
    return -(ux * dx + uy * dy + uz * dz) * half, (vx * dx + vy * dy + vz * dz) * half


@compiled
def _doubled_area(points: Floats, a: int, b: int, c: int) -> float:
    """Twice the area of a triangle, at least `SMALLEST_AREA` of its squares, the same to the bit for its corners in any order.

    On a thin cap the rounding of three cross products taken at its three corners differs by more than its smallest height allows:
    only one area for all three cotangents keeps the stiffness semidefinite.
    """
    i, j, k = np.int64(a), np.int64(b), np.int64(c)  # numba makes a float of an unsigned and a signed integer
    low, middle = (i, j) if i < j else (j, i)
    middle, high = (middle, k) if middle < k else (k, middle)
    low, middle = (low, middle) if low < middle else (middle, low)
    ux, uy, uz = points[middle, 0] - points[low, 0], points[middle, 1] - points[low, 1], points[middle, 2] - points[low, 2]
    vx, vy, vz = points[high, 0] - points[low, 0], points[high, 1] - points[low, 1], points[high, 2] - points[low, 2]
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    squares = (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz) + (dx * dx + dy * dy + dz * dz)
    doubled: float = max(math.sqrt(cx * cx + cy * cy + cz * cz), SMALLEST_AREA * squares + _NEVER_ZERO)
    return doubled


@compiled
def _halved_cotangent(points: Floats, corner: int, i: int, j: int) -> float:
    """Half the cotangent at a corner of the triangle (corner, i, j), the same to the bit for (corner, j, i)."""
    ux, uy, uz = points[i, 0] - points[corner, 0], points[i, 1] - points[corner, 1], points[i, 2] - points[corner, 2]
    vx, vy, vz = points[j, 0] - points[corner, 0], points[j, 1] - points[corner, 1], points[j, 2] - points[corner, 2]
    half: float = 0.5 * (ux * vx + uy * vy + uz * vz) / _doubled_area(points, corner, i, j)
    return half


@compiled(parallel=True)
def _add_cotangents(points: Floats, end_offsets: Longs, ends: Ints, offsets: Longs, neighbours: Ints, weights: Floats) -> None:
    for i in prange(offsets.shape[0] - 1):
        for k in range(end_offsets[i], end_offsets[i + 1], 2):
            a, b = ends[k], ends[k + 1]
            weights[position(neighbours, offsets[i], offsets[i + 1], b)] += _halved_cotangent(points, a, i, b)
            weights[position(neighbours, offsets[i], offsets[i + 1], a)] += _halved_cotangent(points, b, i, a)
