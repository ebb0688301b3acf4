"""Runs a batch: submits scans to workers, writes their outcomes to the journal and calls a listener."""

import os
import secrets
import signal
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Protocol

from ..processes.cluster import LostSchedulerError, Scheduler
from ..processes.pool import Pool
from ..processes.process import Items
from ..running.interrupts import Interrupted, Interrupts
from ..running.job import Job
from .journal import Journal
from .outcome import Outcome
from .plan import Scan
from .station import ThisMachine, Workers, pool_of

#: seconds between checks of the workers
_PULSE = 1.0


class Listener(Protocol):
    """Called on the events of a batch, in the thread that runs it. An exception of a method ends the batch."""

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended; its outcome is in the journal."""

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        """A page was drawn: the result of `pymeshfair.batch.drawing.draw`, or ``"problem"`` with the reason of a failure."""

    def note(self, text: str) -> None:
        """A message about the workers for the user."""


def carry_out(
    scans: Sequence[Scan],
    template: Job,
    journal: Journal,
    folder: Path,
    *,
    scheduler: Scheduler | None,
    jobs: int,
    pool: Pool | None = None,
    stop: bool,
    pages: bool,
    listener: Listener,
    done: Sequence[Scan] = (),
) -> None:
    """Clean scans, report each outcome once it is in the journal, and draw pages of the cleaned scans.

    Raises:
        ClusterError: no scheduler or no workers; a worker with other versions or without the files; the scheduler stopped.
        BatchError: the journal cannot be written.
        KeyboardInterrupt: Ctrl-C, within a second; a second one ends the process at once.
    """
    items: Items = SimpleQueue()
    with ExitStack() as opened:
        if scheduler is None:
            workers: Workers = opened.enter_context(ThisMachine(template, folder, jobs, items, pool or pool_of(jobs)))
        else:
            from .cluster import workers_of_scheduler

            name = f"pymeshfair-batch-{secrets.token_hex(8)}"
            workers = opened.enter_context(workers_of_scheduler(scheduler, template, scans or done, folder, items, name))
        opened.enter_context(Interrupts(items))
        _Course(workers, journal, items, listener, stop=stop, pages=pages).run(scans, done)


@dataclass
class _Course:
    """The event loop of one batch."""

    workers: Workers
    journal: Journal
    items: Items
    listener: Listener
    stop: bool  # after the first scan that fails
    pages: bool  # whether to draw them
    left: int = 0  # tasks that have not ended

    def run(self, scans: Sequence[Scan], done: Sequence[Scan]) -> None:
        self.left = len(scans) + (len(done) if self.pages else 0)
        for scan in scans:
            self.workers.submit("clean", scan)
        for scan in done if self.pages else ():
            self.workers.submit("draw", scan)
        try:
            while self.left:
                self._next()
        except BaseException:
            self.workers.give_up()
            raise

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
        if kind == "draw":
            self.listener.page(scan, _page(result))
        else:
            self._take(scan, result)

    def _take(self, scan: Scan, result: Callable[[], Outcome]) -> None:
        """Record the outcome of a scan that has ended."""
        try:
            outcome = result()
        except LostSchedulerError:
            raise
        except Exception as error:
            outcome = Outcome.of_error(scan.input, scan.output, error, 0.0, "")
        self.journal.append(outcome)
        self.listener.outcome(scan, outcome)
        if outcome.status != "done" and self.stop:
            self.workers.give_up()
            self.left = 0
        elif outcome.status != "failed" and self.pages:
            self.workers.submit("draw", scan)
            self.left += 1


def _page(result: Callable[[], Mapping[str, Any]]) -> Mapping[str, Any]:
    """The result of drawing a page, or the problem."""
    try:
        return result()
    except LostSchedulerError:
        raise
    except Exception as error:
        return {"problem": f"its worker was lost: {error}"}
