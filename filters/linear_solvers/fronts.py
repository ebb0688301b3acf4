"""Factors L D L^T of sparse symmetric matrices by dense fronts [duff1983]: half the work of L U, on vectors of the processor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..libraries import sparse
from ..mesh import Floats, Ints, Longs
from ..topology import sort_slice
from .conjugate_gradients import CompressedRows
from .nested_dissection import dissected

#: Columns that are eliminated together, and right-hand sides that one pass over the factors solves for.
_BLOCK, _TOGETHER = 8, 4


class Fronts(NamedTuple):
    """How the rows of a matrix are eliminated: in groups, each of which changes the same later rows.

    The group g eliminates the rows from ``firsts[g]`` to before ``firsts[g + 1]`` and changes the rows
    ``rows[starts[g] : starts[g + 1]]``. All numbers of rows are places in `order`.

    Attributes:
        order: (n,) int32 the row of the matrix at each place.
        places: (n,) int32 the place of each row.
        firsts: (groups + 1,).
        lows: (groups,) what a group changes goes into the first later group whose number here is not above its `firsts`.
        starts: (groups + 1,).
        rows: int32, ascending in each group.
    """

    order: Ints
    places: Ints
    firsts: Longs
    lows: Longs
    starts: Longs
    rows: Ints

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> Fronts:
        """Of a symmetric pattern, by nested dissection."""
        entries = _compressed(matrix)
        order, firsts, lows = dissected(entries)
        places = np.empty_like(order)
        places[order] = np.arange(len(order), dtype=np.int32)
        starts = np.zeros(len(firsts), dtype=np.int64)
        rows = _changed_rows(entries, order, places, firsts, lows, starts)
        return cls(order, places, firsts, lows, starts, rows)

    def factors(self, matrix: sparse.csr_matrix) -> tuple[Floats, Floats]:
        """L, group by group its columns from the diagonal on, and D, (n,), of a matrix of this pattern or of a part of it."""
        own, changed = np.diff(self.firsts), np.diff(self.starts)
        values, pivots = np.empty(_all_numbers(self)), np.empty(len(self.order))
        _factorise(self, _compressed(matrix), int((own + changed).max(initial=0)), _most_held(self), values, pivots)
        return values, pivots

    def solve(self, values: Floats, b: Floats) -> Floats:
        """The solution for (n, k) right-hand sides by the factors, (n, k), in the order in memory of the right-hand sides."""
        is_fortran = b.flags.f_contiguous
        right = np.asfortranarray(b) if is_fortran else np.ascontiguousarray(b)
        x = np.empty(b.shape, order="F" if is_fortran else "C")
        y = np.empty((-(-b.shape[1] // _TOGETHER), len(b), _TOGETHER))
        widest = int((np.diff(self.firsts) + np.diff(self.starts)).max(initial=0))
        _put_in_order(self.order, right, y)
        _solve(self, values, np.empty((widest, _TOGETHER)), y)
        _put_back(self.order, y, x)
        return x

    def in_place(self) -> Fronts:
        """The same for the matrix with its rows and columns in `order`."""
        same = np.arange(len(self.order), dtype=np.int32)
        return self._replace(order=same, places=same)


@compiled
def _numbers(own: int, changed: int) -> int:
    """How many numbers L has in a group."""
    return own * (own + changed) - own * (own - 1) // 2


@compiled
def _all_numbers(fronts: Fronts) -> int:
    """How many L has."""
    count = 0
    for g in range(fronts.lows.shape[0]):
        count += _numbers(fronts.firsts[g + 1] - fronts.firsts[g], fronts.starts[g + 1] - fronts.starts[g])
    return count


def _compressed(matrix: sparse.csr_matrix) -> CompressedRows:
    """The arrays of a symmetric matrix for kernels."""
    return CompressedRows(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32, copy=False), matrix.data)


@compiled(nogil=True)
def _changed_rows(matrix: CompressedRows, order: Ints, places: Ints, firsts: Longs, lows: Longs, starts: Longs) -> Ints:
    """The rows of `Fronts`; `starts` is filled."""
    n, at, top = order.shape[0], 0, 0
    seen = np.full(n, -1, dtype=np.int32)
    rows = np.empty(8 * n, dtype=np.int32)
    waiting = np.empty(lows.shape[0], dtype=np.int32)
    for g in range(lows.shape[0]):
        end = firsts[g + 1]
        if at + n > rows.shape[0]:
            more = np.empty(2 * rows.shape[0] + n, dtype=np.int32)
            more[:at] = rows[:at]
            rows = more
        for k in range(firsts[g], end):
            for p in range(matrix.indptr[order[k]], matrix.indptr[order[k] + 1]):
                r = places[matrix.indices[p]]
                if r >= end and seen[r] != g:
                    seen[r] = g
                    rows[at] = r
                    at += 1
        while top > 0 and firsts[waiting[top - 1]] >= lows[g]:
            top -= 1
            for p in range(starts[waiting[top]], starts[waiting[top] + 1]):
                r = rows[p]
                if r >= end and seen[r] != g:
                    seen[r] = g
                    rows[at] = r
                    at += 1
        sort_slice(rows, starts[g], at)
        starts[g + 1] = at
        waiting[top] = g
        top += 1
    return rows[:at].copy()


@compiled
def _most_held(fronts: Fronts) -> int:
    """The most numbers that groups hold for later ones at a time."""
    most, held, top = 0, 0, 0
    waiting = np.empty(fronts.lows.shape[0], dtype=np.int32)
    for g in range(fronts.lows.shape[0]):
        while top > 0 and fronts.firsts[waiting[top - 1]] >= fronts.lows[g]:
            top -= 1
            held -= (fronts.starts[waiting[top] + 1] - fronts.starts[waiting[top]]) ** 2
        waiting[top] = g
        top += 1
        held += (fronts.starts[g + 1] - fronts.starts[g]) ** 2
        most = max(most, held)
    return most


@compiled(nogil=True, error_model="numpy")
def _factorise(fronts: Fronts, matrix: CompressedRows, widest: int, most: int, values: Floats, pivots: Floats) -> None:
    """Fills the factors, group by group: what the groups before it change is summed up in a dense matrix, its front."""
    order, places, firsts, lows, starts, rows = fronts
    work, held = np.empty(widest * widest), np.empty(most)
    local = np.empty(order.shape[0], dtype=np.int32)
    waiting = np.empty(lows.shape[0], dtype=np.int32)
    top, full, at = 0, 0, 0
    for g in range(lows.shape[0]):
        first, own, changed = firsts[g], firsts[g + 1] - firsts[g], starts[g + 1] - starts[g]
        size = own + changed
        front = work[: size * size].reshape(size, size)  # column by column, on and below the diagonal
        for k in range(own):
            local[first + k] = k
        for k in range(changed):
            local[rows[starts[g] + k]] = own + k
        for j in range(size):
            front[j, j:] = 0.0
        for k in range(own):
            i = order[first + k]
            for p in range(matrix.indptr[i], matrix.indptr[i + 1]):
                r = places[matrix.indices[p]]
                if r >= first + k:
                    front[k, local[r]] += matrix.data[p]
        while top > 0 and firsts[waiting[top - 1]] >= lows[g]:
            top -= 1
            begin, count = starts[waiting[top]], starts[waiting[top] + 1] - starts[waiting[top]]
            full -= count * count
            _add(held[full : full + count * count].reshape(count, count), local, rows[begin : begin + count], front)
        _eliminate(front, own)
        for k in range(own):
            pivots[first + k] = front[k, k]
            values[at : at + size - k] = front[k, k:]
            at += size - k
        for j in range(own, size):
            held[full + (j - own) : full + changed] = front[j, j:]
            full += changed
        waiting[top] = g
        top += 1


@compiled(nogil=True)
def _add(part: Floats, local: Ints, rows: Ints, front: Floats) -> None:
    """Adds what an earlier group changes."""
    for j in range(np.uint64(part.shape[0])):
        column = front[np.uint32(local[rows[j]])]
        for i in range(np.uint64(j), np.uint64(part.shape[0])):
            column[np.uint32(local[rows[i]])] += part[j, i]


@compiled(nogil=True, error_model="numpy")
def _eliminate(front: Floats, own: int) -> None:
    """L and D of the first columns, in their place; the other columns become what is left of them."""
    size = front.shape[0]
    for first in range(0, own, _BLOCK):
        last = min(first + _BLOCK, own)
        for j in range(first, last):
            column = front[j]
            for k in range(first, j):
                before, factor = front[k], front[k, j] * front[k, k]
                for i in range(j, size):
                    column[i] -= before[i] * factor
            inverse = 1.0 / column[j]
            for i in range(j + 1, size):
                column[i] *= inverse
        _subtract(front, first, last)


@compiled(nogil=True)
def _subtract(front: Floats, first: int, last: int) -> None:
    """Subtracts L D L^T of a block of up to eight columns, named one by one for the compiler, from the columns after them."""
    a, b, c, d = front[first], front[min(first + 1, last - 1)], front[min(first + 2, last - 1)], front[min(first + 3, last - 1)]
    e, f, g = front[min(first + 4, last - 1)], front[min(first + 5, last - 1)], front[min(first + 6, last - 1)]
    h = front[min(first + 7, last - 1)]
    pivots = np.zeros(_BLOCK)
    for k in range(first, last):
        pivots[k - first] = front[k, k]
    for j in range(last, front.shape[0]):
        column = front[j]
        s, t, u, v = a[j] * pivots[0], b[j] * pivots[1], c[j] * pivots[2], d[j] * pivots[3]
        w, x, y, z = e[j] * pivots[4], f[j] * pivots[5], g[j] * pivots[6], h[j] * pivots[7]
        for i in range(j, front.shape[0]):
            one = (a[i] * s + b[i] * t) + (c[i] * u + d[i] * v)
            column[i] -= one + ((e[i] * w + f[i] * x) + (g[i] * y + h[i] * z))


@compiled(nogil=True)
def _put_in_order(order: Ints, b: Floats, y: Floats) -> None:
    """The right-hand sides in groups of four; 0 where there are none left."""
    for h in range(y.shape[0]):
        for i in range(order.shape[0]):
            for c in range(_TOGETHER):
                column = h * _TOGETHER + c
                y[h, i, c] = b[order[i], column] if column < b.shape[1] else 0.0


@compiled(nogil=True)
def _put_back(order: Ints, y: Floats, x: Floats) -> None:
    for h in range(y.shape[0]):
        for i in range(order.shape[0]):
            for c in range(min(_TOGETHER, x.shape[1] - h * _TOGETHER)):
                x[order[i], h * _TOGETHER + c] = y[h, i, c]


@compiled(nogil=True)
def _solve(fronts: Fronts, values: Floats, local: Floats, y: Floats) -> None:
    """Solves in place for right-hand sides in the order of elimination; the groups of four take turns at every front."""
    firsts, starts, rows = fronts.firsts, fronts.starts, fronts.rows
    at = 0
    for g in range(fronts.lows.shape[0]):
        own, changed = firsts[g + 1] - firsts[g], rows[starts[g] : starts[g + 1]]
        count = _numbers(own, changed.shape[0])
        for h in range(y.shape[0]):
            _forward(y[h], local, values[at : at + count], firsts[g], own, changed)
        at += count
    for g in range(fronts.lows.shape[0] - 1, -1, -1):
        own, changed = firsts[g + 1] - firsts[g], rows[starts[g] : starts[g + 1]]
        at -= _numbers(own, changed.shape[0])
        for h in range(y.shape[0]):
            _backward(y[h], local, values[at:], firsts[g], own, changed)


@compiled(nogil=True)
def _forward(x: Floats, local: Floats, values: Floats, first: int, own: int, rows: Ints) -> None:
    size = own + rows.shape[0]
    for k in range(size):
        for c in range(_TOGETHER):
            local[k, c] = x[first + k, c] if k < own else 0.0
    at = 0
    for k in range(own):
        s, t, u, v = local[k, 0], local[k, 1], local[k, 2], local[k, 3]
        pivot = values[at]
        for i in range(np.uint64(k + 1), np.uint64(size)):
            value = values[np.uint64(at - k) + i]
            local[i, 0] -= value * s
            local[i, 1] -= value * t
            local[i, 2] -= value * u
            local[i, 3] -= value * v
        at += size - k
        x[first + k, 0], x[first + k, 1], x[first + k, 2], x[first + k, 3] = s / pivot, t / pivot, u / pivot, v / pivot
    for k in range(own, size):
        r = rows[k - own]
        for c in range(_TOGETHER):
            x[r, c] += local[k, c]


@compiled(nogil=True)
def _backward(x: Floats, local: Floats, values: Floats, first: int, own: int, rows: Ints) -> None:
    size = own + rows.shape[0]
    for k in range(size):
        r = first + k if k < own else rows[k - own]
        for c in range(_TOGETHER):
            local[k, c] = x[r, c]
    at = _numbers(own, rows.shape[0])
    for k in range(own - 1, -1, -1):
        at -= size - k
        s, t, u, v = local[k, 0], local[k, 1], local[k, 2], local[k, 3]
        for i in range(np.uint64(k + 1), np.uint64(size)):
            value = values[np.uint64(at - k) + i]
            s -= value * local[i, 0]
            t -= value * local[i, 1]
            u -= value * local[i, 2]
            v -= value * local[i, 3]
        local[k, 0], local[k, 1], local[k, 2], local[k, 3] = s, t, u, v
        for c in range(_TOGETHER):
            x[first + k, c] = local[k, c]
