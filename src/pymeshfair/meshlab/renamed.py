"""Filters whose names in MeshLab have changed since 2010, and what they are called today."""

from __future__ import annotations

import functools
import importlib.resources
import json
from typing import NamedTuple


class Renamed(NamedTuple):
    """Today's name of a filter, and what else has to change, as the end of a sentence."""

    name: str
    note: str = ""


def renamed_filter(old: str) -> Renamed | None:
    """What the filter of that name is called today; None if no change of its name is known."""
    entry = _table().get(old)
    return None if entry is None else Renamed(*entry)


@functools.cache
def _table() -> dict[str, list[str]]:
    text = importlib.resources.files(__package__).joinpath("renamed_filters.json").read_text("utf-8")
    table: dict[str, list[str]] = json.loads(text)
    return table
