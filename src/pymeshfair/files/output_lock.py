"""One run at a time to one output: two at once would both end well, and the result of one be gone."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from ..operating_system import this_system
from .errors import OutputBusyError, OutputError

#: what the name of the file begins with that is locked; it lies beside the output while a run goes on
LOCK_PREFIX = ".pymeshfair-lock-"


@contextlib.contextmanager
def output_lock(output: Path) -> Iterator[None]:
    """Hold the right to write an output. A process that dies loses it; the file that it leaves is used and removed by the next.

    Where there are no locks of files, nothing is held.

    Raises:
        OutputBusyError: another run holds it.
    """
    path = output.with_name(LOCK_PREFIX + hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16])
    with _taken(path, output):
        try:
            yield
        finally:
            # While the lock is held: the new file of another run is not removed.
            with contextlib.suppress(OSError):
                path.unlink()


def _taken(path: Path, output: Path) -> BinaryIO:
    """The open file that holds the lock."""
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
        file.close()  # its name was removed by the run that had it, between our opening and our locking
