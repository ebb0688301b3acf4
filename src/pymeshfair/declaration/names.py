"""The name that was most likely meant."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The one of `names` that `name` was most likely meant to be, upper and lower case, spaces and underscores aside; or None."""
    plain = {re.sub(r"[\s_-]+", "", n.casefold()): n for n in names}
    found = difflib.get_close_matches(re.sub(r"[\s_-]+", "", name.casefold()), plain, n=1, cutoff=0.6)
    return plain[found[0]] if found else None
