"""The progress of a batch: a bar on a terminal, a line a scan elsewhere; always on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from ..batch.journal import Outcome
from ..batch.numbers import displacement_in_edges
from ..batch.plan import Scan
from .streams import Talk, printable, say, talk


class BatchLines:
    """A line for each scan that ends."""

    def __init__(self) -> None:
        self._total = 0
        self._ended = 0

    def __enter__(self) -> BatchLines:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def begin(self, total: int) -> None:
        """So many scans are to do."""
        self._total = total

    def note(self, text: str) -> None:
        """Say something about the batch as a whole."""
        say(text, err=True)

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended."""
        self._ended += 1
        self.note(f"[{self._ended:>{len(str(self._total))}}/{self._total}] {told(scan, outcome)}")

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        """A page was made."""
        if "problem" in made:
            self.note(f"{scan.label}: no page: {made['problem']}")


class BatchBar(BatchLines):
    """A bar over all scans with their rate, the time left and the worst so far; those that fail stay above it."""

    def __init__(self) -> None:
        super().__init__()
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=Console(stderr=True, highlight=False, emoji=False),
            transient=True,
        )
        self._task = self._bar.add_task("preparing", total=None)
        self._started = time.monotonic()
        self._failed = 0
        self._worst: tuple[float, str] | None = None

    def __enter__(self) -> BatchBar:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def begin(self, total: int) -> None:
        self._started = time.monotonic()
        self._bar.update(self._task, total=total, description="starting")

    def note(self, text: str) -> None:
        self._bar.console.print(printable(text), markup=False)

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        self._ended += 1
        self._failed += outcome.status != "done"
        moved = displacement_in_edges(outcome)
        if moved is not None and (self._worst is None or moved > self._worst[0]):
            self._worst = moved, scan.label
        if outcome.status != "done":
            self.note(told(scan, outcome))
        rate = 60.0 * self._ended / max(1e-9, time.monotonic() - self._started)
        words = [f"{rate:.3g} a minute", f"{self._failed} failed"]
        if self._worst is not None:
            words.append(f"moved most: {self._worst[1]}, {self._worst[0]:.2g} edges")
        self._bar.update(self._task, completed=self._ended, description=escape(printable(", ".join(words))))

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        super().page(scan, made)
        self._bar.update(self._task, description=escape(printable(f"page of {scan.label}")))


def told(scan: Scan, outcome: Outcome) -> str:
    """One line about a scan that has ended."""
    if outcome.error is not None:
        return f"{scan.label}: failed: {outcome.error['message']}" + (f"; {outcome.former}" if outcome.former else "")
    broken = "; ".join(f"{breach['guard']}: {breach['message']}" for breach in outcome.breaches)
    moved = displacement_in_edges(outcome)
    words = [f"{outcome.seconds:.2f} s"]
    if moved is not None:
        words.append(f"moved by {moved:.2g} edges")
    if outcome.warnings:
        words.append(counted_warnings(outcome))
    return f"{scan.label}: {', '.join(words)}" + (f", written although {broken}" if broken else "")


def counted_warnings(outcome: Outcome) -> str:
    """The number of warnings of a scan, in words."""
    return "1 warning" if len(outcome.warnings) == 1 else f"{len(outcome.warnings)} warnings"


def batch_progress() -> BatchLines:
    """A bar if stderr is a terminal, else lines, which `say` prints."""
    return BatchBar() if sys.stderr.isatty() and talk() == Talk.USUAL else BatchLines()
