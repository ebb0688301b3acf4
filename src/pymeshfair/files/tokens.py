"""Takes the text of a mesh file apart into lines of words and numbers, once and without believing any of it.

MeshLab's readers take text for numbers as C does: ``1,5`` is 1, ``abc`` is 0, and what else stands on a line is skipped. Here a
number is a number to its last character, and whatever a line holds is seen by the check of its format.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lexer import UNSURE, Bytes, count, lex, powers_of_ten, spans
from .references import shown

#: what a token is: a word, a whole number, a number, or one that is not finite; nothing between two slashes or at a slash's end
WORD, INTEGER, REAL, NOT_FINITE, EMPTY = 0, 1, 2, 3, 4
#: added to the kind of a token that follows a slash instead of a blank
AFTER_SLASH = 8
#: what a text has that MeshLab's readers do not all understand alike: lines that begin with blanks, comments behind other words,
#: and carriage returns that are no part of a line's end
INDENTED, REMARKED, LONE_RETURN = 1, 2, 4
_CHUNK = 64 << 20
_TOKEN_END = re.compile(rb"[ \t\r\n/]")


@dataclass(frozen=True)
class Tokens:
    """Some whole lines of a text, without empty lines and comments.

    Attributes:
        text: the bytes.
        kinds: (t,) what each token is.
        values: (t,) the numbers, to the nearest double, 0 for words.
        first: (l + 1,) the first token of each line, and t.
        keywords: (l,) the first word of each line, see `word`; 0 if the line begins with a number or a longer word.
        seconds: (l,) the same of the second word.
        starts: (l,) where each line begins in the text.
        numbers: (l,) the number of each line in the file, from 1.
        oddities: the sum of what makes the text ambiguous.
    """

    text: Bytes
    kinds: NDArray[np.uint8]
    values: NDArray[np.float64]
    first: NDArray[np.int64]
    keywords: NDArray[np.uint64]
    seconds: NDArray[np.uint64]
    starts: NDArray[np.int64]
    numbers: NDArray[np.int64]
    oddities: int

    @property
    def lengths(self) -> NDArray[np.int64]:
        """(l,) how many tokens each line has."""
        return np.diff(self.first)

    def spans(self, lines: NDArray[np.int64], columns: list[int]) -> NDArray[np.int64]:
        """(l, c, 2) where tokens of lines, counted from 0 and ascending, begin and end in the text."""
        found = np.empty((len(lines), len(columns), 2), np.int64)
        spans(self.text, self.starts[lines], np.array(columns, np.int64), found)
        return found

    def line(self, k: int) -> bytes:
        """The bytes of a line, without its end."""
        start = int(self.starts[k])
        return self.text[start : start + 4096].tobytes().replace(b"\r", b"\n").partition(b"\n")[0]


def word(text: bytes) -> np.uint64:
    """The number that stands for a word of at most eight bytes."""
    assert 0 < len(text) <= 8
    return np.uint64(int.from_bytes(text, "little"))


def tokenise(data: bytes, *, slashes: bool = False) -> Iterator[Tokens]:
    """The text in pieces of whole lines.

    Args:
        data: the text.
        slashes: whether a slash parts two tokens, as in the faces of OBJ files.
    """
    text = np.frombuffer(data, dtype=np.uint8)
    start, line = 0, 1
    while start < len(text):
        end = _line_end(data, min(start + _CHUNK, len(text)))
        piece = text[start:end]
        n_tokens, n_lines = count(piece, slashes)
        kinds, values = np.empty(n_tokens, np.uint8), np.empty(n_tokens)
        first, starts, numbers = (np.empty(n_lines + 1, np.int64) for _ in range(3))
        keywords, seconds = np.zeros(n_lines, np.uint64), np.zeros(n_lines, np.uint64)
        places = np.empty(n_tokens, np.int64)
        arrays = (kinds, values, first, starts, numbers, keywords, seconds, places)
        t, k, line, oddities = lex(piece, slashes, *arrays, line, *powers_of_ten())
        kinds, values = kinds[:t], values[:t]
        _complete(piece, kinds, values, places)
        yield Tokens(piece, kinds, values, first[: k + 1], keywords[:k], seconds[:k], starts[:k], numbers[:k], oddities)
        start = end


def _complete(text: Bytes, kinds: NDArray[np.uint8], values: NDArray[np.float64], places: NDArray[np.int64]) -> None:
    """Read the numbers again that were not sure to be the nearest double: with more digits than a double has, or very large."""
    for t in np.flatnonzero(kinds & UNSURE).tolist():
        place, length = int(places[t]), 64
        while not (end := _TOKEN_END.search(text[place : place + length].tobytes())) and place + length < len(text):
            length *= 16
        token = text[place : place + (end.start() if end else length)].tobytes()
        values[t] = float(token)
        kinds[t] -= UNSURE
        if not np.isfinite(values[t]):
            kinds[t] += NOT_FINITE - (kinds[t] & (AFTER_SLASH - 1))


def joined_pieces(pieces: Iterable[Tokens]) -> Tokens:
    """All pieces of a text as one; nothing of no text."""
    parts = list(pieces)
    if len(parts) == 1:
        return parts[0]
    tokens = np.cumsum([0, *(len(p.kinds) for p in parts)])
    sizes = np.cumsum([0, *(len(p.text) for p in parts)])

    def joined(name: str, shifts: NDArray[np.int64] | None = None) -> NDArray[Any]:
        arrays = [getattr(p, name) if shifts is None else getattr(p, name) + shifts[k] for k, p in enumerate(parts)]
        return np.concatenate(arrays) if arrays else np.empty(0, np.int64)

    first = np.concatenate([*(p.first[:-1] + tokens[k] for k, p in enumerate(parts)), tokens[-1:]])
    oddities = 0
    for p in parts:
        oddities |= p.oddities
    return Tokens(
        text=joined("text"),
        kinds=joined("kinds"),
        values=joined("values"),
        first=first,
        keywords=joined("keywords"),
        seconds=joined("seconds"),
        starts=joined("starts", sizes),
        numbers=joined("numbers"),
        oddities=oddities,
    )


def _line_end(data: bytes, position: int) -> int:
    """Where the line that goes over a position ends."""
    return data.find(b"\n", position) + 1 or len(data)


def joined(data: bytes) -> bytes:
    """The text without a byte order mark, each line that a backslash continues made one with the next."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\\" in data and re.search(rb"#[^\r\n]*\\\r?\n", data):
        data = re.sub(rb"(?<![^ \t\r\n])#[^\r\n]*", b"", data)  # a comment ends with its line: `# from C:\scans\`
    return re.sub(rb"\\\r?\n", b" ", data) if b"\\" in data else data


def plain(data: bytes) -> bytes:
    """The text with one blank between words, without comments, and with line feeds for all ends of lines."""
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    data = re.sub(rb"[ \t]+", b" ", data)
    return re.sub(rb"(?m)(^ | $|(^|[ ])#.*)", b"", data)


def about_line(piece: Tokens, k: int, why: str) -> str:
    """The sentence of an error about line k of a piece: its number, the beginning of what it says, and what is wrong with it."""
    return f"its line {piece.numbers[k]:,}, {shown(piece.line(k).decode('utf-8', 'replace'), 60)}, {why}"
