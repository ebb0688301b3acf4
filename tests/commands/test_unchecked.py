"""Files that MeshLab alone understands, or that name others: commands that show a mesh take the options of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pymeshfair.errors import RunError

from .command_line import invoke


@pytest.mark.parametrize(
    ("arguments", "reader"),
    [
        (("info", "a.3ds"), "pymeshfair.running.read.inspect_mesh"),
        (("compare", "a.3ds", "b.ply"), "pymeshfair.running.read.read_mesh"),
        (("picture", "a.3ds", "-o", "a.png"), "pymeshfair.running.read.read_mesh"),
    ],
)
@pytest.mark.parametrize("given", [(), ("--unchecked",), ("--allow-outside",), ("--unchecked", "--allow-outside")])
def test_what_is_asked_for_reaches_the_reader(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, arguments: tuple[str, ...], reader: str, given: tuple[str, ...]
) -> None:
    """`--unchecked` and `--allow-outside` are passed on, and neither is on unless it was given."""
    seen: dict[str, Any] = {}

    def read(path: Path, **more: Any) -> None:
        seen.update(more)
        raise RunError("read")

    monkeypatch.setattr(reader, read)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.3ds").touch()
    assert invoke(*arguments, *given).exit_code == 1
    assert (seen["unchecked"], seen["allow_outside"]) == ("--unchecked" in given, "--allow-outside" in given)
