"""The rows of the elements of a PLY file that is a text."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .ply import PlyElement, PlyError, PlyHeader
from .ply_rows import KINDS, PADDING, AllRows, Rows
from .tokens import INTEGER, NOT_FINITE, REAL, REMARKED, Tokens, joined_pieces, tokenise


def text_rows(data: NDArray[np.uint8], header: PlyHeader) -> AllRows:
    """The rows of a text, one a line.

    Raises:
        PlyError: a line is not what the header declares.
    """
    body = data[header.size :].tobytes().rstrip(PADDING)
    piece = joined_pieces(tokenise(body))
    if piece.oddities & REMARKED or b"#" in body:
        raise PlyError("it has comments behind its header")
    rows = AllRows()
    rows.exact = piece.exact
    line = 0
    for element in header.elements:
        if len(piece.lengths) - line < element.count:
            raise PlyError(f"it declares {element.count:,} of {element.name!r}, but {len(piece.lengths) - line:,} lines follow")
        rows[element.name] = _text_element(piece, line, element, body)
        line += element.count
    if line < len(piece.lengths):
        raise _fail(piece, line, "is one more than its header declares")
    return rows


def _text_element(piece: Tokens, line: int, element: PlyElement, body: bytes) -> Rows:
    rows = Rows(element, text=body)
    first = piece.first[line : line + element.count]
    end = piece.first[line + 1 : line + element.count + 1]
    at = first.copy()
    last = max(len(piece.kinds) - 1, 0)
    for p in element.properties:
        lengths = np.ones(element.count, np.int64)
        if p.count_type:
            said = piece.values[np.minimum(at, last)]
            wrong = (at >= end) | (piece.kinds[np.minimum(at, last)] != INTEGER) | (said < 0) | (said > end - at)
            _refuse(piece, line, wrong, f"does not say how long its list {p.name!r} is")
            lengths = said.astype(np.int64)
            at += 1
            rows.list_lengths[p.name] = lengths
        _refuse(piece, line, at + lengths > end, f"ends before its {p.name!r}")
        tokens = np.repeat(at, lengths)
        tokens += np.arange(len(tokens)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
        whole = KINDS[p.type][0] != "f"
        strange = ~np.isin(piece.kinds[tokens], (INTEGER,) if whole else (INTEGER, REAL, NOT_FINITE))
        if whole:
            limits = np.iinfo(KINDS[p.type])
            strange |= ~((piece.values[tokens] >= limits.min) & (piece.values[tokens] <= limits.max))
        elif p.type == "float":
            strange |= np.isfinite(piece.values[tokens]) & (np.abs(piece.values[tokens]) > np.finfo(np.float32).max)
        if strange.any():
            row = int(np.repeat(np.arange(element.count), lengths)[np.argmax(strange)])
            raise _fail(piece, line + row, f"has a {p.name!r} that is no {p.type}")
        rows.values[p.name] = piece.values[tokens]
        rows.tokens[p.name] = tokens
        at += lengths
    _refuse(piece, line, at != end, "has more than is declared")
    return rows


def _refuse(piece: Tokens, line: int, wrong: NDArray[np.bool_], why: str) -> None:
    if wrong.any():
        raise _fail(piece, line + int(np.argmax(wrong)), why)


def _fail(piece: Tokens, k: int, why: str) -> PlyError:
    return PlyError(f"line {piece.numbers[k]:,} behind its header, {piece.line(k)[:60].decode('utf-8', 'replace')!r}, {why}")
