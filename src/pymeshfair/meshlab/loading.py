"""Imports pymeshlab, and names the system libraries that it lacks."""

import contextlib
import importlib
import io
import re
from functools import cache

from ..errors import PymeshfairError

_MISSING = re.compile(r"([\w.+-]+\.so[\w.]*): cannot open shared object file")
#: how to install the system libraries that pymeshlab needs and its wheels do not contain
ADVICE = (
    "pymeshlab needs system libraries that are missing here: `apt install libgl1 libopengl0` (Debian, Ubuntu) "
    "or `dnf install libglvnd-glx libglvnd-opengl` (Fedora) installs them"
)


class MeshLabLoadError(PymeshfairError, ImportError):
    """Pymeshlab is not installed, or a system library that it needs is missing."""


def load_pymeshlab() -> None:
    """Imports pymeshlab; raises `MeshLabLoadError` if it is not installed, or if it or a plugin of it lacks a system library."""
    if missing := _missing_libraries():
        raise MeshLabLoadError(f"{', '.join(missing)}: cannot open shared object file; {ADVICE}")


@cache
def _missing_libraries() -> tuple[str, ...]:
    """Returns the system libraries that pymeshlab or its plugins reported as missing at import."""
    printed = io.StringIO()  # pymeshlab prints which plugins it cannot load
    try:
        with contextlib.redirect_stdout(printed):
            importlib.import_module("pymeshlab")
    except ImportError as error:
        if not _MISSING.search(str(error)):
            raise MeshLabLoadError(str(error)) from error
        printed.write(str(error))
    missing = sorted(set(_MISSING.findall(printed.getvalue())))
    if not missing and printed.getvalue():
        print(printed.getvalue(), end="")
    return tuple(missing)


if __name__ == "__main__":
    load_pymeshlab()
