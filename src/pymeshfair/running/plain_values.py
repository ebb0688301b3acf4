"""Parameters and results of filters in the types of JSON."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..declaration import Length

#: arrays of more numbers are described, not listed
LONGEST_LIST = 64


def plain(value: Any) -> Any:
    """The value as numbers, texts, lists and dictionaries; numbers that are not finite become the texts nan, inf and -inf."""
    match value:
        case None | bool() | int() | str():
            return value
        case np.bool_() | np.integer():
            return value.item()
        case float() | np.floating():
            number = float(value)
            return number if math.isfinite(number) else str(number)
        case Length():
            return value.amount if value.unit == "absolute" else str(value)
        case np.ndarray():
            return plain(value.tolist()) if value.size <= LONGEST_LIST else f"array of shape {value.shape}"
        case Mapping():
            return {str(k): plain(v) for k, v in value.items()}
        case list() | tuple() | set() | frozenset():
            return [plain(v) for v in value]
    return _plain_object(value)


def _plain_object(value: Any) -> Any:
    """The classes of pymeshlab: a length, a colour, a box."""
    for names in (("value",), ("red", "green", "blue", "alpha"), ("min", "max")):
        if all(callable(getattr(value, name, None)) for name in names):
            values = [plain(getattr(value, name)()) for name in names]
            return values[0] if len(values) == 1 else values
    return str(value)
