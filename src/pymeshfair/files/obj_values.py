"""The rows of numbers of an OBJ file: how many each line has, and what is odd about those that MeshLab alters in silence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .errors import ContentsError
from .tokens import INTEGER, NOT_FINITE, REAL, Tokens, about_line, word


class ObjError(ContentsError):
    """The text is no OBJ file, or lies; the message gives the line."""


def fail(piece: Tokens, k: int, why: str) -> ObjError:
    """The error about line k of a piece."""
    return ObjError(about_line(piece, k, why))


def is_misspaced(pieces: list[Tokens]) -> bool:
    """Whether MeshLab would take blanks on the first line of a vertex for a colour: it counts them instead of words."""
    for piece in pieces:
        found = np.flatnonzero(piece.keywords == word(b"v"))
        if len(found):
            line = piece.line(int(found[0]))
            return line.count(b" ") + line.count(b"\t") >= 6 > int(piece.lengths[found[0]]) - 1
    return False


def check_rows(piece: Tokens, keyword: str, widths: tuple[int, ...]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which lines have a keyword and of how many numbers each is made, which must be one of `widths`."""
    lines = np.flatnonzero(piece.keywords == word(keyword.encode()))
    counts = piece.lengths[lines] - 1
    wrong = ~np.isin(counts, widths)
    if wrong.any():
        k = int(np.argmax(wrong))
        expected = " or ".join(str(w) for w in widths)
        raise fail(piece, int(lines[k]), f"has {counts[k]} {'value' if counts[k] == 1 else 'values'} and not {expected}")
    for width in np.unique(counts).tolist():
        rows = lines[counts == width]
        kinds = piece.kinds[piece.first[rows, None] + np.arange(1, width + 1)]
        strange = ~np.isin(kinds, (INTEGER, REAL, NOT_FINITE)).all(axis=1)
        if strange.any():
            raise fail(piece, int(rows[np.argmax(strange)]), "has something else than numbers; decimals are written with a point")
    return lines, counts


def texture_coordinate_notes(piece: Tokens) -> Iterator[str]:
    """What MeshLab does not keep of the texture coordinates."""
    lines, counts = check_rows(piece, "vt", (2, 3))
    if piece.values[piece.first[lines[counts == 3]] + 3].any():
        yield "third texture coordinates"
    yield from _not_finite(piece, lines, 2, "texture coordinates")


def normal_notes(piece: Tokens) -> Iterator[str]:
    """What MeshLab does not keep of the normals."""
    yield from _not_finite(piece, check_rows(piece, "vn", (3,))[0], 3, "normals")


def _not_finite(piece: Tokens, lines: NDArray[np.int64], width: int, what: str) -> Iterator[str]:
    if (piece.kinds[piece.first[lines, None] + np.arange(1, width + 1)] == NOT_FINITE).any():
        yield f"{what} that are not finite"
