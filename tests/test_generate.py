"""The command that writes stubs, pages and the table of MeshLab's filters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import generate
import pages
import pytest

from pymeshfair import registry
from pymeshfair.registry import custom_filters


@pytest.fixture
def target(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that is generated in place of the stub."""
    file = tmp_path / "generated.txt"
    file.write_text("old", encoding="utf-8")
    monkeypatch.setitem(generate.TARGETS, "stubs", lambda: {file: "new"})
    return file


def test_a_check_writes_nothing(target: Path) -> None:
    """`--check` fails where a file is not current and leaves it; without it the file is written and the check passes."""
    assert generate.main(["stubs", "--check"]) == 1
    assert target.read_text(encoding="utf-8") == "old"
    assert generate.main(["stubs"]) == 0
    assert target.read_text(encoding="utf-8") == "new"
    assert generate.main(["stubs", "--check"]) == 0


def test_nothing_is_written_while_a_plugin_of_ours_is_broken(
    target: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A plugin of ours that cannot be loaded would vanish from the files: it is named, and they stay."""
    broken = registry.BrokenPlugin("pymeshfair", "fairing = pymeshfair.plugins.x", "ImportError: no module named 'scan'")
    monkeypatch.setattr(generate, "broken_plugins", lambda: (broken,))
    assert generate.main(["stubs"]) == 1
    assert "plugin 'fairing' of pymeshfair cannot be used: ImportError: no module named 'scan'" in capsys.readouterr().err
    assert target.read_text(encoding="utf-8") == "old"


def test_a_key_that_the_bibliography_lacks_names_file_and_filter(
    target: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A misspelt key of a declaration ends the command with the bibliography's path, the filter and the nearest key."""
    known = next(f for f in custom_filters() if "taubin1995" in f.references)
    monkeypatch.setattr(pages, "custom_filters", lambda: (replace(known, references=("taubn1995",)),))
    assert generate.main(["stubs", "pages"]) == 1
    said = capsys.readouterr().err
    for words in (str(pages.BIBLIOGRAPHY), known.python_name, "'taubn1995'", "did you mean 'taubin1995'"):
        assert words in said
    assert target.read_text(encoding="utf-8") == "old"
