"""pymeshlab's own examples and tests run on our `MeshSet` as they are."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pymeshlab
import pytest

TESTS = Path(pymeshlab.__file__).parent / "tests"
PROGRAMS = sorted(path.stem for path in TESTS.glob("*.py") if path.stem.startswith(("example_", "test_")))
#: those that open a window of OpenGL, without which MeshLab aborts the process
NEED_OPENGL = {"test_texture_map_defragmentation"}

# Runs in the folder where the programs were copied to, one process for all: only pymeshlab's MeshSet is another.
DRIVER = """
import importlib, inspect, sys, traceback
import pymeshfair, pymeshlab
pymeshlab.MeshSet = pymeshfair.MeshSet
for program in sys.argv[1:]:
    try:
        module = importlib.import_module(f"bundled.{program}")
        functions = [f for name, f in inspect.getmembers(module, inspect.isfunction) if name.startswith(("test_", "example_"))]
        assert functions, "holds no function to run"
        for function in functions:
            function()
    except Exception:
        traceback.print_exc()
    else:
        print(f"passed {program}", file=sys.stderr, flush=True)
"""


@pytest.fixture(scope="module")
def passed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """What the driver says of the programs that need no OpenGL."""
    folder = tmp_path_factory.mktemp("programs")
    shutil.copytree(TESTS, folder / "bundled", ignore=shutil.ignore_patterns("__pycache__", "test_output"))
    programs = [program for program in PROGRAMS if program not in NEED_OPENGL]
    done = subprocess.run([sys.executable, "-c", DRIVER, *programs], cwd=folder, capture_output=True, text=True, timeout=300)
    yield f"{done.stderr}\nexit status {done.returncode}"
    shutil.rmtree(folder)


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_bundled_program_runs_unchanged(program: str, passed: str) -> None:
    """The program does what it asserts with pymeshlab.MeshSet replaced by ours."""
    if program in NEED_OPENGL:
        pytest.skip("needs OpenGL; without a display plain pymeshlab aborts there, too")
    assert f"passed {program}\n" in passed, passed


def test_there_are_programs() -> None:
    """The wheel carries them; should it stop to, this says so."""
    assert len(PROGRAMS) >= 25


def test_filters_of_plugins_work_where_ours_has_taken_the_place_of_pymeshlabs() -> None:
    """A program that replaces pymeshlab.MeshSet by ours applies a filter of ours: what the write-back does enters no script."""
    program = (
        "import pymeshfair, pymeshlab\n"
        "pymeshlab.MeshSet = pymeshfair.MeshSet\n"
        "meshes = pymeshlab.MeshSet()\n"
        "meshes.create_sphere()\n"
        "meshes.apply_coord_taubin_fairing()\n"
        "meshes.print_filter_script()\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.stdout.startswith("Filter Script Size : 2\n"), done.stderr
