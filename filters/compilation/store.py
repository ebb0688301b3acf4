"""The store of machine code: code compiled by the installation beside this module, other code in a folder of the user.

A file is named after everything that its content follows from, so that none is ever stale: another version of a function, of
numba or of Python, and another level of processor look for other files.
"""

import os
import pickle
import sys
import uuid
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from .machine_code import MachineCode, made_here

#: the kernels that come with the package; only the installation writes there
INSTALLED = Path(__file__).parent / "kernels"


def lasts() -> bool:
    """Whether later processes find there what this one compiles: not where the folder cannot be made or written."""
    folder = users_folder()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        return os.access(folder, os.W_OK | os.X_OK)
    return False


def users_folder() -> Path:
    """The folder of the user's for what is compiled: in NUMBA_CACHE_DIR, or where the system keeps caches."""
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(given) / "pymeshfair"
    home = Path("~").expanduser()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData/Local") / "pymeshfair" / "kernels"
    if sys.platform == "darwin":
        return home / "Library/Caches/pymeshfair/kernels"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "pymeshfair" / "kernels"


class Stored(NamedTuple):
    """The compiled functions for this Python, this numba and this processor.

    Attributes:
        installed: how many kernels came compiled with the package.
        kept: how many have been compiled since.
        folder: their place.
        lasts: whether that folder can be written to; else every process compiles anew what is not there.
    """

    installed: int
    kept: int
    folder: Path
    lasts: bool


def stored() -> Stored:
    """The compiled functions that are stored."""
    folder = users_folder()
    installed, kept = (sum(1 for _ in (place / made_here()).glob("*")) for place in (INSTALLED, folder))
    return Stored(installed, kept, folder, lasts())


def read(name: str) -> MachineCode | None:
    """The data stored under that name, or None."""
    for place in (INSTALLED, users_folder()):
        with suppress(OSError, EOFError, pickle.UnpicklingError, TypeError, ValueError):  # a disk that was full or has failed
            return MachineCode(*pickle.loads((place / made_here() / name).read_bytes()))
    return None


def write(name: str, code: MachineCode) -> None:
    """Store it; a file appears whole or not at all, as several processes may write the same one."""
    place = users_folder() / made_here()
    with suppress(OSError):  # where nothing can be written the next process compiles it again
        place.mkdir(parents=True, exist_ok=True)
        part = place / f"{uuid.uuid4().hex}.part"
        try:
            part.write_bytes(pickle.dumps(tuple(code)))
            part.replace(place / name)
        finally:
            part.unlink(missing_ok=True)
