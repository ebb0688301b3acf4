"""A batch from its plan to its summary."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from ..processes.cluster import Scheduler
from ..processes.pool import Pool
from ..running.job import Job
from .checks import Prospect, check_own_files, look_ahead
from .engine import Listener, carry_out
from .journal import NAME, BatchError, Journal, read_journal
from .outcome import Outcome, now
from .page import write_page
from .plan import Scan
from .resume import Done, done_before, rename_outputs
from .sample import sample
from .station import pool_of
from .summary import Summary


class Audience(Listener, Protocol):
    """Who is told how a batch goes, from its beginning."""

    def begin(self, total: int) -> None:
        """So many scans are to do."""


class _Record:
    """Keeps what came of scans, and passes on what is told."""

    def __init__(self, audience: Audience, outcomes: Mapping[int, Outcome]) -> None:
        self._audience = audience
        self.outcomes = dict(outcomes)
        self.pages: dict[int, Mapping[str, Any]] = {}

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        self.outcomes[scan.number] = outcome
        self._audience.outcome(scan, outcome)

    def page(self, scan: Scan, made: Mapping[str, Any]) -> None:
        self.pages[scan.number] = made
        self._audience.page(scan, made)

    def note(self, text: str) -> None:
        self._audience.note(text)


class Task:
    """One batch.

    Attributes:
        scans: all of them.
        template: of their runs: what all scans share.
        folder: where outputs go.
        written: the files about the batch as a whole, once they are there.
    """

    def __init__(
        self,
        scans: Sequence[Scan],
        template: Job,
        folder: Path,
        scheduler: Scheduler | None,
        jobs: int,
        *,
        resume: bool = False,
        stop: bool = False,
        sample: int | None = None,
        report: bool = False,
        renumber: bool = False,
    ) -> None:
        """Plan it.

        Args:
            scans: all of them.
            template: of their runs: what all scans share.
            folder: where outputs go, an absolute path; made if need be.
            scheduler: of dask; None for this machine.
            jobs: scans at a time on this machine.
            resume: skip what is done.
            stop: give up after the first scan that fails.
            sample: do only so many, spread by size and noise.
            report: make a page of every scan that is done, and one of the batch.
            renumber: with `resume`, rename outputs whose numbers in the names have changed.
        """
        self.scans = scans
        self.template = template
        self.folder = folder
        self.written: tuple[Path, ...] = ()
        self._scheduler = scheduler
        self._jobs = jobs
        self._resume = resume
        self._stop = stop
        self._sample = sample
        self._report = report
        self._renumber = renumber and resume

    def look_ahead(self) -> Prospect:
        """What would be done; nothing is written.

        Raises:
            ScriptError, InputError: see `pymeshfair.batch.checks.look_ahead`.
            OutputError: see `pymeshfair.batch.checks.check_own_files`.
        """
        if self.folder.is_dir():
            check_own_files(self.folder, self.template, report=self._report)
        done = self._done(read_journal(self.folder / NAME))
        return look_ahead(self.scans, self.template, self.folder, done)

    def _done(self, journal: Mapping[str, Outcome]) -> dict[int, Done]:
        return done_before(self.scans, self.template, journal, renumber=self._renumber) if self._resume else {}

    @contextmanager
    def processes(self) -> Iterator[Pool | None]:
        """Processes of this machine for `carry_out`, which are started as soon as the context is entered."""
        if self._scheduler is not None:
            yield None
            return
        with pool_of(min(self._jobs, len(self.scans))) as pool:
            pool.prepare()
            yield pool

    def carry_out(self, audience: Audience, pool: Pool | None = None) -> Summary:
        """Do it, and write ``batch.json`` and ``batch.csv``, also if it is interrupted, and ``batch.html`` if a report is wanted.

        Args:
            audience: who is told.
            pool: see `processes`.

        Raises:
            ScriptError, InputError: see `pymeshfair.batch.checks.look_ahead`.
            OutputError: see `pymeshfair.batch.checks.check_own_files`; or a file cannot be written.
            BatchError, KeyboardInterrupt: see `pymeshfair.batch.engine.carry_out`.
        """
        started, clock = now(), time.monotonic()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BatchError(f"cannot make the folder {self.folder}: {error.strerror or error}") from error
        check_own_files(self.folder, self.template, report=self._report)
        with Journal(self.folder, resume=self._resume) as journal:
            done = self._done(journal.before)
            if self._renumber:
                rename_outputs(self.scans, done, journal)
            if journal.before and not self._resume:
                audience.note(
                    f"the journal of {len(journal.before):,} scans in {self.folder} begins anew; --resume would go on with it"
                )
            if look_ahead(self.scans, self.template, self.folder, done).lacks_room:
                audience.note(f"the disk of {self.folder} may be too small: outputs may need twice the size of the inputs")
            todo = [scan for scan in self.scans if scan.number not in done]
            if self._sample is not None:
                todo = sample(todo, self._sample)
            audience.begin(len(todo))
            record = _Record(audience, {number: one.outcome for number, one in done.items()})
            drawn = [scan for scan in self.scans if scan.number in done and self._report]
            try:
                if todo or drawn:
                    carry_out(
                        todo,
                        self.template,
                        journal,
                        self.folder,
                        scheduler=self._scheduler,
                        jobs=min(self._jobs, len(todo) or len(drawn)),
                        pool=pool,
                        stop=self._stop,
                        pages=self._report,
                        listener=record,
                        done=drawn,
                    )
            finally:
                if record.outcomes:  # else nothing was begun, and what is known of a former batch stays
                    outcomes = [record.outcomes[scan.number] for scan in self.scans if scan.number in record.outcomes]
                    finished, seconds = now(), time.monotonic() - clock
                    summary = Summary.of(
                        outcomes, len(self.scans), self.template, started=started, finished=finished, seconds=seconds
                    )
                    self.written = (*summary.write(self.folder), journal.path)
            if self._report:
                made = {str(scan.output): record.pages.get(scan.number, {}) for scan in self.scans}
                self.written += (write_page(self.folder, summary, made),)
        return summary
