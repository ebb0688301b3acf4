"""Parallel kernels: how many threads they take, from several threads of a program, and without OpenMP."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pymeshfair.filters.compilation import allowed_threads, compiled, most_threads, prange, set_threads, single_thread

PROJECT = Path(__file__).parents[2]
#: takes away OpenMP before a kernel is loaded
WITHOUT_OPENMP = """
from pymeshfair.filters.compilation import machine_code
def extension(name, original=machine_code.extension):
    if name.endswith("omppool"):
        raise ImportError(name)
    return original(name)
machine_code.extension = extension
"""
#: smooths in four threads of Python at once, and in another after that; prints whether all results are that of the first
SEVERAL = """
import threading
from pymeshfair.filters.compilation import single_thread
from pymeshfair.filters.diffusion import explicit_smoothing
from tests.meshes import icosphere
mesh, found = icosphere(5), {}
def work(k):
    found[k] = explicit_smoothing(*mesh, iterations=100)
with single_thread():
    work(0)
workers = [threading.Thread(target=work, args=(k,)) for k in range(1, 5)]
[w.start() for w in workers]; [w.join() for w in workers]
work(5)
print(all((found[k] == found[0]).all() for k in range(6)))
"""
#: smooths in a process, in a fork of it, in a fork of the fork, and again in the process; prints whether all results are the same
FORKS = """
import os
from pymeshfair.filters.diffusion import explicit_smoothing
from tests.meshes import icosphere
mesh = icosphere(6)
expected = explicit_smoothing(*mesh, iterations=2)
def same(forks):
    found = (explicit_smoothing(*mesh, iterations=2) == expected).all()
    if found and forks:
        fork = os.fork()
        if fork == 0:
            os._exit(not same(forks - 1))
        found = os.waitpid(fork, 0)[1] == 0
    return found
print(bool(same(2) and same(0)))
"""


@compiled(parallel=True)
def sums(count: int) -> Any:
    """Keeps threads busy."""
    found = np.empty(count)
    for k in prange(count):
        total = 0.0
        for i in range(20_000):
            total += np.sin(k + i)
        found[k] = total
    return found


def others_share() -> float:
    """The share of the processor time of a parallel kernel that other threads than the caller take."""
    whole, own = time.process_time(), time.thread_time()
    sums(1000)
    whole, own = time.process_time() - whole, time.thread_time() - own
    return 1.0 - own / whole


def run(program: str, **environment: str) -> str:
    """What a fresh process prints."""
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(PROJECT), "NUMBA_NUM_THREADS": "4", **environment},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(most_threads() < 2, reason="takes two processors")
def test_a_kernel_takes_as_many_threads_as_its_caller_allows() -> None:
    """All, or one within a context of one; afterwards as many as before. What one thread allows concerns no other."""
    everything = allowed_threads()
    assert everything == most_threads()
    sums(1)
    assert others_share() > 0.25
    with single_thread():
        assert allowed_threads() == 1
        time.sleep(0.2)  # for some milliseconds after a kernel its threads still look for work
        assert others_share() < 0.05
        with ThreadPoolExecutor(1) as pool:
            assert pool.submit(allowed_threads).result() == everything
            assert pool.submit(others_share).result() > 0.25
    assert allowed_threads() == everything
    assert others_share() > 0.25


@pytest.mark.parametrize("count", [0, -1, 10_000])
def test_other_numbers_are_refused(count: int) -> None:
    """Fewer than one and more than there are is an error that says so, and changes nothing."""
    before = allowed_threads()
    with pytest.raises(ValueError, match=f"from 1 to {most_threads()}, got {count}"):
        set_threads(count)
    assert allowed_threads() == before


@pytest.mark.parametrize("layer", ["", WITHOUT_OPENMP], ids=["as it is", "without OpenMP"])
def test_several_threads_call_parallel_kernels_at_once(layer: str) -> None:
    """The results are those of one thread; numba's own threads, without OpenMP, would end the process without the lock."""
    assert run(layer + SEVERAL) == "True\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs forks")
@pytest.mark.parametrize("layer", ["", WITHOUT_OPENMP], ids=["as it is", "without OpenMP"])
def test_forks_call_parallel_kernels(layer: str) -> None:
    """Forks, and forks of forks, have the results of the process. OpenMP would kill them; without new threads they would wait."""
    assert run(layer + FORKS) == "True\n"


@pytest.mark.slow
def test_numba_itself_works_beside_the_kernels() -> None:
    """A program's own parallel functions of numba run after ours and before, with threads of their own."""
    own = (
        "import numba, numpy as np\n"
        "@numba.njit(parallel=True)\n"
        "def total(a):\n"
        "    s = 0.0\n"
        "    for i in numba.prange(len(a)):\n"
        "        s += a[i]\n"
        "    return s\n"
        "assert total(np.ones(1000)) == 1000.0\n"
    )
    again = "assert total(np.ones(1000)) == 1000.0\n"
    assert run(own + SEVERAL + again) == "True\n"
    assert run(SEVERAL + own) == "True\n"
