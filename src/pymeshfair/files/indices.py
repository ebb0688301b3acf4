"""Numbers and indices of documents in which a list stands in a text: checked as a whole, without a loop in Python."""

import numpy as np
from numpy.typing import NDArray

from .errors import ContentsError
from .references import shown


def numbers(text: str, what: str, count: int | None = None) -> NDArray[np.float64]:
    """The `count` finite numbers of a text, parted by blanks; `what` names them in messages."""
    words = text.split()
    try:
        if "_" in text or not text.isascii():  # of which Python makes numbers, too
            raise ValueError
        values = np.array(words, dtype=np.float64)
    except ValueError:
        strange = next(w for w in words if "_" in w or not w.isascii() or not is_number(w))
        raise ContentsError(f"{shown(strange, 30)} among {what} is no number; decimals are written with a point") from None
    if not np.isfinite(values).all():
        raise ContentsError(f"number {int(np.argmin(np.isfinite(values))) + 1:,} of {what} is not finite")
    if count is not None and len(values) != count:
        raise ContentsError(f"{what} has {len(values):,} numbers and not {count}")
    return values


def rows(text: str, width: int, what: str) -> NDArray[np.float64]:
    """(n, width) the numbers of a text."""
    values = numbers(text, what)
    if len(values) % width:
        raise ContentsError(f"{what} are {len(values):,} numbers, which are no whole number of {width}")
    return values.reshape(-1, width)


def indices(text: str, what: str) -> NDArray[np.int64]:
    """The whole numbers of a text, parted by blanks."""
    values = numbers(text, what)
    whole = (values == np.rint(values)) & (np.abs(values) < 1 << 53)
    if not whole.all():
        raise ContentsError(f"number {int(np.argmin(whole)) + 1:,} of {what} is no whole number")
    return values.astype(np.int64)


def check_range(values: NDArray[np.int64], least: int, below: int, what: str) -> None:
    """Refuse indices that name nothing."""
    wrong = (values < least) | (values >= below)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise ContentsError(f"number {k + 1:,} of {what} is {values[k]}, which is none of {below:,}")


def is_number(text: str) -> bool:
    """Whether Python makes a number of a word."""
    try:
        float(text)
    except ValueError:
        return False
    return True
