"""One run at a time to one output: two at once would both end well, and the result of one be gone."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterator
from pathlib import Path

from .errors import OutputError

#: what the name of the file begins with that is locked; it lies beside the output while a run goes on
LOCK_PREFIX = ".pymeshfair-lock-"


@contextlib.contextmanager
def output_lock(output: Path) -> Iterator[None]:
    """Hold the right to write an output. A process that dies loses it; the file that it leaves is used and removed by the next.

    Raises:
        OutputError: another run holds it.
    """
    path = output.with_name(LOCK_PREFIX + hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16])
    descriptor = _taken(path, output)
    try:
        yield
    finally:
        if descriptor is not None:
            # While it is held, so that nobody's new file is removed.
            with contextlib.suppress(OSError):
                path.unlink()
            os.close(descriptor)


def _taken(path: Path, output: Path) -> int | None:
    """The open file that holds the lock, or None where there are no such locks."""
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
        except OSError as error:
            raise OutputError(output, f"cannot make a file beside it: {error.strerror or error}") from error
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            raise OutputError(output, "another run is writing it at this moment; wait for that, or name another output") from None
        except OSError:  # a file system without locks
            os.close(descriptor)
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.lstat()):
                return descriptor
        os.close(descriptor)  # removed by the one who had it, between our opening and our locking
