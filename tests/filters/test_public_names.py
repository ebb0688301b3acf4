"""The public names of the mathematics: where they are imported from, so that a module may move and break nobody."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, get_origin

PROJECT = Path(__file__).parents[2]
#: the rooms of the mathematics, packages and single modules
PACKAGES = sorted(room.name for room in pkgutil.iter_modules([str(PROJECT / "filters")]))
PROMISED = Path(__file__).with_name("public_names.txt").read_text(encoding="utf-8").split()
#: what users read and copy from; plugins import as those of others would
SHOWN = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *(
        file
        for folder in ("docs", "examples", "tools", "plugins")
        for kind in ("md", "py")
        for file in (PROJECT / folder).rglob(f"*.{kind}")
    ),
]


def package(name: str) -> Any:
    """A package of the mathematics."""
    return importlib.import_module(f"pymeshfair.filters.{name}")


def test_the_public_names_are_those_that_are_promised() -> None:
    """A name that is gone breaks users, a new one is a promise: public_names.txt lists what every package exports."""
    exported = {f"{name}.{public}" for name in PACKAGES for public in package(name).__all__}
    assert sorted(exported - set(PROMISED)) == [], "python tools/generate.py adds these names"
    assert sorted(set(PROMISED) - exported) == [], "these names are promised to users"
    assert len(PROMISED) == len(set(PROMISED))


def test_every_public_name_is_there_and_explains_itself() -> None:
    """What a package exports can be imported from it; functions and classes are the project's own and have a docstring."""
    wrong = []
    for name in PROMISED:
        where, _, public = name.partition(".")
        thing = getattr(package(where), public)
        is_alias = get_origin(thing) is not None  # a class before Python 3.11
        if (inspect.isfunction(thing) or inspect.isclass(thing)) and not is_alias:
            wrong += [name] if not thing.__doc__ or not thing.__module__.startswith("pymeshfair.filters.") else []
    assert not wrong


def test_nothing_that_users_read_imports_a_module_of_a_package() -> None:
    """Readme, pages, examples and plugins import public names from the packages that export them."""
    inside = re.compile(r"pymeshfair\.filters\.\w+\.\w+")
    assert not [f"{file}: {match}" for file in SHOWN for match in inside.findall(file.read_text(encoding="utf-8"))]


def test_importing_the_mathematics_alone_loads_nothing_heavy() -> None:
    """Who imports `pymeshfair.filters` pays for a family only when importing that."""
    program = "import sys, pymeshfair.filters; print([m for m in ('numba', 'numpy', 'scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"
