"""A value that someone gave, as a number and as words in a message."""

from __future__ import annotations

import math
import numbers
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
