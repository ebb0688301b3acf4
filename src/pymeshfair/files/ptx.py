"""Reads PTX files: grids of points from scanners, each after a head with its size, the scanner's pose and a matrix."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh_data import MeshData, Source
from .errors import ContentsError
from .reading import Reading, unended
from .references import References
from .tokens import INTEGER, Tokens, at_line, numbers_of, refuse, tokenise

#: numbers in the lines of a head: columns, rows, four lines of the scanner's pose, four of a matrix
_HEAD = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
#: numbers of a point: position and intensity; the same and a colour
_PLAIN, _COLOURED = 4, 7
#: tolerance for the rounding of a written matrix
_ROUNDED = 1e-6


def read_ptx(path: Path, references: References) -> Reading:
    """Read the points of all grids, transformed by the matrices of their heads."""
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        raise ContentsError("it is no text")
    if b"#" in data:
        raise ContentsError("it has comments, which the format does not know")
    tokens = tokenise(data)
    grids, extras, line = [], [], 0
    while line < len(tokens.numbers):
        count = _count(tokens, line)
        first = line + len(_HEAD)
        width = _width(tokens, first, count)
        numbers_of(tokens, np.arange(line + 2, line + 6), 0, 3)
        matrix = numbers_of(tokens, np.arange(line + 6, first), 0, 4)
        position = tokens.values[tokens.first[line + 2] : tokens.first[line + 3]]
        if position.any() or not np.array_equal(matrix, np.eye(4)):
            extras.append(f"the scanner's place {' '.join(f'{x:g}' for x in position)}")
        line = first + count
        grids.append(_placed(numbers_of(tokens, np.arange(first, line), 0, width), matrix))
    widest = max((grid.shape[1] for grid in grids), default=_PLAIN)
    # White in a grid without colours, if another one has some.
    grids = [np.pad(grid, ((0, 0), (0, widest - grid.shape[1])), constant_values=255.0) for grid in grids]
    rows = np.concatenate([np.empty((0, widest)), *grids])
    if not len(rows):
        raise ContentsError("it holds no points")
    measured = rows[~np.isnan(rows[:, 0])]
    attributes: dict[str, NDArray[Any]] = {"intensity": measured[:, 3]}
    if measured.shape[1] == _COLOURED:
        colors = np.append(measured[:, 4:], np.full((len(measured), 1), 255.0), axis=1)
        if not ((colors >= 0) & (colors <= 255) & (colors == np.rint(colors))).all():
            raise ContentsError("the last three numbers of its points are no colours from 0 to 255")
        attributes["colors"] = colors.astype(np.uint8)
    if len(extras) > 1:
        extras = [f"the scanner's places ({len(extras):,})"]
    missing = len(rows) - len(measured)
    doubts = (f"{missing:,} positions of its grids without a measured point are left out",) if missing else ()
    mesh = MeshData(vertices=measured[:, :3], vertex_attributes=attributes, source=Source(path, "ptx", extras=tuple(extras)))
    return Reading(mesh, (*unended(data), *doubts))


def _placed(rows: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rows transformed by the matrix of their head, whose last row is the translation; NaN where nothing was measured."""
    if not np.allclose(matrix[:, 3], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=_ROUNDED):
        raise ContentsError("the last column of a grid's matrix is not 0 0 0 1")
    places = rows[:, :3]
    missing = ~places.any(axis=1)
    if not np.array_equal(matrix, np.eye(4)):
        with np.errstate(over="ignore", invalid="ignore"):
            places = places @ matrix[:3, :3] + matrix[3, :3]
        if not np.isfinite(places[~missing & np.isfinite(rows[:, :3]).all(axis=1)]).all():
            raise ContentsError("a grid's matrix makes points infinite")
    placed = np.concatenate([places, rows[:, 3:]], axis=1)
    placed[missing, :3] = np.nan
    return placed


def _count(tokens: Tokens, line: int) -> int:
    """The number of points of the grid whose head begins at a line."""
    lengths = tokens.lengths[line : line + len(_HEAD)].tolist()
    first = tokens.first[line : line + 2]
    if lengths != list(_HEAD) or (tokens.kinds[first] != INTEGER).any() or (tokens.values[first] < 0).any():
        raise at_line(tokens, line, "begins no grid (columns, rows, four lines of the scanner's pose, four of a matrix)")
    columns, rows = tokens.values[first].tolist()
    return int(min(columns * rows, 1 << 53))


def _width(tokens: Tokens, line: int, points: int) -> int:
    """The number of values of each point of a grid."""
    lengths = tokens.lengths[line : line + points]
    if len(lengths) < points:
        raise ContentsError(f"one of its grids declares {points:,} points, but {len(lengths):,} lines follow")
    wrong = (lengths != lengths[:1]) | ~np.isin(lengths, (_PLAIN, _COLOURED))
    why = "has {} numbers; points have 4 or 7, the same in the whole grid"
    refuse(tokens, np.arange(line, line + points), wrong, why, lengths)
    return int(lengths[0]) if points else _PLAIN
