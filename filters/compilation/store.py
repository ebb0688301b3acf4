"""Where machine code lies: what the installation compiled beside this module, the rest in a folder of the user's.

A file is named after everything that its content follows from, so that none is ever stale: another version of a function, of
numba or of Python, and another processor look for other files.
"""

from __future__ import annotations

import hashlib
import os
import sys
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from .numba_threads import load_numba

#: what comes with the package; the installation writes it, nobody else
INSTALLED = Path(__file__).parent / "kernels"


def compiled_here(target: tuple[str, ...]) -> str:
    """The name of the folder for what this Python, this numba and that processor make.

    Args:
        target: the system, the processor and its features, as numba's code generator names them.
    """
    import llvmlite

    config = load_numba().config
    options = (config.OPT, config.BOUNDSCHECK, config.LOOP_VECTORIZE, config.SLP_VECTORIZE, config.USING_SVML)
    versions = f"{sys.implementation.cache_tag}-numba{load_numba().__version__}-llvmlite{llvmlite.__version__}"
    return f"{versions}-{hashlib.sha256(repr((target, options)).encode()).hexdigest()[:12]}"


@cache
def users_folder() -> Path:
    """Where processes of this user keep what they compile: in NUMBA_CACHE_DIR, else in the user's cache."""
    from numba.misc import appdirs

    users: Any = appdirs.user_cache_dir
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given) / "pymeshfair" if given else Path(users("pymeshfair", appauthor=False)) / "kernels"


@cache
def lasts() -> bool:
    """Whether later processes find there what this one compiles: not where the folder cannot be written."""
    folder = users_folder()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return os.access(folder, os.W_OK | os.X_OK)


class Stored(NamedTuple):
    """What is there for this Python, this numba and this processor.

    Attributes:
        installed: how many kernels came compiled with the package.
        kept: how many have been compiled since.
        folder: where those are.
        lasts: whether what is compiled now goes there.
    """

    installed: int
    kept: int
    folder: Path
    lasts: bool


def stored() -> Stored:
    """What need not be compiled any more."""
    from numba.core.registry import cpu_target

    here, folder = compiled_here(cpu_target.target_context.codegen().magic_tuple()), users_folder()
    installed, kept = (sum(1 for _ in (place / here).glob("*")) for place in (INSTALLED, folder))
    return Stored(installed, kept, folder, lasts())


def read(folder: str, name: str) -> bytes | None:
    """What is stored under that name, or None."""
    for place in (INSTALLED, users_folder()):
        with suppress(OSError):
            return (place / folder / name).read_bytes()
    return None


def write(folder: str, name: str, content: bytes) -> None:
    """Store it; a file appears whole or not at all, as several processes may write the same one."""
    place = users_folder() / folder
    with suppress(OSError):  # a full disk costs the next process its time, and this one nothing
        place.mkdir(parents=True, exist_ok=True)
        part = place / f"{uuid.uuid4().hex}.part"
        try:
            part.write_bytes(content)
            part.replace(place / name)
        finally:
            part.unlink(missing_ok=True)
