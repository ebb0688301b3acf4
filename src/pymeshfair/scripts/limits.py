"""How much a script may be of anything: more than people and programs write, and little enough to be read at once."""

from __future__ import annotations

from collections.abc import Mapping

MOST_BYTES = 5_000_000
MOST_LEVELS = 64
MOST_FILTERS = 1000
#: of one element
MOST_ATTRIBUTES = 100
#: characters of a name of a filter, a parameter or a type
LONGEST_NAME = 1000


def excess(attributes: Mapping[str, str]) -> str | None:
    """Why an element has more than it may; None if it has not."""
    if len(attributes) > MOST_ATTRIBUTES:
        return f"has an element of {len(attributes):,} attributes; {MOST_ATTRIBUTES} are the most"
    longest = max(len(attributes.get(key, "")) for key in ("name", "type"))
    return f"has a name of {longest:,} characters; {LONGEST_NAME:,} are the most" if longest > LONGEST_NAME else None
