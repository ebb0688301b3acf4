"""The environment that a result depends on: the versions of packages, and the threads of libraries."""

import importlib.metadata
import os
import platform
import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

#: the packages whose version may change a result
PACKAGES = ("pymeshfair", "pymeshlab", "numpy", "scipy", "numba", "llvmlite", "robust-laplacian")


def versions() -> dict[str, Any]:
    """The versions that a result depends on besides the input and the recipe."""
    found: dict[str, Any] = {"python": platform.python_version(), "implementation": platform.python_implementation()}
    return found | packages_here() | {"system": platform.platform(), "machine": platform.machine(), "byte_order": sys.byteorder}


def packages_here() -> dict[str, Any]:
    """The versions of the packages that a result depends on."""
    return {name: _version(name) for name in PACKAGES}


@cache
def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def thread_settings(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The variables that say how many threads libraries may use, as far as they are set."""
    return {name: environment[name] for name in sorted(environment) if name.endswith("_NUM_THREADS")}
