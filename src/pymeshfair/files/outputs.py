"""Files that appear whole or not at all.

Everything is written to a hidden folder beside the output (`staging`), flushed to the disk, and then renamed into place, in this
order: the old provenance is removed; textures and material files, the output and the new provenance are put in place. Wherever a
power cut stops that, no output is beside the provenance of another one.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..operating_system import this_system
from .errors import OutputError
from .formats import MISSING_LASPY, WRITABLE, extension, listed
from .provenance import provenance_path, read_provenance, recorded_digest, sha256_of

#: bytes of a name, as usual file systems have it
LONGEST_NAME = 255
_OVERWRITE = "name another output, or ask to overwrite"


def material_path(output: Path) -> Path:
    """The material file that MeshLab writes beside an OBJ file."""
    return output.with_name(f"{output.name}.mtl")


def check_output(output: Path, input: Path, *, overwrite: bool, formats: Collection[str] = tuple(WRITABLE)) -> None:
    """Raise if an output cannot or must not be written, before any work is done.

    Without `overwrite` an existing file is replaced only if it is what a former run wrote: its provenance names the same input
    and its digest is the one recorded there. So the same command can be given again, and no other file is lost.

    Args:
        output: the file to write.
        input: the file to read.
        overwrite: whether any file may be replaced.
        formats: the extensions that can be written.

    Raises:
        OutputError: an unknown format, a name that is too long, no such folder, a folder that cannot be written to, a folder in
            the way, the input itself, or a file that must not be replaced.
    """
    folder = output.parent
    if extension(output) not in formats:
        what = f"{output.suffix!r} is no format for it" if output.suffix else "it has no extension that says the format"
        raise OutputError(output, f"{what}; a run writes {listed(tuple(formats))}")
    if output.name.lower().endswith(".copc.laz"):
        raise OutputError(output, "COPC files are read and not written; name the output .laz")
    if extension(output) in ("las", "laz") and find_spec("laspy") is None:
        raise OutputError(output, MISSING_LASPY)
    if not folder.is_dir():
        raise OutputError(output, f"the folder {folder} {'is no folder' if folder.exists() else 'does not exist; make it first'}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(output, f"the folder {folder} cannot be written to (permissions, or a read-only disk)")
    if (length := len(os.fsencode(provenance_path(output).name))) > LONGEST_NAME:
        raise OutputError(
            output, f"its name, with what is written beside it, has {length} bytes, and {LONGEST_NAME} are the most; shorten it"
        )
    files = [output, provenance_path(output), *([material_path(output)] if extension(output) == "obj" else [])]
    for path in files:
        if path.is_dir():
            raise OutputError(path, "there is a folder of that name")
    if overwrite:
        return
    if output.exists() and output.samefile(input):
        raise OutputError(output, f"it is the input; {_OVERWRITE}")
    record = read_provenance(output)
    for path in filter(os.path.lexists, files):
        if reason := _not_ours(path, record, input):
            raise OutputError(path, f"it exists and {reason}; {_OVERWRITE}")


def check_maps(maps: Sequence[Path], output: Path, input: Path, *, overwrite: bool) -> None:
    """Refuse files of an intervention map that cannot or must not be written, as `check_output` does an output.

    Raises:
        OutputError: another format than PLY, no such folder, the input or the output, or a file that must not be replaced.
    """
    record = read_provenance(output)
    for path in maps:
        if extension(path) != "ply":
            raise OutputError(path, "an intervention map is a .ply file")
        if not path.parent.is_dir() or path.is_dir():
            raise OutputError(path, "there is no such folder" if not path.parent.is_dir() else "there is a folder of that name")
        if path == output.absolute() or (path.exists() and path.samefile(input)):
            raise OutputError(path, "it is the input or the output of the run; name another file for the map")
        if os.path.lexists(path) and not overwrite and (reason := _not_ours(path, record, input)):
            raise OutputError(path, f"it exists and {reason}; {_OVERWRITE}")


def place_files(files: Sequence[StagedFile]) -> None:
    """Put files in place that belong to no output.

    Raises:
        OutputError: a rename failed.
    """
    try:
        for file in files:
            shutil.move(file.staged, file.target)
    except OSError as error:
        raise OutputError(file.target, f"cannot put it in place: {error.strerror or error}") from error


def _not_ours(path: Path, record: Mapping[str, Any] | None, input: Path) -> str | None:
    """Why an existing file is not what a former run wrote from this input; None if it is."""
    if path.is_symlink() or not path.is_file():
        return "is no regular file"
    if record is None:
        return "no provenance says that a run wrote it"
    source = Path(str(record.get("input", {}).get("path")))
    if not (source == input.absolute() or (source.exists() and source.samefile(input))):
        return f"was made from another input, {source}"
    if path.name.endswith(".provenance.json"):
        return None
    return None if sha256_of(path) == recorded_digest(record, path) else "has been changed since a run wrote it"


def write_whole(path: Path, data: bytes) -> None:
    """Write a new file and wait until the disk has it."""
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


@dataclass(frozen=True)
class StagedFile:
    """A finished file in the staging folder, and where it belongs."""

    staged: Path
    target: Path


def commit(output: StagedFile, provenance: StagedFile, side_files: Sequence[StagedFile], backups: Path) -> None:
    """Put all files in place, or none.

    Args:
        output: the mesh file.
        provenance: the file beside it.
        side_files: textures and material files.
        backups: an empty folder on the same file system for what is replaced, until all is done.

    Raises:
        OutputError: a rename failed; what was there before is there again.
    """
    done: list[tuple[Path, Path | None]] = []
    try:
        done.append((provenance.target, _kept(provenance.target, backups / "provenance")))
        provenance.target.unlink(missing_ok=True)
        for number, file in enumerate((*side_files, output, provenance)):
            done.append((file.target, _kept(file.target, backups / str(number))))
            file.staged.replace(file.target)
        this_system().flush(output.target.parent)
    except BaseException as error:
        for target, backup in reversed(done):
            with contextlib.suppress(OSError):
                if backup is None:
                    target.unlink(missing_ok=True)
                else:
                    backup.replace(target)
        if isinstance(error, OSError):
            raise OutputError(output.target, f"cannot put it in place: {error.strerror or error}") from error
        raise


def _kept(target: Path, backup: Path) -> Path | None:
    """A second name for what is at `target` now, so that it can be put back; None if there is nothing."""
    if not os.path.lexists(target):
        return None
    try:
        os.link(target, backup, follow_symlinks=False)
    except (OSError, NotImplementedError):  # a file system without hard links
        shutil.copy2(target, backup, follow_symlinks=False)
    return backup
