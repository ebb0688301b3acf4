"""Kernels are compiled when they are first called, once for all processes, and never taken for others."""

from __future__ import annotations

import importlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

from pymeshfair.filters.compilation import ahead, compiled, listed_signatures, loaded_kernels
from pymeshfair.filters.compilation.fingerprint import fingerprint

PROJECT = Path(__file__).parents[2]
PACKAGES = ("filters", "src", "plugins", "mlx_scripts")
#: calls a kernel, and tells what was compiled and where it is kept
PROGRAM = """
import numpy as np, pymeshfair.filters.topology as t
from pymeshfair.filters.compilation import on_compilation, stored
compiled = []
on_compilation(compiled.append)
print(t.border_edges(np.array([[0, 1, 2]], dtype=np.int32)).tolist(), len(compiled), stored().folder)
"""
EDGES = "[[0, 1], [0, 2], [1, 2]]"
SIZE = 3


@compiled
def inner(x: float) -> float:
    """Uses a number of this module."""
    return x * SIZE


@compiled
def outer(x: float) -> float:
    """Uses another kernel."""
    return inner(x) + 1.0


def run(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """A fresh process."""
    return subprocess.run(
        [sys.executable, *arguments], env={**os.environ, **environment}, capture_output=True, text=True, timeout=120, check=False
    )


def copied_tree(folder: Path) -> Path:
    """The packages without anything compiled."""
    for name in PACKAGES:
        shutil.copytree(PROJECT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    return folder / "src"


@pytest.mark.skipif(not sys.platform.startswith("linux") or os.geteuid() != 0, reason="takes a read-only mount, as root on Linux")
def test_kernels_work_where_neither_the_package_nor_a_home_can_be_written(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """On a read-only file system and without a home the mathematics is imported, compiles and runs, and leaves nothing behind."""
    source = copied_tree(tmp_path)
    shell = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && cd / && exec "$2" -c "$3"'
    environment = {
        **{k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"},
        "HOME": "/proc/nowhere",
        "XDG_CACHE_HOME": "/proc/nowhere",
        "PYTHONPATH": str(source),
        "PYTHONDONTWRITEBYTECODE": "1",
        "TMPDIR": str(tmp_path_factory.mktemp("temporary")),
    }
    command = ["unshare", "--mount", "sh", "-c", shell, "sh", str(tmp_path), sys.executable, PROGRAM]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    if "unshare" in done.stderr or "mount:" in done.stderr:
        pytest.skip(f"this machine does not let a test mount: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    edges, count, folder = done.stdout.strip().rsplit(" ", 2)
    assert edges == EDGES
    assert int(count) > 0
    assert folder.startswith("/proc/nowhere")
    assert not list(Path(environment["TMPDIR"]).iterdir())


def test_what_one_process_compiles_the_next_ones_load(tmp_path: Path) -> None:
    """With an empty store kernels are compiled and that is told; the next process compiles none, nor does one to which the
    store came with a package that it cannot write to.
    """
    source = copied_tree(tmp_path / "copy")  # an installation has its kernels already
    environment = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(tmp_path / "store")}
    first, second = (run(environment, "-c", PROGRAM) for _ in range(2))
    assert first.stdout.startswith(f"{EDGES} "), first.stderr
    assert int(first.stdout.split()[-2]) > 0
    assert second.stdout.startswith(f"{EDGES} 0 "), second.stderr
    shutil.copytree(tmp_path / "store/pymeshfair", tmp_path / "copy/filters/compilation/kernels")
    installed = run({"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(tmp_path / "empty")}, "-c", PROGRAM)
    assert installed.stdout.startswith(f"{EDGES} 0 "), installed.stderr


def test_several_threads_call_parallel_kernels_where_openmp_is_missing() -> None:
    """Numba's own threads, which it then takes, would end the process; the results are those of one thread."""
    program = (
        "import threading\n"
        "from pymeshfair.filters.compilation.numba_threads import load_numba\n"
        "from pymeshfair.filters.diffusion import explicit_smoothing; from tests.meshes import icosphere\n"
        "v, f = icosphere(5); found = {}\n"
        "def work(k): found[k] = explicit_smoothing(v, f, iterations=200)\n"
        "work(0); threads = [threading.Thread(target=work, args=(k,)) for k in range(1, 5)]\n"
        "[t.start() for t in threads]; [t.join() for t in threads]\n"
        "print(load_numba().threading_layer(), all((found[k] == found[0]).all() for k in range(5)))\n"
    )
    done = run({"NUMBA_THREADING_LAYER": "workqueue", "PYTHONPATH": str(PROJECT)}, "-c", program)
    assert done.stdout == "workqueue True\n", done.stderr


def test_a_damaged_file_in_the_store_is_compiled_again(tmp_path: Path) -> None:
    """What a full disk has cut off is no reason to fail."""
    source, store = copied_tree(tmp_path / "copy"), tmp_path / "store"
    environment = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(store)}
    run(environment, "-c", PROGRAM)
    for file in store.glob("pymeshfair/*/*"):
        file.write_bytes(file.read_bytes()[:100])
    done = run(environment, "-c", PROGRAM)
    assert done.stdout.startswith(f"{EDGES} "), done.stderr
    assert int(done.stdout.split()[-2]) > 0


def test_a_change_of_what_a_kernel_is_compiled_from_changes_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Constants of its module, kernels that it calls and what numba is told are part of a kernel, as its own code is."""

    def anew(kernel: Any, **options: bool) -> str:
        return fingerprint(kernel.py_func, options)

    before = anew(inner)
    assert anew(inner) == before
    assert anew(inner, nogil=True) != before
    assert anew(outer) != before
    called = anew(outer)
    monkeypatch.setattr(sys.modules[__name__], "SIZE", 4)
    assert anew(inner) != before
    monkeypatch.setattr(sys.modules[__name__], "inner", compiled(inner.py_func))  # type: ignore[attr-defined]
    assert anew(outer) != called


def test_what_no_hash_can_be_made_of_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel must not use what could change unseen, such as a list."""
    monkeypatch.setattr(sys.modules[__name__], "SIZE", [3])
    function: Any = inner
    assert isinstance(function.py_func, FunctionType)
    with pytest.raises(TypeError, match=r"test_compilation\.inner uses \[3\]"):
        fingerprint(function.py_func, {})


def test_every_kernel_has_a_fingerprint_of_its_own() -> None:
    """None uses anything that no hash can be made of; two of the same fingerprint are the same function."""
    for module in PROJECT.glob("filters/*/*.py"):
        if module.stem != "__main__":
            importlib.import_module(f"pymeshfair.filters.{module.parent.name}.{module.stem}".removesuffix(".__init__"))
    found: dict[str, Any] = {}
    for _, _, kernel in loaded_kernels("pymeshfair"):
        other = found.setdefault(kernel.fingerprint, kernel)
        assert other.py_func.__code__.co_code == kernel.py_func.__code__.co_code
    assert len(found) > 100


def test_the_list_of_what_is_compiled_ahead_can_be_read() -> None:
    """Every kernel of the list exists, and numba knows the types: `python tools/generate.py kernels` writes it anew."""
    for module, kernels in listed_signatures().items():
        for name, signatures in kernels.items():
            assert hasattr(getattr(importlib.import_module(module), name), "fingerprint"), f"{module}.{name}"
            assert all(repr(ahead._parsed(text)) == text for text in signatures)


def test_the_list_has_what_common_filters_use() -> None:
    """Smoothing and measuring a mesh takes no kernel, and none for other types, than are compiled ahead."""
    program = (
        "import json, numpy as np; from pymeshfair.filters.compilation import loaded_kernels, signatures_of;"
        "from pymeshfair.filters.inspection import surface_measures; from pymeshfair.filters.diffusion import taubin_fairing;"
        "from tests.meshes import icosphere; v, f = icosphere(2); taubin_fairing(v, f); surface_measures(v, f);"
        "print(json.dumps(signatures_of(loaded_kernels('pymeshfair'))))"
    )
    done = run({"PYTHONPATH": str(PROJECT)}, "-c", program)
    assert done.returncode == 0, done.stderr
    listed, missing = listed_signatures(), []
    for module, kernels in json.loads(done.stdout).items():
        for name, signatures in kernels.items():
            missing += [f"{module}.{name} {s}" for s in signatures if s not in listed.get(module, {}).get(name, ())]
    assert not missing, "python tools/generate.py kernels"
