"""Tables and texts on stdout. Texts of users, such as paths with brackets, are never read as rich's markup."""

import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..looking.words import measure_rows
from .streams import printable

#: characters of a line where the output is a file or a pipe; programs read --json
_WIDTH = 100


def console() -> Console:
    """The console on stdout."""
    width = None if sys.stdout.isatty() or "COLUMNS" in os.environ else _WIDTH
    return Console(width=width, highlight=False, markup=False, emoji=False, soft_wrap=True)


def table(headers: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Iterable[int] = ()) -> Table:
    """A table of texts; the columns in `numbers` are aligned to the right."""
    result = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    right = set(numbers)
    for index, header in enumerate(headers):
        result.add_column(Text(printable(header)), justify="right" if index in right else "left", overflow="fold")
    for row in rows:
        result.add_row(*(Text(printable(cell)) for cell in row))
    return result


def measures_table(columns: Mapping[str, Mapping[str, Any]], unit: str | None = None) -> Table:
    """One column for each mesh, by its header; rare measures that are 0 or unknown in all of them are left out.

    `unit` is that of the scan, if it is known.
    """
    return table(["", *columns], measure_rows(columns, unit), numbers=range(1, len(columns) + 1))
