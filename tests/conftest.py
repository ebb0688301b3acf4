"""What tests of all kinds need."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from pymeshfair.filters.compilation import allowed_threads

# Processes that run tests side by side are told the width of a terminal; the commands under test write to pipes.
os.environ.pop("COLUMNS", None)
# Examples may wait for the compiler, so none has a deadline; they are the same ones every time, whatever else is collected.
settings.register_profile("compiled", deadline=None, derandomize=True)
settings.load_profile("compiled")
# Numba is loaded as pymeshfair does it, before a test imports it: it would warn of an old threading library otherwise.
allowed_threads()


@pytest.fixture
def terminal_signals() -> Iterator[None]:
    """Processes that the test starts answer signals as in a terminal.

    A background job of a script ignores SIGINT, one under nohup SIGHUP, and what it starts inherits that; handlers are not
    inherited. pymeshfair leaves an ignored signal ignored, as a program should.
    """
    before: dict[int, Any] = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) == signal.SIG_IGN:
            usual = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
            before[number] = signal.signal(number, usual)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Makes a file system of its own that takes so much, such as ``"40k"``."""
    folders: list[Path] = []

    def mount(size: str) -> Path:
        if sys.platform != "linux" or os.geteuid() != 0:
            pytest.skip("mounting a disk takes the superuser of a Linux system")
        folder = tmp_path / f"disk of {size}"
        folder.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True, text=True)
        if done.returncode:
            pytest.skip(f"this system mounts no disk: {done.stderr.strip()}")
        folders.append(folder)
        return folder

    yield mount
    for folder in folders:
        subprocess.run(["umount", folder], check=True)
