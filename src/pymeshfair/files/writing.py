"""The one way to write files: rules for replacing them, and files that appear whole or not at all.

Nothing that exists is replaced unless that was asked for, and links, folders, pipes and devices not even then. One file is
written by `write_file`: a temporary file beside it, flushed to the disk, and renamed. The files of a run are written to a hidden
folder beside the output (`staging`) and put in place by `place`, all or none.
"""

import contextlib
import os
import secrets
import shutil
import stat
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..operating_system import this_system
from .errors import OutputError
from .formats import extension, listed
from .staging import staging_folder

#: bytes of a name, as usual file systems have it
LONGEST_NAME = 255
#: the advice about a file that is not replaced
OVERWRITE = "name another output, or ask to overwrite"
_KINDS = (
    (stat.S_ISLNK, "a link: name the file itself that it leads to"),
    (stat.S_ISDIR, "a folder: name a file"),
    (stat.S_ISFIFO, "a pipe, and a file would take its place: name another one"),
)


# ------------------------------------------------------------------------------------------------------------------- checks


def check_place(path: Path) -> bool:
    """Whether there is a regular file; refuse a place where no file can be put."""
    folder = path.parent
    try:
        if not folder.is_dir():
            why = "is no folder" if os.path.lexists(folder) else "does not exist; make it first"
            raise OutputError(path, f"the folder {folder} {why}")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(path, f"the folder {folder} cannot be written to (permissions, or a read-only disk)")
        if (length := len(os.fsencode(path.name))) > LONGEST_NAME:
            raise OutputError(path, f"its name has {length} bytes, and {LONGEST_NAME} are the most; shorten it")
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return False
    except OSError as error:
        raise OutputError(path, _words(error)) from error
    if not stat.S_ISREG(mode):
        what = next((words for is_it, words in _KINDS if is_it(mode)), "a device or a socket: name a file")
        raise OutputError(path, f"there is {what}")
    return True


def check_target(path: Path, kinds: Collection[str], *, overwrite: bool) -> None:
    """Refuse an extension that is none of `kinds`, a place where no file can be put, and without `overwrite` an existing file."""
    check_kind(path, kinds)
    _check_free(path, overwrite=overwrite)


def _check_free(path: Path, *, overwrite: bool) -> None:
    if check_place(path) and not overwrite:
        raise OutputError(path, f"it exists; {OVERWRITE}")


def check_kind(path: Path, kinds: Collection[str]) -> None:
    """Refuse a file with another extension than these."""
    if extension(path) not in kinds:
        what = f"{path.suffix!r} is no format for it" if path.suffix else "it has no extension that says the format"
        raise OutputError(path, f"{what}; name a file that ends with {listed(tuple(kinds))}")


# ------------------------------------------------------------------------------------------------------------------ writing


def write_file(path: Path, data: bytes, *, overwrite: bool) -> None:
    """Write one file, which appears whole or not at all.

    Raises:
        OutputError: it cannot or must not be written; a former file is still there.
    """
    _check_free(path, overwrite=overwrite)
    made = path.with_name(f".pymeshfair-{secrets.token_hex(8)}")
    try:
        try:
            _write_whole(made, data)
            made.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                made.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise OutputError(path, _words(error)) from error


def _write_whole(path: Path, data: bytes) -> None:
    """Write a new file and wait until the disk has it."""
    with path.open("xb") as file:
        file.write(data)
        to_disk(file)


def to_disk(file: BinaryIO) -> None:
    """Wait until the disk has the contents of a file."""
    file.flush()
    os.fsync(file.fileno())


@dataclass(frozen=True)
class StagedFile:
    """A finished file in a staging folder, and where it belongs."""

    staged: Path
    target: Path


def stage_file(staged: Path, target: Path, data: bytes) -> StagedFile:
    """Write a file into a staging folder."""
    try:
        _write_whole(staged, data)
    except OSError as error:
        raise OutputError(target, _words(error)) from error
    return StagedFile(staged, target)


def place(files: Sequence[StagedFile], stage: Path, *, outdated: Path | None = None) -> None:
    """Put all files in place in their order, or none; `outdated` is removed before.

    A rename works within a file system alone; so files for other folders than that of the staging folder are first brought into
    a staging folder there. Replaced files are kept in the staging folder until all is done.

    Raises:
        OutputError: one could not be put in place; the former files are there again.
    """
    done: list[tuple[Path, Path | None]] = []
    stages, target = {stage.parent: stage}, files[0].target if files else stage
    with contextlib.ExitStack() as opened:
        try:
            ready = []
            for number, file in enumerate(files):
                target, folder = file.target, file.target.parent
                if folder not in stages:
                    stages[folder] = opened.enter_context(staging_folder(target))
                near = file.staged
                if stages[folder] != stage:
                    near = stages[folder] / "new" / str(number)
                    shutil.move(file.staged, near)
                    this_system().flush(near)
                ready.append((near, target, stages[folder] / "old" / str(number)))
            if outdated is not None:
                done.append((outdated, _kept(outdated, stage / "old" / "outdated")))
                outdated.unlink(missing_ok=True)
            for near, target, backup in ready:
                done.append((target, _kept(target, backup)))
                near.replace(target)
            for folder in stages:
                this_system().flush(folder)
        except BaseException as error:
            for path, former in reversed(done):
                with contextlib.suppress(OSError):
                    if former is None:
                        path.unlink(missing_ok=True)
                    else:
                        former.replace(path)
            if isinstance(error, OSError):
                raise OutputError(target, f"cannot put it in place: {_words(error)}") from error
            raise


def _kept(target: Path, backup: Path) -> Path | None:
    """A second name for the file at `target`, so that it can be put back; None if there is none."""
    if not os.path.lexists(target):
        return None
    try:
        os.link(target, backup, follow_symlinks=False)
    except (OSError, NotImplementedError):  # a file system without hard links
        shutil.copy2(target, backup, follow_symlinks=False)
    return backup


def _words(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
