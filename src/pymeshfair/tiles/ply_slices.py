"""Binary PLY files read by slices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.errors import ContentsError
from ..files.ply import PlyElement, PlyHeader, read_header
from ..files.ply_rows import KINDS

#: the numbers of a corner list
CORNERS = ("vertex_indices", "vertex_index")
#: what stands before the name of a list for its length
COUNT = "count of "


@dataclass(frozen=True)
class Table:
    """The rows of one element, all of the same size.

    Attributes:
        path: the file.
        element: what the header says of it.
        dtype: of a row; a list is an array with its length before it.
        offset: the byte of its first row.
    """

    path: Path
    element: PlyElement
    dtype: np.dtype[Any]
    offset: int

    def read(self, first: int, last: int) -> NDArray[Any]:
        """The rows from `first` to before `last`.

        Raises:
            ContentsError: a list is not as long as that of the first row.
        """
        rows = np.fromfile(self.path, self.dtype, last - first, offset=self.offset + first * self.dtype.itemsize)
        if len(rows) < last - first:
            raise ContentsError(f"it ends within its element {self.element.name!r}")
        for p in self.element.properties:
            if p.count_type is not None:
                length = self.dtype[p.name].shape[0]
                wrong = rows[COUNT + p.name] != length
                if wrong.any():
                    raise ContentsError(
                        f"the list {p.name!r} of its {self.element.name} {first + int(wrong.argmax()) + 1:,} has another length "
                        f"than {length}; by tiles, all faces must be triangles: read and save it with pymeshfair run, if it fits"
                    )
        return rows

    @property
    def end(self) -> int:
        """The byte after its last row."""
        return self.offset + self.element.count * self.dtype.itemsize

    def has(self, *names: str) -> bool:
        """Whether each row has properties of these names."""
        return set(names) <= {p.name for p in self.element.properties}


@dataclass(frozen=True)
class PlySlices:
    """A binary PLY file whose elements have rows of one size each; whatever is read raises `ContentsError` where it does not fit.

    Attributes:
        path: the file.
    """

    path: Path

    @cached_property
    def header(self) -> PlyHeader:
        """What its header says, checked."""
        header = read_header(self.path)
        if header.format == "ascii":
            raise ContentsError("it is a text; by tiles a PLY file must be binary")
        names = [(e.name, *(p.name for p in e.properties)) for e in header.elements]
        if len({n[0] for n in names}) < len(names) or any(len(set(n[1:])) < len(n[1:]) for n in names):
            raise ContentsError("it declares an element or a property twice")
        return header

    @cached_property
    def tables(self) -> dict[str, Table]:
        """Its elements by name, in the order of the file."""
        order = "<" if self.header.format == "binary_little_endian" else ">"
        found, offset = {}, self.header.size
        for element in self.header.elements:
            kinds: list[Any] = []
            place = offset
            for p in element.properties:
                number = np.dtype(f"{order}{KINDS[p.type]}")
                if p.count_type is None:
                    kinds.append((p.name, number))
                else:
                    count = np.dtype(f"{order}{KINDS[p.count_type]}")
                    length = int(np.fromfile(self.path, count, 1, offset=place)[0]) if element.count else 3
                    if element.name == "face" and p.name in CORNERS and length != 3:
                        raise ContentsError(f"its first face has {length} corners; by tiles, all faces must be triangles")
                    kinds += [(COUNT + p.name, count), (p.name, number, (length,))]
                place = offset + np.dtype(kinds).itemsize
            table = Table(self.path, element, np.dtype(kinds), offset)
            found[element.name], offset = table, table.end
        if self.path.stat().st_size < offset:
            raise ContentsError(f"it has {self.path.stat().st_size:,} bytes, of the {offset:,} that its header declares")
        return found

    @cached_property
    def vertices(self) -> Table:
        """The element of its vertices, which have places."""
        table = self.tables.get("vertex")
        if table is None or not table.has("x", "y", "z") or not table.element.count:
            raise ContentsError("it has no vertices with x, y and z")
        if any(p.count_type is not None for p in table.element.properties):
            raise ContentsError("its vertices have lists; by tiles they must have numbers alone")
        return table

    def __len__(self) -> int:
        """How many vertices it has."""
        return self.vertices.element.count

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """(m, 3) coordinates of the vertices, so many at a time."""
        for rows in self.rows(size):
            yield np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)

    def rows(self, size: int) -> Iterator[NDArray[Any]]:
        """The vertices as they are, so many at a time."""
        for first in range(0, len(self), size):
            yield self.vertices.read(first, min(first + size, len(self)))


def header_text(header: PlyHeader, elements: tuple[PlyElement, ...]) -> bytes:
    """A header of the same format and comments with these elements."""
    lines = ["ply", f"format {header.format} 1.0", *(f"comment {c}" for c in header.comments)]
    for element in elements:
        lines.append(f"element {element.name} {element.count}")
        lines += [
            f"property {p.type} {p.name}" if p.count_type is None else f"property list {p.count_type} {p.type} {p.name}"
            for p in element.properties
        ]
    return "\n".join([*lines, "end_header", ""]).encode("utf-8", "surrogateescape")
