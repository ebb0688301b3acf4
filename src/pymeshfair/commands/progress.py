"""The progress of a run: a bar on a terminal, lines elsewhere; always on stderr."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from types import TracebackType

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, ProgressColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

from ..running.job import Compiling, Event, Message, PhaseStarted, StepFinished, StepProgress, StepStarted
from .streams import Talk, printable, talk

#: seconds between two lines about the same step where there is no bar
_PATIENCE = 10.0
_COMPILING = "compiling filters for this machine"


class ProgressLines(contextlib.ExitStack):
    """One line when a step begins, and what filters note; with `much` also how long it takes, and how far a long one is."""

    _margin = ""  # before what is said of compilation

    def __init__(self, *, much: bool = False) -> None:
        super().__init__()
        self.push(self._end)
        self._much = much
        self._step = ""
        self._compiled: Compiling | None = None
        self._warnings: list[str] = []
        self._silent_since = time.monotonic()

    def _end(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._compiled is not None:
            self._say(f"{self._margin}{_compiled(self._compiled)}")
        if error is not None:  # else the command shows them below its results
            for text in self._warnings:
                self._say(f"warning: {text}")

    def __call__(self, event: Event) -> None:
        """Show an event of the run."""
        if isinstance(event, StepStarted):
            self._step = f"step {event.index} of {event.total}"
            self._say(f"{self._step}: {event.filter}")
        elif isinstance(event, Compiling):
            self._compiled = event
            if event.kernels == 1 and event.is_going_on:
                self._say(f"  {_COMPILING}")
        elif isinstance(event, Message) and event.level == "info":
            self._say(f"  step {event.step}: {event.text}" if event.step else f"  {event.text}")
        elif isinstance(event, Message):
            self._warnings.append(event.text)
        if self._much:
            self._show_more(event)

    def _show_more(self, event: Event) -> None:
        waited = time.monotonic() - self._silent_since > _PATIENCE
        if isinstance(event, PhaseStarted):
            self._say(event.phase)
        elif isinstance(event, StepFinished):
            self._say(f"{self._step}: {event.seconds:.2f} s")
        elif isinstance(event, StepProgress) and waited:
            self._say(f"{self._step}: {event.fraction:.0%}")
        elif isinstance(event, Compiling) and waited:
            self._say(f"  {_COMPILING}: {event.seconds:.0f} s so far")

    def _say(self, text: str) -> None:
        typer.echo(printable(text), err=True)
        self._silent_since = time.monotonic()


class ProgressBar(ProgressLines):
    """A bar over the steps, which also moves within a step whose filter tells how far it is; finished steps stay above it."""

    _margin = " " * 17

    def __init__(self) -> None:
        super().__init__()
        self._bar = self.enter_context(progress_bar(BarColumn(), TaskProgressColumn(), TimeElapsedColumn()))
        self._task = self._bar.add_task("starting", total=None)
        self._doing = "starting"

    def __call__(self, event: Event) -> None:
        if isinstance(event, PhaseStarted):
            self._doing = event.phase
            self._bar.update(self._task, description=self._doing)
        elif isinstance(event, StepStarted):
            self._step = event.filter
            self._doing = escape(f"step {event.index} of {event.total}: {event.filter}")
            self._bar.update(self._task, description=self._doing, total=event.total, completed=event.index - 1)
        elif isinstance(event, StepProgress):
            self._bar.update(self._task, completed=event.index - 1 + event.fraction)
        elif isinstance(event, StepFinished):
            self._bar.update(self._task, completed=event.index)
            self._say(f"{event.index:>3}  {event.seconds:8.2f} s  {self._step}")
        elif isinstance(event, Compiling):
            self._compiled = event
            so_far = f"{self._doing}: {_COMPILING}, {event.seconds:.0f} s so far"
            self._bar.update(self._task, description=so_far if event.is_going_on else self._doing)
        elif event.level == "info":
            about = f"step {event.step}: " if event.step else ""
            self._say(f"{self._margin}{about}{event.text}")
        else:
            self._warnings.append(event.text)

    def _say(self, text: str) -> None:
        self._bar.console.print(printable(text), markup=False)


def progress_bar(*columns: ProgressColumn) -> Progress:
    """A bar on stderr behind the words about its task, which leaves nothing behind; a context manager."""
    console = Console(stderr=True, highlight=False, emoji=False)
    return Progress(TextColumn("{task.description}"), *columns, console=console, transient=True)


def _compiled(event: Compiling) -> str:
    after = (
        "the next run has them"
        if event.lasts
        else "they are kept nowhere, as your cache folder cannot be written: set NUMBA_CACHE_DIR to a folder where they can be"
    )
    return f"{event.seconds:.1f} s of that went into {_COMPILING}; {after}"


@contextlib.contextmanager
def progress() -> Iterator[Callable[[Event], None]]:
    """The display of events: none if little is to be printed, a bar if stderr is a terminal, else lines."""
    if talk() == Talk.LITTLE:
        yield lambda event: None
        return
    has_bar = talk() == Talk.USUAL and sys.stderr.isatty()
    with ProgressBar() if has_bar else ProgressLines(much=talk() == Talk.MUCH) as show:
        yield show
