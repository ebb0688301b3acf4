"""The corners of the faces and polylines of an OBJ file: ``vertex/texture coordinate/normal``."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .tokens import AFTER_SLASH, EMPTY, INTEGER, Tokens, word


@dataclass
class Corners:
    """The corners on the lines of one keyword in a piece of text.

    Attributes:
        lines: (m,) the lines, as the piece counts them.
        counts: (m,) how many corners each has.
        texture_counts: (m,) how many of them have texture coordinates.
        values: (c,) the indices in order.
        slots: (c,) what each is an index of: 0 a vertex, 1 a texture coordinate, 2 a normal.
        line_of: (c,) the line of each.
        strange: the first line with something that is no corner, or -1.
    """

    lines: NDArray[np.int64]
    counts: NDArray[np.int64]
    texture_counts: NDArray[np.int64]
    values: NDArray[np.float64]
    slots: NDArray[np.int8]
    line_of: NDArray[np.int64]
    strange: int

    def absolute(self, piece: Tokens) -> dict[int, bytes]:
        """The lines by their number, with the indices as they are in `values`."""
        text = {}
        for k, rows in self._rows():
            corners = [b"%d" % self.values[i] for i in rows]
            for j, i in enumerate(rows):
                if self.slots[i]:
                    corners[j] = (b"/" if self.slots[i] == 1 or self.slots[rows[j - 1]] == 1 else b"//") + corners[j]
                elif j:
                    corners[j] = b" " + corners[j]
            text[int(piece.numbers[k])] = b"f " + b"".join(corners)
        return text

    def single_edges(self, piece: Tokens) -> dict[int, bytes]:
        """The lines by their number, with each edge in a line of its own: of ``l 1 2 3`` MeshLab reads the first edge alone."""
        text = {}
        for k, rows in self._rows():
            named = [int(self.values[i]) for i in rows if self.slots[i] == 0]
            text[int(piece.numbers[k])] = b"\n".join(b"l %d %d" % pair for pair in itertools.pairwise(named))
        return text

    def _rows(self) -> list[tuple[int, list[int]]]:
        ends = np.searchsorted(self.line_of, self.lines, side="right").tolist()
        return [(k, list(range(start, end))) for k, start, end in zip(self.lines.tolist(), [0, *ends[:-1]], ends, strict=True)]


def corners_of(piece: Tokens, keyword: str) -> Corners:
    """Take the lines of a keyword apart."""
    chosen = piece.keywords == word(keyword.encode())
    lines = np.flatnonzero(chosen)
    lengths = piece.lengths
    mask = np.repeat(chosen, lengths)
    mask[piece.first[lines]] = False
    kinds, values = piece.kinds[mask], piece.values[mask]
    line_of = np.repeat(lines, lengths[lines] - 1)
    follows = kinds >= AFTER_SLASH
    kinds = kinds & (AFTER_SLASH - 1)
    slots = follows.astype(np.int8)
    if follows.any():
        slots[1:] += follows[1:] & follows[:-1]
        strange = np.zeros(len(slots), dtype=bool)
        strange[2:] = follows[2:] & follows[1:-1] & follows[:-2]  # three slashes
        strange |= (kinds == EMPTY) & (slots != 1)
    else:
        strange = kinds == EMPTY
    strange |= (kinds != INTEGER) & (kinds != EMPTY)
    there = kinds == INTEGER
    order = np.repeat(np.arange(len(lines)), lengths[lines] - 1)
    per_line = np.bincount(order[slots == 0], minlength=len(lines))
    textured = np.bincount(order[(slots == 1) & there], minlength=len(lines)) if follows.any() else np.zeros_like(per_line)
    first_strange = int(line_of[np.argmax(strange)]) if strange.any() else -1
    return Corners(lines, per_line, textured, values[there], slots[there], line_of[there], first_strange)
