"""The event loop of a batch: submits scans to workers, writes their outcomes to the journal and calls a listener."""

import os
import signal
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from queue import Empty
from typing import Any, Protocol

from ..processes.cluster import LostSchedulerError
from ..processes.process import Items
from ..running.interrupts import Interrupted
from .journal import Journal, Outcome
from .plan import Scan
from .station import Kind, Workers

#: seconds between checks of the workers
_PULSE = 1.0


class Listener(Protocol):
    """Called on the events of a batch, in the thread that runs it. An exception of a method ends the batch."""

    def begin(self, total: int) -> None:
        """So many scans are to do."""

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended; its outcome is in the journal."""

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        """A page was drawn: the result of `pymeshfair.batch.drawing.draw`, or ``"problem"`` with the reason of a failure."""

    def note(self, text: str) -> None:
        """A message about the workers for the user."""


@dataclass
class Course:
    """Cleans scans, reports each outcome once it is in the journal, and draws pages of the cleaned scans."""

    workers: Workers
    journal: Journal
    items: Items
    listener: Listener
    outcomes: dict[int, Outcome]  # takes those of the scans by their numbers
    pages: dict[int, Mapping[str, Any]] | None  # takes the drawn pages; None draws none
    stop: bool  # after the first scan that fails
    left: int = 0  # tasks that have not ended

    def run(self, scans: Sequence[Scan], drawn: Sequence[Scan]) -> None:
        """Clean the scans, and draw the pages of others that are done.

        Raises:
            ClusterError: a worker was lost, or the scheduler stopped.
            BatchError: the journal cannot be written.
            KeyboardInterrupt: Ctrl-C, within a second; a second one ends the process at once.
        """
        for scan in scans:
            self.submit("clean", scan)
        for scan in drawn:
            self.submit("draw", scan)
        try:
            while self.left:
                self._next()
        except BaseException:
            self.workers.give_up()
            raise

    def submit(self, kind: Kind, scan: Scan) -> None:
        """Let the workers do a task."""
        self.workers.submit(kind, scan)
        self.left += 1

    def _next(self) -> None:
        try:
            kind, item = self.items.get(timeout=_PULSE)
        except Empty:
            if note := self.workers.look():
                self.listener.note(note)
            return
        if kind == "signal":
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))
            raise Interrupted
        self.left -= 1
        scan, result = item
        try:
            made = result()
        except LostSchedulerError:
            raise
        except Exception as error:
            lost = {"problem": f"its worker was lost: {error}"}
            made = lost if kind == "draw" else Outcome.of_error(scan.input, scan.output, error, 0.0, "")
        if kind == "clean":
            self._take(scan, made)
        elif self.pages is not None:
            self.pages[scan.number] = made
            self.listener.page(scan, made)

    def _take(self, scan: Scan, outcome: Outcome) -> None:
        """Record the outcome of a scan that has ended."""
        self.journal.append(outcome)
        self.outcomes[scan.number] = outcome
        self.listener.outcome(scan, outcome)
        if outcome.status != "done" and self.stop:
            self.workers.give_up()
            self.left = 0
        elif outcome.status != "failed" and self.pages is not None:
            self.submit("draw", scan)
