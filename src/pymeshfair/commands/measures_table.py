"""The measures of one or more meshes side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from ..looking.words import measure_rows
from .tables import table


def measures_table(columns: Mapping[str, Mapping[str, Any]]) -> Table:
    """One column for each mesh, by its header; rare measures that are 0 or unknown in all of them are left out."""
    return table(["", *columns], measure_rows(columns), numbers=range(1, len(columns) + 1))
