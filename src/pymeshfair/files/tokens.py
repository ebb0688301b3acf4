"""Splits texts of mesh files into lines of words and numbers, formats numbers as lines, and replaces words."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..filters.compilation import compiled
from ..filters.mesh import Bools, Floats, Longs
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import quoted

Bytes: TypeAlias = NDArray[np.uint8]

_EXACT = 1 << 53  # all integers up to this one are exact in double precision
_INFINITY = np.frombuffer(b"infinity", np.uint8)


@compiled
def _ends_line(text: Bytes, i: int) -> bool:
    return bool(text[i] == 10 or text[i] == 13)


@compiled
def _not_finite(text: Bytes, i: int, end: int) -> tuple[int, float]:
    """Returns NOT_FINITE and the value for nan, inf and infinity; WORD and 0 for other words."""
    negative = text[i] == 45
    if text[i] == 45 or text[i] == 43:
        i += 1
    length = end - i
    if length == 3 and text[i] | 32 == 110 and text[i + 1] | 32 == 97 and text[i + 2] | 32 == 110:
        return 3, np.nan
    if length == 3 or length == 8:
        for k in range(length):
            if text[i + k] | 32 != _INFINITY[k]:
                return 0, 0.0
        return 3, -np.inf if negative else np.inf
    return 0, 0.0


@compiled
def lex(
    text: Bytes, slashes: bool, kinds: Any, values: Any, first: Any, starts: Any, numbers: Any, keywords: Any, decimals: Any
) -> tuple[int, int]:
    """Fills the arrays of `Tokens`; returns the counts of tokens and lines.

    The value of a decimal, or of an integer above `_EXACT`, is NaN; `tokenise` reads the number from its copy in `decimals`.
    """
    i, n, t, length, line = 0, len(text), 0, 0, 1
    end_of_token = np.zeros(256, np.bool_)
    for c in (9, 10, 13, 32):
        end_of_token[c] = True
    end_of_token[47] = slashes
    while i < n:
        # one line: where it begins, its number, its first token
        begin, number, token0 = i, line, t
        after_slash = False
        while i < n and not _ends_line(text, i):
            c = text[i]
            if c == 32 or c == 9:
                i += 1
                continue
            if c == 35:  # a comment
                while i < n and not _ends_line(text, i):
                    i += 1
                break
            # a number: its sign, its digits, its exponent
            j, kind, whole, digits = i, 1, 0, 0
            negative = c == 45
            if negative or c == 43:
                j += 1
            while j < n and 48 <= text[j] <= 57:
                if whole <= _EXACT:
                    whole = whole * 10 + (text[j] - 48)
                digits += 1
                j += 1
            if j < n and text[j] == 46:
                kind = 2
                j += 1
                while j < n and 48 <= text[j] <= 57:
                    digits += 1
                    j += 1
            if digits > 0 and j + 1 < n and text[j] | 32 == 101:
                kind = 2
                j += 1
                if text[j] == 45 or text[j] == 43:
                    j += 1
                digits = 0
                while j < n and 48 <= text[j] <= 57:
                    digits += 1
                    j += 1
            value = 0.0
            if j == n or end_of_token[text[j]]:
                if j == i:
                    kind = 4
                elif digits == 0:
                    kind = 0
                elif kind == 2 or whole > _EXACT:
                    value = np.nan
                    decimals[i:j] = text[i:j]
                else:
                    value = -float(whole) if negative else float(whole)
            else:
                while j < n and not end_of_token[text[j]]:
                    j += 1
                kind, value = _not_finite(text, i, j)
            kinds[t] = kind + (8 if after_slash else 0)
            values[t] = value
            if kind == 0 and j - i <= 8 and t == token0:
                code = np.uint64(0)
                for k in range(j - 1, i - 1, -1):
                    code = (code << np.uint64(8)) | np.uint64(text[k])
                keywords[length] = code
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
            i += 2 if text[i] == 13 and i + 1 < n and text[i + 1] == 10 else 1
            line += 1
        if t > token0:
            first[length] = token0
            starts[length] = begin
            numbers[length] = number
            length += 1
    first[length] = t
    return t, length


#: kinds of tokens: a word, an integer, a decimal, nan or infinity, and an empty token beside a slash
WORD, INTEGER, REAL, NOT_FINITE, EMPTY = 0, 1, 2, 3, 4
AFTER_SLASH = 8  # added to the kind of a token that follows a slash instead of a blank


@dataclass(frozen=True)
class Tokens:
    """The lines of a text, without empty lines and comments."""

    text: Bytes
    kinds: NDArray[np.uint8]  # (t,)
    values: Floats  # (t,) the numbers, rounded to the nearest double; 0 for words
    first: Longs  # (l + 1,) the first token of each line; the last entry is t
    #: (l,) the first token of each line, encoded by `word`; 0 for a number, and for a word of over 8 bytes
    keywords: NDArray[np.uint64]
    starts: Longs  # (l,) where each line begins in the text
    numbers: Longs  # (l,) the number of each line in the file, from 1; of joined lines that of the first

    @property
    def lengths(self) -> Longs:
        """(l,) the number of tokens of each line."""
        return np.diff(self.first)

    def spans(self, lines: Longs, columns: list[int]) -> Longs:
        """Returns (l, c, 2) where words begin and end in the text; `columns` are ascending numbers of words in a line, from 0."""
        inside = _inside_words(self.text.tobytes())
        words = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)
        return np.asarray(words[np.searchsorted(words[:, 0], self.starts[lines])[:, None] + columns])

    def line(self, k: int) -> bytes:
        start, end = self.starts[k], self.starts[k + 1] if k + 1 < len(self.starts) else len(self.text)
        return self.text[start:end].tobytes().replace(b"\r", b"\n").partition(b"\n")[0]


def is_number(text: str) -> bool:
    """Whether a word is a number in ASCII, without Python's underscores."""
    try:
        float(text)
    except ValueError:
        return False
    return text.isascii() and "_" not in text


def word(text: bytes) -> np.uint64:
    """Encodes a word of at most eight bytes as an integer."""
    assert 0 < len(text) <= 8
    return np.uint64(int.from_bytes(text, "little"))


def _inside_words(text: bytes) -> Bools:
    return np.frombuffer(text.translate(bytes(c not in b"\t\n\r " for c in range(256))), np.bool_)


def tokenise(raw: bytes, *, slashes: bool = False, joins: bool = False) -> Tokens:
    """Splits a text into tokens; with `slashes` also at slashes, as in OBJ faces; with `joins`, lines are `joined` first."""
    data = joined(raw) if joins else raw
    text = np.frombuffer(data, dtype=np.uint8)
    inside = _inside_words(data)
    n_tokens = 1 + int(np.count_nonzero(inside[1:] > inside[:-1])) + data.count(b"/") * slashes  # an upper bound
    n_lines = 1 + data.count(b"\n") + data.count(b"\r")
    kinds, values, decimals = np.empty(n_tokens, np.uint8), np.empty(n_tokens), np.full(len(text), 32, np.uint8)
    first, starts, numbers = (np.empty(n_lines + 1, np.int64) for _ in range(3))
    keywords = np.zeros(n_lines, np.uint64)
    t, k = lex(text, slashes, kinds, values, first, starts, numbers, keywords, decimals)
    kinds, values = kinds[:t], values[:t]
    if data is not raw:
        numbers[:k] += np.searchsorted(np.flatnonzero((np.frombuffer(raw, np.uint8) == 10) & (text != 10)), starts[:k])
    unread = np.flatnonzero(np.isnan(values) & (kinds & (AFTER_SLASH - 1) != NOT_FINITE))
    if len(unread):
        values[unread] = np.fromstring(decimals.tobytes(), sep=" ")
        beyond = unread[np.isinf(values[unread])]
        kinds[beyond] = kinds[beyond] & AFTER_SLASH | NOT_FINITE
    return Tokens(text, kinds, values, first[: k + 1], keywords[:k], starts[:k], numbers[:k])


def joined(data: bytes) -> bytes:
    """Replaces each byte of a byte order mark, and of a backslash with its line end, by a blank: this joins lines."""
    if data.startswith(b"\xef\xbb\xbf"):
        data = b"   " + data[3:]
    if b"\\" in data and re.search(rb"#[^\r\n]*\\\r?\n", data):  # a comment such as `# from C:\scans\` is not joined
        data = re.sub(rb"(?<![^ \t\r\n])#[^\r\n]*", lambda match: b" " * len(match[0]), data)
    return re.sub(rb"\\\r?\n", lambda match: b" " * len(match[0]), data) if b"\\" in data else data


def numbers_of(tokens: Tokens, lines: Longs, skipped: int, width: int) -> Floats:
    """Returns (l, width) the numbers that follow the first `skipped` words of the given lines."""
    chosen = tokens.first[lines][:, None] + np.arange(skipped, skipped + width)
    wrong = ~np.isin(tokens.kinds[chosen], (INTEGER, REAL, NOT_FINITE)).all(axis=1)
    refuse(tokens, lines, wrong, "has something else than numbers; decimals are written with a point")
    return np.asarray(tokens.values[chosen])


def refuse(tokens: Tokens, lines: Longs, wrong: Any, why: str, counts: Longs | None = None) -> None:
    """Raises the error about the first line that is wrong, if any; {} in `why` stands for the line's entry in `counts`."""
    if wrong.any():
        k = int(np.argmax(wrong))
        raise at_line(tokens, int(lines[k]), why if counts is None else why.format(counts[k]))


def at_line(tokens: Tokens, k: int, why: str) -> ContentsError:
    """Makes the error about line `k`, counted from 0, with its number, its beginning and the reason."""
    return ContentsError(f"its line {tokens.numbers[k]:,}, {quoted(tokens.line(k).decode('utf-8', 'replace'), 60)}, {why}")


_CHUNK = 1 << 16  # rows in a block
_Word = TypeVar("_Word")


def words(values: Array) -> list[bytes]:
    """Formats numbers as words that are read as the same numbers in the precision of their type."""
    if values.dtype.kind != "f":
        return [b"%d" % value for value in values.tolist()]
    form = "{:.9g}".format if values.dtype.itemsize == 4 else repr
    return " ".join(map(form, values.tolist())).encode("ascii").split()


def rows(template: str, columns: Sequence[Array]) -> Iterator[bytes]:
    """Yields blocks of lines, one line for each row of the columns; the template has ``%r`` for each number."""
    for start in range(0, len(columns[0]), _CHUNK):
        parts = [column[start : start + _CHUNK].tolist() for column in columns]
        numbers = tuple(chain.from_iterable(zip(*parts, strict=True)))
        yield ((template + "\n") * len(parts[0]) % numbers).encode("ascii")


def runs(words: Sequence[_Word], lengths: Longs) -> Iterator[Sequence[_Word]]:
    """Yields successive runs of words with these lengths."""
    ends = np.cumsum(lengths)
    for start, end in zip((ends - lengths).tolist(), ends.tolist(), strict=True):
        yield words[start:end]


def changed_words(
    tokens: Tokens, lines: Longs, columns: list[int], new: Sequence[Array], differs: Sequence[Bools]
) -> tuple[Longs, list[bytes]]:
    """Returns (k, 2) the spans of the words that change (`differs`), and the new words."""
    is_changed = np.stack(differs, axis=1)
    new_words = np.stack([np.array(words(column), object) for column in new], axis=1)
    return tokens.spans(lines, columns)[is_changed], new_words[is_changed].tolist()


def patched(text: bytes, spans: Longs, new: Sequence[bytes]) -> bytes:
    """Returns the text with new words at the (k, 2) ascending spans, whose ends are exclusive."""
    parts = [b""] * (2 * len(new) + 1)
    begins, ends = [0, *spans[:, 1].tolist()], [*spans[:, 0].tolist(), len(text)]
    parts[::2] = [text[begin:end] for begin, end in zip(begins, ends, strict=True)]
    parts[1::2] = new
    return b"".join(parts)
