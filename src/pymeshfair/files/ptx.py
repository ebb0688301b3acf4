"""Reads PTX files: grids of points as scanners write them, each behind a head that says how many and where the scanner stood.

MeshLab's reader leaves measured points out at the end of a grid, and allocates whatever a head declares.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .errors import ContentsError
from .points import PointsContents
from .tokens import INTEGER, NOT_FINITE, REAL, Tokens, about_line, joined_pieces, tokenise

#: the lines of a head: columns, rows, four of the scanner's place, four of a matrix
_HEAD = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
#: of how many numbers a point is made: its place and intensity, with a colour
_PLAIN, _COLOURED = 4, 7
#: by how much what programs write of an exact matrix may be off
_ROUNDED = 1e-6


def read_ptx(data: bytes) -> tuple[PointsContents, int]:
    """The points of all grids, where the matrices of their heads put them, and how many more were not measured.

    Raises:
        ContentsError: it is none, or declares what it does not hold.
    """
    if b"\0" in data[:4096]:
        raise ContentsError("it is no text")
    piece = joined_pieces(tokenise(data))
    strange = ~np.isin(piece.kinds, (INTEGER, REAL, NOT_FINITE))
    if strange.any():
        k = int(np.searchsorted(piece.first, int(np.argmax(strange)), side="right")) - 1
        raise _fail(piece, k, "has something else than numbers; decimals are written with a point")
    if piece.oddities & 2 or b"#" in data:
        raise ContentsError("it has comments, which the format does not know")
    values = np.array(data.split(), dtype="S").astype(np.float64)  # to the last bit, which those of the tokens are not
    grids = []
    line = 0
    while line < len(piece.lengths):
        points = _head(piece, line)
        first = line + len(_HEAD)
        line = first + points
        width = _width(piece, first, points)
        head = values[piece.first[first - len(_HEAD)] : piece.first[first]]
        grids.append(_placed(values[piece.first[first] : piece.first[line]].reshape(points, width), head[14:].reshape(4, 4)))
    rows = np.concatenate([_coloured(grid, any(g.shape[1] == _COLOURED for g in grids)) for grid in grids]) if grids else None
    if rows is None or not len(rows):
        raise ContentsError("it holds no points")
    measured = rows[~np.isnan(rows[:, 0])]
    return _contents(measured), len(rows) - len(measured)


def _contents(rows: NDArray[np.float64]) -> PointsContents:
    colours = rows[:, 4:]
    if not ((colours >= 0) & (colours <= 255) & (colours == np.rint(colours))).all():
        raise ContentsError("the last three numbers of its points are no colours from 0 to 255")
    return PointsContents(
        points=rows[:, :3],
        count=len(rows),
        intensity=rows[:, 3],
        colours=colours.astype(np.uint8) if colours.shape[1] else None,
        normals=None,
        note="",
        plain=False,
    )


def _placed(rows: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rows where the matrix of a head puts them, whose last line is the translation; at NaN what was not measured."""
    if not np.allclose(matrix[:, 3], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=_ROUNDED):
        raise ContentsError("the last column of the matrix of a grid of it is not 0 0 0 1")
    places = rows[:, :3]
    missing = ~places.any(axis=1)
    if not np.array_equal(matrix, np.eye(4)):
        with np.errstate(over="ignore", invalid="ignore"):
            places = places @ matrix[:3, :3] + matrix[3, :3]
        if not np.isfinite(places[~missing & np.isfinite(rows[:, :3]).all(axis=1)]).all():
            raise ContentsError("the matrix of a grid of it puts points beyond all numbers")
    placed = np.concatenate([places, rows[:, 3:]], axis=1)
    placed[missing, :3] = np.nan
    return placed


def _coloured(rows: NDArray[np.float64], coloured: bool) -> NDArray[np.float64]:
    """The rows with a colour, white if they have none, where other grids have one."""
    if not coloured or rows.shape[1] == _COLOURED:
        return rows
    return np.concatenate([rows, np.full((len(rows), 3), 255.0)], axis=1)


def _head(piece: Tokens, line: int) -> int:
    """The number of points of the grid whose head begins at a line."""
    lengths = piece.lengths[line : line + len(_HEAD)].tolist()
    first = piece.first[line : line + 2]
    if lengths != list(_HEAD) or (piece.kinds[first] != INTEGER).any() or (piece.values[first] < 0).any():
        raise _fail(piece, line, "begins no grid: columns, rows, four lines of the scanner's place and four of a matrix")
    columns, rows = piece.values[first].tolist()
    return int(min(columns * rows, 1 << 53))


def _width(piece: Tokens, line: int, points: int) -> int:
    """Of how many numbers the points of a grid are made."""
    lengths = piece.lengths[line : line + points]
    if len(lengths) < points:
        raise ContentsError(f"a grid of it declares {points:,} points, but {len(lengths):,} lines follow")
    wrong = (lengths != lengths[:1]) | ~np.isin(lengths, (_PLAIN, _COLOURED))
    if wrong.any():
        k = int(np.argmax(wrong))
        raise _fail(piece, line + k, f"has {lengths[k]} numbers; a point has 4 or 7, and all of a grid the same")
    return int(lengths[0]) if points else _PLAIN


def _fail(piece: Tokens, k: int, why: str) -> ContentsError:
    return ContentsError(about_line(piece, k, why))
