"""Factors L D L^T of sparse symmetric matrices by the multifrontal method [duff1983]: half the work of L U, and vectorised."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from ..compilation import compiled, prange
from ..execution import SERIAL_BELOW, threads_for
from ..libraries import sparse
from ..mesh import Floats, Ints, Longs
from ..topology import sort_slice
from .conjugate_gradients import CompressedRows
from .nested_dissection import PARTS, dissected

#: Number of columns that are eliminated together, and of right-hand sides that one pass over the factors solves for.
_BLOCK, _TOGETHER = 8, 4
#: Number of columns of a panel, which is eliminated before later columns are updated; and of a strip of columns updated together.
_PANEL, _STRIP = 64, 32
#: A row of a front (a front is the dense matrix of a group) counts as this many vertices in comparisons with `SERIAL_BELOW`.
_WORK = 64


class Fronts(NamedTuple):
    """The plan of an elimination: groups of rows that are eliminated together and update the same later rows.

    Group g eliminates the rows from ``firsts[g]`` to before ``firsts[g + 1]`` and updates the rows
    ``rows[starts[g] : starts[g + 1]]``. Rows are numbered by their place in `order`. A part is a subtree of groups in the
    elimination tree, or several trees. Threads eliminate the parts in parallel; the groups above all parts follow one by one.
    """

    order: Ints  # (n,) the row of the matrix at each place
    places: Ints  # (n,) the place of each row
    firsts: Longs  # (groups + 1,)
    lows: Longs  # (groups,) the first row of the subtree of each group in the elimination tree
    starts: Longs  # (groups + 1,)
    rows: Ints  # the updated rows, ascending in each group
    numbers: Longs  # (groups + 1,) where each group's entries of L begin
    parts: Longs  # (p, 2) the first group of each part, and the first group after it
    last: Longs  # the last group of each part and the groups above all parts, ascending
    above: Ints  # (n,) the index of each row among the rows that are in no part, -1 for rows of a part

    @classmethod
    def of(cls, matrix: sparse.csr_matrix) -> Fronts:
        """Plans the elimination for the sparsity pattern of a symmetric matrix by nested dissection."""
        entries = _compressed(matrix)
        order, firsts, lows = dissected(entries)
        places = np.empty_like(order)
        places[order] = np.arange(len(order), dtype=np.int32)
        starts = np.zeros(len(firsts), dtype=np.int64)
        rows = _updated_rows(entries, order, places, firsts, lows, starts)
        eliminated, updated = np.diff(firsts), np.diff(starts)
        numbers = np.append(0, np.cumsum(eliminated * (eliminated + updated) - eliminated * (eliminated - 1) // 2))
        parts, top = _parts(firsts, lows, numbers, PARTS if len(order) >= SERIAL_BELOW else 1)
        rises = np.zeros(len(order), dtype=np.bool_)
        for g in top:
            rises[firsts[g] : firsts[g + 1]] = True
        above = np.where(rises, np.cumsum(rises) - 1, -1).astype(np.int32)
        last = np.sort(np.append(parts[:, 1] - 1, top))
        return cls(order, places, firsts, lows, starts, rows, numbers, parts, last, above)

    def factors(self, matrix: sparse.csr_matrix) -> tuple[Floats, Floats]:
        """Returns L by groups and columns, with D on the diagonal; and (n,) D. `matrix` must have the planned pattern."""
        values, pivots = np.empty(int(self.numbers[-1])), np.empty(len(self.order))
        entries, ends = _compressed(matrix), self.parts[:, 1] - 1
        counts = self.starts[ends + 1] - self.starts[ends]
        begins = np.append(0, np.cumsum(counts * (counts + 1) // 2))
        updates = np.empty(int(begins[-1]))
        with threads_for(len(self.order)):
            _factorise_parts(self, entries, begins, updates, values, pivots)
            _factorise(self, entries, self.last, updates, values, pivots, True)
        return values, pivots

    def solve(self, values: Floats, b: Floats) -> Floats:
        """Solves for (n, k) right-hand sides with the factors; the (n, k) result has the memory layout of b."""
        layout: Literal["F", "C"] = "F" if b.flags.f_contiguous else "C"
        x = np.empty(b.shape, order=layout)
        y = np.zeros((-(-b.shape[1] // _TOGETHER), len(b), _TOGETHER))
        aside = np.zeros((len(self.parts), len(y), int(self.above.max(initial=-1)) + 1, _TOGETHER))
        _put_in_order(self.order, np.asarray(b, order=layout), y)
        with threads_for(len(self.order)):
            _forward_parts(self, values, y, aside)
            _solve_above(self, values, y, aside)
            _backward_parts(self, values, y)
        _put_back(self.order, y, x)
        return x

    def in_order(self) -> Fronts:
        """Returns the same plan for the matrix whose rows and columns are sorted into `order`."""
        same = np.arange(len(self.order), dtype=np.int32)
        return self._replace(order=same, places=same)


@compiled(nogil=True)
def _put_in_order(order: Ints, b: Floats, y: Floats) -> None:
    for h in range(y.shape[0]):
        for i in range(order.shape[0]):
            for c in range(min(_TOGETHER, b.shape[1] - h * _TOGETHER)):
                y[h, i, c] = b[order[i], h * _TOGETHER + c]


@compiled(nogil=True)
def _put_back(order: Ints, y: Floats, x: Floats) -> None:
    for h in range(y.shape[0]):
        for i in range(order.shape[0]):
            for c in range(min(_TOGETHER, x.shape[1] - h * _TOGETHER)):
                x[order[i], h * _TOGETHER + c] = y[h, i, c]


def _parts(firsts: Longs, lows: Longs, numbers: Longs, count: int) -> tuple[Longs, Longs]:
    """Returns (p, 2) ranges of groups, about `count` parts of similar size (a subtree or several trees); and the groups above."""

    def subtrees(low: int, high: int) -> list[tuple[int, int]]:
        """Returns the largest subtrees with rows from `low` to before `high`, as ranges of groups."""
        ranges = []
        while high > low:
            g = int(np.searchsorted(firsts, high)) - 1
            high = int(lows[g])
            ranges.append((int(np.searchsorted(firsts, high)), g + 1))
        return ranges

    roots = sorted(subtrees(0, int(firsts[-1])))
    bounds = np.arange(min(count, len(roots)) + 1) * len(roots) // max(1, min(count, len(roots)))
    parts, top = [(roots[i][0], roots[j - 1][1]) for i, j in pairwise(bounds)], []
    while 0 < len(parts) < count:
        part = max(parts, key=lambda part: int(numbers[part[1]] - numbers[part[0]]))
        below = subtrees(int(firsts[part[0]]), int(firsts[part[1] - 1]))
        if not 0 < len(below) <= count:
            break
        parts.remove(part)
        parts += below
        top.append(part[1] - 1)
    return np.array(sorted(parts), dtype=np.int64).reshape(-1, 2), np.array(sorted(top), dtype=np.int64)


def _compressed(matrix: sparse.csr_matrix) -> CompressedRows:
    return CompressedRows(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32, copy=False), matrix.data)


@compiled(nogil=True)
def _updated_rows(matrix: CompressedRows, order: Ints, places: Ints, firsts: Longs, lows: Longs, starts: Longs) -> Ints:
    """Returns `Fronts.rows` and fills `Fronts.starts`."""
    n, at, top = order.shape[0], 0, 0
    seen = np.full(n, -1, dtype=np.int32)
    rows = np.empty(8 * n, dtype=np.int32)
    waiting = np.empty(lows.shape[0], dtype=np.int32)
    for g in range(lows.shape[0]):
        end = firsts[g + 1]
        if at + n > rows.shape[0]:
            larger = np.empty(2 * rows.shape[0] + n, dtype=np.int32)
            larger[:at] = rows[:at]
            rows = larger
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


@compiled(nogil=True)
def _triangle(rows: int) -> int:
    return rows * (rows + 1) // 2


@compiled(parallel=True)
def _factorise_parts(
    fronts: Fronts, matrix: CompressedRows, begins: Longs, updates: Floats, values: Floats, pivots: Floats
) -> None:
    """Factorises the parts; writes the updates that part p makes to later rows to `updates`, from ``begins[p]`` on."""
    for part in prange(fronts.parts.shape[0]):
        groups = np.arange(fronts.parts[part, 0], fronts.parts[part, 1])
        _factorise(fronts, matrix, groups, updates[begins[part] : begins[part + 1]], values, pivots, False)


@compiled(nogil=True)
def _factorise(
    fronts: Fronts, matrix: CompressedRows, groups: Longs, updates: Floats, values: Floats, pivots: Floats, above: bool
) -> None:
    """Factorises the groups of a part and fills `updates`; or, with `above`, the groups of `Fronts.last` that are in no part."""
    firsts, lows, starts, rows = fronts.firsts, fronts.lows, fronts.starts, fronts.rows
    local = np.empty(fronts.order.shape[0], dtype=np.int32)
    widest, most = _room(fronts, groups)
    work, held = np.empty(widest * widest), np.empty(most)
    # A stack of groups whose updates wait to be added to a front. `held` has these updates in the same order.
    waiting = np.empty(groups.shape[0], dtype=np.int64)
    top, full, taken = 0, 0, 0
    for g in groups:
        eliminated, updated = firsts[g + 1] - firsts[g], starts[g + 1] - starts[g]
        size = eliminated + updated
        if above and fronts.above[firsts[g]] < 0:
            held[full : full + _triangle(updated)] = updates[taken : taken + _triangle(updated)]
            taken += _triangle(updated)
        else:
            front = work[: size * size].reshape(size, size)
            _assemble(matrix, fronts.order, fronts.places, firsts[g], eliminated, rows[starts[g] : starts[g + 1]], local, front)
            while top > 0 and firsts[waiting[top - 1]] >= lows[g]:
                top -= 1
                begin, end = starts[waiting[top]], starts[waiting[top] + 1]
                full -= _triangle(end - begin)
                _add(rows[begin:end], held[full:], local, front)
            for begin in range(0, eliminated, _PANEL):
                end = min(begin + _PANEL, eliminated)
                _eliminate_panel(front, begin, end)
                if above and _WORK * size >= SERIAL_BELOW:
                    _subtract_panel_by_threads(front, begin, end)
                else:
                    for left in range(end, size, _STRIP):
                        _subtract_panel(front, begin, end, left)
            for k in range(eliminated):
                pivots[firsts[g] + k] = front[k, k]
            _copy_columns(front, 0, eliminated, values[fronts.numbers[g] :])
            _copy_columns(front, eliminated, size, held[full:])
        full += _triangle(updated)
        waiting[top] = g
        top += 1
    if not above:
        updates[:] = held[full - updates.shape[0] : full]


@compiled
def _room(fronts: Fronts, groups: Longs) -> tuple[int, int]:
    """Returns the row count of the widest front of the groups, and the largest entry count of the stack of waiting updates."""
    widest, most, held, top = 0, 0, 0, 0
    waiting = np.empty(groups.shape[0], dtype=np.int64)
    for g in groups:
        updated = fronts.starts[g + 1] - fronts.starts[g]
        widest = max(widest, fronts.firsts[g + 1] - fronts.firsts[g] + updated)
        while top > 0 and fronts.firsts[waiting[top - 1]] >= fronts.lows[g]:
            top -= 1
            held -= _triangle(fronts.starts[waiting[top] + 1] - fronts.starts[waiting[top]])
        waiting[top] = g
        top += 1
        held += _triangle(updated)
        most = max(most, held)
    return widest, most


@compiled(nogil=True)
def _assemble(
    matrix: CompressedRows, order: Ints, places: Ints, first: int, eliminated: int, rows: Ints, local: Ints, front: Floats
) -> None:
    """Copies a group's matrix entries on and below the diagonal to its front; `local` gets the index of each row in the front."""
    for k in range(eliminated):
        local[first + k] = k
    for k in range(rows.shape[0]):
        local[rows[k]] = eliminated + k
    for j in range(front.shape[0]):
        front[j, j:] = 0.0
    for k in range(eliminated):
        i = order[first + k]
        for p in range(matrix.indptr[i], matrix.indptr[i + 1]):
            r = places[matrix.indices[p]]
            if r >= first + k:
                front[k, local[r]] += matrix.data[p]


@compiled(nogil=True)
def _add(rows: Ints, update: Floats, local: Ints, front: Floats) -> None:
    begin, count = np.uint64(0), np.uint64(rows.shape[0])
    for j in range(count):
        column = front[np.uint32(local[rows[j]])]
        for i in range(np.uint64(j), count):
            column[np.uint32(local[rows[i]])] += update[begin + i]
        begin += count - j - np.uint64(1)


@compiled(nogil=True)
def _copy_columns(front: Floats, first: int, last: int, packed: Floats) -> None:
    at = 0
    for j in range(first, last):
        packed[at : at + front.shape[0] - j] = front[j, j:]
        at += front.shape[0] - j


@compiled(nogil=True, error_model="numpy")
def _eliminate_panel(front: Floats, begin: int, end: int) -> None:
    """Replaces the columns of a panel by those of L, with D on the diagonal."""
    size = front.shape[0]
    for first in range(begin, end, _BLOCK):
        last = min(first + _BLOCK, end)
        for j in range(first, last):
            column = front[j]
            for k in range(first, j):
                before, factor = front[k], front[k, j] * front[k, k]
                for i in range(np.uint64(j), np.uint64(size)):
                    column[i] -= before[i] * factor
            inverse = 1.0 / column[j]
            for i in range(np.uint64(j + 1), np.uint64(size)):
                column[i] *= inverse
        _subtract(front, first, last, last, end)


@compiled(parallel=True)
def _subtract_panel_by_threads(front: Floats, begin: int, end: int) -> None:
    """Runs `_subtract_panel` for all strips; each thread gets long and short columns."""
    count = -(-(front.shape[0] - end) // _STRIP)
    for k in prange(count):
        strip = k // 2 if k % 2 == 0 else count - 1 - k // 2
        _subtract_panel(front, begin, end, end + strip * _STRIP)


@compiled
def _subtract_panel(front: Floats, begin: int, end: int, left: int) -> None:
    """Subtracts L D L^T of a panel from a strip of later columns, which stays in the cache."""
    for block in range(begin, end, _BLOCK):
        _subtract(front, block, min(block + _BLOCK, end), left, min(left + _STRIP, front.shape[0]))


@compiled(nogil=True)
def _subtract(front: Floats, first: int, last: int, left: int, right: int) -> None:
    """Subtracts L D L^T of a block of up to eight columns from the columns from `left` to before `right`, unrolled for speed."""
    a, b, c, d = front[first], front[min(first + 1, last - 1)], front[min(first + 2, last - 1)], front[min(first + 3, last - 1)]
    e, f, g = front[min(first + 4, last - 1)], front[min(first + 5, last - 1)], front[min(first + 6, last - 1)]
    h = front[min(first + 7, last - 1)]
    count = last - first
    for j in range(left, right):
        column = front[j]
        s = a[j] * a[first]
        t = b[j] * b[first + 1] if count > 1 else 0.0
        u = c[j] * c[first + 2] if count > 2 else 0.0
        v = d[j] * d[first + 3] if count > 3 else 0.0
        w = e[j] * e[first + 4] if count > 4 else 0.0
        x = f[j] * f[first + 5] if count > 5 else 0.0
        y = g[j] * g[first + 6] if count > 6 else 0.0
        z = h[j] * h[first + 7] if count > 7 else 0.0
        # Signed indices might be negative, which would keep the compiler from vectorising.
        for i in range(np.uint64(j), np.uint64(front.shape[0])):
            one = (a[i] * s + b[i] * t) + (c[i] * u + d[i] * v)
            column[i] -= one + ((e[i] * w + f[i] * x) + (g[i] * y + h[i] * z))


@compiled(parallel=True)
def _forward_parts(fronts: Fronts, values: Floats, y: Floats, aside: Floats) -> None:
    """Solves L D y = b in place on the parts; sums up in `aside` each part's updates of the rows above the parts."""
    for p in prange(fronts.parts.shape[0]):
        first, last = fronts.parts[p]
        _forward(fronts, values, np.arange(first, last), fronts.firsts[last], y, aside[p])


@compiled(parallel=True)
def _backward_parts(fronts: Fronts, values: Floats, y: Floats) -> None:
    """Solves L^T x = y in place on the parts."""
    for p in prange(fronts.parts.shape[0]):
        first, last = fronts.parts[p]
        _backward(fronts, values, np.arange(first, last), y)


@compiled(nogil=True)
def _solve_above(fronts: Fronts, values: Floats, y: Floats, aside: Floats) -> None:
    """Solves L D L^T y = b in place on the rows that are in no part."""
    groups = fronts.last[fronts.above[fronts.firsts[fronts.last]] >= 0]
    for g in groups:
        for i in range(fronts.firsts[g], fronts.firsts[g + 1]):
            for p in range(aside.shape[0]):
                for h in range(y.shape[0]):
                    for c in range(_TOGETHER):
                        y[h, i, c] += aside[p, h, fronts.above[i], c]
    if groups.shape[0] > 0:
        _forward(fronts, values, groups, fronts.order.shape[0], y, aside[0])
        _backward(fronts, values, groups, y)


@compiled(nogil=True)
def _forward(fronts: Fronts, values: Floats, groups: Longs, end: int, y: Floats, aside: Floats) -> None:
    """Solves L D y = b on the rows of some groups; adds updates of rows before `end` to `y`, and of later rows to `aside`."""
    firsts, starts, above = fronts.firsts, fronts.starts, fronts.above
    local = np.empty((_room(fronts, groups)[0], _TOGETHER))
    for g in groups:
        first, eliminated, updated = firsts[g], firsts[g + 1] - firsts[g], fronts.rows[starts[g] : starts[g + 1]]
        for h in range(y.shape[0]):
            _forward_group(y[h], local, values[fronts.numbers[g] :], first, eliminated, updated.shape[0])
            for k in range(updated.shape[0]):
                r = updated[k]
                for c in range(_TOGETHER):
                    if r < end:
                        y[h, r, c] += local[eliminated + k, c]
                    else:
                        aside[h, above[r], c] += local[eliminated + k, c]


@compiled(nogil=True)
def _forward_group(x: Floats, local: Floats, values: Floats, first: int, eliminated: int, updated: int) -> None:
    size = eliminated + updated
    for k in range(size):
        for c in range(_TOGETHER):
            local[k, c] = x[first + k, c] if k < eliminated else 0.0
    at = 0
    for k in range(eliminated):
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


@compiled(nogil=True)
def _backward(fronts: Fronts, values: Floats, groups: Longs, y: Floats) -> None:
    """Solves L^T x = y on the rows of some groups, from the last group to the first."""
    firsts, starts = fronts.firsts, fronts.starts
    local = np.empty((_room(fronts, groups)[0], _TOGETHER))
    for g in groups[::-1]:
        first, eliminated, updated = firsts[g], firsts[g + 1] - firsts[g], fronts.rows[starts[g] : starts[g + 1]]
        for h in range(y.shape[0]):
            _backward_group(y[h], local, values[fronts.numbers[g] : fronts.numbers[g + 1]], first, eliminated, updated)


@compiled(nogil=True)
def _backward_group(x: Floats, local: Floats, values: Floats, first: int, eliminated: int, rows: Ints) -> None:
    size = eliminated + rows.shape[0]
    for k in range(size):
        r = first + k if k < eliminated else rows[k - eliminated]
        for c in range(_TOGETHER):
            local[k, c] = x[r, c]
    at = values.shape[0]
    for k in range(eliminated - 1, -1, -1):
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
