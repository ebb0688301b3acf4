"""Laplace operators: a stiffness matrix and a mass for every vertex, and those whose weights depend on edges alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..geometry import edge_lengths
from ..libraries import sparse
from ..mesh import Floats, Ints, Longs
from ..topology import OneRings, one_rings


@dataclass(frozen=True, eq=False)
class Laplacian:
    """The operator L = M^-1 C on n vertices, with real eigenvalues of at most 0.

    Attributes:
        stiffness: C, (n, n) scipy.sparse.csr_matrix float64, symmetric, negative semidefinite, with
            C_ij = w_ij for an edge and C_ii = -sum_j w_ij, so that every row sums to 0. Indices are sorted; the diagonal
            is stored.
        mass: the diagonal of M, (n,) float64, not negative; 0 at a vertex that no triangle uses.
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
        """An upper bound of the largest eigenvalue of -L, by Gershgorin's circles: max_i (|C_ii| + sum_j |C_ij|) / M_ii.

        An explicit step of at most 2 / bound amplifies no mode. On regular triangulations the bound is 4/3 of the truth.
        """
        sums = np.asarray(abs(self.stiffness).sum(axis=1)).ravel()
        return float((sums * self.inverse_mass).max(initial=0.0))

    def components(self) -> Ints:
        """(n,) a label from 0 for every vertex, the same for vertices that entries of C connect."""
        labels: Ints = sparse.csgraph.connected_components(self.stiffness, directed=False)[1]
        return labels


def assemble_stiffness(rings: OneRings, weights: Floats) -> sparse.csr_matrix:
    """C, (n, n), with ``C[i, neighbours[k]] = weights[k]`` for the entries k of i's one-ring and rows that sum to 0."""
    n = len(rings.offsets) - 1
    starts = row_starts(rings.offsets + np.arange(n + 1))
    columns, data = np.empty(starts[-1], dtype=starts.dtype), np.empty(starts[-1])
    with threads_for(n):
        _fill_rows(rings.offsets, rings.neighbours, weights, columns, data)
    return csr_of_rows(starts, columns, data)


def row_starts(starts: Longs) -> Ints | Longs:
    """(n + 1,) where the rows of a matrix begin, in 32 bits where these suffice."""
    index_type: Any = np.int32 if starts[-1] < np.iinfo(np.int32).max else np.int64
    return starts.astype(index_type)


def csr_of_rows(starts: Ints | Longs, columns: Ints | Longs, data: Floats) -> sparse.csr_matrix:
    """The (n, n) matrix of rows whose columns ascend, each once."""
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


#: An edge shorter than this share of the mean edge has the weight of that length, which keeps weights finite. Coordinates of 32
#: bits do not resolve shorter edges.
SHORTEST_EDGE = 1e-6


def uniform_laplacian(faces_or_edges: Ints, n_vertices: int) -> Laplacian:
    """L p_i = mean of the one-ring minus p_i: w_ij = 1, mass the number of neighbours [taubin1995].

    The eigenvalues lie in [-2, 0] for any mesh, so a step of up to 1 is stable. It does not depend on coordinates: it also evens
    out the triangulation, and so moves the vertices of a flat but irregular mesh.
    """
    rings = one_rings(faces_or_edges, n_vertices)
    return Laplacian(assemble_stiffness(rings, np.ones(len(rings.neighbours))), np.diff(rings.offsets).astype(np.float64))


def inverse_length_laplacian(vertices: Floats, faces_or_edges: Ints) -> Laplacian:
    """L p_i = sum_j w_ij (p_j - p_i) / sum_j w_ij with w_ij = 1 / |p_j - p_i|; mass sum_j w_ij [desbrun1999].

    A straight polyline keeps its vertices, however unevenly they lie. The eigenvalues lie in [-2, 0], so a step of up to 1 is
    stable. Edges shorter than 1e-6 of the mean edge get the weight of that length.
    """
    rings = one_rings(faces_or_edges, len(vertices))
    stiffness = assemble_stiffness(rings, 1.0 / floored_lengths(vertices, rings))
    return Laplacian(stiffness, np.abs(stiffness.diagonal()))


def floored_lengths(vertices: Floats, rings: OneRings) -> Floats:
    """(2 e,) the length to each neighbour, at least `SHORTEST_EDGE` of their mean, and 1 if all vertices coincide."""
    starts = np.repeat(np.arange(len(vertices), dtype=np.int32), np.diff(rings.offsets))
    lengths = edge_lengths(vertices, np.column_stack([starts, rings.neighbours]))
    mean = float(lengths.mean()) if len(lengths) else 0.0
    return np.maximum(lengths, SHORTEST_EDGE * mean) if mean > 0.0 else np.ones_like(lengths)


def scale_dependent_laplacian(vertices: Floats, faces_or_edges: Ints) -> Laplacian:
    """L p_i = (2 / E_i) sum_j (p_j - p_i) / e_ij with e_ij = |p_j - p_i| and E_i = sum_j e_ij [fujiwara1995, desbrun1999].

    In the form M^-1 C: w_ij = 1 / e_ij, mass E_i / 2. Along a polyline it is the second derivative by arc length. Its unit is one
    over a squared length, so a step counts in squared mesh units and is stable up to half the square of the shortest edge or
    somewhat more. Edges shorter than 1e-6 of the mean edge count as that long.
    """
    rings = one_rings(faces_or_edges, len(vertices))
    lengths = floored_lengths(vertices, rings)
    sums = np.bincount(np.repeat(np.arange(len(vertices)), np.diff(rings.offsets)), lengths, len(vertices))
    return Laplacian(assemble_stiffness(rings, 1.0 / lengths), sums / 2.0)
