"""The rows of a PLY file as columns, read and checked to the last byte."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled
from .errors import ContentsError
from .ply_header import KINDS, SIZES, PlyElement, PlyHeader
from .tokens import INTEGER, NOT_FINITE, REAL, Tokens, at_line, refuse, tokenise

#: bytes that may follow the last row: ends of lines, and the padding of some programs
PADDING = b" \t\r\n\0\x1a"
Array: TypeAlias = NDArray[Any]


class Lists(NamedTuple):
    """The lists of one property: all values, one row after the other, and (n,) how many each row has."""

    values: Array
    lengths: NDArray[np.int64]

    @property
    def width(self) -> int | None:
        """The length of all lists; None if they differ, or there is no row."""
        return int(self.lengths[0]) if len(self.lengths) and (self.lengths == self.lengths[0]).all() else None

    @property
    def starts(self) -> NDArray[np.int64]:
        """(n,) the number of the first value of each row."""
        return np.cumsum(self.lengths) - self.lengths

    def chosen(self, rows: NDArray[np.int64]) -> Lists:
        """The lists of some rows; -1 stands for an empty one."""
        lengths = np.where(rows < 0, 0, self.lengths[rows]) if len(self.lengths) else np.zeros(len(rows), np.int64)
        starts = self.starts[rows] if len(self.lengths) else lengths
        return Lists(self.values[indices_of_runs(starts, lengths)], lengths)


#: (n,) values, or lists
Column: TypeAlias = Array | Lists


@dataclass(frozen=True, eq=False)
class Table:
    """The rows of one element."""

    element: PlyElement  # its declaration in the header
    columns: Mapping[str, Column]  # by property
    bytes: tuple[int, int] = (0, 0)  # where they begin and end in the file
    lines: NDArray[np.int64] | None = None  # (n,) the lines of a text that they are, as `Tokens` counts them

    def numbers(self, name: str) -> Array | None:
        """(n,) the values of a property; None if it has no such property, or one of lists."""
        column = self.columns.get(name)
        return None if isinstance(column, Lists) else column

    def lists(self, name: str) -> Lists | None:
        """The lists of a property; None if it has no such property, or one of single values."""
        column = self.columns.get(name)
        return column if isinstance(column, Lists) else None


def indices_of_runs(starts: NDArray[np.int64], lengths: NDArray[np.int64]) -> NDArray[np.int64]:
    """Runs of consecutive numbers, each from its start and of its length, one after the other."""
    ends = np.cumsum(lengths)
    positions = np.repeat(starts - (ends - lengths), lengths)
    positions += np.arange(len(positions))
    return positions


def row_type(element: PlyElement, order: str, widths: Mapping[str, int]) -> np.dtype[Any]:
    """The type of a binary row whose lists have these lengths; the length of the list ``x`` is the field ``x count``."""
    fields: list[Any] = []
    for p in element.properties:
        if p.count_type is None:
            fields.append((p.name, order + KINDS[p.type]))
        else:
            fields += [(f"{p.name} count", order + KINDS[p.count_type]), (p.name, order + KINDS[p.type], (widths[p.name],))]
    return np.dtype(fields)


# ------------------------------------------------------------------------------------------------------------------- binary


def row_type_at(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> np.dtype[Any]:
    """The type of all rows of an element, if their lists are as long as those of the first, which begins at that byte."""
    if not any(p.count_type for p in element.properties):
        return row_type(element, order, {})
    lengths = _walked(data, position, element, order, min(element.count, 1))[1]
    return row_type(element, order, {p.name: int(n) for p, n in zip(element.properties, lengths.sum(axis=0), strict=True)})


def binary_tables(data: NDArray[np.uint8], header: PlyHeader) -> dict[str, Table]:
    """The tables of a binary file by element."""
    tables: dict[str, Table] = {}
    position = header.size
    for element in header.elements:
        tables[element.name] = table = _binary_table(data, position, element, header.byte_order)
        position = table.bytes[1]
    more = data[position:].tobytes().strip(PADDING)
    if more:
        raise ContentsError(f"{len(more):,} bytes follow behind all that its header declares")
    return tables


def _binary_table(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> Table:
    n, properties = element.count, element.properties
    kind = row_type_at(data, position, element, order)
    if not n or not properties:
        return Table(element, _columns(np.empty(0, kind), element), (position, position))
    end = position + n * kind.itemsize
    if end <= len(data):
        rows = np.frombuffer(data, kind, n, position)
        if all((rows[f"{p.name} count"] == kind[p.name].shape[0]).all() for p in properties if p.count_type):
            return Table(element, _columns(rows, element), (position, end))
    places, lengths, end = _walked(data, position, element, order, n)
    columns: dict[str, Column] = {}
    for k, p in enumerate(properties):
        kind = np.dtype(order + KINDS[p.type])
        at = places[:, k]
        if p.count_type:
            at = np.repeat(at, lengths[:, k])
            at += indices_of_runs(np.zeros(n, np.int64), lengths[:, k]) * kind.itemsize
        each = data[at[:, None] + np.arange(kind.itemsize)] if len(at) else np.empty((0, kind.itemsize), np.uint8)
        values = np.ascontiguousarray(each).view(kind)[:, 0]
        columns[p.name] = Lists(values, lengths[:, k].copy()) if p.count_type else values
    return Table(element, columns, (position, end))


def _columns(rows: Array, element: PlyElement) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for p in element.properties:
        column = rows[p.name]
        if p.count_type:
            columns[p.name] = Lists(column.reshape(-1), np.full(len(rows), column.shape[1] if column.ndim > 1 else 0, np.int64))
        else:
            columns[p.name] = column
    return columns


def _walked(
    data: NDArray[np.uint8], position: int, element: PlyElement, order: str, n: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """(n, p) the places and lengths of the properties of the first rows, one for a single value; the end of the last row."""
    counts = np.array([SIZES[p.count_type] if p.count_type else 0 for p in element.properties])
    kinds = np.array([ord(KINDS[p.count_type][0]) if p.count_type else 0 for p in element.properties])
    sizes = np.array([SIZES[p.type] for p in element.properties])
    places, lengths = np.empty((n, len(sizes)), np.int64), np.empty((n, len(sizes)), np.int64)
    end = _walk(data, position, n, counts, kinds, sizes, order == ">", places, lengths)
    if end < 0:
        raise ContentsError(f"its element {element.name!r} is cut short, or a list in it has a length that cannot be")
    return places, lengths, end


@compiled
def _count_at(data: Any, position: int, size: int, kind: int, big: bool) -> int:
    """The length of a list in a file; -1 if it is below 0 or no whole number."""
    whole = 0
    for b in range(size):
        whole = whole * 256 + data[position + b if big else position + size - 1 - b]
    if kind != 102:  # no "f"
        return -1 if kind == 105 and whole >= 1 << (8 * size - 1) else whole
    digits = (data[position : position + size][::-1] if big else data[position : position + size]).copy()
    count = float(digits.view(np.float32)[0]) if size == 4 else float(digits.view(np.float64)[0])
    return int(count) if 0.0 <= count < 2.0**53 and count == np.floor(count) else -1


@compiled
def _walk(data: Any, position: int, n: int, counts: Any, kinds: Any, sizes: Any, big: bool, places: Any, lengths: Any) -> int:
    """Find the place and length of each value or list of each row; the end of the last row, or -1."""
    for row in range(n):
        for k in range(len(sizes)):
            length = 1
            if counts[k]:
                if position + counts[k] > len(data):
                    return -1
                length = _count_at(data, position, counts[k], kinds[k], big)
                if length < 0:
                    return -1
                position += counts[k]
            places[row, k] = position
            lengths[row, k] = length
            if length > (len(data) - position) // sizes[k]:
                return -1
            position += length * sizes[k]
    return position


# --------------------------------------------------------------------------------------------------------------------- text


def text_tables(text: bytes, header: PlyHeader) -> tuple[dict[str, Table], Tokens]:
    """The tables of the text behind the header, one row a line; and the text in tokens."""
    body = text.rstrip(PADDING)
    piece = tokenise(body)
    piece = replace(piece, numbers=piece.numbers + len(header.text.splitlines()))
    if b"#" in body:
        raise ContentsError("it has comments behind its header")
    tables: dict[str, Table] = {}
    line = 0
    for element in header.elements:
        if (left := len(piece.lengths) - line) < element.count:
            raise ContentsError(f"it declares {element.count:,} of {element.name!r}, but {left:,} lines follow")
        tables[element.name] = _text_table(piece, line, element)
        line += element.count
    if line < len(piece.lengths):
        raise at_line(piece, line, "is one more than its header declares")
    return tables, piece


def _text_table(piece: Tokens, line: int, element: PlyElement) -> Table:
    at = piece.first[line : line + element.count].copy()
    end = piece.first[line + 1 : line + element.count + 1]
    last = max(len(piece.kinds) - 1, 0)
    lines = np.arange(line, line + element.count)
    columns: dict[str, Column] = {}
    for p in element.properties:
        lengths = np.ones(element.count, np.int64)
        if p.count_type:
            declared = piece.values[np.minimum(at, last)]
            wrong = (at >= end) | (declared != np.rint(declared)) | (declared < 0) | (declared > end - at)
            wrong |= ~_fits(piece, np.minimum(at, last), p.count_type)
            refuse(piece, lines, wrong, f"does not say how long its list {p.name!r} is")
            lengths = declared.astype(np.int64)
            at += 1
        refuse(piece, lines, at + lengths > end, f"ends before its {p.name!r}")
        tokens = indices_of_runs(at, lengths)
        if not (fit := _fits(piece, tokens, p.type)).all():
            refuse(piece, np.repeat(lines, lengths), ~fit, f"has a {p.name!r} that is no {p.type}")
        values = piece.values[tokens].astype(KINDS[p.type])
        columns[p.name] = Lists(values, lengths) if p.count_type else values
        at += lengths
    refuse(piece, lines, at != end, "has more than is declared")
    return Table(element, columns, lines=lines)


def _fits(piece: Tokens, tokens: NDArray[np.int64], type_: str) -> NDArray[np.bool_]:
    """Which tokens are numbers of a type."""
    kinds, values = piece.kinds[tokens], piece.values[tokens]
    if KINDS[type_][0] != "f":
        limits = np.iinfo(KINDS[type_])
        return np.asarray((kinds == INTEGER) & (values >= limits.min) & (values <= limits.max))
    numbers = (kinds == INTEGER) | (kinds == REAL) | (kinds == NOT_FINITE)
    return np.asarray(numbers & ~(np.isfinite(values) & (np.abs(values) > np.finfo(KINDS[type_]).max)))
