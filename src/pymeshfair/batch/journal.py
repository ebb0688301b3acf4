"""The journal of a batch: one line of JSON per scan, on the disk before the outcome is reported. A batch resumes from it."""

from __future__ import annotations

import json
import os
from dataclasses import fields
from pathlib import Path

from ..errors import PymeshfairError
from ..operating_system import this_system
from .outcome import Outcome

#: file name of the journal in the folder of outputs
NAME = "batch.jsonl"


class BatchError(PymeshfairError):
    """The batch as a whole has failed; the scans in its journal stay done."""


class Journal:
    """The journal in a folder; a context manager that locks the folder against other batches.

    Attributes:
        path: the file.
        before: the outcomes of earlier batches by output, whether the file keeps them or not.
    """

    def __init__(self, folder: Path, *, resume: bool) -> None:
        """Open and lock the journal in the folder of outputs; without `resume` its lines are deleted when the first scan ends."""
        self.path = folder / NAME
        try:
            self._file = self.path.open("a+b", buffering=0)
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error
        if this_system().try_lock(self._file, alone=True) is False:
            self._file.close()
            raise BatchError(f"another batch is writing to {folder} at this moment; wait for it, or name another folder")
        self._is_old = not resume
        try:
            self.before = read_journal(self.path)
            self._end_torn_line()
        except OSError as error:
            self._file.close()
            raise BatchError(f"cannot read the journal {self.path}: {error.strerror or error}") from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def append(self, outcome: Outcome) -> None:
        """Write one line, and wait until the disk has it."""
        try:
            if self._is_old:
                self._file.truncate(0)
                self._is_old = False
            line = json.dumps(outcome.to_document(), ensure_ascii=False)
            self._file.write(line.encode("utf-8", "surrogateescape") + b"\n")
            os.fsync(self._file.fileno())
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error

    def _end_torn_line(self) -> None:
        """End an incomplete last line, which a killed batch leaves, so that the next line stands by itself."""
        size = self._file.seek(0, os.SEEK_END)
        if size:
            self._file.seek(size - 1)
            if self._file.read(1) != b"\n":
                self._file.write(b"\n")


def read_journal(path: Path) -> dict[str, Outcome]:
    """The last outcome of each output; incomplete lines are skipped, and a missing journal is empty."""
    outcomes: dict[str, Outcome] = {}
    try:
        lines = path.read_bytes().splitlines()
    except FileNotFoundError:
        return outcomes
    for line in lines:
        try:
            document = json.loads(line)
            outcome = Outcome(**{f.name: document[f.name] for f in fields(Outcome) if f.name in document})
        except (ValueError, TypeError, AttributeError):
            continue
        outcomes[outcome.output] = outcome
    return outcomes
