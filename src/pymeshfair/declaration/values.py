"""A value as a number and as text in a message, and the name that was most likely meant."""

import difflib
import math
import numbers
import re
from collections.abc import Iterable
from typing import Any

import numpy as np


def as_float(value: Any) -> float | None:
    """The float of a real number of Python or numpy; None of anything else, truth values included."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def shown(value: Any) -> str:
    """The value as it would be written in Python, cut to a length that a message can hold."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The one of `names` that `name` was most likely meant to be, upper and lower case, spaces and underscores aside; or None."""
    plain = {re.sub(r"[\s_-]+", "", n.casefold()): n for n in names}
    near = difflib.get_close_matches(re.sub(r"[\s_-]+", "", name.casefold()), plain, n=1, cutoff=0.6)
    return plain[near[0]] if near else None
