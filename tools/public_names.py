"""The list of public names of the mathematics, which tests hold: a name that leaves it breaks users."""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path

PROJECT = Path(__file__).parents[1]
LIST = PROJECT / "tests/filters/public_names.txt"


def list_text() -> str:
    """One line a name, ``family.name``, in ascending order."""
    rooms = [room.name for room in pkgutil.iter_modules([str(PROJECT / "filters")])]
    names = {f"{name}.{public}" for name in rooms for public in importlib.import_module(f"pymeshfair.filters.{name}").__all__}
    return "\n".join(sorted(names)) + "\n"
