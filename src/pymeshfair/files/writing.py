"""Checks which files may be replaced, and puts new files in place whole or not at all.

A run replaces a file on request, or if it is unchanged since a run with the same input, recipe, layers and unit wrote it.
A link, folder, pipe or device is never replaced. A run writes its files to a hidden staging folder; `place` moves all or none.
A power failure or a killed process may leave a staging folder behind. The next run that writes beside the folder removes it if
no process holds the lock in the folder. On a system without locks users remove such folders.
The folder of a run by tiles may hold hours of work, so only a run by tiles to the same output, or `doctor`, removes it.
"""

import contextlib
import hashlib
import json
import os
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..operating_system import this_system
from .errors import OutputBusyError, OutputError, reason_of
from .formats import extension, listed

_LONGEST_NAME = 255  # bytes
OVERWRITE = "name another output, or ask to overwrite"
_KINDS = (
    (stat.S_ISLNK, "a link: name the file itself that it leads to"),
    (stat.S_ISDIR, "a folder: name a file"),
    (stat.S_ISFIFO, "a pipe, which a file would replace: name a file"),
)
#: name prefixes of lock files, of staging folders and of folders of runs by tiles; name suffix of a folder under removal
_LOCK_PREFIX, STAGE_PREFIX, WORK_PREFIX, _GONE = ".pymeshfair-lock-", ".pymeshfair-run-", ".pymeshfair-tiles-", "-gone"
_LOCK = "lock"  # the lock file in a staging folder, and in the folder of a run by tiles
_MOVES = "moves"  # the list of moves in a staging folder
_GRACE = 3600.0  # seconds until a folder without a lock file counts as abandoned; before, it may be in creation or removal


def check_place(path: Path, *, makes_folder: bool = False) -> bool:
    """Returns whether the path is a regular file; refuses a path where no file can be put.

    With `makes_folder`, the caller will make missing folders, so only the nearest existing folder above the path is checked.
    """
    folder = next(filter(os.path.lexists, path.parents), path.parent) if makes_folder else path.parent
    try:
        if not folder.is_dir():
            why = "is no folder" if os.path.lexists(folder) else "does not exist; make it first"
            raise OutputError(path, f"the folder {folder} {why}")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(path, f"the folder {folder} cannot be written to (permissions, or a read-only disk)")
        if (length := len(os.fsencode(path.name))) > _LONGEST_NAME:
            raise OutputError(path, f"its name has {length} bytes, and {_LONGEST_NAME} are the most; shorten it")
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return False
    except OSError as error:
        raise OutputError(path, reason_of(error)) from error
    if not stat.S_ISREG(mode):
        what = next((words for is_it, words in _KINDS if is_it(mode)), "a device or a socket: name a file")
        raise OutputError(path, f"there is {what}")
    return True


def check_target(path: Path, kinds: Collection[str], *, overwrite: bool) -> None:
    """As `check_kind`; also refuses a path where no file can be put, and without `overwrite` an existing file."""
    check_kind(path, kinds)
    _check_free(path, overwrite=overwrite)


def _check_free(path: Path, *, overwrite: bool) -> None:
    if check_place(path) and not overwrite:
        undo_killed(path.parent)
        if check_place(path):
            raise OutputError(path, f"it exists; {OVERWRITE}")


def check_kind(path: Path, kinds: Collection[str]) -> None:
    """Refuses a file whose extension is none of `kinds`."""
    if extension(path) not in kinds:
        what = f"{path.suffix!r} is no format for it" if path.suffix else "it has no extension that says the format"
        raise OutputError(path, f"{what}; name a file that ends with {listed(tuple(kinds))}")


@contextlib.contextmanager
def output_lock(output: Path) -> Iterator[None]:
    """Locks an output for writing, if the file system has locks; raises `OutputBusyError` if another run has locked it."""
    path = output.with_name(_LOCK_PREFIX + mark(output))
    with _locked(path, output):
        for folder in output.parent.glob(f"{STAGE_PREFIX}{mark(output)}-*"):
            if not (folder / _LOCK).exists():  # a run died before it locked its folder
                remove_folder(folder)
        try:
            yield
        finally:
            # Removed before the lock is released: later the file may belong to another run.
            with contextlib.suppress(OSError):
                path.unlink()


def mark(output: Path) -> str:
    """Returns what the names of the lock and the hidden folders of an output have in common."""
    return hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16]


def _locked(path: Path, output: Path) -> BinaryIO:
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


@contextlib.contextmanager
def staging_folder(output: Path) -> Iterator[Path]:
    """Removes abandoned staging folders beside `output`, and makes one with empty ``new`` and ``old``, removed at the end."""
    for folder in abandoned_folders(output.parent):
        if not folder.name.startswith(WORK_PREFIX):
            remove_folder(folder)
    stage: Path | None = None
    try:
        with contextlib.ExitStack() as opened:
            try:
                stage = Path(tempfile.mkdtemp(prefix=f"{STAGE_PREFIX}{mark(output)}-", dir=output.parent))
                opened.enter_context(in_use(stage))
                (stage / "new").mkdir()
                (stage / "old").mkdir()
            except OSError as error:
                raise OutputError(output, f"cannot make a temporary folder beside it: {error.strerror or error}") from error
            yield stage
    finally:
        if stage is not None:
            remove_folder(stage)


@contextlib.contextmanager
def in_use(folder: Path) -> Iterator[None]:
    """Holds a lock in a folder, so that the folder does not count as abandoned."""
    system = this_system()
    # The file gets its final name once it is locked, so that no other run sees an unlocked lock file.
    with (folder / f"{_LOCK}.new").open("wb") as lock:
        system.try_lock(lock, alone=False)
        system.move_open_file(Path(lock.name), folder / _LOCK)
        yield


def remove_folder(folder: Path) -> None:
    """Removes a staging folder, even while another process still adds files to it; first undoes moves that did not end."""
    undo(folder)
    gone = folder if folder.name.endswith(_GONE) else folder.with_name(f"{folder.name}{_GONE}")
    with contextlib.suppress(OSError):
        folder.replace(gone)
    for path in dict.fromkeys((folder, gone)):  # an earlier removal may have stopped half way
        shutil.rmtree(path, ignore_errors=True)


def clear_up(stage: Path, output: Path) -> None:
    """Removes the staging folder and the lock file of a process that ended without removing them."""
    remove_folder(stage)
    for _ in range(20):  # a process that ends may close its pipes a moment before it releases its locks
        try:
            with output_lock(output):
                return
        except OutputBusyError:  # noqa: PERF203
            time.sleep(0.05)
        except OutputError:
            return


def abandoned_folders(parent: Path) -> list[Path]:
    """Returns the folders of runs in `parent` that no process uses."""
    with contextlib.suppress(OSError):
        return [f for f in sorted(parent.iterdir()) if f.name.startswith((STAGE_PREFIX, WORK_PREFIX)) and _is_abandoned(f)]
    return []


def _is_abandoned(folder: Path) -> bool:
    if folder.name.endswith(_GONE):
        return True
    with contextlib.suppress(OSError):
        try:
            with (folder / _LOCK).open("rb") as lock:
                return this_system().try_lock(lock, alone=True) is True
        except FileNotFoundError:
            return time.time() - folder.stat().st_mtime > _GRACE
    return False


def write_file(path: Path, data: bytes, *, overwrite: bool) -> None:
    """Writes one file whole or not at all; if this fails, a former file stays."""
    _check_free(path, overwrite=overwrite)
    temporary = path.with_name(f".pymeshfair-{secrets.token_hex(8)}")
    try:
        _write_whole(temporary, data)
        temporary.replace(path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OutputError(path, reason_of(error)) from error
        raise


def _write_whole(path: Path, data: bytes) -> None:
    with path.open("xb") as file:
        file.write(data)
        to_disk(file)


def to_disk(file: BinaryIO) -> None:
    """Flushes a file, and waits until the disk has its contents."""
    file.flush()
    os.fsync(file.fileno())


@dataclass(frozen=True)
class StagedFile:
    """A finished file in a staging folder."""

    staged: Path
    target: Path


def stage_file(staged: Path, target: Path, data: bytes) -> StagedFile:
    """Writes a file into a staging folder."""
    try:
        _write_whole(staged, data)
    except OSError as error:
        raise OutputError(target, reason_of(error)) from error
    return StagedFile(staged, target)


def place(files: Sequence[StagedFile], stage: Path, *, outdated: Sequence[Path] = ()) -> None:
    """Puts the files in place, one after the other; if one fails, restores all former files. `outdated` files are removed first.

    A rename works only within a file system, so files for another folder first move to a staging folder there.
    """
    moves, ready = list[tuple[str, str, int | None]](), list[tuple[Path | None, Path]]()  # `moves`: see `undo`
    stages, target = {stage.parent: stage}, files[0].target if files else stage
    with contextlib.ExitStack() as opened:
        try:
            for near, target in (*((None, path) for path in outdated), *((file.staged, file.target) for file in files)):
                if target.parent not in stages:
                    stages[target.parent] = opened.enter_context(staging_folder(target))
                folder, number = stages[target.parent], str(len(moves))
                if near is not None and folder != stage:
                    near = Path(shutil.move(near, folder / "new" / number))
                    this_system().flush(near)
                _keep(target, folder / "old" / number)
                moves.append((str(folder), target.name, None if near is None else near.lstat().st_ino))
                ready.append((near, target))
            for folder in stages.values():
                _write_whole(folder / _MOVES, json.dumps(moves).encode())
            for near, target in ready:
                if near is None:
                    target.unlink(missing_ok=True)
                else:
                    near.replace(target)
            for folder in stages:
                this_system().flush(folder)
            for folder in stages.values():
                (folder / _MOVES).unlink()
        except BaseException as error:
            undo(stage)
            if isinstance(error, OSError):
                raise OutputError(target, f"cannot put it in place: {reason_of(error)}") from error
            raise


def undo(stage: Path) -> bool:
    """Restores the files as they were before a `place` that did not end; returns whether there was one.

    `place` lists all its moves in each of its staging folders: the staging folder beside the target, the name of the target,
    and the inode number of the new file, or None for an outdated file. A file that another program has put there since stays.
    """
    try:
        listed_moves = json.loads((stage / _MOVES).read_bytes())
        moves = [(Path(folder), Path(folder).with_name(name), number) for folder, name, number in listed_moves]
        for k, (folder, target, number) in reversed([*enumerate(moves)]):
            # Only beside a staging folder, so that the list in a foreign archive reaches no other files.
            is_stage = folder == stage or (folder.name.startswith(STAGE_PREFIX) and folder.is_dir())
            former = folder / "old" / str(k)
            with contextlib.suppress(OSError):
                if not is_stage or (target.lstat().st_ino if os.path.lexists(target) else None) != number:
                    continue
                if os.path.lexists(former):
                    former.replace(target)
                else:
                    target.unlink(missing_ok=True)
        (stage / _MOVES).unlink()
    except (OSError, TypeError, ValueError):
        return False
    return True


def undo_killed(parent: Path) -> bool:
    """Undoes the moves of killed runs in a folder; returns whether there were any."""
    return sum(map(undo, abandoned_folders(parent))) > 0  # all of them: `any` would end at the first


def _keep(target: Path, backup: Path) -> None:
    if not os.path.lexists(target):
        return
    try:
        os.link(target, backup, follow_symlinks=False)
    except (OSError, NotImplementedError):  # a file system without hard links
        shutil.copy2(target, backup, follow_symlinks=False)
