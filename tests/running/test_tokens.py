"""The text of mesh files, taken apart."""

from __future__ import annotations

import re

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pymeshfair.files import tokens
from pymeshfair.files.tokens import AFTER_SLASH, EMPTY, INTEGER, NOT_FINITE, REAL, WORD, plain, tokenise, word

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


@settings(max_examples=400, deadline=None, derandomize=True)
@given(TEXT, st.integers(1, 20))
def test_tokens_are_those_of_the_grammar(text: str, size: int) -> None:
    """Kinds and values are those of a parser by regular expressions, whatever the text and wherever its pieces end."""
    tokens_chunk, tokens._CHUNK = tokens._CHUNK, size
    try:
        found = [
            [(int(k), float(v)) for k, v in zip(p.kinds[a:b], p.values[a:b], strict=True)]
            for p in tokenise(text.encode(), slashes=True)
            for a, b in zip(p.first[:-1], p.first[1:], strict=True)
        ]
    finally:
        tokens._CHUNK = tokens_chunk
    wanted = expected(text)
    assert [[k for k, _ in line] for line in found] == [[k for k, _ in line] for line in wanted]
    np.testing.assert_allclose(
        [v for line in found for _, v in line], [v for line in wanted for _, v in line], rtol=1e-15, atol=0
    )


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.floats(allow_nan=False, min_value=-1e308, max_value=1e308))
def test_numbers_are_within_units_in_the_last_place(value: float) -> None:
    """A number of up to 17 digits is read within four units in the last place: one rounding of the digits and three scalings."""
    (piece,) = tokenise(repr(value).encode())
    assert abs(piece.values[0] - value) <= 4 * np.spacing(abs(value))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(TEXT)
def test_a_plain_text_has_no_oddities_and_the_same_tokens(text: str) -> None:
    """Made plain, a text says the same and no reader has a choice."""
    before = list(tokenise(text.encode()))
    after = list(tokenise(plain(text.encode())))
    assert all(piece.oddities == 0 for piece in after)
    assert [k for p in before for k in p.kinds.tolist()] == [k for p in after for k in p.kinds.tolist()]


def test_lines_know_their_words_and_places() -> None:
    """Each line gives its first two words, its number and its bytes."""
    (piece,) = tokenise(b"# nothing\n\nvn 1 2\r\n usemtl  a/b c\nlongestword x\n")
    assert piece.keywords.tolist() == [word(b"vn"), word(b"usemtl"), 0]
    assert piece.seconds.tolist() == [0, word(b"a/b"), word(b"x")]
    assert piece.numbers.tolist() == [3, 4, 5]
    assert piece.line(1) == b" usemtl  a/b c"
