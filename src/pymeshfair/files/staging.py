"""The hidden folder beside an output in which it is written: on the same file system, so that a rename puts it in place.

It is removed with the run. One that was left behind, because the power failed or everything was killed at once, is removed by the
next run in the same folder: a process that works in it holds a lock, and a dead one holds none. On a system without such locks it
stays until a user removes it. The folder of a run by tiles may hold hours of work: it stays until that run goes on, or a user
removes it.

The output is locked meanwhile: of two simultaneous runs one would silently replace the result of the other.
"""

import contextlib
import hashlib
import os
import shutil
import tempfile
import time
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
    path = output.with_name(LOCK_PREFIX + _mark(output))
    with _locked(path, output):
        for folder in output.parent.glob(f"{STAGE_PREFIX}{_mark(output)}-*"):
            if not (folder / _LOCK).exists():  # of a run that died before it locked the folder that it had just made
                remove_folder(folder)
        try:
            yield
        finally:
            # Before the lock is released, so that the lock file of another run is not removed.
            with contextlib.suppress(OSError):
                path.unlink()


def _mark(output: Path) -> str:
    return hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16]


def _locked(path: Path, output: Path) -> BinaryIO:
    """The open and locked file."""
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)
        except OSError as error:
            raise OutputError(output, f"cannot make a file beside it: {error.strerror or error}") from error
        file = os.fdopen(descriptor, "r+b")
        if this_system().try_lock(file, alone=True) is False:
            file.close()
            raise OutputBusyError(output, "another run is writing it at this moment; wait for that, or name another output")
        with contextlib.suppress(OSError):
            if os.path.samestat(os.fstat(descriptor), path.lstat()):
                return file
        file.close()  # the former run has removed the file between our opening and locking it


#: the start of the folder's name
STAGE_PREFIX = ".pymeshfair-run-"
#: the same for a run by tiles
WORK_PREFIX = ".pymeshfair-tiles-"
_LOCK = "lock"
#: the end of the name of a folder that is being removed
_GONE = "-gone"
#: seconds after which a folder without a lock file counts as abandoned; a younger one may just be being made or removed
_GRACE = 3600.0


@contextlib.contextmanager
def staging_folder(output: Path) -> Iterator[Path]:
    """A new folder beside `output` with the empty folders ``new`` and ``old``; it is gone afterwards with all that is in it."""
    for folder in abandoned_folders(output.parent):
        if not folder.name.startswith(WORK_PREFIX):
            remove_folder(folder)
    stage: Path | None = None
    try:
        with contextlib.ExitStack() as opened:
            try:
                stage = Path(tempfile.mkdtemp(prefix=f"{STAGE_PREFIX}{_mark(output)}-", dir=output.parent))
                opened.enter_context(in_use(stage))
                for name in ("new", "old"):
                    (stage / name).mkdir()
            except OSError as error:
                raise OutputError(output, f"cannot make a temporary folder beside it: {error.strerror or error}") from error
            yield stage
    finally:
        if stage is not None:
            remove_folder(stage)


@contextlib.contextmanager
def in_use(folder: Path) -> Iterator[None]:
    """Hold a lock in a folder, so that it does not count as abandoned."""
    system = this_system()
    # The file gets its final name once it is locked, so that no other run sees an unlocked one.
    with (folder / f"{_LOCK}.new").open("wb") as lock:
        system.try_lock(lock, alone=False)
        system.move_open_file(lock, Path(lock.name), folder / _LOCK)
        yield


def remove_folder(folder: Path) -> None:
    """Remove a staging folder, even while something still wants to put files into it."""
    gone = folder if folder.name.endswith(_GONE) else folder.with_name(f"{folder.name}{_GONE}")
    with contextlib.suppress(OSError):
        folder.replace(gone)
    for path in dict.fromkeys((folder, gone)):  # the process that began may have died in between
        shutil.rmtree(path, ignore_errors=True)


def clear_up(stage: Path, output: Path) -> None:
    """Remove the staging folder, and the file that was locked, of a process that ended before it could."""
    remove_folder(stage)
    for _ in range(20):  # it may lose its pipes a moment before its locks
        try:
            with output_lock(output):
                return
        except OutputBusyError:  # noqa: PERF203
            time.sleep(0.05)
        except OutputError:
            return


def abandoned_folders(parent: Path) -> list[Path]:
    """The folders of runs in `parent` that no process uses any more."""
    abandoned = []
    with contextlib.suppress(OSError):
        for folder in sorted(path for prefix in (STAGE_PREFIX, WORK_PREFIX) for path in parent.glob(f"{prefix}*")):
            with contextlib.suppress(OSError):
                if _is_abandoned(folder):
                    abandoned.append(folder)
    return abandoned


def _is_abandoned(folder: Path) -> bool:
    if folder.name.endswith(_GONE):
        return True  # another process may remove it at the same time
    try:
        with (folder / _LOCK).open("rb") as lock:
            return this_system().try_lock(lock, alone=True) is True
    except FileNotFoundError:
        return time.time() - folder.stat().st_mtime > _GRACE
