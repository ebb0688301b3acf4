"""A lock per output: of two simultaneous runs one would silently replace the result of the other."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from ..operating_system import this_system
from .errors import OutputBusyError, OutputError

#: prefix of the lock file's name; it lies beside the output during a run
LOCK_PREFIX = ".pymeshfair-lock-"


@contextlib.contextmanager
def output_lock(output: Path) -> Iterator[None]:
    """Lock an output for writing. If a process dies, its lock is released; the next run reuses and removes its lock file.

    On file systems without locks nothing is locked.

    Raises:
        OutputBusyError: another run has locked it.
        OutputError: the lock file cannot be made.
    """
    path = output.with_name(LOCK_PREFIX + hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16])
    with _locked(path, output):
        try:
            yield
        finally:
            # Before the lock is released, so that the lock file of another run is not removed.
            with contextlib.suppress(OSError):
                path.unlink()


def _locked(path: Path, output: Path) -> BinaryIO:
    """The open and locked file."""
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)
        except OSError as error:
            raise OutputError(output, f"cannot make a file beside it: {error.strerror or error}") from error
        file = os.fdopen(descriptor, "r+b")
        if this_system().claim(file) is False:
            file.close()
            raise OutputBusyError(output, "another run is writing it at this moment; wait for that, or name another output")
        with contextlib.suppress(OSError):
            if os.path.samestat(os.fstat(descriptor), path.lstat()):
                return file
        file.close()  # the former run has removed the file between our opening and locking it
