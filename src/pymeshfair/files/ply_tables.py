"""Parses PLY headers, and reads the rows of elements as columns."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled
from ..filters.mesh import Bools, Longs
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .tokens import INTEGER, NOT_FINITE, REAL, Tokens, at_line, refuse, tokenise

#: the numpy type of each PLY type
KINDS: Mapping[str, str] = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4"},
    "float64": "f8",
}
_SIZES: Mapping[str, int] = {name: int(kind[1]) for name, kind in KINDS.items()}
_PLAIN_NAMES = {"uint8": "uchar", "int32": "int", "uint32": "uint", "float32": "float", "float64": "double"}
_FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")
#: limits of a header, so that a hostile file cannot fill the memory: its bytes; its elements and properties together
_LONGEST_HEADER, _MOST_DECLARED = 1 << 26, 1_000
_PADDING = b" \t\r\n\0\x1a"  # bytes that may follow the last row: line ends, and padding by some programs
_END = re.compile(rb"[\r\n]end_header(\r\n|\n|\r)")


@dataclass(frozen=True)
class PlyProperty:
    """A property of an element; `count_type` is the type of a list's length, None for a scalar."""

    name: str
    type: str
    count_type: str | None = None

    def __str__(self) -> str:
        return f"{'' if self.count_type is None else 'list '}{self.type} {self.name}"


@dataclass(frozen=True)
class PlyElement:
    """A kind of element, such as ``vertex``, and its declared count."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...] = ()


@dataclass(frozen=True)
class PlyHeader:
    """A PLY header."""

    format: str  # one of `_FORMATS`
    elements: tuple[PlyElement, ...]  # in the order of the file
    comments: tuple[str, ...]  # what follows ``comment`` and ``obj_info``
    size: int  # its length in bytes, including the end of its last line
    text: bytes  # its bytes

    @property
    def byte_order(self) -> str:
        """The byte order of a binary file: ``"<"`` for little-endian, ``">"`` for big-endian."""
        return ">" if self.format == "binary_big_endian" else "<"

    @property
    def textures(self) -> tuple[str, ...]:
        """The texture files that the header names, as written there."""
        words = (comment.split(maxsplit=1) for comment in self.comments)
        return tuple(w[1].strip() for w in words if len(w) == 2 and w[0].lower() == "texturefile")


def read_header(path: Path) -> PlyHeader:
    """Reads the header of a PLY file; refuses names that occur twice, and counts that are too large for the size of the file."""
    with path.open("rb") as file:
        data = file.read(1 << 16)
        if _END.search(data) is None:
            data += file.read(_LONGEST_HEADER)
        file_size = file.seek(0, 2)
    header = parse_header(data)
    bytes_left = file_size - header.size
    for element in header.elements:
        if element.count and not element.properties:
            raise ContentsError(f"its header declares {element.count:,} of {element.name[:40]!r}, which have no properties")
        # In a text a value takes at least a digit and a separator; lists may be empty.
        row = sum(2 if header.format == "ascii" else _SIZES[p.count_type or p.type] for p in element.properties)
        needed = element.count * row - (header.format == "ascii")
        if needed > bytes_left:
            what = f"{element.count:,} of {element.name!r}, which take at least {needed:,} bytes"
            raise ContentsError(f"its header declares {what}, but only {max(bytes_left, 0):,} follow")
        bytes_left -= needed
    if len({element.name for element in header.elements}) != len(header.elements):
        raise ContentsError("it declares an element twice")
    for element in header.elements:
        if len({p.name for p in element.properties}) != len(element.properties):
            raise ContentsError(f"its element {element.name!r} has a property twice")
    return header


def parse_header(data: bytes) -> PlyHeader:
    """Parses the header at the beginning of the bytes."""
    if not data.startswith(b"ply"):
        raise ContentsError("it does not begin with 'ply'")
    if (end := _END.search(data)) is None:
        raise ContentsError(f"its header has no end within {min(len(data), _LONGEST_HEADER):,} bytes")
    # A carriage return alone ends the lines of files from old Macs.
    lines = data[: end.start()].decode("utf-8", "surrogateescape").replace("\r\n", "\n").replace("\r", "\n").split("\n")[1:]
    format_, comments, elements = "", [], list[tuple[str, int, list[PlyProperty]]]()
    if sum(line.lstrip().startswith(("property", "element")) for line in lines) > _MOST_DECLARED:
        raise ContentsError(f"its header declares more than {_MOST_DECLARED:,} elements and properties")
    for number, line in enumerate(lines, 2):
        match line.split():
            case ["format", word, "1.0"] if word in _FORMATS and not format_:
                format_ = word
            case ["comment" | "obj_info" as keyword, *_]:
                comments.append(line.strip()[len(keyword) :].strip())
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append((name, int(count), []))
            case ["property", "list", count_type, type_, name] if elements and count_type in KINDS and type_ in KINDS:
                elements[-1][2].append(PlyProperty(name, _plain(type_), _plain(count_type)))
            case ["property", type_, name] if elements and type_ in KINDS:
                elements[-1][2].append(PlyProperty(name, _plain(type_)))
            case []:
                pass
            case _:
                raise ContentsError(f"line {number} of its header is {line.strip()[:80]!r}, which is not allowed there")
    if not format_:
        raise ContentsError("its header names no format (ascii, binary_little_endian or binary_big_endian)")
    whole = tuple(PlyElement(name, count, tuple(properties)) for name, count, properties in elements)
    return PlyHeader(format_, whole, tuple(comments), end.end(), data[: end.end()])


def _plain(type_: str) -> str:
    return _PLAIN_NAMES.get(type_, type_)


def header_bytes(header: PlyHeader, elements: Sequence[PlyElement], textures: Sequence[str] | None = None) -> bytes:
    """Returns the header with only `elements`, their properties in the given order, and `textures` (None: its own)."""
    missing, textures = {e.name: e for e in elements}, header.textures if textures is None else textures
    names, further = list(textures[: len(header.textures)]), textures[len(header.textures) :]
    undeclared: dict[str, PlyProperty] = {}  # properties of the element that are not declared yet
    end = "\n"
    lines: list[str] = []
    for raw in header.text.splitlines(keepends=True):
        new = raw.rstrip(b"\r\n").decode("utf-8", "surrogateescape")
        words, end = new.split(), raw[len(raw.rstrip(b"\r\n")) :].decode()
        if words[:1] in (["element"], ["end_header"]):
            lines += [_declaration(p) + end for p in undeclared.values()]
            lines += [f"comment TextureFile {name}{end}" for name in further]
            undeclared, further = {}, ()
        match words:
            case ["end_header"]:
                break
            case ["element", name, count]:
                if (element := missing.pop(name, None)) is None:
                    continue
                undeclared = {p.name: p for p in element.properties}
                new = new if int(count) == element.count else f"element {name} {element.count}"
            case ["property", *types, name]:
                while name in undeclared:
                    p = undeclared.pop(next(iter(undeclared)))
                    same = _declaration(p).split() == ["property", *map(_plain, types), name]
                    lines.append((new if same else _declaration(p)) + end)
                continue
            case [keyword, word, _, *_] if keyword in ("comment", "obj_info") and word.lower() == "texturefile":
                if not names:
                    continue
                if new.split(maxsplit=2)[2].strip() != (name := names.pop(0)):
                    new = f"{keyword} {word} {name}"
        lines.append(new + end)
    for element in missing.values():
        lines += [f"element {element.name} {element.count}{end}", *(_declaration(p) + end for p in element.properties)]
    return "".join((*lines, "end_header", end)).encode("utf-8", "surrogateescape")


def _declaration(p: PlyProperty) -> str:
    return f"property {p.type} {p.name}" if p.count_type is None else f"property list {p.count_type} {p.type} {p.name}"


class Lists(NamedTuple):
    """The lists of one property: the values of all rows in turn, and (n,) the length of each list."""

    values: Array
    lengths: Longs

    @property
    def width(self) -> int | None:
        """The common length of all lists; None if lengths differ, or there is no row."""
        return int(self.lengths[0]) if len(self.lengths) and (self.lengths == self.lengths[0]).all() else None

    @property
    def starts(self) -> Longs:
        """(n,) the index of the first value of each row."""
        return np.cumsum(self.lengths) - self.lengths

    def chosen(self, rows: Longs) -> Lists:
        """Returns the lists of some rows; row -1 gives an empty list."""
        lengths = np.where(rows < 0, 0, self.lengths[rows]) if len(self.lengths) else np.zeros(len(rows), np.int64)
        starts = self.starts[rows] if len(self.lengths) else lengths
        return Lists(self.values[indices_of_runs(starts, lengths)], lengths)


#: (n,) values, or lists
Column: TypeAlias = Array | Lists


@dataclass(frozen=True, eq=False)
class Table:
    """The rows of one element."""

    element: PlyElement
    columns: Mapping[str, Column]  # by property
    bytes: tuple[int, int] | None = None  # where the rows begin and end in the file; None for new rows
    lines: Longs | None = None  # (n,) in a text, the index of each row's line in `Tokens`
    changed: frozenset[str] = frozenset()  # the properties whose numbers differ from those in the file

    def numbers(self, name: str) -> Array | None:
        """Returns (n,) the values of a scalar property; None if the element has no such scalar."""
        column = self.columns.get(name)
        return None if isinstance(column, Lists) else column

    def lists(self, name: str) -> Lists | None:
        """Returns the lists of a list property; None if the element has no such list."""
        column = self.columns.get(name)
        return column if isinstance(column, Lists) else None


def indices_of_runs(starts: Longs, lengths: Longs) -> Longs:
    """Concatenates runs of consecutive integers."""
    positions = np.repeat(starts - (np.cumsum(lengths) - lengths), lengths)
    positions += np.arange(len(positions))
    return positions


def row_type(element: PlyElement, order: str, widths: Mapping[str, int]) -> np.dtype[Any]:
    """Returns the dtype of a binary row with lists of these lengths; the field ``x count`` is the length of the list ``x``."""
    fields: list[Any] = []
    for p in element.properties:
        if p.count_type is None:
            fields.append((p.name, order + KINDS[p.type]))
        else:
            fields += [(f"{p.name} count", order + KINDS[p.count_type]), (p.name, order + KINDS[p.type], (widths[p.name],))]
    return np.dtype(fields)


def row_type_at(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> np.dtype[Any]:
    """Returns the dtype of the rows that begin at byte `position`, with lists as long as in the first row."""
    if not any(p.count_type for p in element.properties):
        return row_type(element, order, {})
    lengths = _walked(data, position, element, order, min(element.count, 1))[1]
    return row_type(element, order, {p.name: int(n) for p, n in zip(element.properties, lengths.sum(axis=0), strict=True)})


def binary_tables(data: NDArray[np.uint8], header: PlyHeader) -> dict[str, Table]:
    """Reads the tables of a binary file, by element."""
    tables: dict[str, Table] = {}
    position = header.size
    for element in header.elements:
        columns, end = _binary_columns(data, position, element, header.byte_order)
        tables[element.name] = Table(element, columns, (position, end))
        position = end
    if trailing := data[position:].tobytes().strip(_PADDING):
        raise ContentsError(f"{len(trailing):,} bytes follow the last row that its header declares")
    return tables


def _binary_columns(data: NDArray[np.uint8], position: int, element: PlyElement, order: str) -> tuple[dict[str, Column], int]:
    """Returns the columns of the element at byte `position`, and the byte after its last row."""
    n, properties = element.count, element.properties
    kind = row_type_at(data, position, element, order)
    if not n or not properties:
        return _columns(np.empty(0, kind), element), position
    end = position + n * kind.itemsize
    if end <= len(data):
        rows = np.frombuffer(data, kind, n, position)
        if all((rows[f"{p.name} count"] == kind[p.name].shape[0]).all() for p in properties if p.count_type):
            return _columns(rows, element), end
    places, lengths, end = _walked(data, position, element, order, n)
    columns: dict[str, Column] = {}
    for k, p in enumerate(properties):
        kind = np.dtype(order + KINDS[p.type])
        at = places[:, k]
        if p.count_type:
            at = np.repeat(at, lengths[:, k])
            at += indices_of_runs(np.zeros(n, np.int64), lengths[:, k]) * kind.itemsize
        value_bytes = data[at[:, None] + np.arange(kind.itemsize)] if len(at) else np.empty((0, kind.itemsize), np.uint8)
        values = np.ascontiguousarray(value_bytes).view(kind)[:, 0]
        columns[p.name] = Lists(values, lengths[:, k].copy()) if p.count_type else values
    return columns, end


def _columns(rows: Array, element: PlyElement) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for p in element.properties:
        column = rows[p.name]
        if p.count_type:
            columns[p.name] = Lists(column.reshape(-1), np.full(len(rows), column.shape[1] if column.ndim > 1 else 0, np.int64))
        else:
            columns[p.name] = column
    return columns


def _walked(data: NDArray[np.uint8], position: int, element: PlyElement, order: str, n: int) -> tuple[Longs, Longs, int]:
    counts = np.array([_SIZES[p.count_type] if p.count_type else 0 for p in element.properties])
    kinds = np.array([ord(KINDS[p.count_type][0]) if p.count_type else 0 for p in element.properties])
    sizes = np.array([_SIZES[p.type] for p in element.properties])
    places, lengths = np.empty((n, len(sizes)), np.int64), np.empty((n, len(sizes)), np.int64)
    end = _walk(data, position, n, counts, kinds, sizes, order == ">", places, lengths)
    if end < 0:
        raise ContentsError(f"its element {element.name!r} is cut short, or a list in it has an impossible length")
    return places, lengths, end


@compiled
def _count_at(data: Any, position: int, size: int, kind: int, big: bool) -> int:
    """Reads the length of a list; returns -1 if it is negative or no whole number."""
    whole = 0
    for b in range(size):
        whole = whole * 256 + data[position + b if big else position + size - 1 - b]
    if kind != 102:  # 102 is "f" (float), and 105 is "i" (signed)
        return -1 if kind == 105 and whole >= 1 << (8 * size - 1) else whole
    digits = (data[position : position + size][::-1] if big else data[position : position + size]).copy()
    count = float(digits.view(np.float32)[0]) if size == 4 else float(digits.view(np.float64)[0])
    return int(count) if 0.0 <= count < 2.0**53 and count == np.floor(count) else -1


@compiled
def _walk(data: Any, position: int, n: int, counts: Any, kinds: Any, sizes: Any, big: bool, places: Any, lengths: Any) -> int:
    """Finds position and length of each value or list; returns the end of the last row, or -1 if a row is invalid."""
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


def text_tables(text: bytes, header: PlyHeader) -> tuple[dict[str, Table], Tokens]:
    """Reads the tables of the text after the header, one row per line; also returns the tokens."""
    body = text.rstrip(_PADDING)
    tokens = tokenise(body)
    tokens = replace(tokens, numbers=tokens.numbers + len(header.text.splitlines()))
    if b"#" in body:
        raise ContentsError("it has comments after its header")
    tables: dict[str, Table] = {}
    line, position = 0, header.size
    for element in header.elements:
        if (lines_left := len(tokens.lengths) - line) < element.count:
            raise ContentsError(f"it declares {element.count:,} of {element.name!r}, but {lines_left:,} lines follow")
        lines = np.arange(line, line + element.count)
        line += element.count
        end = header.size + int(tokens.starts[line] if line < len(tokens.starts) else len(body))
        tables[element.name] = Table(element, _text_columns(tokens, lines, element), (position, end), lines)
        position = end
    if line < len(tokens.lengths):
        raise at_line(tokens, line, "is one more than its header declares")
    return tables, tokens


def _text_columns(tokens: Tokens, lines: Longs, element: PlyElement) -> dict[str, Column]:
    at, end = tokens.first[lines], tokens.first[lines + 1]
    last = max(len(tokens.kinds) - 1, 0)
    columns: dict[str, Column] = {}
    for p in element.properties:
        lengths = np.ones(element.count, np.int64)
        if p.count_type:
            declared = tokens.values[np.minimum(at, last)]
            wrong = (at >= end) | (declared != np.rint(declared)) | (declared < 0) | (declared > end - at)
            wrong |= ~_fits(tokens, np.minimum(at, last), p.count_type)
            refuse(tokens, lines, wrong, f"does not give its list {p.name!r} a length that fits the line")
            lengths = declared.astype(np.int64)
            at += 1
        refuse(tokens, lines, at + lengths > end, f"ends before its {p.name!r}")
        indices = indices_of_runs(at, lengths)
        if not (fit := _fits(tokens, indices, p.type)).all():
            refuse(tokens, np.repeat(lines, lengths), ~fit, f"has a {p.name!r} that is no {p.type}")
        values = tokens.values[indices].astype(KINDS[p.type])
        columns[p.name] = Lists(values, lengths) if p.count_type else values
        at += lengths
    refuse(tokens, lines, at != end, "has more values than its header declares")
    return columns


def _fits(tokens: Tokens, indices: Longs, type_: str) -> Bools:
    kinds, values = tokens.kinds[indices], tokens.values[indices]
    if KINDS[type_][0] != "f":
        limits = np.iinfo(KINDS[type_])
        return np.asarray((kinds == INTEGER) & (values >= limits.min) & (values <= limits.max))
    numbers = (kinds == INTEGER) | (kinds == REAL) | (kinds == NOT_FINITE)
    return np.asarray(numbers & ~(np.isfinite(values) & (np.abs(values) > np.finfo(KINDS[type_]).max)))
