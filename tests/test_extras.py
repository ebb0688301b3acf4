"""What needs an extra says so before it works, with the command that installs it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

#: by the package that is missing: its extra, and a command that needs it
COMMANDS = {
    "matplotlib": ("plot", ["spectrum", "scan.ply", "-o", "curve.png"]),
    "starlette": ("tune", ["tune", "scan.ply"]),
}


@pytest.mark.parametrize("package", COMMANDS)
def test_a_missing_package_is_named_with_its_extra(package: str, tmp_path: Path) -> None:
    """The command ends with the line that installs the package, though the mesh is no mesh at all: nothing was read."""
    extra, command = COMMANDS[package]
    for name in command:
        if name.startswith("scan"):
            (tmp_path / name).write_bytes(b"")
    program = f"import sys; sys.modules[{package!r}] = None; from pymeshfair.commands.app import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", program, *command], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode != 0
    assert f"python -m pip install 'pymeshfair[{extra}]'" in done.stderr
    assert "Traceback" not in done.stderr
