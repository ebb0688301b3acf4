"""Reads STL files strictly, before MeshLab does, which takes what there is of a text that was cut off for the whole of it."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .references import shown
from .tokens import INTEGER, REAL, WORD, Tokens, joined_pieces, plain, tokenise, word

#: the first word of each line of a facet
_FACET = (b"facet", b"outer", b"vertex", b"vertex", b"vertex", b"endloop", b"endfacet")
_LENGTHS = {b"facet": 5, b"outer": 2, b"vertex": 4, b"endloop": 1, b"endfacet": 1}
#: what makes a letter small, in every byte of a word
_SMALL = np.uint64(0x2020202020202020)


class StlError(ValueError):
    """The file is no STL file, or lies; the message says where."""


@dataclass(frozen=True)
class StlContents:
    """What is in an STL file.

    Attributes:
        faces: how many triangles.
        note: what its head says, or nothing.
        text: what a text says, in a form that MeshLab's reader understands; None if that is the file itself.
    """

    faces: int
    note: str
    text: bytes | None = None


def read_stl(data: bytes) -> StlContents:
    """Read an STL file, text or binary.

    Raises:
        StlError: it is none, or declares what it does not hold.
    """
    if len(data) >= 84:
        declared = int(struct.unpack_from("<I", data, 80)[0])
        if len(data) == 84 + 50 * declared:
            return StlContents(declared, data[:80].decode("latin-1").strip("\0 "))
        if data.lstrip()[:5].lower() != b"solid":
            raise StlError(
                f"it declares {declared:,} triangles, which take {84 + 50 * declared:,} bytes, but it has {len(data):,}"
            )
    if data.lstrip()[:5].lower() != b"solid":
        raise StlError("it is neither a text that begins with 'solid' nor long enough for a binary file")
    if b"\0" in data:
        raise StlError("it begins like a text, but is none")
    text = data
    piece = joined_pieces(tokenise(text))
    if piece.oddities:
        text = plain(text)
        piece = joined_pieces(tokenise(text))
    solids, lines = _parted(piece)
    strange_normals = _check_facets(piece, lines)
    if len(solids) > 2 or strange_normals:
        text = re.sub(rb"(?mi)^[ \t]*(end)?solid\b.*$", b"", text)
        text = re.sub(rb"(?mi)^[ \t]*facet[ \t].*$", b"facet normal 0 0 0", text)
        text = b"solid\n" + text + b"\nendsolid\n"
    note = " ".join(piece.line(0).decode("latin-1").split()[1:])
    return StlContents(len(lines) // len(_FACET), note, None if text is data else text)


def _fail(piece: Tokens, k: int, why: str) -> StlError:
    return StlError(f"its line {piece.numbers[k]:,}, {shown(piece.line(k).decode('utf-8', 'replace'), 60)}, {why}")


def _keyed(text: bytes) -> np.uint64:
    return word(text) | _SMALL


def _parted(piece: Tokens) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The lines that begin and end solids, and those of their facets."""
    words = piece.keywords | _SMALL
    begins, ends = words == _keyed(b"solid"), words == _keyed(b"endsolid")
    solids = np.flatnonzero(begins | ends)
    if len(solids) % 2 or not begins[solids[0::2]].all() or not ends[solids[1::2]].all():
        raise StlError("it is cut short: 'solid' and 'endsolid' do not come in pairs")
    if solids[0] != 0 or solids[-1] != len(words) - 1:
        raise StlError("it has something before 'solid' or behind 'endsolid'")
    return solids, np.flatnonzero(~(begins | ends))


def _check_facets(piece: Tokens, lines: NDArray[np.int64]) -> bool:
    """Refuse lines that are not those of facets in their order; whether a normal is no number, which nobody needs."""
    expected = np.resize(np.array([_keyed(w) for w in _FACET], dtype=np.uint64), len(lines))
    lengths = np.resize(np.array([_LENGTHS[w] for w in _FACET]), len(lines))
    wrong = (piece.keywords[lines] | _SMALL != expected) | (piece.lengths[lines] != lengths)
    if len(lines) % len(_FACET) or wrong.any():
        k = int(lines[np.argmax(wrong)]) if wrong.any() else int(lines[-1])
        raise _fail(piece, k, "is not what comes next in a facet")
    first = piece.first[lines]
    corners = first[expected == _keyed(b"vertex")][:, None] + np.arange(1, 4)
    strange = ~np.isin(piece.kinds[corners], (INTEGER, REAL)).all(axis=1)
    if strange.any():
        k = int(lines[expected == _keyed(b"vertex")][np.argmax(strange)])
        raise _fail(piece, k, "has something else than finite numbers; decimals are written with a point")
    normals = first[expected == _keyed(b"facet")][:, None] + np.arange(2, 5)
    return bool((piece.kinds[normals] == WORD).any())
