"""Writes texts of numbers: rows of them, and a text as it was in which only some words are others."""

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_CHUNK = 1 << 16
_Word = TypeVar("_Word")


def words(values: NDArray[Any]) -> list[bytes]:
    """Numbers as words that are read as the same numbers: whole ones, or real ones of the precision of their type."""
    if values.dtype.kind != "f":
        return [b"%d" % value for value in values.tolist()]
    form = "{:.9g}".format if values.dtype.itemsize == 4 else repr
    return " ".join(map(form, values.tolist())).encode("ascii").split()


def rows(template: str, columns: Sequence[NDArray[Any]]) -> Iterator[bytes]:
    """One line for each row of some columns, in pieces; the template has ``%r`` in the place of each number."""
    for start in range(0, len(columns[0]), _CHUNK):
        parts = [column[start : start + _CHUNK].tolist() for column in columns]
        numbers = tuple(chain.from_iterable(zip(*parts, strict=True)))
        yield ((template + "\n") * len(parts[0]) % numbers).encode("ascii")


def runs(words: Sequence[_Word], lengths: NDArray[np.int64]) -> Iterator[Sequence[_Word]]:
    """Runs of words, one for each length."""
    ends = np.cumsum(lengths)
    for start, end in zip((ends - lengths).tolist(), ends.tolist(), strict=True):
        yield words[start:end]


def patched(text: bytes, spans: NDArray[np.int64], new: Sequence[bytes]) -> bytes:
    """The text with new words in place of the (k, 2) ascending spans, each from its first byte to before its end."""
    parts = [b""] * (2 * len(new) + 1)
    begins, ends = [0, *spans[:, 1].tolist()], [*spans[:, 0].tolist(), len(text)]
    parts[::2] = [text[begin:end] for begin, end in zip(begins, ends, strict=True)]
    parts[1::2] = new
    return b"".join(parts)
