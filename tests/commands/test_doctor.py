"""`pymeshfair doctor` finds what is wrong with a machine and says what to do."""

from __future__ import annotations

import importlib.metadata
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from pymeshfair import registry
from pymeshfair.commands import findings
from pymeshfair.commands.failure import LIBGL_ADVICE

from .command_line import document, invoke, run_process


def found(name: str) -> findings.Finding:
    """The finding of that name."""
    [finding] = [f for f in findings.look_around() if f.name == name]
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
    assert "281 of MeshLab" in details["filters"]


def fake_pymeshlab(folder: Path, source: str) -> dict[str, str]:
    """An environment in which `import pymeshlab` runs `source`."""
    (folder / "pymeshlab").mkdir()
    (folder / "pymeshlab" / "__init__.py").write_text(source, encoding="utf-8")
    return {"PYTHONPATH": str(folder)}


def test_missing_libgl_is_found_with_its_cure(tmp_path: Path) -> None:
    """A pymeshlab whose library does not load is a finding with the package to install; the other looks go on."""
    words = "libGL.so.1: cannot open shared object file: No such file or directory"
    done = run_process("doctor", environment=fake_pymeshlab(tmp_path, f"raise ImportError({words!r})"))
    assert done.returncode == 1
    assert f"WRONG  pymeshlab     ImportError: {words}" in done.stdout
    assert LIBGL_ADVICE in done.stdout
    assert "disk" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr


def test_a_pymeshlab_that_crashes_is_found(tmp_path: Path) -> None:
    """A library that ends the process does not end the doctor."""
    done = run_process("doctor", "--json", environment=fake_pymeshlab(tmp_path, "import os; os.abort()"))
    read = document(done.stdout)
    assert done.returncode == 1
    assert "pymeshlab" in read["error"]["message"]
    [finding] = [f for f in read["findings"] if f["name"] == "pymeshlab"]
    assert not finding["ok"]
    assert "-6" in finding["detail"]  # SIGABRT


def test_a_broken_plugin_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """A third party's plugin that does not load is wrong, and the package that brought it is named."""
    broken = registry.BrokenPlugin("scanlab", "scanlab = scanlab.filters", "ImportError: no module named 'scan'")
    monkeypatch.setattr(registry, "broken_plugins", lambda: (broken,))
    finding = found("plugin")
    assert not finding.ok
    assert finding.detail == "scanlab: scanlab = scanlab.filters: ImportError: no module named 'scan'"
    assert "uninstall scanlab" in finding.advice
    assert invoke("doctor").exit_code == 1


def test_a_full_disk_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """Less free space than two copies of a large scan need is a finding."""
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=10_000_000))
    assert not found("disk").ok
    assert "TMPDIR" in found("disk").advice


def test_a_cache_that_cannot_be_written_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba refuses to compile with a cache where it can keep none; the cure is named."""
    import numba

    def refuse(**options: bool) -> Callable[..., None]:
        def decorate(function: Callable[..., object]) -> None:
            raise RuntimeError("cannot cache function '_successor': no locator available")

        return decorate

    monkeypatch.setattr(numba, "njit", refuse)
    assert not found("numba").ok
    assert "NUMBA_CACHE_DIR" in found("numba").advice


def test_a_look_that_fails_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception within one look is told under its name and stops no other."""

    def broken() -> str:
        raise OSError("no platform")

    monkeypatch.setattr(findings.platform, "platform", broken)
    looked = {f.name: f for f in findings.look_around()}
    assert looked["python"].detail == "OSError: no platform"
    assert looked["disk"].ok
