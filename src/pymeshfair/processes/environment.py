"""The environment of a worker and of its results: threads, memory and locale of libraries, and the versions of packages."""

import os
import platform
import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

from ..operating_system import this_system

#: the packages whose version may change a result
PACKAGES = ("pymeshfair", "pymeshlab", "numpy", "scipy", "numba", "llvmlite", "robust-laplacian")


def versions() -> dict[str, Any]:
    """The versions that a result depends on besides the input and the recipe."""
    python: dict[str, Any] = {"python": platform.python_version(), "implementation": platform.python_implementation()}
    return python | packages_here() | {"system": platform.platform(), "machine": platform.machine(), "byte_order": sys.byteorder}


def packages_here() -> dict[str, Any]:
    """The versions of the packages that a result depends on."""
    return {name: _version(name) for name in PACKAGES}


@cache
def _version(package: str) -> str | None:
    import importlib.metadata  # not for the help of the command

    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def thread_settings(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The variables that say how many threads libraries may use, as far as they are set."""
    return {name: environment[name] for name in sorted(environment) if name.endswith("_NUM_THREADS")}


#: the variables by which linear algebra takes one thread
ONE_BLAS_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
#: the variable that says above how many free bytes the C library gives memory back
TRIM_THRESHOLD = "MALLOC_TRIM_THRESHOLD_"


def worker_environment(threads: int | None, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The environment of a worker: one thread for linear algebra, so that results do not depend on their number.

    Filters have `threads`; None means what OMP_NUM_THREADS says, or all processors.
    """
    count = str(threads) if threads is not None else environment.get("OMP_NUM_THREADS", str(this_system().processors()))
    changes = {"OMP_NUM_THREADS": count, "NUMBA_NUM_THREADS": count}
    changes |= ONE_BLAS_THREAD
    # Threads that wait should sleep: spinning ones make MeshLab's Poisson reconstruction 16 times slower on a busy machine.
    changes["OMP_WAIT_POLICY"] = environment.get("OMP_WAIT_POLICY", "PASSIVE")
    # The C library gives large memory back at once: kept for later, it came to a tenth of what a million faces take.
    changes[TRIM_THRESHOLD] = environment.get(TRIM_THRESHOLD, str(2**25))
    # MeshLab opens "é.ply" in a locale of UTF-8 alone, and reads "1.5" as 1 in some that write "1,5".
    changes["LC_ALL"] = "C.UTF-8"
    # Files in the working folder must not be imported in place of libraries.
    changes["PYTHONSAFEPATH"] = "1"
    return {**environment, **changes}


def program_of(module: str) -> list[str]:
    """The command that runs a module as a program in `worker_environment`."""
    if sys.version_info >= (3, 11):
        return [sys.executable, "-m", module]
    # Python 3.10 does not know PYTHONSAFEPATH.
    run = "import sys; del sys.path[0]; import runpy; runpy.run_module(sys.argv.pop(1), run_name='__main__')"
    return [sys.executable, "-c", run, module]
