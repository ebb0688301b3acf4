"""The rows of the elements of a PLY file with lists of any length, and those of a binary file; a text is in `ply_text_rows`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled
from .ply import SIZES, PlyElement, PlyError, PlyHeader

KINDS = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8"}
#: what may stand behind the last row: ends of lines, and what some programs fill a file up with
PADDING = b" \t\r\n\0\x1a"
KINDS |= {"int8": "i1", "int16": "i2", "uint16": "u2"}


@dataclass
class Rows:
    """The rows of one element.

    Attributes:
        fixed: the rows as an array with a field a property, where all lists of a property are equally long; else None.
        list_lengths: (n,) by the name of a list.
        values: the values of each property by name, one row after the other; those of a text a few units off in the last place.
        tokens: of which words of a text they are.
        text: the text.
    """

    element: PlyElement
    fixed: NDArray[Any] | None = None
    list_lengths: dict[str, NDArray[np.int64]] = field(default_factory=dict)
    values: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    tokens: dict[str, NDArray[np.int64]] = field(default_factory=dict)
    text: bytes = b""

    def has_column(self, name: str) -> bool:
        """Whether a property has one value a row that is known."""
        known = next((p for p in self.element.properties if p.name == name), None)
        return known is not None and known.count_type is None and (name in self.values or self.fixed is not None)

    def column(self, name: str) -> NDArray[np.float64]:
        """(n,) the values of a property that is no list."""
        if name in self.values:
            return self.values[name]
        if self.fixed is None:
            raise PlyError(f"the rows of its element {self.element.name!r} are not equally long")
        return self.fixed[name].astype(np.float64)

    def exact_column(self, name: str) -> NDArray[np.float64]:
        """The same to the last bit, also of a text, which takes longer."""
        if name not in self.tokens:
            return self.column(name)
        words = self.text.split()
        return np.array([float(words[k]) for k in self.tokens[name].tolist()])

    def lengths(self, name: str) -> NDArray[np.int64]:
        """(n,) how many values the lists of a property have."""
        return self.list_lengths[name]

    def check_range(self, name: str, least: int, end: int, what: str) -> None:
        """Refuse indices below `least` or not below `end`."""
        items = self.values[name] if self.fixed is None else self.fixed[name]
        if items.size and not (items.min() >= least and items.max() < end):
            raise PlyError(f"a {what} of it names a vertex that is none of its {end:,}")


class AllRows(dict[str, Rows]):
    """The rows of all elements by name; `done` are those looked at, `exact` says whether a text gave every bit of them."""

    def __init__(self) -> None:
        """See the class."""
        super().__init__()
        self.done: list[str] = []
        self.exact = False


def binary_rows(data: NDArray[np.uint8], header: PlyHeader) -> AllRows:
    """The rows of a binary file.

    Raises:
        PlyError: the file ends before they do.
    """
    order = "<" if header.format == "binary_little_endian" else ">"
    rows = AllRows()
    position = header.size
    for element in header.elements:
        rows[element.name], position = _binary_element(data, position, element, order)
    more = data[position:].tobytes().strip(PADDING)
    if more:
        raise PlyError(f"{len(more):,} bytes follow behind all that its header declares")
    return rows


def _binary_element(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> tuple[Rows, int]:
    rows = Rows(element)
    lists = [p for p in element.properties if p.count_type]
    if element.count == 0 or not element.properties:
        rows.list_lengths = {p.name: np.empty(0, np.int64) for p in lists}
        rows.fixed = np.empty(0, [(p.name, KINDS[p.type]) for p in element.properties])
        return rows, position
    # All rows may be like the first.
    kind = _row_type(data, position, element, order)
    if kind is not None and element.count * kind.itemsize <= len(data) - position:
        fixed = np.frombuffer(data, kind, element.count, position)
        if all((fixed[f"{p.name} count"] == fixed[f"{p.name} count"][0]).all() for p in lists):
            rows.fixed = fixed
            rows.list_lengths = {p.name: fixed[f"{p.name} count"].astype(np.int64) for p in lists}
            return rows, position + element.count * kind.itemsize
    return _uneven(data, position, element, order)


def _row_type(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> np.dtype[Any] | None:
    """The type of rows that are like the one at a position."""
    fields: list[Any] = []
    for p in element.properties:
        kind = order + KINDS[p.type]
        if p.count_type is None:
            fields.append((p.name, kind))
            position += SIZES[p.type]
            continue
        size = SIZES[p.count_type]
        if position + size > len(data):
            return None
        count = int(np.frombuffer(data, order + KINDS[p.count_type], 1, position)[0])
        if not 0 <= count <= (len(data) - position) // SIZES[p.type]:
            return None
        fields += [(f"{p.name} count", order + KINDS[p.count_type]), (p.name, kind, (count,))]
        position += size + count * SIZES[p.type]
    return np.dtype(fields)


def _uneven(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> tuple[Rows, int]:
    """Rows with lists of different lengths."""
    n, properties = element.count, element.properties
    counts = np.array([SIZES[p.count_type] if p.count_type else 0 for p in properties])
    signed = np.array([KINDS[p.count_type][0] == "i" if p.count_type else False for p in properties])
    sizes = np.array([SIZES[p.type] for p in properties])
    places = np.empty((n, len(properties)), np.int64)
    lengths = np.empty((n, len(properties)), np.int64)
    end = _walk(data, position, n, counts, signed, sizes, order == ">", places, lengths)
    if end < 0:
        raise PlyError(f"its element {element.name!r} is cut short, or a list in it has a length that cannot be")
    rows = Rows(element)
    for k, p in enumerate(properties):
        kind = np.dtype(order + KINDS[p.type])
        at = places[:, k]
        if p.count_type:
            rows.list_lengths[p.name] = lengths[:, k]
            total = int(lengths[:, k].sum())
            at = np.repeat(at, lengths[:, k])
            at += (np.arange(total) - np.repeat(np.cumsum(lengths[:, k]) - lengths[:, k], lengths[:, k])) * kind.itemsize
        each = data[at[:, None] + np.arange(kind.itemsize)] if len(at) else np.empty((0, kind.itemsize), np.uint8)
        rows.values[p.name] = np.ascontiguousarray(each).view(kind)[:, 0].astype(np.float64)
    return rows, end


@compiled
def _walk(data: Any, position: int, n: int, counts: Any, signed: Any, sizes: Any, big: bool, places: Any, lengths: Any) -> int:
    """Where each value or list of each row begins and how long it is; the end of the last row, or -1."""
    for row in range(n):
        for k in range(len(sizes)):
            length = 1
            if counts[k]:
                if position + counts[k] > len(data):
                    return -1
                length = 0
                for b in range(counts[k]):
                    byte = data[position + b] if big else data[position + counts[k] - 1 - b]
                    length = length * 256 + byte
                if signed[k] and length >= 1 << (8 * counts[k] - 1):
                    return -1
                position += counts[k]
            places[row, k] = position
            lengths[row, k] = length
            if length > (len(data) - position) // sizes[k]:
                return -1
            position += length * sizes[k]
    return position
