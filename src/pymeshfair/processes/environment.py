"""The environment of workers (threads, memory and locale of libraries), and the versions of packages."""

import os
import platform
import re
import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

from ..operating_system import this_system

#: the packages whose version may change a result
PACKAGES = ("pymeshfair", "pymeshlab", "numpy", "scipy", "numba", "llvmlite", "robust-laplacian")


def versions() -> dict[str, Any]:
    """Returns the versions of software and system that a result depends on."""
    python: dict[str, Any] = {"python": platform.python_version(), "implementation": platform.python_implementation()}
    return python | packages_here() | {"system": platform.platform(), "machine": platform.machine(), "byte_order": sys.byteorder}


def packages_here() -> dict[str, Any]:
    """Returns the versions of `PACKAGES`."""
    return {name: _version(name) for name in PACKAGES}


@cache
def _version(package: str) -> str | None:
    import importlib.metadata  # here, since the help of the command does not need it

    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def thread_settings(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Returns the environment variables that are set and limit the threads of libraries."""
    return {name: environment[name] for name in sorted(environment) if name.endswith("_NUM_THREADS")}


ONE_BLAS_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
#: the variable for the number of free bytes above which the C library returns memory to the system
TRIM_THRESHOLD = "MALLOC_TRIM_THRESHOLD_"


def worker_environment(threads: int | None, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Returns the environment of a worker; linear algebra has one thread, so that the number of processors changes no result.

    Filters have `threads` threads. None: the number in OMP_NUM_THREADS, or one for each processor if it is not set.
    """
    listed = re.match(r"\s*([1-9]\d*)", environment.get("OMP_NUM_THREADS", ""))  # it may be a list, for nested loops
    count = str(threads or (listed[1] if listed else this_system().processors()))
    changes = {"OMP_NUM_THREADS": count, "NUMBA_NUM_THREADS": count, **ONE_BLAS_THREAD}
    # Waiting threads sleep: if they spin, MeshLab's Poisson reconstruction is 16 times slower on a busy machine.
    changes["OMP_WAIT_POLICY"] = environment.get("OMP_WAIT_POLICY", "PASSIVE")
    # The C library returns large blocks at once: if it keeps them, a run on a million faces takes a tenth more memory.
    changes[TRIM_THRESHOLD] = environment.get(TRIM_THRESHOLD, str(2**25))
    # MeshLab opens "é.ply" only in a UTF-8 locale, and reads "1.5" as 1 in some locales that write "1,5".
    # Files in the working folder must not be imported in place of libraries.
    changes |= {"LC_ALL": "C.UTF-8", "PYTHONIOENCODING": "utf-8", "PYTHONSAFEPATH": "1"}
    return {**environment, **changes}


def program_of(module: str) -> list[str]:
    """Returns the command that runs a module as a program in `worker_environment`."""
    if sys.version_info >= (3, 11):
        return [sys.executable, "-m", module]
    # Python 3.10 ignores PYTHONSAFEPATH.
    run = "import sys; del sys.path[0]; import runpy; runpy.run_module(sys.argv.pop(1), run_name='__main__')"
    return [sys.executable, "-c", run, module]
