"""Takes the text of a mesh file apart into lines of words and numbers: a number is one to its last character, or a word."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .errors import ContentsError
from .lexer import UNSURE, Bytes, count, lex, powers_of_ten, spans
from .references import shown

#: what a token is: a word, a whole number, a number, or one that is not finite; nothing between two slashes or at a slash's end
WORD, INTEGER, REAL, NOT_FINITE, EMPTY = 0, 1, 2, 3, 4
#: added to the kind of a token that follows a slash instead of a blank
AFTER_SLASH = 8
_TOKEN_END = re.compile(rb"[ \t\r\n/]")


@dataclass(frozen=True)
class Tokens:
    """The lines of a text, without empty ones and comments.

    Attributes:
        text: the bytes.
        kinds: (t,) what each token is.
        values: (t,) the numbers, to the nearest double, 0 for words.
        first: (l + 1,) the first token of each line, and t.
        keywords: (l,) the first word of each line, see `word`; 0 if the line begins with a number or a longer word.
        starts: (l,) where each line begins in the text.
        numbers: (l,) the number of each line in the file, from 1.
    """

    text: Bytes
    kinds: NDArray[np.uint8]
    values: NDArray[np.float64]
    first: NDArray[np.int64]
    keywords: NDArray[np.uint64]
    starts: NDArray[np.int64]
    numbers: NDArray[np.int64]

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


def tokenise(data: bytes, *, slashes: bool = False) -> Tokens:
    """The tokens of a text.

    Args:
        data: the text.
        slashes: whether a slash parts two tokens, as in the faces of OBJ files.
    """
    text = np.frombuffer(data, dtype=np.uint8)
    n_tokens, n_lines = count(text, slashes)
    kinds, values, places = np.empty(n_tokens, np.uint8), np.empty(n_tokens), np.empty(n_tokens, np.int64)
    first, starts, numbers = (np.empty(n_lines + 1, np.int64) for _ in range(3))
    keywords = np.zeros(n_lines, np.uint64)
    t, k = lex(text, slashes, kinds, values, first, starts, numbers, keywords, places, *powers_of_ten())
    kinds, values = kinds[:t], values[:t]
    _complete(text, kinds, values, places)
    return Tokens(text, kinds, values, first[: k + 1], keywords[:k], starts[:k], numbers[:k])


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


def joined(data: bytes) -> bytes:
    """The text of as many bytes with blanks for a byte order mark, and for the ends of lines that a backslash continues."""
    if data.startswith(b"\xef\xbb\xbf"):
        data = b"   " + data[3:]
    if b"\\" in data and re.search(rb"#[^\r\n]*\\\r?\n", data):  # a comment ends with its line: `# from C:\scans\`
        data = re.sub(rb"(?<![^ \t\r\n])#[^\r\n]*", _blank, data)
    return re.sub(rb"\\\r?\n", _blank, data) if b"\\" in data else data


def _blank(match: re.Match[bytes]) -> bytes:
    return b" " * len(match[0])


def numbers_of(tokens: Tokens, lines: NDArray[np.int64], skipped: int, width: int) -> NDArray[np.float64]:
    """(l, width) the numbers on lines, behind some words.

    Raises:
        ContentsError: something else is among them.
    """
    chosen = tokens.first[lines][:, None] + np.arange(skipped, skipped + width)
    strange = ~np.isin(tokens.kinds[chosen], (INTEGER, REAL, NOT_FINITE)).all(axis=1)
    if strange.any():
        k = int(lines[np.argmax(strange)])
        raise at_line(tokens, k, "has something else than numbers; decimals are written with a point")
    return np.asarray(tokens.values[chosen])


def at_line(tokens: Tokens, k: int, why: str) -> ContentsError:
    """The error about a line, counted from 0: its number, the beginning of what it says, and what is wrong with it."""
    return ContentsError(f"its line {tokens.numbers[k]:,}, {shown(tokens.line(k).decode('utf-8', 'replace'), 60)}, {why}")
