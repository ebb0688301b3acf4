"""`pymeshfair doctor` finds what is wrong with a machine and says what to do."""

from __future__ import annotations

import importlib.metadata
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from pymeshfair import registry
from pymeshfair.commands import doctor as findings
from pymeshfair.meshlab import facts
from pymeshfair.meshlab.loading import ADVICE

from .command_line import document, invoke, run_process


def found(look: Callable[[], Iterator[findings.Finding]], name: str) -> findings.Finding:
    """The finding of that name that a look makes."""
    [finding] = [f for f in look() if f.name == name]
    return finding


def test_a_sound_machine_is_well() -> None:
    """Where the tests run nothing is wrong, every dependency has its version, and the exit code is 0."""
    done = run_process("doctor", "--json")
    read = document(done.stdout)
    assert [f for f in read["findings"] if not f["ok"]] == []
    assert done.returncode == 0
    assert "error" not in read
    details = {f["name"]: f["detail"] for f in read["findings"]}
    assert f"pymeshlab {importlib.metadata.version('pymeshlab')}" in details["packages"]
    packages = details["packages"].split(", ")
    assert len(packages) == len(set(packages)), "a package that is required twice is named twice"
    assert "281 of MeshLab" in details["filters"]
    assert {"python", "pymeshlab", "facts", "numba", "disk"} <= set(details)


def fake_pymeshlab(folder: Path, source: str) -> dict[str, str]:
    """An environment in which `import pymeshlab` runs `source`."""
    (folder / "pymeshlab").mkdir()
    (folder / "pymeshlab" / "__init__.py").write_text(source, encoding="utf-8")
    return {"PYTHONPATH": str(folder)}


@pytest.mark.slow
def test_missing_libgl_is_found_with_its_cure(tmp_path: Path) -> None:
    """A pymeshlab whose library does not load is a finding with the package to install; the other looks go on."""
    words = "libGL.so.1: cannot open shared object file: No such file or directory"
    done = run_process("doctor", environment=fake_pymeshlab(tmp_path, f"raise ImportError({words!r})"))
    assert done.returncode == 1
    assert f"WRONG  pymeshlab     MeshLabLoadError: libGL.so.1: cannot open shared object file; {ADVICE}" in done.stdout
    assert "disk" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.slow
def test_a_pymeshlab_that_crashes_is_found(tmp_path: Path) -> None:
    """A library that ends the process does not end the doctor."""
    done = run_process("doctor", "--json", environment=fake_pymeshlab(tmp_path, "import os; os.abort()"))
    read = document(done.stdout)
    assert done.returncode == 1
    assert "pymeshlab" in read["error"]["message"]
    [finding] = [f for f in read["findings"] if f["name"] == "pymeshlab"]
    assert not finding["ok"]
    assert "-6" in finding["detail"]  # SIGABRT


def test_another_pymeshlab_is_wrong_only_if_its_filters_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    """A newer version with the same filters is named and is well; a filter that differs is wrong, with the version to install."""
    differences: list[str] = []
    monkeypatch.setattr(facts, "differences_from_installed", lambda: differences)
    assert found(findings.look_at_facts, "facts").ok
    assert importlib.metadata.version("pymeshlab") in found(findings.look_at_facts, "facts").detail
    differences.append("filter 'apply_coord_taubin_smoothing' is not installed")
    assert not found(findings.look_at_facts, "facts").ok
    assert found(findings.look_at_facts, "facts").detail.startswith("1 of MeshLab")
    assert f"pymeshlab=={facts.table_version()}" in found(findings.look_at_facts, "facts").advice


def test_a_broken_plugin_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """A third party's plugin that does not load is wrong, and the package that brought it is named."""
    broken = registry.BrokenPlugin("scanlab", "scanlab = scanlab.filters", "ImportError: no module named 'scan'")
    monkeypatch.setattr(registry, "broken_plugins", lambda: (broken,))
    finding = found(findings.look_at_plugins, "plugin")
    assert not finding.ok
    assert finding.detail == "scanlab: scanlab = scanlab.filters: ImportError: no module named 'scan'"
    assert "uninstall scanlab" in finding.advice
    monkeypatch.setattr(findings, "look_at_pymeshlab", lambda: iter(()))
    assert invoke("doctor").exit_code == 1


def test_a_full_disk_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """Less free space than two copies of a large scan need is a finding."""
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=10_000_000))
    assert not found(findings.look_at_disk, "disk").ok
    assert "TMPDIR" in found(findings.look_at_disk, "disk").advice


def test_kernels_that_are_kept_nowhere_are_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the folder cannot be written every process compiles anew; the cure is named."""
    from pymeshfair.filters import compilation

    monkeypatch.setattr(compilation, "stored", lambda: compilation.Stored(0, 0, Path("/proc/nowhere"), lasts=False))
    assert not found(findings.look_at_numba, "numba").ok
    assert "NUMBA_CACHE_DIR" in found(findings.look_at_numba, "numba").advice


def test_a_numba_that_computes_wrong_results_is_not_said_to_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line that is marked as wrong says what is wrong."""
    monkeypatch.setattr("numba.njit", lambda function: lambda number: 0)
    assert not found(findings.look_at_numba, "numba").ok
    assert found(findings.look_at_numba, "numba").detail.startswith("computes wrongly")


def test_where_nothing_is_compiled_the_command_for_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """An installation without kernels is sound, and slower at first."""
    from pymeshfair.filters import compilation

    monkeypatch.setattr(compilation, "stored", lambda: compilation.Stored(0, 0, Path("/tmp/store"), lasts=True))
    assert found(findings.look_at_numba, "numba").ok
    assert "doctor --warm" in found(findings.look_at_numba, "numba").advice


@pytest.mark.slow
def test_warming_compiles_what_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    """`--warm` hands the whole list to the compiler, and tells what it could not compile."""
    from pymeshfair.filters import compilation

    asked = []

    def compile_ahead(signatures: object, **options: object) -> list[str]:
        asked.append(signatures)
        return ["pymeshfair.filters.a.b: TypeError"]

    monkeypatch.setattr(compilation, "compile_ahead", compile_ahead)
    assert invoke("doctor", "--warm", "--remove").exit_code == 2
    done = invoke("doctor", "--warm")
    assert asked == [compilation.listed_signatures()]
    assert "not compiled: pymeshfair.filters.a.b" in done.stderr


def test_a_look_that_fails_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception within one look is told under its name and stops no other."""

    def broken() -> Iterator[findings.Finding]:
        raise OSError("no such thing")

    broken.__name__ = "look_at_python"
    monkeypatch.setattr(findings, "look_at_python", broken)
    monkeypatch.setattr(findings, "look_at_pymeshlab", lambda: iter(()))
    looked = {f.name: f for f in findings.look_around()}
    assert not looked["python"].ok
    assert looked["python"].detail == "OSError: no such thing"
    assert looked["disk"].ok
