"""Aggregates of strongly connected unknowns, and the smoothed prolongation from them to the unknowns [vanek1996]."""

from __future__ import annotations

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Floats, Ints


def prolongation_matrix(matrix: sparse.csr_matrix, strength: float) -> sparse.csr_matrix:
    """P = (I - 4/3 diag(1 / sum_j |a_ij|) A) T, with T the 0-1 matrix of the aggregates.

    Args:
        matrix: A, (n, n) symmetric, with a positive diagonal.
        strength: unknowns i and j are strongly connected if -a_ij >= strength sqrt(a_ii a_jj). Larger makes smaller aggregates.

    Returns:
        (n, aggregates).
    """
    diagonal = matrix.diagonal()
    aggregates, count = _aggregate(matrix.indptr, matrix.indices, matrix.data, diagonal, strength)
    members = np.flatnonzero(aggregates >= 0)
    entries = np.ones(len(members)), (members, aggregates[members])
    tentative = sparse.csr_matrix(entries, shape=(len(aggregates), count))
    smoothing = sparse.csr_matrix(matrix @ tentative)
    damping = (-4.0 / 3.0) / np.asarray(abs(matrix).sum(axis=1)).ravel()
    smoothing.data *= np.repeat(damping, np.diff(smoothing.indptr))
    return with_sorted_indices(tentative + smoothing)


def with_sorted_indices(matrix: sparse.spmatrix) -> sparse.csr_matrix:
    """The matrix as CSR with sorted indices, of 32 bits where they suffice."""
    csr = sparse.csr_matrix(matrix)
    csr.sort_indices()
    if csr.indices.dtype != np.int32 and csr.nnz < np.iinfo(np.int32).max:
        csr.indices, csr.indptr = csr.indices.astype(np.int32), csr.indptr.astype(np.int32)
    return csr


@compiled
def _is_strong(entry: float, i: int, j: int, diagonal: Floats, strength: float) -> bool:
    return i != j and entry < 0.0 and entry * entry >= strength * strength * diagonal[i] * diagonal[j]


@compiled
def _aggregate(indptr: Ints, indices: Ints, data: Floats, diagonal: Floats, strength: float) -> tuple[Ints, int]:
    """The aggregate of every unknown, -1 without strong connections, and their number, by algorithm 5.1 of [vanek1996]."""
    n = indptr.shape[0] - 1
    aggregate = np.full(n, -1, dtype=np.int32)
    count = 0
    for i in range(n):
        # 1. An unknown with all its strong neighbours, where none of them is taken.
        alone = True
        taken = aggregate[i] >= 0
        for k in range(indptr[i], indptr[i + 1]):
            if _is_strong(data[k], i, indices[k], diagonal, strength):
                alone = False
                taken = taken or aggregate[indices[k]] >= 0
        if not alone and not taken:
            for k in range(indptr[i], indptr[i + 1]):
                if _is_strong(data[k], i, indices[k], diagonal, strength):
                    aggregate[indices[k]] = count
            aggregate[i] = count
            count += 1
    # 2. The others join the aggregate of their strongest neighbour.
    joined = aggregate.copy()
    for i in range(n):
        strongest = 0.0
        if aggregate[i] < 0:
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                if aggregate[j] >= 0 and _is_strong(data[k], i, j, diagonal, strength):
                    share = data[k] * data[k] / diagonal[j]
                    if share > strongest:
                        strongest = share
                        joined[i] = aggregate[j]
    # 3. What is left has no neighbour in an aggregate: it makes its own.
    for i in range(n):
        if joined[i] < 0:
            used = False
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                if joined[j] < 0 and _is_strong(data[k], i, j, diagonal, strength):
                    joined[j] = count
                    used = True
            if used:
                joined[i] = count
                count += 1
    return joined, count
