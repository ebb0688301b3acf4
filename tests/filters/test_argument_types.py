"""The texts of argument types are the types that numba itself gives the arguments; others are left to numba."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pymeshfair.filters.compilation import compiled
from pymeshfair.filters.compilation.compiler import numba_type
from pymeshfair.filters.compilation.kernel import UnknownTypeError, from_json, signature_of


class Pair(NamedTuple):
    """Arguments that belong together."""

    values: Any
    factor: Any


@compiled
def first(value: Any) -> Any:
    """Gives back what it takes."""
    return value


def layouts(array: np.ndarray[Any, Any]) -> Iterator[np.ndarray[Any, Any]]:
    """The array in every layout that numba tells apart, to be written and to be read only."""
    for each in (array, array.T, np.asfortranarray(array), array[..., ::2], array[::-1], array[:0], array[:1]):
        yield each
        frozen = each.view()
        frozen.flags.writeable = False
        yield frozen


def arguments() -> Iterator[Any]:
    """Everything that has a text."""
    yield from (True, 3, 2.5, None)
    for code in ("?", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"):
        yield np.dtype(code).type(1)
        for shape in ((4,), (4, 4), (4, 4, 4), ()):
            yield from layouts(np.zeros(shape, code)) if shape else (np.zeros(shape, code),)
    values = np.zeros(3)
    yield from ((1, 2), (1, 2.5), (values, 1), ((1, 2.5), values), Pair(values, 1.0), Pair(1, 1), Pair(Pair(values, 1), 2.5))


def test_types_are_those_that_numba_finds() -> None:
    """The text of an argument's type stands for the type that numba gives it, and for no other; read from JSON, too."""
    from numba import typeof

    texts: dict[Any, Any] = {}
    for argument in arguments():
        (written,) = signature_of((argument,))
        found = typeof(argument)  # type: ignore[no-untyped-call]
        assert numba_type(written) == found, written
        assert texts.setdefault(written, found) == found
        as_lists = (
            [list(part) if isinstance(part, tuple) else part for part in written] if isinstance(written, tuple) else written
        )
        assert from_json(as_lists) == written
    assert len(texts) == len(set(texts.values()))


def test_numba_chooses_the_same_code_for_a_call() -> None:
    """The types for which numba's own dispatcher compiles when it is called are those of the text."""
    kernel: Any = first
    for argument in (1, 2.5, np.zeros((3, 3))[:, ::2], np.zeros(3, "u1"), (1, 2.5), Pair(np.zeros(3), 1)):
        kernel.dispatcher(argument)
        (written,) = signature_of((argument,))
        assert kernel.dispatcher.nopython_signatures[-1].args == (numba_type(written),)


@settings(max_examples=200, deadline=None)
@given(st.recursive(st.one_of(st.integers(-5, 5), st.floats(0, 1), st.booleans(), st.none()), lambda part: st.tuples(part, part)))
def test_tuples_of_any_depth_are_told_apart(value: Any) -> None:
    """Whatever is nested in tuples, the text stands for the type that numba finds."""
    from numba import typeof

    (written,) = signature_of((value,))
    assert numba_type(written) == typeof(value)  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(
    "value",
    [
        np.zeros(2, np.complex128),
        np.zeros(2, ">f8"),
        np.zeros(2, [("x", "f8")]),
        np.zeros(17, "u1")[1:].view("f8"),
        "a text",
        1 + 2j,
        np.longdouble(1) if np.dtype("g").itemsize != 8 else 1j,
    ],
    ids=["complex", "big-endian", "rows", "unaligned", "text", "complex number", "long double"],
)
def test_other_types_have_no_text(value: Any) -> None:
    """They are refused, and not taken for a type that is alike."""
    with pytest.raises(UnknownTypeError, match="no machine code is made for"):
        signature_of((value,))


@pytest.mark.parametrize("value", [np.arange(3) * 1j, 1 + 2j, "a text"], ids=["array", "number", "text"])
def test_an_argument_without_text_is_left_to_numba(value: Any) -> None:
    """The kernel is called all the same, compiled by numba in this process."""
    kernel: Any = first
    known = list(kernel.code)
    assert np.array_equal(kernel(value), value)
    assert list(kernel.code) == known
