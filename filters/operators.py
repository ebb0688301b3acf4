"""Laplace operators of meshes, point clouds and polylines, by name: L = M^-1 C with a negative semidefinite stiffness C."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from .checks import FilterInputError, check_choice
from .compilation import compiled, prange
from .execution import threads_for
from .geometry import edge_lengths
from .libraries import robust_laplacian, sparse
from .mesh import Floats, Ints, Longs, mask_of, scaled_to_unit
from .topology import SLOTS, OneRings, distinct_ends, non_manifold_edges, one_rings, position, proper_faces, ring_ends, slot_of

__all__ = [
    "CURVE_OPERATOR",
    "OPERATOR_NAMES",
    "SHORTEST_EDGE",
    "Laplacian",
    "OperatorName",
    "SurfaceOperatorName",
    "build_laplacian",
    "cotangent_laplacian",
    "curve_laplacian",
    "halved_cotangents",
    "laplace_beltrami",
    "mixed_share",
    "mixed_voronoi_areas",
    "surface_laplacian",
    "uniform_laplacian",
]

OperatorName: TypeAlias = Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "laplace_beltrami", "robust"]
OPERATOR_NAMES: tuple[OperatorName, ...] = get_args(OperatorName)
SurfaceOperatorName: TypeAlias = Literal["auto", "cotangent", "robust"]
#: A mesh needs the robust operator if the doubled area of a triangle is below this share of its summed squared edges: cotangents
#: then make the spectrum so wide that the rounding errors of the highest eigenvalues hide the lowest.
_SLIVER = 1e-5
#: Intrinsic mollification lengthens all edges until triangle inequalities hold with this margin, in mean edges [sharp2020].
_MOLLIFIED = 1e-5
#: The number of neighbours in the triangulation around a point of a cloud.
_NEIGHBOURS = 30
#: The curve operator for each surface operator. Inverse lengths on a polyline are linear finite elements, as cotangents are on
#: triangles. The scale-dependent operator is the second derivative by arc length, which has the unit of Laplace-Beltrami.
CURVE_OPERATOR: dict[OperatorName, Literal["uniform", "inverse_length", "scale_dependent"]] = {
    "uniform": "uniform",
    "inverse_length": "inverse_length",
    "cotangent": "inverse_length",
    "scale_dependent": "scale_dependent",
    "laplace_beltrami": "scale_dependent",
    "robust": "scale_dependent",
}
#: In weights, edges shorter than this share of the mean edge have this length, so that weights stay finite. 32-bit coordinates
#: do not resolve shorter edges.
SHORTEST_EDGE = 1e-6
#: In cotangents, the doubled area of a triangle is at least this share of its summed squared edges: cotangents stay below 1e10.
SMALLEST_AREA = 1e-10
NEVER_ZERO = 1e-300  # is added to divisors
# Up to this number, the ends of edges at a vertex are sorted by insertion, which takes quadratic time.
_FEW = 48
# The number of vertices that share a hash table.
_BLOCK = 1024


@dataclass(frozen=True, eq=False)
class Laplacian:
    """The operator L = M^-1 C on n vertices, with real eigenvalues of at most 0.

    Attributes:
        stiffness: C, (n, n) scipy.sparse.csr_matrix float64, symmetric, negative semidefinite, with
            C_ij = w_ij for an edge and C_ii = -sum_j w_ij, so that every row sums to 0. Indices are sorted. The
            diagonal is stored; only "robust" leaves it out, in rows without other entries.
        mass: the diagonal of M, (n,) float64, not negative; 0 at a vertex without neighbours.
    """

    stiffness: sparse.csr_matrix
    mass: Floats

    @property
    def inverse_mass(self) -> Floats:
        """(n,) 1 / mass, and 0 where the mass is 0: L does not move such a vertex."""
        return np.divide(1.0, self.mass, out=np.zeros_like(self.mass), where=self.mass > 0.0)

    def matrix(self) -> sparse.csr_matrix:
        """L = M^-1 C, (n, n); the row of a vertex without mass is 0."""
        return sparse.csr_matrix(sparse.diags_array(self.inverse_mass) @ self.stiffness)

    def apply(self, values: Floats) -> Floats:
        """L @ values for (n,) or (n, k) values."""
        product: Floats = self.stiffness @ values
        return product * (self.inverse_mass if values.ndim == 1 else self.inverse_mass[:, None])

    def spectral_bound(self) -> float:
        """An upper bound of the largest eigenvalue of -L, by Gershgorin's circles: max_i sum_j |C_ij| / M_ii, j = i included."""
        sums = np.asarray(abs(self.stiffness).sum(axis=1)).ravel()
        return float((sums * self.inverse_mass).max(initial=0.0))

    def components(self) -> Ints:
        """(n,) the connected component of every vertex in the graph of C, numbered from 0."""
        labels: Ints = sparse.csgraph.connected_components(self.stiffness, directed=False)[1]
        return labels


def assemble_stiffness(rings: OneRings, weights: Floats) -> sparse.csr_matrix:
    """Returns C, (n, n), with ``C[i, neighbours[k]] = weights[k]`` for the entries k of i's one-ring; rows sum to 0."""
    n = len(rings.offsets) - 1
    starts = row_starts(rings.offsets + np.arange(n + 1))
    columns, data = np.empty(starts[-1], dtype=starts.dtype), np.empty(starts[-1])
    with threads_for(n):
        _fill_rows(rings.offsets, rings.neighbours, weights, columns, data)
    return csr_of_rows(starts, columns, data)


def row_starts(starts: Longs) -> Ints | Longs:
    """(n + 1,) where the rows of a matrix begin, as 32-bit numbers if these suffice."""
    index_type: Any = np.int32 if starts[-1] < np.iinfo(np.int32).max else np.int64
    return starts.astype(index_type)


def csr_of_rows(starts: Ints | Longs, columns: Ints | Longs, data: Floats) -> sparse.csr_matrix:
    """Returns the (n, n) matrix with these rows; the columns of each row must ascend without repetition."""
    n = len(starts) - 1
    matrix = sparse.csr_matrix((data, columns, starts), shape=(n, n))
    matrix.has_sorted_indices = True
    matrix.has_canonical_format = True
    return matrix


@compiled(parallel=True)
def _fill_rows(offsets: Longs, neighbours: Ints, weights: Floats, columns: Ints | Longs, data: Floats) -> None:
    for i in prange(offsets.shape[0] - 1):
        at = offsets[i] + i
        diagonal = -1
        total = 0.0
        for k in range(offsets[i], offsets[i + 1]):
            j = neighbours[k]
            if j > i and diagonal < 0:
                diagonal = at
                at += 1
            columns[at] = j
            data[at] = weights[k]
            total += weights[k]
            at += 1
        if diagonal < 0:
            diagonal = at
        columns[diagonal] = i
        data[diagonal] = -total


def uniform_laplacian(faces_or_edges: Ints, n_vertices: int) -> Laplacian:
    """L p_i = mean of the one-ring minus p_i: w_ij = 1, mass the number of neighbours [taubin1995].

    The eigenvalues lie in [-2, 0], so a step of up to 1 is stable. L also makes the triangulation more regular, and so moves the
    vertices of a flat but irregular mesh.
    """
    rings = one_rings(faces_or_edges, n_vertices)
    return Laplacian(assemble_stiffness(rings, np.ones(len(rings.neighbours))), np.diff(rings.offsets).astype(np.float64))


def inverse_length_laplacian(vertices: Floats, faces_or_edges: Ints) -> Laplacian:
    """L p_i = sum_j w_ij (p_j - p_i) / sum_j w_ij with w_ij = 1 / |p_j - p_i|; mass sum_j w_ij [desbrun1999].

    The inner vertices of a straight polyline stay, even if unevenly spaced. The eigenvalues lie in [-2, 0], so a step of up to 1
    is stable.
    """
    rings = one_rings(faces_or_edges, len(vertices))
    stiffness = assemble_stiffness(rings, 1.0 / floored_lengths(vertices, rings))
    return Laplacian(stiffness, np.abs(stiffness.diagonal()))


def floored_lengths(vertices: Floats, rings: OneRings) -> Floats:
    """(2 e,) the length to each neighbour, at least `SHORTEST_EDGE` of the mean length; 1 if all vertices coincide."""
    starts = np.repeat(np.arange(len(vertices), dtype=np.int32), np.diff(rings.offsets))
    lengths = edge_lengths(vertices, np.column_stack([starts, rings.neighbours]))
    mean = float(lengths.mean()) if len(lengths) else 0.0
    return np.maximum(lengths, SHORTEST_EDGE * mean) if mean > 0.0 else np.ones_like(lengths)


def scale_dependent_laplacian(vertices: Floats, faces_or_edges: Ints) -> Laplacian:
    """L p_i = (2 / E_i) sum_j (p_j - p_i) / e_ij with e_ij = |p_j - p_i| and E_i = sum_j e_ij [fujiwara1995, desbrun1999].

    In the form M^-1 C: w_ij = 1 / e_ij, mass E_i / 2. Along a polyline L is the second derivative by arc length. Its unit is one
    over a squared length, so a step counts in squared mesh units. Steps of half the squared shortest edge are stable.
    """
    rings = one_rings(faces_or_edges, len(vertices))
    lengths = floored_lengths(vertices, rings)
    sums = np.bincount(np.repeat(np.arange(len(vertices)), np.diff(rings.offsets)), lengths, len(vertices))
    return Laplacian(assemble_stiffness(rings, 1.0 / lengths), sums / 2.0)


def cotangent_stiffness(vertices: Floats, faces: Ints) -> sparse.csr_matrix:
    """Returns C, (n, n): C_ij = (cot a_ij + cot b_ij) / 2 with the angles opposite the edge, C_ii = -sum_j C_ij [pinkall1993].

    The sign is that of ``igl.cotmatrix``. C is symmetric to the bit, its rows sum to 0, and it is negative semidefinite even if
    obtuse angles make a weight negative. The weight of an edge adds up the cotangents of all its faces, however many.
    """
    return _assembled(vertices, faces, np.empty(0))


def cotangent_laplacian(vertices: Floats, faces: Ints) -> Laplacian:
    """The normalised operator: L p_i = sum_j w_ij (p_j - p_i) / sum_j |w_ij| with w the weights of `cotangent_stiffness`.

    Obtuse angles can make weights negative. Then sum_j w_ij may be so small that a division by it would allow only tiny steps.
    Divided by sum_j |w_ij|, L has eigenvalues in [-2, 0]. So a step of up to 1 is stable and does not increase the area of a
    closed surface. The interior vertices of a flat mesh stay.
    """
    stiffness = cotangent_stiffness(vertices, faces)
    sizes = abs(stiffness)
    sizes.setdiag(0.0)
    return Laplacian(stiffness, sizes @ np.ones(len(vertices)))


def laplace_beltrami(vertices: Floats, faces: Ints) -> Laplacian:
    """L p_i = 1 / (2 A_i) sum_j (cot a_ij + cot b_ij) (p_j - p_i), A_i the mixed Voronoi area [meyer2003].

    L p is -2 H n with the normal n and the mean curvature H, positive on bulges. On a sphere it points inwards and tends to
    -2 p / r^2. On subdivided icosahedra of edge length h the error is of the order h at the worst vertices, h^1.4 in the root
    mean square, and 0 at those of valence 5, whose neighbours are symmetric. With barycentric areas L would be 15 % wrong at
    these vertices at every level. The unit of L is one over a squared length, so a step counts in squared mesh units.
    """
    areas = np.empty(len(vertices))
    stiffness = _assembled(vertices, faces, areas)
    _, scale = scaled_to_unit(vertices)
    return Laplacian(stiffness, areas / scale / scale)


def _assembled(vertices: Floats, faces: Ints, areas: Floats) -> sparse.csr_matrix:
    """Assembles the stiffness. Fills `areas`, unless it is empty, with the areas after `scaled_to_unit`."""
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


@compiled(error_model="numpy")
def halved_cotangents(
    ux: float, uy: float, uz: float, uu: float, vx: float, vy: float, vz: float, vv: float
) -> tuple[float, float]:
    """Half the cotangents at u and at v of the triangle (0, u, v); `uu` and `vv` are the squared lengths of u and v."""
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    smallest = SMALLEST_AREA * (uu + vv + (dx * dx + dy * dy + dz * dz)) + NEVER_ZERO
    half = 0.5 / max(math.sqrt(cx * cx + cy * cy + cz * cz), smallest)
    return -(ux * dx + uy * dy + uz * dz) * half, (vx * dx + vy * dy + vz * dz) * half


@compiled(parallel=True)
def count_entries(end_offsets: Longs, ends: Ints, sizes: Longs) -> None:
    """Writes the number of entries of every row (neighbours and diagonal) to ``sizes[i + 1]``."""
    n = end_offsets.shape[0] - 1
    for block in prange(-(-n // _BLOCK)):
        seen, owner = np.full(SLOTS, -1, dtype=np.int32), np.full(SLOTS, -1, dtype=np.int32)
        for i in range(block * _BLOCK, min((block + 1) * _BLOCK, n)):
            count, clashes = 1, 0
            for k in range(end_offsets[i], end_offsets[i + 1]):
                slot = slot_of(ends[k])
                new = (seen[slot] != ends[k]) | (owner[slot] != i)
                clashes += new & (owner[slot] == i)
                count += new
                seen[slot], owner[slot] = ends[k], i
            sizes[i + 1] = count if clashes == 0 else 1 + distinct_ends(ends, end_offsets[i], end_offsets[i + 1]).shape[0]


@compiled(parallel=True)
def fill_rows(points: Floats, end_offsets: Longs, ends: Ints, starts: Any, columns: Any, data: Floats, areas: Floats) -> None:
    """Writes the ascending columns and the values of row i from ``starts[i]`` on, and the areas."""
    for i in prange(end_offsets.shape[0] - 1):
        first, last = starts[i], starts[i + 1]
        _write_columns(i, ends, end_offsets[i], end_offsets[i + 1], columns, first)
        for k in range(first, last):
            data[k] = 0.0
        area = 0.0
        for k in range(end_offsets[i], end_offsets[i + 1], 2):
            a, b = ends[k], ends[k + 1]
            ux, uy, uz = points[a, 0] - points[i, 0], points[a, 1] - points[i, 1], points[a, 2] - points[i, 2]
            vx, vy, vz = points[b, 0] - points[i, 0], points[b, 1] - points[i, 1], points[b, 2] - points[i, 2]
            dx, dy, dz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
            doubled = _doubled_area(points, i, a, b)
            # Each product has the same bits as the product that the other end of the edge computes.
            data[position(columns, first, last, b)] += 0.5 * -(ux * dx + uy * dy + uz * dz) / doubled
            data[position(columns, first, last, a)] += 0.5 * (vx * dx + vy * dy + vz * dz) / doubled
            if areas.shape[0]:
                area += mixed_share(ux, uy, uz, ux * ux + uy * uy + uz * uz, vx, vy, vz, vx * vx + vy * vy + vz * vz)
        if areas.shape[0]:
            areas[i] = area
        total = 0.0
        diagonal = first
        for k in range(first, last):
            if columns[k] == i:
                diagonal = k
            else:
                total += data[k]
        data[diagonal] = -total


@compiled
def _write_columns(i: int, ends: Ints, start: int, stop: int, columns: Any, first: int) -> None:
    if stop - start > _FEW:
        ring = distinct_ends(ends, start, stop)
        before = np.searchsorted(ring, i)
        for k in range(ring.shape[0]):
            columns[first + k + (k >= before)] = ring[k]
        columns[first + before] = i
        return
    columns[first] = i
    count = 1
    for k in range(start, stop):
        j = ends[k]
        m = first + count
        while m > first and columns[m - 1] > j:
            m -= 1
        if m > first and columns[m - 1] == j:
            continue
        for later in range(first + count, m, -1):
            columns[later] = columns[later - 1]
        columns[m] = j
        count += 1


@compiled
def _doubled_area(points: Floats, a: int, b: int, c: int) -> float:
    """Twice the area of a triangle, at least `SMALLEST_AREA` of its summed squared edges; the order of corners changes no bit.

    The stiffness is semidefinite only if the cotangents at all three corners of a thin triangle are computed with one area.
    """
    i, j, k = np.int64(a), np.int64(b), np.int64(c)  # numba mixes an unsigned and a signed integer as floats
    low, middle = (i, j) if i < j else (j, i)
    middle, high = (middle, k) if middle < k else (k, middle)
    low, middle = (low, middle) if low < middle else (middle, low)
    ux, uy, uz = points[middle, 0] - points[low, 0], points[middle, 1] - points[low, 1], points[middle, 2] - points[low, 2]
    vx, vy, vz = points[high, 0] - points[low, 0], points[high, 1] - points[low, 1], points[high, 2] - points[low, 2]
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    squares = (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz) + (dx * dx + dy * dy + dz * dz)
    doubled: float = max(math.sqrt(cx * cx + cy * cy + cz * cz), SMALLEST_AREA * squares + NEVER_ZERO)
    return doubled


def mixed_voronoi_areas(vertices: Floats, faces: Ints) -> Floats:
    """(n,) the mixed Voronoi area of each vertex [meyer2003].

    In a triangle without an obtuse angle each corner gets the area of the points nearest to it. Otherwise the obtuse corner gets
    half of the triangle and each other corner a quarter.
    """
    points, scale = scaled_to_unit(vertices)
    areas = np.empty(len(vertices))
    with threads_for(len(vertices)):
        _sum_areas(points, *ring_ends(faces, len(vertices)), areas)
    return areas / scale / scale


@compiled(parallel=True)
def _sum_areas(points: Floats, offsets: Longs, ends: Ints, areas: Floats) -> None:
    for i in prange(offsets.shape[0] - 1):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        total = 0.0
        for k in range(offsets[i], offsets[i + 1], 2):
            a, b = ends[k], ends[k + 1]
            ux, uy, uz = points[a, 0] - x, points[a, 1] - y, points[a, 2] - z
            vx, vy, vz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
            total += mixed_share(ux, uy, uz, ux * ux + uy * uy + uz * uz, vx, vy, vz, vx * vx + vy * vy + vz * vz)
        areas[i] = total


@compiled
def mixed_share(ux: float, uy: float, uz: float, uu: float, vx: float, vy: float, vz: float, vv: float) -> float:
    """The mixed Voronoi area at corner 0 of the triangle (0, u, v); `uu` and `vv` are the squared lengths of u and v."""
    cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    doubled = math.sqrt(cx * cx + cy * cy + cz * cz)
    if doubled == 0.0:
        return 0.0
    if ux * vx + uy * vy + uz * vz < 0.0:
        return 0.25 * doubled
    dx, dy, dz = vx - ux, vy - uy, vz - uz
    at_u = -(ux * dx + uy * dy + uz * dz)
    at_v = vx * dx + vy * dy + vz * dz
    if at_u < 0.0 or at_v < 0.0:
        return 0.125 * doubled
    return (vv * (at_u / doubled) + uu * (at_v / doubled)) * 0.125


def build_laplacian(vertices: Floats, faces: Ints, operator: OperatorName) -> Laplacian:
    """Builds the operator of the given name on a mesh, or "robust" on a point cloud if there are no faces.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, or (0, 3) for a point cloud.
        operator: "uniform", "inverse_length" and "cotangent" are normalised: L has no unit and eigenvalues in [-2, 0].
            "scale_dependent", "laplace_beltrami" and "robust" have the unit of one over a squared length.

    Raises:
        FilterInputError: an unknown name, a point cloud with an operator other than "robust", or "robust" cannot be built.
    """
    check_choice("operator", operator, OPERATOR_NAMES)
    if len(faces) == 0 and len(vertices) > 0:
        if operator != "robust":
            raise FilterInputError(f"operator {operator!r} needs triangles and there are none; only 'robust' takes point clouds")
        return robust_cloud_laplacian(vertices)
    return _build_named(vertices, faces, operator)


def _build_named(vertices: Floats, faces_or_edges: Ints, operator: OperatorName) -> Laplacian:
    builders = {
        "inverse_length": inverse_length_laplacian,
        "scale_dependent": scale_dependent_laplacian,
        "cotangent": cotangent_laplacian,
        "laplace_beltrami": laplace_beltrami,
        "robust": robust_mesh_laplacian,
    }
    if operator == "uniform":
        return uniform_laplacian(faces_or_edges, len(vertices))
    return builders[operator](vertices, faces_or_edges)


def surface_laplacian(points: Floats, faces: Ints, operator: SurfaceOperatorName = "auto") -> Laplacian:
    """Builds the Laplace-Beltrami operator of a surface, in one over squared mesh units.

    "cotangent" is `laplace_beltrami`. "robust" is linear finite elements on the intrinsic Delaunay triangulation of the tufted
    cover [sharp2020], with barycentric areas. "auto" takes "robust" if an edge has more than two faces or a triangle is nearly
    degenerate (`_SLIVER`), else "cotangent".

    Raises:
        FilterInputError: an unknown operator, or the lengths of edges differ too much for "robust".
    """
    check_choice("operator", operator, SurfaceOperatorName)
    if operator == "auto" and (len(non_manifold_edges(faces)) > 0 or _thinnest_triangle(points, faces) < _SLIVER):
        operator = "robust"
    return robust_mesh_laplacian(points, faces) if operator == "robust" else laplace_beltrami(points, faces)


@compiled(nogil=True)
def _thinnest_triangle(points: Floats, faces: Ints) -> float:
    """The least doubled area of a triangle as a share of its summed squared edges, 0.29 if it is equilateral."""
    least = np.inf
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if a == b or b == c or c == a:
            continue
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        size = max(abs(ux), abs(uy), abs(uz), abs(vx), abs(vy), abs(vz))
        if not size > 0.0:
            return 0.0
        ux, uy, uz, vx, vy, vz = ux / size, uy / size, uz / size, vx / size, vy / size, vz / size
        cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        squares = (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz)
        squares += (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
        least = min(least, math.sqrt(cx * cx + cy * cy + cz * cz) / squares)
    return least


def curve_laplacian(vertices: Floats, edges: Ints, operator: OperatorName) -> Laplacian:
    """Builds the `CURVE_OPERATOR` of an operator on the polylines of (e, 2) edges, for example the borders of a mesh."""
    return _build_named(vertices, edges, CURVE_OPERATOR[operator])


def robust_mesh_laplacian(vertices: Floats, faces: Ints) -> Laplacian:
    """Builds the Laplace-Beltrami operator with weights that are neither negative nor infinite [sharp2020].

    The mass is a third of the area around a vertex in the intrinsic triangulation.
    """
    n = len(vertices)
    proper = faces[proper_faces(faces)]
    used = mask_of(proper, n)
    points = vertices[used]
    if len(points) == 0 or not (points != points[0]).any():
        return Laplacian(sparse.csr_matrix((n, n)), np.zeros(n))
    scaled, scale = scaled_to_unit(np.ascontiguousarray(points - points.mean(axis=0)))
    index = np.cumsum(used) - 1
    positive, masses = robust_laplacian.mesh_laplacian(scaled, index[proper], _MOLLIFIED)
    spread = sparse.csr_array((np.ones(len(points)), np.flatnonzero(used), np.arange(len(points) + 1)), shape=(len(points), n))
    return _transferred(positive, masses, scale, spread)


def robust_cloud_laplacian(points: Floats) -> Laplacian:
    """Builds the robust operator of a point cloud from a Delaunay triangulation around every point [sharp2020].

    Points in the same place share the mass of one point, and so move together.
    """
    n = len(points)
    if n == 0:
        return Laplacian(sparse.csr_matrix((0, 0)), np.zeros(0))
    places, place_of, together = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    if len(places) <= _NEIGHBOURS:
        raise FilterInputError(
            f"a point cloud of {len(places)} distinct points has fewer than {_NEIGHBOURS} neighbours for each point: "
            f"the operator needs at least {_NEIGHBOURS + 1} such points"
        )
    if len(places) == n:
        places, place_of = points, np.arange(n)
        together = np.ones(n, dtype=np.int64)
    scaled, scale = scaled_to_unit(np.ascontiguousarray(places - places.mean(axis=0)))
    try:
        positive, masses = robust_laplacian.point_cloud_laplacian(scaled, _MOLLIFIED, _NEIGHBOURS)
    except RuntimeError as error:
        raise FilterInputError(
            "the local triangulations leave a point of the cloud without a triangle, as happens where many points lie on a line "
            f"or nearly coincide: remove such points, for example by a Poisson-disk sampling first ({error})"
        ) from error
    place_of = place_of.ravel()
    spread = sparse.csr_array((1.0 / together[place_of], (place_of, np.arange(n))), shape=(len(places), n))
    return _transferred(positive, masses, scale, spread)


def _transferred(positive: Any, masses: Any, scale: float, spread: sparse.csr_array) -> Laplacian:
    """Transfers an operator of `robust_laplacian` from k points to n vertices; `spread[i, j]` is j's share of point i."""
    stiffness = sparse.csr_matrix(-(spread.T @ sparse.csr_array(positive) @ spread))
    stiffness.sort_indices()
    if not np.isfinite(stiffness.data).all():
        raise FilterInputError(
            "edges of the mesh differ in length by so many orders of magnitude that its operator is out of the range of numbers: "
            "remove spikes, or the smallest triangles, first"
        )
    return Laplacian(stiffness, np.asarray(spread.T @ masses.diagonal()) / scale / scale)
