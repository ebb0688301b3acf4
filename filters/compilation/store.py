"""The store of machine code: code compiled by the installation beside this module, other code in a folder of the user.

The name of a file contains everything that its content depends on, so that no file is outdated: the function, the versions of
numba and Python, the level of the processor.
"""

import os
import pickle
import sys
import uuid
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from .machine_code import MachineCode, made_here

#: The kernels that come with the package; only the installation writes there.
INSTALLED = Path(__file__).parent / "kernels"


def lasts() -> bool:
    """Whether later processes find the code that this one compiles: whether the user's folder can be written."""
    folder = users_folder()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        return os.access(folder, os.W_OK | os.X_OK)
    return False


def users_folder() -> Path:
    """The user's folder for compiled code: in NUMBA_CACHE_DIR, or where the system keeps caches."""
    if folder := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(folder) / "pymeshfair"
    home = Path("~").expanduser()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData/Local") / "pymeshfair" / "kernels"
    if sys.platform == "darwin":
        return home / "Library/Caches/pymeshfair/kernels"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "pymeshfair" / "kernels"


class Stored(NamedTuple):
    """The compiled functions for this Python, this numba and this processor.

    Attributes:
        installed: the number of kernels that came compiled with the package.
        kept: the number of kernels compiled since.
        folder: the folder of the latter.
        lasts: whether that folder can be written; if not, every process compiles missing kernels anew.
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
