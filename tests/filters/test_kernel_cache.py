"""Kernels can be compiled where nothing can be written beside them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]


@pytest.mark.skipif(not sys.platform.startswith("linux") or os.geteuid() != 0, reason="takes a read-only mount, as root on Linux")
def test_kernels_work_where_neither_the_package_nor_a_home_can_be_written(tmp_path: Path) -> None:
    """On a read-only file system and without a home the mathematics is imported, compiles and runs, and leaves nothing behind."""
    for name in ("filters", "src", "plugins", "mlx_scripts"):
        shutil.copytree(
            PROJECT / name, tmp_path / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info")
        )
    program = (
        "import numpy as np, numba, os, pymeshfair.filters.topology as t;"
        "assert t.__file__.startswith(os.environ['PYTHONPATH']), t.__file__;"
        "print(t.border_edges(np.array([[0, 1, 2]], dtype=np.int32)).tolist(), numba.config.CACHE_DIR)"
    )
    shell = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && cd / && exec "$2" -c "$3"'
    environment = {
        **{k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"},
        "HOME": "/proc/nowhere",
        "XDG_CACHE_HOME": "/proc/nowhere",
        "PYTHONPATH": str(tmp_path / "src"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    command = ["unshare", "--mount", "sh", "-c", shell, "sh", str(tmp_path), sys.executable, program]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    if "unshare" in done.stderr or "mount:" in done.stderr:
        pytest.skip(f"this machine does not let a test mount: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    edges, _, folder = done.stdout.strip().rpartition(" ")
    assert edges == "[[0, 1], [0, 2], [1, 2]]"
    assert not Path(folder).exists()


def test_compilation_is_told_once_and_only_where_it_happens(tmp_path: Path) -> None:
    """The first process with an empty cache tells once; the next finds every kernel compiled and tells nothing."""
    program = (
        "from pymeshfair.filters.compilation.kernel_cache import on_first_compilation;"
        "from pymeshfair.filters.robust import kernel_weight;"
        "on_first_compilation(lambda: print('compiling'));"
        "kernel_weight(0, 1.0, 2.0)"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    said = [
        subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=120, check=True)
        for _ in range(2)
    ]
    assert [done.stdout for done in said] == ["compiling\n", ""]
