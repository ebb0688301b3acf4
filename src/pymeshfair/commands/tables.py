"""Tables and texts on stdout. Texts of users, such as paths with brackets, are never read as rich's markup."""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..looking.words import measure_rows
from .streams import printable

if TYPE_CHECKING:
    from ..running.suitability import Suitability


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


#: characters of a line of text about recipes and rims
_NARROW = 80
_INDENT = " " * 6
_MOST_RIMS = 12


def fitting_lines(recipes: Sequence[Suitability]) -> Iterator[str]:
    """The recipes that fit, the best first, with reasons; then in one line each those that do not."""
    fitting = [s for s in recipes if s.fits]
    if not fitting:
        yield "no recipe is for such a mesh"
    for number, suited in enumerate(fitting, 1):
        title = f"{number:>4}  {suited.recipe}: {suited.title}"
        yield textwrap.fill(title, _NARROW, subsequent_indent=_INDENT)
        # The first condition, that there are faces, is left out where there are others.
        words = [text for _, text in suited.met[len(suited.met) > 1 :]]
        reasons = "; ".join([*words, *([] if suited.trial is None else [suited.trial.words])])
        yield textwrap.fill(reasons, _NARROW, initial_indent=_INDENT, subsequent_indent=_INDENT)
    others = [s for s in recipes if not s.fits]
    if others:
        yield "not for this one:"
    for suited in others:
        text = f"{suited.recipe}: {suited.unmet[0][1]}" if suited.unmet else f"{suited.recipe}: does not say for what it is"
        yield textwrap.fill(text, _NARROW, initial_indent=_INDENT, subsequent_indent=_INDENT + "  ")


def rim_lines(rims: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """The holes and outer borders of a mesh, the largest first."""
    for rim in rims[:_MOST_RIMS]:
        kind = "outer border" if rim["outer"] else "hole"
        x, y, z = rim["middle"]
        yield f"  {kind} of {rim['edges']:,} edges, {rim['length']:.4g} long, around {x:.4g}, {y:.4g}, {z:.4g}"
    if len(rims) > _MOST_RIMS:
        least = rims[_MOST_RIMS]["edges"]
        yield f"  and {len(rims) - _MOST_RIMS:,} more of at most {least:,} edges"
