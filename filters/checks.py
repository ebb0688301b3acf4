"""Errors of the filters, and checks of single parameters with uniform messages.

A whole number is an `int` or a NumPy integer: 2.0 is refused like 2.5. `bool` is refused as a number.
"""

import math
from decimal import ROUND_FLOOR, Context
from numbers import Integral, Real
from typing import Any, get_args

import numpy as np


class PymeshfairError(Exception):
    """Base class of the errors of pymeshfair; also in `pymeshfair.errors`."""

    def __reduce__(self) -> tuple[Any, ...]:  # unpickling would otherwise call the class with the message alone
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[PymeshfairError], arguments: tuple[Any, ...], attributes: dict[str, Any]) -> PymeshfairError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(attributes)
    return error


class FilterInputError(PymeshfairError, ValueError):
    """The technique is not defined for this mesh or parameter; the message says why."""


class UnstableStepError(FilterInputError):
    """An explicit step is too long.

    Attributes:
        largest_stable: the longest step that is allowed, in the unit of the step.
    """

    def __init__(self, message: str, *, largest_stable: float) -> None:
        """Writes the longest step in place of "{}" in the message, rounded down: a step of the written length is allowed."""
        written = float(Context(6, ROUND_FLOOR).create_decimal_from_float(largest_stable))
        super().__init__(message.replace("{}", f"{written:g}"))
        self.largest_stable = largest_stable


class ConvergenceError(PymeshfairError, RuntimeError):
    """A solver failed or ended above its tolerance; the message says by how much where this is known."""


def check_whole_number(name: str, value: object, *, least: int = 0, most: int | None = None, note: str = "") -> int:
    """Returns the value as an `int` from `least` to `most`, both included; `most` None means no upper bound.

    Raises:
        FilterInputError: not an integer, or out of range: "iterations is 2.5: it must be a whole number of at least 0". The
            message ends with `note`: a punctuation mark, then an explanation of the value, or the remedy.
    """
    highest = math.inf if most is None else most
    if isinstance(value, Integral) and not isinstance(value, bool) and least <= int(value) <= highest:
        return int(value)
    allowed = f"of at least {least}" if most is None else f"from {least} to {most}"
    is_whole = isinstance(value, float | np.floating) and float(value).is_integer() and least <= value <= highest
    written = f", written {value:.0f}" if is_whole else ""
    raise FilterInputError(f"{name} is {_shown(value)}: it must be a whole number {allowed}{written}{note}")


def check_finite(name: str, value: object, *, least: float | None = None, most: float | None = None) -> float:
    """Returns the value as a finite `float` from `least` to `most`, both included; `most` needs `least`.

    Raises:
        FilterInputError: not a real number, not finite, or out of range: "time_step is nan: it must be finite and at least 0".
    """
    number = _real(value)
    low, high = -math.inf if least is None else least, math.inf if most is None else most
    if math.isfinite(number) and low <= number <= high:
        return number
    allowed = "finite" if least is None else f"finite and at least {least:g}" if most is None else f"from {least:g} to {most:g}"
    raise FilterInputError(f"{name} is {_shown(value)}: it must be {allowed}")


def check_positive(name: str, value: object, *, most: float | None = None, note: str = "") -> float:
    """Returns the value as a finite `float` above 0 and at most `most` (None: no bound); `note` as in `check_whole_number`.

    Raises:
        FilterInputError: not a real number, not finite, or out of range: "detail_size is 0.0: it must be finite and above 0".
    """
    number = _real(value)
    if 0.0 < number < math.inf and (most is None or number <= most):
        return number
    allowed = "finite and above 0" if most is None else f"above 0 and at most {most:g}"
    raise FilterInputError(f"{name} is {_shown(value)}: it must be {allowed}{note}")


def check_choice(name: str, value: object, allowed: Any) -> None:
    """Refuses a value that is not one of the allowed names, given as a `Literal` type or as a sequence.

    Raises:
        FilterInputError: another name, or not a string: "border 'open' is not one of 'fixed', 'along', 'free'".
    """
    names = get_args(allowed) or allowed
    if not (isinstance(value, str) and value in names):
        raise FilterInputError(f"{name} {_shown(value)} is not one of {', '.join(map(repr, names))}")


def _real(value: object) -> float:
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    except OverflowError:  # of a whole number or a fraction
        return math.inf


def _shown(value: object) -> str:
    return repr(value.item() if isinstance(value, np.generic) else value)[:80]


__all__ = [
    "ConvergenceError",
    "FilterInputError",
    "PymeshfairError",
    "UnstableStepError",
    "check_choice",
    "check_finite",
    "check_positive",
    "check_whole_number",
]
