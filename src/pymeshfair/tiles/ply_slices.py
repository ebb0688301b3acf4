"""Binary PLY files read by slices."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.errors import ContentsError
from ..files.ply import CORNERS, PLACE
from ..files.ply_header import KINDS, PlyElement, PlyHeader, header_bytes, read_header
from ..files.ply_tables import row_type
from ..files.writing import to_disk


@dataclass(frozen=True)
class SlicedTable:
    """The rows of one element, all of the same size."""

    path: Path
    element: PlyElement  # its declaration in the header
    dtype: np.dtype[Any]  # the type of a row, see `pymeshfair.files.ply_tables.row_type`
    offset: int  # the byte of its first row

    def read(self, first: int, last: int) -> NDArray[Any]:
        """The rows from `first` to before `last`."""
        rows = np.fromfile(self.path, self.dtype, last - first, offset=self.offset + first * self.dtype.itemsize)
        if len(rows) < last - first:
            raise ContentsError(f"it ends within its element {self.element.name!r}")
        for p in self.element.properties:
            if p.count_type is not None:
                length = self.dtype[p.name].shape[0]
                wrong = rows[f"{p.name} count"] != length
                if wrong.any():
                    raise ContentsError(
                        f"the list {p.name!r} of its {self.element.name} {first + int(wrong.argmax()) + 1:,} has another length "
                        f"than {length}; by tiles, all faces must be triangles: read and save it whole with pymeshfair run"
                    )
        return rows

    def slices(self, size: int) -> Iterator[NDArray[Any]]:
        """Its rows, `size` at a time."""
        for first in range(0, self.element.count, size):
            yield self.read(first, min(first + size, self.element.count))

    @property
    def end(self) -> int:
        """The byte after its last row."""
        return self.offset + self.element.count * self.dtype.itemsize


@dataclass(frozen=True)
class PlySlices:
    """A binary PLY file in which all rows of an element have the same size; other files raise `ContentsError` when read."""

    path: Path

    @cached_property
    def header(self) -> PlyHeader:
        """Its header, checked."""
        header = read_header(self.path)
        if header.format == "ascii":
            raise ContentsError("it is a text; by tiles a PLY file must be binary")
        return header

    @cached_property
    def tables(self) -> dict[str, SlicedTable]:
        """Its elements by name, in the order of the file."""
        tables, offset = {}, self.header.size
        for element in self.header.elements:
            table = SlicedTable(self.path, element, self._row_type(element, offset), offset)
            tables[element.name], offset = table, table.end
        if self.path.stat().st_size < offset:
            raise ContentsError(f"it has {self.path.stat().st_size:,} bytes, of the {offset:,} that its header declares")
        return tables

    def _row_type(self, element: PlyElement, offset: int) -> np.dtype[Any]:
        """The type of an element's row; its lists are as long as in the first row, which begins at byte `offset`."""
        order, widths = self.header.byte_order, dict[str, int]()
        for k, p in enumerate(element.properties):
            if p.count_type is not None:
                before = row_type(PlyElement(element.name, 1, element.properties[:k]), order, widths)
                place = offset + before.itemsize
                lengths = np.fromfile(self.path, order + KINDS[p.count_type], min(element.count, 1), offset=place)
                if element.count and not len(lengths):
                    raise ContentsError(f"it ends before byte {place:,}, where its header has the first {element.name!r}")
                length = int(lengths[0]) if element.count else 3
                if element.name == "face" and p.name in CORNERS and length != 3:
                    raise ContentsError(f"its first face has {length} corners; by tiles, all faces must be triangles")
                widths[p.name] = length
        return row_type(element, order, widths)

    @cached_property
    def vertices(self) -> SlicedTable:
        """The element of its vertices, which must have coordinates."""
        table = self.tables.get("vertex")
        if table is None or not set(PLACE) <= {p.name for p in table.element.properties} or not table.element.count:
            raise ContentsError("it has no vertices with x, y and z")
        if any(p.count_type is not None for p in table.element.properties):
            raise ContentsError("its vertices have lists; by tiles they must have single numbers")
        return table

    def __len__(self) -> int:
        """The number of vertices."""
        return self.vertices.element.count

    def points(self, size: int) -> Iterator[NDArray[np.float64]]:
        """(m, 3) coordinates of the vertices, `size` at a time."""
        for rows in self.vertices.slices(size):
            yield np.stack([rows[axis].astype(np.float64) for axis in PLACE], axis=1)

    def rewrite(
        self, target: Path, elements: Sequence[PlyElement], vertices: Iterable[Mapping[str, NDArray[Any]]], size: int
    ) -> None:
        """Write the file with other elements and other columns of vertices, a slice at a time; all else as it was."""
        with target.open("wb") as file:
            file.write(header_bytes(self.header, elements))
            for element in elements:
                if element.name != "vertex":
                    file.writelines(rows.tobytes() for rows in self.tables[element.name].slices(size))
                    continue
                kind = row_type(element, self.header.byte_order, {})
                for columns in vertices:
                    new = np.empty(len(columns["x"]), kind)
                    for name, values in columns.items():
                        new[name] = values
                    file.write(new.tobytes())
            to_disk(file)
