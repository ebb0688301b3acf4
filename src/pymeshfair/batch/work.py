"""A batch from its plan to its summary."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from .checks import Prospect, look_ahead
from .engine import carry_out
from .errors import BatchError
from .journal import NAME, Journal, read_journal
from .outcome import Outcome, now
from .plan import Scan
from .resume import done_before
from .sample import sample
from .settings import Settings
from .summary import Summary


class Audience(Protocol):
    """Who is told how a batch goes."""

    def begin(self, total: int) -> None:
        """So many scans are to do."""

    def note(self, text: str) -> None:
        """Something about the batch as a whole."""

    def outcome(self, scan: Scan, outcome: Outcome) -> None:
        """A scan has ended."""


class Task:
    """One batch.

    Attributes:
        scans: all of them.
        settings: what they share.
        folder: where outputs go.
        written: the files about the batch as a whole, once they are there.
    """

    def __init__(
        self,
        scans: Sequence[Scan],
        settings: Settings,
        folder: Path,
        address: str | None,
        jobs: int,
        *,
        resume: bool = False,
        stop: bool = False,
        sample: int | None = None,
    ) -> None:
        """Plan it.

        Args:
            scans: all of them.
            settings: what they share.
            folder: where outputs go, an absolute path; made if need be.
            address: of a scheduler of dask; None for this machine.
            jobs: scans at a time on this machine.
            resume: skip what is done.
            stop: give up after the first scan that fails.
            sample: do only so many, spread by size and noise.
        """
        self.scans = scans
        self.settings = settings
        self.folder = folder
        self.written: tuple[Path, ...] = ()
        self._address = address
        self._jobs = jobs
        self._resume = resume
        self._stop = stop
        self._sample = sample

    def look_ahead(self) -> Prospect:
        """What would be done; nothing is written.

        Raises:
            ScriptError, InputError: see `pymeshfair.batch.checks.look_ahead`.
        """
        done = done_before(self.scans, self.settings, read_journal(self.folder / NAME)) if self._resume else {}
        return look_ahead(self.scans, self.settings, self.folder, done)

    def carry_out(self, audience: Audience) -> Summary:
        """Do it, and write ``batch.json`` and ``batch.csv``, also if it is interrupted.

        Raises:
            ScriptError, InputError: see `pymeshfair.batch.checks.look_ahead`.
            BatchError, KeyboardInterrupt: see `pymeshfair.batch.engine.carry_out`.
        """
        started, clock = now(), time.monotonic()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BatchError(f"cannot make the folder {self.folder}: {error.strerror or error}") from error
        with Journal(self.folder, resume=self._resume) as journal:
            done = done_before(self.scans, self.settings, journal.before) if self._resume else {}
            if journal.before and not self._resume:
                audience.note(
                    f"the journal of {len(journal.before):,} scans in {self.folder} begins anew; --resume would go on with it"
                )
            if look_ahead(self.scans, self.settings, self.folder, done).lacks_room:
                audience.note(f"the disk of {self.folder} may be too small: outputs may need twice the size of the inputs")
            todo = [scan for scan in self.scans if scan.number not in done]
            if self._sample is not None:
                todo = sample(todo, self._sample)
            audience.begin(len(todo))
            outcomes = dict(done)

            def note(scan: Scan, outcome: Outcome) -> None:
                outcomes[scan.number] = outcome
                audience.outcome(scan, outcome)

            try:
                if todo:
                    carry_out(
                        todo,
                        self.settings,
                        journal,
                        self.folder,
                        address=self._address,
                        jobs=min(self._jobs, len(todo)),
                        stop=self._stop,
                        on_outcome=note,
                        on_note=audience.note,
                    )
            finally:
                ordered = [outcomes[scan.number] for scan in self.scans if scan.number in outcomes]
                seconds = time.monotonic() - clock
                summary = Summary.of(ordered, len(self.scans), self.settings, started=started, finished=now(), seconds=seconds)
                self.written = (*summary.write(self.folder), journal.path)
        return summary
