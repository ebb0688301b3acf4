"""What needs an extra says so before it works, with the command that installs it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

#: by the package that is missing: its extra, and a command that needs it
COMMANDS = {
    "matplotlib": ("plot", ["spectrum", "scan.ply", "-o", "curve.png"]),
    "websockets": ("tune", ["tune", "scan.ply"]),
    "distributed": ("cluster", ["batch", "denoise", "scan.ply", "-o", "out", "--scheduler", "tcp://127.0.0.1:1"]),
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


def test_a_batch_needs_no_extra(tmp_path: Path) -> None:
    """Where none of the packages of extras is there, a batch on this machine goes to its end."""
    (tmp_path / "cube.off").write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    missing = ["distributed", "dask", "laspy", "pye57", "matplotlib", "websockets"]
    program = (
        f"import sys; sys.modules.update(dict.fromkeys({missing!r})); from pymeshfair.commands.app import main; sys.exit(main())"
    )
    command = [sys.executable, "-c", program, "batch", "smooth_taubin", "cube.off", "-o", "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "cube.off").exists()
