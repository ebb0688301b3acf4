"""Takes the text of a mesh file apart into lines of words and numbers, once and without believing any of it.

MeshLab's readers take text for numbers as C does: ``1,5`` is 1, ``abc`` is 0, and what else stands on a line is skipped. Here a
number is a number to its last character, and whatever a line holds is seen by the check of its format.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

Bytes: TypeAlias = NDArray[np.uint8]

#: what a token is: a word, a whole number, a number, or one that is not finite; nothing between two slashes or at a slash's end
WORD, INTEGER, REAL, NOT_FINITE, EMPTY = 0, 1, 2, 3, 4
#: added to the kind of a token that follows a slash instead of a blank
AFTER_SLASH = 8
#: what a text has that MeshLab's readers do not all understand alike: lines that begin with blanks, comments behind other words,
#: and carriage returns that are no part of a line's end
INDENTED, REMARKED, LONE_RETURN = 1, 2, 4
_CHUNK = 16 << 20
_POWERS = 10.0 ** np.arange(301)


@dataclass(frozen=True)
class Tokens:
    """Some whole lines of a text, without empty lines and comments.

    Attributes:
        text: the bytes.
        kinds: (t,) what each token is.
        values: (t,) the numbers, within a few units in the last place, 0 for words.
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
        n_tokens, n_lines = _count(piece, slashes)
        kinds, values = np.empty(n_tokens, np.uint8), np.empty(n_tokens)
        first, starts, numbers = (np.empty(n_lines + 1, np.int64) for _ in range(3))
        keywords, seconds = np.zeros(n_lines, np.uint64), np.zeros(n_lines, np.uint64)
        t, k, line, oddities = _lex(piece, slashes, kinds, values, first, starts, numbers, keywords, seconds, line)
        yield Tokens(piece, kinds[:t], values[:t], first[: k + 1], keywords[:k], seconds[:k], starts[:k], numbers[:k], oddities)
        start = end


def joined_pieces(pieces: Iterable[Tokens]) -> Tokens:
    """All pieces of a text as one; nothing of no text."""
    parts = list(pieces)
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
    return re.sub(rb"\\\r?\n", b" ", data) if b"\\" in data else data


def plain(data: bytes) -> bytes:
    """The text with one blank between words, without comments, and with line feeds for all ends of lines."""
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    data = re.sub(rb"[ \t]+", b" ", data)
    return re.sub(rb"(?m)(^ | $|(^|[ ])#.*)", b"", data)


@njit(cache=True)
def _ends_line(text: Bytes, i: int) -> bool:
    return bool(text[i] == 10 or text[i] == 13)


@njit(cache=True)
def _count(text: Bytes, slashes: bool) -> tuple[int, int]:
    """Upper bounds of the number of tokens and of lines."""
    tokens, lines, blank = 0, 1, True
    for c in text:
        if c == 10 or c == 13:
            lines += 1
            blank = True
        elif c == 32 or c == 9:
            blank = True
        elif c == 47 and slashes:
            tokens += 1 + blank  # nothing before it is a token as well
            blank = False
        else:
            tokens += blank
            blank = False
    return tokens, lines


@njit(cache=True)
def _not_finite(text: Bytes, i: int, end: int) -> tuple[int, float]:
    """NOT_FINITE and its value for nan, inf and infinity, WORD for everything else."""
    negative = text[i] == 45
    if text[i] == 45 or text[i] == 43:
        i += 1
    if end - i == 3 or end - i == 8:
        a, b, c = text[i] | 32, text[i + 1] | 32, text[i + 2] | 32
        if end - i == 3 and a == 110 and b == 97 and c == 110:
            return 3, np.nan
        if a == 105 and b == 110 and c == 102 and (end - i == 3 or (text[i + 3] | 32 == 105 and text[i + 7] | 32 == 121)):
            return 3, -np.inf if negative else np.inf
    return 0, 0.0


@njit(cache=True)
def _scaled(mantissa: int, power: int) -> float:
    """Mantissa * 10 ** power, in two steps so that neither leaves the range of a double before the result does."""
    value = float(mantissa)
    if power < 0:
        value /= _POWERS[min(-power, 300)]
        if power < -300:
            value /= _POWERS[min(-power - 300, 300)]
    elif power > 0:
        value *= _POWERS[min(power, 300)]
        if power > 300:
            value *= _POWERS[min(power - 300, 300)]
    return value


@njit(cache=True)
def _lex(
    text: Bytes,
    slashes: bool,
    kinds: Any,
    values: Any,
    first: Any,
    starts: Any,
    numbers: Any,
    keywords: Any,
    seconds: Any,
    line: int,
) -> tuple[int, int, int, int]:
    """Fill the arrays; how many tokens and lines there are, the number of the next line, and the oddities."""
    i, n, t, length, oddities = 0, len(text), 0, 0, 0
    end_of_token = np.zeros(256, np.bool_)
    for c in (9, 10, 13, 32):
        end_of_token[c] = True
    end_of_token[47] = slashes
    while i < n:
        # one line: its number, where it begins, its tokens
        begin, number, token0 = i, line, t
        after_slash = False
        while i < n and not _ends_line(text, i):
            c = text[i]
            if c == 32 or c == 9:
                i += 1
                continue
            if c == 35:  # a comment
                if t > token0:
                    oddities |= 2
                elif i > begin:
                    oddities |= 1
                while i < n and not _ends_line(text, i):
                    i += 1
                break
            if t == token0 and i > begin:
                oddities |= 1
            # a number: its sign, its digits, its exponent
            j, kind, mantissa, digits, power = i, 1, 0, 0, 0
            negative = c == 45
            if negative or c == 43:
                j += 1
            while j < n and 48 <= text[j] <= 57:
                if mantissa < 100000000000000000:
                    mantissa = mantissa * 10 + (text[j] - 48)
                else:
                    power += 1
                digits += 1
                j += 1
            if j < n and text[j] == 46:
                kind = 2
                j += 1
                while j < n and 48 <= text[j] <= 57:
                    if mantissa < 100000000000000000:
                        mantissa = mantissa * 10 + (text[j] - 48)
                        power -= 1
                    digits += 1
                    j += 1
            if digits > 0 and j + 1 < n and text[j] | 32 == 101:
                kind = 2
                j += 1
                below = text[j] == 45
                if below or text[j] == 43:
                    j += 1
                exponent, digits = 0, 0
                while j < n and 48 <= text[j] <= 57:
                    exponent = min(exponent * 10 + (text[j] - 48), 100000)
                    digits += 1
                    j += 1
                power += -exponent if below else exponent
            value = 0.0
            if j == n or end_of_token[text[j]]:
                if j == i:
                    kind = 4
                elif digits == 0:
                    kind = 0
                else:
                    value = float(mantissa) if power == 0 else _scaled(mantissa, power)
                    if negative:
                        value = -value
                    if not np.isfinite(value):
                        kind = 3
            else:
                kind = 0
                while j < n and not end_of_token[text[j]]:
                    j += 1
                kind, value = _not_finite(text, i, j)
            kinds[t] = kind + (8 if after_slash else 0)
            values[t] = value
            if kind == 0 and j - i <= 8 and t - token0 < 2:
                code = np.uint64(0)
                for k in range(j - 1, i - 1, -1):
                    code = (code << np.uint64(8)) | np.uint64(text[k])
                if t == token0:
                    keywords[length] = code
                else:
                    seconds[length] = code
            t += 1
            i = j
            after_slash = False
            if slashes and i < n and text[i] == 47:
                i += 1
                after_slash = True
                if i == n or _ends_line(text, i) or text[i] == 32 or text[i] == 9:
                    kinds[t] = 4 + 8
                    values[t] = 0.0
                    t += 1
                    after_slash = False
        if i < n:
            if text[i] == 13:
                if i + 1 < n and text[i + 1] == 10:
                    i += 1
                else:
                    oddities |= 4
            i += 1
            line += 1
        if t > token0:
            first[length] = token0
            starts[length] = begin
            numbers[length] = number
            length += 1
    first[length] = t
    return t, length, line, oddities
