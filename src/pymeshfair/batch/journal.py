"""The journal of a batch: one line of JSON a scan, on the disk before anybody hears of it, from which a batch resumes."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import TracebackType

from ..errors import PymeshfairError
from ..operating_system import this_system
from .outcome import Outcome

#: its name in the folder of outputs
NAME = "batch.jsonl"


class BatchError(PymeshfairError):
    """The batch as a whole cannot be done; what its journal holds stays done."""


class Journal:
    """The journal in a folder; a context manager that keeps other batches out of the folder while it lasts.

    Attributes:
        path: the file.
        before: what it held, by output, whether that is kept or not.
    """

    def __init__(self, folder: Path, *, resume: bool) -> None:
        """Open it.

        Args:
            folder: where the outputs go.
            resume: keep what it holds; else it begins anew with the first scan that ends.

        Raises:
            BatchError: another batch has it, or it cannot be written.
        """
        self.path = folder / NAME
        try:
            self._file = self.path.open("a+b", buffering=0)
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error
        if this_system().claim(self._file) is False:
            self._file.close()
            raise BatchError(f"another batch is writing to {folder} at this moment; wait for it, or name another folder")
        self.before = read_journal(self.path)
        self._is_old = not resume
        self._end_torn_line()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._file.close()

    def append(self, outcome: Outcome) -> None:
        """Write one line, and wait until the disk has it.

        Raises:
            BatchError: the disk is full.
        """
        try:
            if self._is_old:
                self._file.truncate(0)
                self._is_old = False
            self._file.write(outcome.line())
            os.fsync(self._file.fileno())
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error

    def _end_torn_line(self) -> None:
        """A batch that was killed as it wrote leaves half a line, which the next must not be joined to."""
        size = self._file.seek(0, os.SEEK_END)
        if size:
            self._file.seek(size - 1)
            if self._file.read(1) != b"\n":
                self._file.write(b"\n")


def read_journal(path: Path) -> dict[str, Outcome]:
    """The last line about each output; lines that were torn are passed over, and a journal that is not there is empty."""
    found: dict[str, Outcome] = {}
    try:
        lines = path.read_bytes().splitlines()
    except FileNotFoundError:
        return found
    for line in lines:
        try:
            outcome = Outcome.from_document(json.loads(line))
        except (ValueError, TypeError, AttributeError):
            continue
        found[outcome.output] = outcome
    return found
