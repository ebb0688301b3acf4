"""``import pymeshfair`` is cheap, and gives what pymeshlab gives."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pymeshlab
import pytest

import pymeshfair
from pymeshfair import MeshSet
from pymeshfair.registry import reload_plugins


def run(program: str) -> str:
    """What a fresh Python prints."""
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True).stdout.strip()


def test_importing_the_package_loads_nothing_heavy() -> None:
    """Neither pymeshlab nor numpy is loaded before somebody asks for a name, so that `pymeshfair --help` answers at once."""
    program = "import sys, pymeshfair; print([m for m in ('pymeshlab', 'numpy', 'numba', 'scipy') if m in sys.modules])"
    assert run(program) == "[]"


@pytest.mark.parametrize("name", ["MeshSet", "Recipe"])
def test_the_classes_take_hardly_longer_to_import_than_pymeshlab(name: str) -> None:
    """Neither plugins, nor scripts, nor the table of MeshLab's filters are loaded before a method is asked for."""
    program = f"import sys, pymeshlab; before = set(sys.modules); from pymeshfair import {name}"
    loaded = run(f"{program}; print(*sorted(set(sys.modules) - before))").split()
    assert len(loaded) < 30, loaded
    assert not [m for m in loaded if m.startswith(("pymeshfair.plugins", "pymeshfair.scripts.", "numba", "scipy"))]


def test_names_without_libgl_tell_what_is_missing(tmp_path: Path) -> None:
    """`dir` of the package says which system library pymeshlab lacks, and how to install it."""
    (tmp_path / "pymeshlab.py").write_text("raise ImportError('libGL.so.1: cannot open shared object file')", encoding="utf-8")
    program = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import pymeshfair\ntry: dir(pymeshfair)"
    assert "apt install libgl1" in run(f"{program}\nexcept ImportError as error: print(error)")


def test_the_package_serves_as_pymeshlab() -> None:
    """Every public name of pymeshlab is there and is pymeshlab's own, but for the ones that know filters of plugins, too."""
    names = {name for name in dir(pymeshlab) if not name.startswith("_")}
    ours = {"MeshSet", "filter_list", "print_filter_list", "print_filter_parameter_list", "search"}
    assert names <= set(dir(pymeshfair))
    assert {name for name in names if getattr(pymeshfair, name) is not getattr(pymeshlab, name)} == ours
    assert pymeshfair.MeshSet is MeshSet
    assert issubclass(MeshSet, pymeshlab.MeshSet)
    assert pymeshfair.reload_plugins is reload_plugins
    with pytest.raises(AttributeError, match="no attribute 'Meshset'"):
        pymeshfair.Meshset  # type: ignore[attr-defined]  # noqa: B018


def test_errors_are_there_by_name() -> None:
    """A program that imported nothing else can catch what pymeshfair raises."""
    program = "import pymeshfair as p; print(issubclass(p.errors.ParameterError, p.PymeshfairError), p.RunResult.__name__)"
    assert run(program) == "True RunResult"


def test_help_on_the_package_is_short() -> None:
    """The classes with a method for each filter have manuals of their own; a star import has them all the same."""
    assert len(run("import pymeshfair; help(pymeshfair)")) < 15_000
    assert run("from pymeshfair import *; print(MeshSet.__name__, Recipe.__name__)") == "MeshSet Recipe"


def test_the_version_is_that_of_the_installed_package() -> None:
    """__version__ comes from the package's metadata."""
    assert run("import pymeshfair, importlib.metadata as m; print(pymeshfair.__version__ == m.version('pymeshfair'))") == "True"


def test_the_lists_know_both_kinds(capsys: pytest.CaptureFixture[str]) -> None:
    """filter_list, its printed form, the parameters of a filter and the search find MeshLab's filters and ours."""
    listed = pymeshfair.filter_list()
    assert set(pymeshlab.filter_list()) < set(listed)
    assert "apply_coord_taubin_fairing" in listed
    assert listed == sorted(listed) == MeshSet.filter_list()
    pymeshfair.print_filter_list()
    out = capsys.readouterr().out
    assert "\tapply_coord_taubin_fairing\n" in out
    assert "\tapply_coord_taubin_smoothing\n" in out
    pymeshfair.print_filter_parameter_list("apply_coord_implicit_fairing")
    assert "\tdetail_size : a length such as '1%'" in capsys.readouterr().out
    pymeshfair.print_filter_parameter_list("meshing_decimation_quadric_edge_collapse")
    assert re.search(r"\n\ttargetfacenum : a whole number.* = depends on the mesh\n", capsys.readouterr().out)
    pymeshfair.search("taubin")
    found = [line.split(" : ")[0] for line in capsys.readouterr().out.splitlines()]
    assert {"apply_coord_taubin_fairing", "apply_coord_taubin_smoothing"} <= set(found[:3])
    pymeshfair.search("")
    assert capsys.readouterr().out == ""
