"""The text of mesh files, taken apart."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pymeshfair.files.tokens import AFTER_SLASH, EMPTY, INTEGER, NOT_FINITE, REAL, WORD, joined, tokenise, word

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
TEXT = st.text(alphabet="vfn 01-.+e/#\t\r\n\\x9i", max_size=60)


def expected(text: str) -> list[list[tuple[int, float]]]:
    """The same, one character at a time: for each line the kinds and values of its tokens."""
    lines = []
    for line in re.split(r"\r\n|\r|\n", text):
        found: list[tuple[int, float]] = []
        for part in re.findall(r"[^ \t]+", line):
            cut = part.startswith("#")
            if cut:
                break
            for k, token in enumerate(part.split("/")):
                # within a word a slash parts tokens, and what begins with # after it is none
                if k and token.startswith("#"):
                    cut = True
                    break
                found.append((kind_of(token) + (AFTER_SLASH if k else 0), value_of(token)))
            if cut:
                break
        if found:
            lines.append(found)
    return lines


def kind_of(token: str) -> int:
    """What a token is."""
    if token == "":
        return EMPTY
    if re.fullmatch(r"[+-]?(nan|inf|infinity)", token, re.IGNORECASE):
        return NOT_FINITE
    if not NUMBER.fullmatch(token):
        return WORD
    return NOT_FINITE if abs(float(token)) == np.inf else INTEGER if re.fullmatch(r"[+-]?\d+", token) else REAL


def value_of(token: str) -> float:
    """The number that a token is, or 0."""
    return float(token) if kind_of(token) not in (WORD, EMPTY) else 0.0


@settings(max_examples=400)
@given(TEXT)
def test_tokens_are_those_of_the_grammar(text: str) -> None:
    """Kinds and values are those of a parser by regular expressions, whatever the text."""
    tokens = tokenise(text.encode(), slashes=True)
    found = [
        [(int(k), float(v)) for k, v in zip(tokens.kinds[a:b], tokens.values[a:b], strict=True)]
        for a, b in zip(tokens.first[:-1], tokens.first[1:], strict=True)
    ]
    assert found == expected(text)


@pytest.mark.parametrize("word", ["infinity", "-Infinity", "infirmly", "infinitx", "in", "nan", "nap", "-inf"])
def test_words_like_infinity_are_words(word: str) -> None:
    """Only nan, inf and infinity are values that are not finite; words that begin or end like them are words."""
    assert int(tokenise(word.encode()).kinds[0]) == kind_of(word)


@settings(max_examples=300)
@given(st.floats(allow_nan=False, min_value=-1e308, max_value=1e308))
def test_numbers_are_the_nearest_doubles(value: float) -> None:
    """A number is read as Python reads it, with 17 digits, with fewer and with more."""
    for word_ in (repr(value), f"{value:.9g}", f"{value:.25e}"):
        assert tokenise(word_.encode()).values[0] == float(word_)


@settings(max_examples=300)
@given(TEXT)
def test_joined_lines_keep_their_places(text: str) -> None:
    """Where a backslash continues a line there are blanks, and every other byte stays where it is."""
    data = text.encode()
    after = joined(data)
    assert len(after) == len(data)
    assert all(a == b or b == 32 for a, b in zip(data, after, strict=True))
    assert joined(b"\xef\xbb\xbf1 \\\r\n2") == b"   1    2"


def test_lines_know_their_words_and_places() -> None:
    """Each line gives its first word, its number, its bytes and the places of its words."""
    tokens = tokenise(b"# nothing\n\nvn 1 2\r\n usemtl  a/b c\nlongestword x\n")
    assert tokens.keywords.tolist() == [word(b"vn"), word(b"usemtl"), 0]
    assert tokens.numbers.tolist() == [3, 4, 5]
    assert tokens.line(1) == b" usemtl  a/b c"
    assert tokens.spans(np.array([0, 1]), [1, 2]).tolist() == [[[14, 15], [16, 17]], [[28, 31], [32, 33]]]


def test_lines_behind_joined_lines_have_their_numbers_in_the_file() -> None:
    """A line that a backslash continues has the number of its first line, and those behind it count all of its lines."""
    tokens = tokenise(b"v 1 \\\n2 \\\r\n 3\n# C:\\\nv 4 5 6\n", joins=True)
    assert tokens.numbers.tolist() == [1, 5]
