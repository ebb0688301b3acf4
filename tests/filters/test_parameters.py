"""The checks of single parameters: what they take, and the one wording of what they refuse."""

import math
from fractions import Fraction

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError, check_choice, check_finite, check_positive, check_whole_number


@pytest.mark.parametrize("value", [0, 3, np.int32(3), np.uint8(3), 10**20])
def test_whole_numbers_come_back_as_int(value: object) -> None:
    """Python's and NumPy's integers are taken, and what follows computes with a plain int."""
    found = check_whole_number("iterations", value)
    assert found == value
    assert type(found) is int


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (-1, "iterations is -1: it must be a whole number of at least 0"),
        (2.5, "iterations is 2.5: it must be a whole number of at least 0"),
        (2.0, "iterations is 2.0: it must be a whole number of at least 0, written 2"),
        (np.float64(2.0), "iterations is 2.0: it must be a whole number of at least 0, written 2"),
        (-1.0, "iterations is -1.0: it must be a whole number of at least 0"),
        (math.nan, "iterations is nan: it must be a whole number of at least 0"),
        (math.inf, "iterations is inf: it must be a whole number of at least 0"),
        (True, "iterations is True: it must be a whole number of at least 0"),
        (np.True_, "iterations is True: it must be a whole number of at least 0"),
        ("3", "iterations is '3': it must be a whole number of at least 0"),
        (None, "iterations is None: it must be a whole number of at least 0"),
    ],
)
def test_what_is_no_whole_number_is_refused_in_the_same_words(value: object, message: str) -> None:
    """Floats, NaN, truth values and strings are refused like numbers out of range; 2.0 is told how to be written."""
    with pytest.raises(FilterInputError) as error:
        check_whole_number("iterations", value)
    assert str(error.value) == message


@pytest.mark.parametrize("value", [0, 9, math.nan])
def test_a_range_of_whole_numbers_names_both_ends(value: object) -> None:
    """With an upper bound the message gives the range, and a note follows it."""
    with pytest.raises(FilterInputError) as error:
        check_whole_number("order", value, least=1, most=8, note="; 2 is usual")
    assert str(error.value) == f"order is {value}: it must be a whole number from 1 to 8; 2 is usual"
    assert [check_whole_number("order", k, least=1, most=8) for k in (1, 8)] == [1, 8]


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, True, "1", None])
def test_lengths_are_finite_and_above_0(value: object) -> None:
    """Zero, negative, NaN, infinite, and what is no number: the same words, with the value."""
    with pytest.raises(FilterInputError) as error:
        check_positive("detail_size", value, note="; None takes it from the mesh")
    assert str(error.value) == f"detail_size is {value!r}: it must be finite and above 0; None takes it from the mesh"


def test_an_upper_bound_is_named_and_allowed() -> None:
    """A step above 0 and at most 1 may be 1."""
    with pytest.raises(FilterInputError, match=r"^step is 1\.5: it must be above 0 and at most 1$"):
        check_positive("step", 1.5, most=1.0)
    assert check_positive("step", 1, most=1.0) == 1.0


@pytest.mark.parametrize(
    ("value", "bounds", "message"),
    [
        (math.nan, {}, "gain is nan: it must be finite"),
        pytest.param(10**400, {}, f"gain is 1{79 * '0'}: it must be finite", id="above floats"),
        (-0.5, {"least": 0.0}, "gain is -0.5: it must be finite and at least 0"),
        (math.inf, {"least": 0.0}, "gain is inf: it must be finite and at least 0"),
        (181.0, {"least": 0.0, "most": 180.0}, "gain is 181.0: it must be from 0 to 180"),
    ],
)
def test_finite_numbers_out_of_range_are_refused(value: float, bounds: dict[str, float], message: str) -> None:
    """The message says which of the bounds there are."""
    with pytest.raises(FilterInputError) as error:
        check_finite("gain", value, **bounds)
    assert str(error.value) == message


@pytest.mark.parametrize("value", [2, np.float32(0.5), Fraction(1, 2), -3.0])
def test_real_numbers_come_back_as_float(value: object) -> None:
    """Any real number is taken, and what follows computes with a plain float."""
    found = check_finite("gain", value)
    assert found == value
    assert type(found) is float


@pytest.mark.parametrize("value", ["open", 1, None, ["free"]])
def test_another_name_is_refused_with_all_that_there_are(value: object) -> None:
    """A name that is not in the list, or no name, is refused with the list in its order."""
    with pytest.raises(FilterInputError) as error:
        check_choice("border", value, ("fixed", "along", "free"))
    assert str(error.value) == f"border {value!r} is not one of 'fixed', 'along', 'free'"
    check_choice("border", "free", ("fixed", "along", "free"))
