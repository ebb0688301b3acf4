"""A few damaged files through the command itself; benchmarks/hostile_files.py tries hundreds of each format."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "hostile_files.py"


@pytest.mark.skipif(sys.platform != "linux", reason="forks")
def test_the_command_survives_damaged_files() -> None:
    """Each ends with its exit code and one document, leaves nothing behind, and says what faces are gone."""
    command = [
        sys.executable,
        str(BENCHMARK),
        "--checks",
        "0",
        "--runs",
        "0",
        "--commands",
        "3",
        "--format",
        ".ply",
        "--seed",
        "5",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout[-2000:]
    assert re.findall(r"^by_command (\S+): ", done.stdout, re.MULTILINE) == ["text.ply", "binary.ply"]
    assert "wrong: 0" in done.stdout
