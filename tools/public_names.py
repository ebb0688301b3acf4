"""The list of public names of the mathematics, which tests hold: a name that leaves it breaks users."""

from __future__ import annotations

import importlib
from pathlib import Path

PROJECT = Path(__file__).parents[1]
LIST = PROJECT / "tests/filters/public_names.txt"


def list_text() -> str:
    """One line a name, ``family.name``, in ascending order."""
    packages = sorted(file.parent.name for file in (PROJECT / "filters").glob("*/__init__.py"))
    names = {f"{name}.{public}" for name in packages for public in importlib.import_module(f"pymeshfair.filters.{name}").__all__}
    return "\n".join(sorted(names)) + "\n"
