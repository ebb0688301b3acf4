"""The environment variables of a worker: threads and memory of libraries, and how they read names and numbers."""

import os
import sys
from collections.abc import Mapping

from ..operating_system import this_system

#: the variables by which linear algebra takes one thread
ONE_BLAS_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
#: the variable that says above how many free bytes the C library gives memory back
TRIM_THRESHOLD = "MALLOC_TRIM_THRESHOLD_"


def worker_environment(threads: int | None, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The environment of a worker: one thread for linear algebra, so that results do not depend on their number.

    Filters have `threads`; None means what OMP_NUM_THREADS says, or all processors.
    """
    said = str(threads) if threads is not None else environment.get("OMP_NUM_THREADS", str(this_system().processors()))
    changes = {"OMP_NUM_THREADS": said, "NUMBA_NUM_THREADS": said}
    changes |= ONE_BLAS_THREAD
    # Threads that wait should sleep: spinning ones make MeshLab's Poisson reconstruction 16 times slower on a busy machine.
    changes["OMP_WAIT_POLICY"] = environment.get("OMP_WAIT_POLICY", "PASSIVE")
    # The C library gives large memory back at once: kept for later, it came to a tenth of what a million faces take.
    changes[TRIM_THRESHOLD] = environment.get(TRIM_THRESHOLD, str(2**25))
    # MeshLab opens "é.ply" in a locale of UTF-8 alone, and reads "1.5" as 1 in some that write "1,5".
    changes["LC_ALL"] = "C.UTF-8"
    # Whatever lies in the working folder must not be imported in place of a library.
    changes["PYTHONSAFEPATH"] = "1"
    return {**environment, **changes}


def program_of(module: str) -> list[str]:
    """The command that runs a module as a program in `worker_environment`."""
    if sys.version_info >= (3, 11):
        return [sys.executable, "-m", module]
    # Python 3.10 does not know PYTHONSAFEPATH.
    run = "import sys; del sys.path[0]; import runpy; runpy.run_module(sys.argv.pop(1), run_name='__main__')"
    return [sys.executable, "-c", run, module]
