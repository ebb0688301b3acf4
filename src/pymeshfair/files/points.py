"""Reads files of points strictly: a row of numbers a point, after a count or a line of titles if there is one.

MeshLab takes such a line for a point, a comma in a number for its end, and colours for normals; it reads no rows of four or seven
numbers, which scanners write (x y z, intensity, red green blue).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .errors import ContentsError
from .tokens import INTEGER, NOT_FINITE, REAL, WORD, Tokens, about_line, joined_pieces, plain, tokenise

#: what rows of so many numbers are, besides a place
_EXPE = b"[Expe/PointSet/"
_COLUMNS = {3: "", 4: "i", 6: "?", 7: "ic"}


class PointsError(ContentsError):
    """The file is none of points, or lies; the message says where."""


@dataclass(frozen=True)
class PointsContents:
    """What is in a file of points.

    Attributes:
        points: (n, 3) their places, or None if they were not read.
        count: how many.
        intensity: (n,) or None.
        colours: (n, 3) in 0 to 255, or None.
        normals: (n, 3) or None.
        note: its line of titles, or nothing.
        plain: whether MeshLab's readers of .xyz files understand it alike.
    """

    points: NDArray[np.float64] | None
    count: int
    intensity: NDArray[np.float64] | None
    colours: NDArray[np.uint8] | None
    normals: NDArray[np.float64] | None
    note: str
    plain: bool


def read_points(data: bytes) -> PointsContents:
    """Read a file of points.

    Raises:
        PointsError: it is none, or says what cannot be.
    """
    if data.startswith(_EXPE):
        return _expe(data)
    if b"\0" in data[:4096]:
        raise PointsError("it is no text")
    text = _separated(data.removeprefix(b"\xef\xbb\xbf"))
    piece = joined_pieces(tokenise(text))
    if piece.oddities:
        text = plain(text)
        piece = joined_pieces(tokenise(text))
    note, start = _titles(piece)
    rows = np.arange(start, len(piece.lengths))
    if len(rows) == 0:
        raise PointsError("it holds no points")
    lengths = piece.lengths[rows]
    declared = None
    if lengths[0] == 1 and piece.kinds[piece.first[start]] == INTEGER:
        declared, rows, lengths = int(piece.values[piece.first[start]]), rows[1:], lengths[1:]
        if declared != len(rows):
            raise PointsError(f"it declares {declared:,} points, but has {len(rows):,}")
    width = int(lengths[0]) if len(rows) else 0
    if width not in _COLUMNS:
        raise PointsError(f"its rows have {width} numbers; those of 3, 4, 6 or 7 are known (x y z, intensity, red green blue)")
    wrong = lengths != width
    if wrong.any():
        k = int(np.argmax(wrong))
        raise _fail(piece, int(rows[k]), f"has {lengths[k]} numbers, while those before it have {width}")
    tokens = piece.first[rows][:, None] + np.arange(width)
    strange = ~np.isin(piece.kinds[tokens], (INTEGER, REAL, NOT_FINITE)).all(axis=1)
    if strange.any():
        raise _fail(piece, int(rows[np.argmax(strange)]), "has something else than numbers; decimals are written with a point")
    return _contents(text, piece, tokens, note, declared is not None or text is not data)


def _expe(data: bytes) -> PointsContents:
    """A binary point set of Expe, which MeshLab reads: a header with the bytes of each property, then the points."""
    head, mark, _body = data[:4096].partition(b"\ndata\n")
    words = [line.split() for line in head.decode("latin-1").splitlines()[1:]]
    sizes = [w[2] for w in words if len(w) == 3 and w[0] == "property" and w[2].isdigit()]
    counts = [w[1] for w in words if len(w) == 2 and w[0] == "nofpoints" and w[1].isdigit()]
    if not mark or not data.startswith(_EXPE + b"Binary/0.1]\n") or len(sizes) + len(counts) != len(words) or len(counts) != 1:
        raise PointsError("it is a point set of Expe of a kind that is not known")
    n, row = int(counts[0]), sum(map(int, sizes))
    if n * row != len(data) - len(head) - len(mark) or not n:
        raise PointsError(f"it declares {n:,} points of {row} bytes, but {len(data) - len(head) - len(mark):,} bytes follow")
    return PointsContents(None, n, None, None, None, "", plain=True)


def _fail(piece: Tokens, k: int, why: str) -> PointsError:
    return PointsError(about_line(piece, k, why))


def _separated(text: bytes) -> bytes:
    """The text with blanks between numbers, where it has semicolons or commas there."""
    head = text[:65536]
    if b";" in head:
        if b"," in text:
            raise PointsError("it has commas and semicolons; decimals are written with a point")
        return text.replace(b";", b" ")
    if b"," not in text:
        return text
    lines = [line for line in head.splitlines() if b"," in line]
    if any(len(line.replace(b", ", b",").split()) > 1 for line in lines if not line.lstrip().startswith(b"#")):
        raise PointsError("it has commas and blanks between numbers; decimals are written with a point")
    return text.replace(b",", b" ")


def _titles(piece: Tokens) -> tuple[str, int]:
    """The first line, if it has nothing but words, and where the rest begins."""
    if len(piece.lengths) and (piece.kinds[: piece.first[1]] == WORD).all():
        words = piece.line(0).decode("utf-8", "replace")
        if not any(c.isdigit() for c in words):
            return " ".join(words.split()), 1
    return "", 0


def _contents(text: bytes, piece: Tokens, tokens: NDArray[np.int64], note: str, altered: bool) -> PointsContents:
    values = piece.values[tokens]
    width = values.shape[1]
    kind = _COLUMNS[width]
    whole = (piece.kinds[tokens[:, -3:]] == INTEGER).all() and ((values[:, -3:] >= 0) & (values[:, -3:] <= 255)).all()
    if kind == "?":
        kind = "c" if whole and values[:, 3:].max() > 1 else "n"
    if "c" in kind and not whole:
        raise PointsError("the last three numbers of its rows are no colours from 0 to 255")
    if kind not in ("", "n") or altered or note:
        values = _exact(text, piece, tokens)
        return PointsContents(
            values[:, :3],
            len(values),
            values[:, 3] if "i" in kind else None,
            values[:, -3:].astype(np.uint8) if "c" in kind else None,
            values[:, 3:] if kind == "n" else None,
            note,
            plain=False,
        )
    return PointsContents(values[:, :3], len(values), None, None, values[:, 3:] if kind == "n" else None, note, plain=True)


def _exact(text: bytes, piece: Tokens, tokens: NDArray[np.int64]) -> NDArray[np.float64]:
    """The numbers to the last bit; those of the tokens are a few units off."""
    skipped = int(tokens[0, 0])
    lines = plain(text).split(b"\n")
    words = b" ".join(lines[int(piece.numbers[0]) - 1 :]).split()
    return np.array(words[skipped:], dtype="S").astype(np.float64).reshape(tokens.shape)


def as_ply(contents: PointsContents) -> list[bytes]:
    """The points as a binary PLY file, which MeshLab reads to the last bit."""
    fields = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")]
    assert contents.points is not None
    columns: list[NDArray[np.float64] | NDArray[np.uint8]] = list(contents.points.T)
    if contents.normals is not None:
        fields += [("nx", "<f8"), ("ny", "<f8"), ("nz", "<f8")]
        columns += list(contents.normals.T)
    if contents.intensity is not None:
        fields.append(("quality", "<f8"))
        columns.append(contents.intensity)
    if contents.colours is not None:
        fields += [("red", "u1"), ("green", "u1"), ("blue", "u1")]
        columns += list(contents.colours.T)
    rows = np.empty(len(contents.points), dtype=fields)
    for (name, _), column in zip(fields, columns, strict=True):
        rows[name] = column
    declared = "".join(f"property {'double' if kind == '<f8' else 'uchar'} {name}\n" for name, kind in fields)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{declared}end_header\n"
    return [head.encode("ascii"), rows.tobytes()]
