"""Output by rich: tables on stdout, and the progress of a run on stderr, as a bar or as lines.

User texts, such as paths with brackets, are never parsed as rich's markup.
"""

from __future__ import annotations

import contextlib
import os
import sys
import textwrap
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, ProgressColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from ..looking.words import measure_rows
from ..running.job import Compiling, Event, Message, PhaseStarted, StepFinished, StepProgress, StepStarted
from .streams import Verbosity, printable, say, verbosity

if TYPE_CHECKING:
    from ..running.suitability import Suitability

_WIDTH = 100  # characters per line if the output is a file or a pipe


def show_table(headers: Sequence[str], *rows: Sequence[str], numbers: Collection[int] = ()) -> None:
    """Print a table of texts; the columns in `numbers` are aligned to the right."""
    width = None if sys.stdout.isatty() or "COLUMNS" in os.environ else _WIDTH
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for index, header in enumerate(headers):
        table.add_column(Text(printable(header)), justify="right" if index in numbers else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    Console(width=width, highlight=False, markup=False, emoji=False, soft_wrap=True).print(table)


def show_measures(columns: Mapping[str, Mapping[str, Any]], unit: str | None = None) -> None:
    """Print a table of the measures of meshes; `columns` has the measures of each mesh by the header of its column."""
    show_table(["", *columns], *measure_rows(columns, unit), numbers=range(1, len(columns) + 1))


_NARROW = 80  # characters per line of text about recipes
_INDENT = " " * 6


def fitting_lines(recipes: Sequence[Suitability]) -> Iterator[str]:
    """Lines about the recipes that fit, the best first, with reasons; then the other recipes, each with a reason."""
    fitting = [s for s in recipes if s.fits]
    if not fitting:
        yield "no recipe is for such a mesh"
    for number, suited in enumerate(fitting, 1):
        yield textwrap.fill(f"{number:>4}  {suited.recipe}: {suited.title}", _NARROW, subsequent_indent=_INDENT)
        # The first condition only says that the scan is a mesh, a cloud or curves: it is left out if there are more.
        words = [text for _, text in suited.met[len(suited.met) > 1 :]]
        reasons = "; ".join([*words, *([] if suited.trial is None else [suited.trial.words])])
        yield textwrap.fill(reasons, _NARROW, initial_indent=_INDENT, subsequent_indent=_INDENT)
    others = [s for s in recipes if not s.fits]
    if others:
        yield "not for this mesh:"
    for suited in others:
        text = f"{suited.recipe}: {suited.unmet[0][1] if suited.unmet else 'does not say which meshes it is for'}"
        yield textwrap.fill(text, _NARROW, initial_indent=_INDENT, subsequent_indent=_INDENT + "  ")


#: seconds without output after which `ProgressLines` prints the progress of a step
_PATIENCE = 10.0
_COMPILING = "compiling filters for this machine"


def progress_bar(*columns: ProgressColumn) -> Progress:
    """A progress bar on stderr, to the right of its task's description; as a context manager it removes the bar on exit."""
    console = Console(stderr=True, highlight=False, emoji=False)
    return Progress(TextColumn("{task.description}"), *columns, console=console, transient=True)


class ProgressLines(contextlib.ExitStack):
    """Prints a line when a step begins, and filters' messages; with `verbose` also phases, times, progress of long steps."""

    _margin = "  "  # before the messages of filters

    def __init__(self, *, verbose: bool = False) -> None:
        super().__init__()
        self.push(self._end)
        self._verbose = verbose
        self._step = ""
        self._warnings: list[str] = []
        self._silent_since = time.monotonic()

    def _end(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for text in self._warnings if error is not None else ():  # else the command prints the warnings
            self._say(f"warning: {text}")

    def __call__(self, event: Event) -> None:
        if not isinstance(event, Message):
            self._show(event)
        elif event.level == "info":
            self._say(f"{self._margin}{f'step {event.step}: ' if event.step else ''}{event.text}")
        else:
            self._warnings.append(event.text)

    def _show(self, event: Event) -> None:
        waited = self._verbose and time.monotonic() - self._silent_since > _PATIENCE
        match event:
            case StepStarted():
                self._step = f"step {event.index} of {event.total}"
                self._say(f"{self._step}: {event.filter}")
            case Compiling(kernels=1, is_going_on=True):
                self._say(f"  {_COMPILING}")
            case Compiling() if waited:
                self._say(f"  {_COMPILING}: {event.seconds:.0f} s so far")
            case PhaseStarted() if self._verbose:
                self._say(event.phase)
            case StepFinished() if self._verbose:
                self._say(f"{self._step}: {event.seconds:.2f} s")
            case StepProgress() if waited:
                self._say(f"{self._step}: {event.fraction:.0%}")

    def _say(self, text: str) -> None:
        say(text, err=True)
        self._silent_since = time.monotonic()


class ProgressBar(ProgressLines):
    """A progress bar over the steps, and within a step if its filter reports progress; lists finished steps above the bar."""

    _margin = " " * 17

    def __init__(self) -> None:
        super().__init__()
        self._bar = self.enter_context(progress_bar(BarColumn(), TaskProgressColumn(), TimeElapsedColumn()))
        self._doing = "starting"
        self._task = self._bar.add_task(self._doing, total=None)

    def _show(self, event: Event) -> None:
        changed: dict[str, Any] = {}
        if isinstance(event, PhaseStarted):
            self._doing = event.phase
        elif isinstance(event, StepStarted):
            self._step = event.filter
            self._doing = escape(f"step {event.index} of {event.total}: {event.filter}")
            changed = {"total": event.total, "completed": event.index - 1}
        elif isinstance(event, StepProgress):
            changed = {"completed": event.index - 1 + event.fraction}
        elif isinstance(event, StepFinished):
            changed = {"completed": event.index}
            self._say(f"{event.index:>3}  {event.seconds:8.2f} s  {self._step}")
        doing = self._doing
        if isinstance(event, Compiling) and event.is_going_on:
            doing = f"{doing}: {_COMPILING}, {event.seconds:.0f} s so far"
        self._bar.update(self._task, description=doing, **changed)

    def _say(self, text: str) -> None:
        self._bar.console.print(printable(text), markup=False)


@contextlib.contextmanager
def progress() -> Iterator[Callable[[Event], None]]:
    """The display of events: none with --quiet, lines with --verbose or if stderr is no terminal, otherwise a bar."""
    if verbosity() == Verbosity.QUIET:
        yield lambda event: None
        return
    has_bar = verbosity() == Verbosity.NORMAL and sys.stderr.isatty()
    with ProgressBar() if has_bar else ProgressLines(verbose=verbosity() == Verbosity.VERBOSE) as show:
        yield show
