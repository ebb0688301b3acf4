"""The package in examples/plugin_package, installed as a stranger would: its filter is there wherever filters are."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "examples/plugin_package"
SCAN = """\
ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float quality
element face 4
property list uchar int vertex_indices
end_header
0 0 0 9
1 0 0 1
0 1 0 1
0 0 1 1
3 0 2 1
3 0 1 3
3 1 2 3
3 0 3 2
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which the package is installed."""
    folder = tmp_path_factory.mktemp("plugin")
    shutil.copytree(PACKAGE, folder / "source", ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*command, "--target", folder / "there", folder / "source"], check=True, timeout=120, capture_output=True)
    return {**os.environ, "PYTHONPATH": str(folder / "there"), "PYTHONDONTWRITEBYTECODE": "1"}


def run(environment: dict[str, str], folder: Path, *command: str) -> str:
    """What a program of Python prints; it must end well."""
    done = subprocess.run([sys.executable, *command], env=environment, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_filter_is_there_in_every_way(environment: dict[str, str], tmp_path: Path) -> None:
    """`list` and `info` name it, a script has it as a step, and a run gives the medians: 1 everywhere."""
    (tmp_path / "scan.ply").write_text(SCAN)
    step = '<FilterScript><filter name="Median of Vertex Scalars"/></FilterScript>'
    (tmp_path / "step.mlx").write_text(f"<!DOCTYPE FilterScript>\n{step}\n")
    assert "apply_scalar_median_per_vertex" in run(environment, tmp_path, "-m", "pymeshfair", "list", "filters", "median")
    assert "iterations" in run(environment, tmp_path, "-m", "pymeshfair", "info", "apply_scalar_median_per_vertex")
    run(environment, tmp_path, "-m", "pymeshfair", "run", "step.mlx", "scan.ply", "-o", "out.ply")
    program = "import pymeshlab; m = pymeshlab.MeshSet(); m.load_new_mesh('out.ply')"
    assert run(environment, tmp_path, "-c", f"{program}; print(*m.current_mesh().vertex_scalar_array())").split() == ["1.0"] * 4


@pytest.mark.slow
def test_its_own_tests_pass(environment: dict[str, str], tmp_path: Path) -> None:
    """With pytest, away from this project."""
    shutil.copytree(PACKAGE / "tests", tmp_path / "tests")
    run(environment, tmp_path, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests")


@pytest.mark.slow
def test_warming_compiles_its_kernel(environment: dict[str, str], tmp_path: Path) -> None:
    """After `_compile_others` the store has the kernel: a process that uses it then compiles nothing."""
    own = {**environment, "NUMBA_CACHE_DIR": str(tmp_path)}
    warm = "from pymeshfair.commands.doctor import _compile_others; assert not _compile_others()"
    run(own, tmp_path, "-c", warm)
    assert [path.name for path in tmp_path.rglob("median._medians-*")]
