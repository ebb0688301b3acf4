"""Reads the text of an OFF file strictly, before MeshLab does, which takes words for 0 and crashes on some colours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .as_binary import are_plain_triangles, mesh_as_ply
from .errors import ContentsError
from .references import shown
from .tokens import INDENTED, INTEGER, NOT_FINITE, REAL, Tokens, about_line, joined_pieces, plain, tokenise


class OffError(ContentsError):
    """The text is no OFF file, or lies; the message gives the line."""


@dataclass(frozen=True)
class OffContents:
    """What is in an OFF file.

    Attributes:
        points: (n, 3) the vertices.
        faces: how many polygons it has.
        triangles: how many triangles they make.
        normals: whether its vertices have normals.
        comments: how many bytes of comments it has.
        text: what it says, in a form that MeshLab's reader understands alike.
        altered: whether that is not the file itself.
        binary: the parts of a PLY file that MeshLab reads alike and sooner; None if there is none.
    """

    points: NDArray[np.float64]
    faces: int
    triangles: int
    normals: bool
    comments: bool
    text: bytes
    altered: bool
    binary: list[bytes] | None = None


def read_off(data: bytes) -> OffContents:
    """Read an OFF file.

    Raises:
        OffError: it is none, or says what cannot be.
    """
    if b"\0" in data[:4096]:
        raise OffError("it is no text; MeshLab reads no binary OFF files")
    text = data.removeprefix(b"\xef\xbb\xbf")
    piece = joined_pieces(tokenise(text))
    if piece.oddities & ~INDENTED:
        text = plain(text)
        piece = joined_pieces(tokenise(text))
    if len(piece.lengths) == 0:
        raise OffError("it does not begin with 'OFF'")
    keyword = piece.line(0).split()[0].decode("latin-1")
    prefix = keyword.removesuffix("OFF")
    if prefix == keyword or prefix not in ("", "C", "N", "CN", "NC", "ST", "STC", "STN", "STCN", "STNC"):
        raise OffError(f"it begins with {shown(keyword, 20)}, and not with OFF, COFF, NOFF, STOFF or their like")
    return _body(piece, prefix, text, altered=text is not data, comments=b"#" in data)


def _body(piece: Tokens, prefix: str, text: bytes, *, altered: bool, comments: bool) -> OffContents:
    lengths, first = piece.lengths, piece.first
    start, token = (1, int(first[1])) if lengths[0] == 1 else (0, 1)
    here = int(first[start + 1]) - token if start < len(lengths) else 0
    counts = piece.values[token : token + here]
    if here not in (2, 3) or (piece.kinds[token : token + here] != INTEGER).any() or (counts < 0).any():
        raise OffError("it does not say how many vertices and faces it has")
    n, m = int(min(counts[0], 1 << 53)), int(min(counts[1], 1 << 53))
    line = start + 1
    if len(lengths) - line < n + m:
        raise OffError(f"it declares {n:,} vertices and {m:,} faces, but {len(lengths) - line:,} lines follow")
    if len(lengths) - line > n + m:
        k = line + n + m
        raise _fail(piece, k, f"is one more than the {n:,} vertices and {m:,} faces that it declares")
    if leading := _leading_colours(piece, line, n, prefix):
        text = _normals_first(piece, line, n, leading)
        return _body(joined_pieces(tokenise(text)), prefix, text, altered=True, comments=comments)
    points = _vertices(piece, line, n, prefix)
    faces, triangles, corners = _faces(piece, line + n, m, n)
    if here == 2:  # MeshLab wants the number of edges as well
        raise OffError("it does not say how many edges it has (0 will do)")
    plainly = not prefix and piece.exact and corners is not None and are_plain_triangles(points, corners)
    binary = mesh_as_ply(points, corners) if plainly and corners is not None else None
    return OffContents(points, faces, triangles, "N" in prefix, comments, text, altered, binary)


def _fail(piece: Tokens, k: int, why: str) -> OffError:
    return OffError(about_line(piece, k, why))


def _leading_colours(piece: Tokens, line: int, n: int, prefix: str) -> int:
    """The width of the colours where they stand before the normals, as MeshLab writes and does not read them; 0 elsewhere."""
    if not ("C" in prefix and "N" in prefix) or n == 0:
        return 0
    lengths, first = piece.lengths[line : line + n], piece.first[line : line + n]
    width = int(lengths[0]) - 6 - 2 * ("ST" in prefix)
    if width not in (3, 4) or (lengths != lengths[0]).any():
        return 0
    colours = piece.kinds[first[:, None] + 3 + np.arange(width)]
    normals = piece.kinds[first[:, None] + 3 + width + np.arange(3)]
    return width if (colours == INTEGER).all() and (normals == REAL).any() else 0


def _normals_first(piece: Tokens, line: int, n: int, width: int) -> bytes:
    """The text with the colours of the vertices, of that width, behind the normals."""
    lines = [piece.line(k) for k in range(len(piece.lengths))]
    for k in range(line, line + n):
        words = lines[k].split()
        lines[k] = b" ".join([*words[:3], *words[3 + width : 6 + width], *words[3 : 3 + width], *words[6 + width :]])
    return b"\n".join(lines) + b"\n"


def _vertices(piece: Tokens, line: int, n: int, prefix: str) -> NDArray[np.float64]:
    if n == 0:
        return np.empty((0, 3))
    lengths, first = piece.lengths[line : line + n], piece.first[line : line + n]
    plain_width = 3 + 3 * ("N" in prefix) + 2 * ("ST" in prefix)
    allowed = (plain_width + 3, plain_width + 4) if "C" in prefix else (plain_width,)
    wrong = (lengths != lengths[0]) | ~np.isin(lengths, allowed)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise _fail(piece, line + k, f"has {lengths[k]} values and not {lengths[0] if lengths[0] in allowed else allowed[0]}")
    rows = first[:, None] + np.arange(lengths[0])
    strange = ~np.isin(piece.kinds[rows], (INTEGER, REAL, NOT_FINITE)).all(axis=1)
    if strange.any():
        raise _fail(piece, line + int(np.argmax(strange)), "has something else than numbers; decimals are written with a point")
    if "C" in prefix:
        at = 3 + 3 * ("N" in prefix)
        _check_colours(piece, np.arange(line, line + n), rows[:, at : int(lengths[0]) - 2 * ("ST" in prefix)])
    return piece.values[rows[:, :3]]


def _check_colours(piece: Tokens, lines: NDArray[np.int64], rows: NDArray[np.int64]) -> None:
    """Refuse colours that are not all whole or all with a point: MeshLab reads the kind of all from the first."""
    kinds, values = piece.kinds[rows], piece.values[rows]
    for wrong, why in (
        (~np.isin(kinds, (INTEGER, REAL)), "has a colour that is no number"),
        (kinds != kinds[:, :1], "has a colour of whole numbers and others; write all with a point"),
        ((values < 0) | (values > np.where(kinds == INTEGER, 255, 1)), "has a colour beyond 0 to 255, or 0.0 to 1.0"),
    ):
        if wrong.any():
            raise _fail(piece, int(lines[np.argmax(wrong.any(axis=1))]), why)


def _faces(piece: Tokens, line: int, m: int, n: int) -> tuple[int, int, NDArray[np.int64] | None]:
    """How many polygons there are, how many triangles they make, and the (m, 3) corners if all are triangles without a colour."""
    if m == 0:
        return 0, 0, None
    lengths, first = piece.lengths[line : line + m], piece.first[line : line + m]
    said = piece.values[first]
    whole = (piece.kinds[first] == INTEGER) & (said >= 2) & (said <= lengths - 1)
    if not whole.all():
        k = int(np.argmax(~whole))
        raise _fail(piece, line + k, "is no face: the number of its vertices and as many indices")
    counts: NDArray[np.int64] = said.astype(np.int64)
    extra = lengths - 1 - counts
    wrong = ~np.isin(extra, (0, 3, 4))
    if wrong.any():
        k = int(np.argmax(wrong))
        what = "a colour by its number in a list, which the file does not have" if extra[k] == 1 else "more than a colour"
        raise _fail(piece, line + k, f"has {what}")
    line_of = np.repeat(np.arange(m), counts)
    tokens = np.arange(len(line_of)) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(first + 1, counts)
    values = piece.values[tokens]
    wrong = (piece.kinds[tokens] != INTEGER) | (values < 0) | (values >= n)
    if wrong.any():
        raise _fail(piece, line + int(line_of[np.argmax(wrong)]), f"names a vertex that is none of its {n:,}")
    coloured = np.flatnonzero(extra)
    for width in (3, 4):
        chosen = coloured[extra[coloured] == width]
        _check_colours(piece, line + chosen, (first[chosen] + 1 + counts[chosen])[:, None] + np.arange(width))
    triangles = values.astype(np.int64).reshape(-1, 3) if (counts == 3).all() and not len(coloured) else None
    return int((counts >= 3).sum()), int((counts - 2).sum()), triangles
