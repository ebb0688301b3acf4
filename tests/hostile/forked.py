"""The command itself as a fork of a process that has loaded it, which forks its worker in turn: a tenth of a second a run.

Everything else is as in a shell: processes of their own, limits of memory and time, signals, exit codes, what is printed.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, NoReturn

from pymeshfair.commands.app import main


@dataclass(frozen=True)
class Ended:
    """How a command ended.

    Attributes:
        status: its exit code, or minus the number of the signal that killed it.
        stdout, stderr: what it printed.
        seconds: of processor time that it and its worker took.
    """

    status: int
    stdout: str
    stderr: str
    seconds: float

    @property
    def document(self) -> dict[str, Any]:
        """What ``--json`` printed."""
        found = json.loads(self.stdout)
        assert isinstance(found, dict)
        return found

    @property
    def error(self) -> dict[str, Any] | None:
        """The error that ``--json`` printed, or None."""
        return self.document.get("error")


def run_command(folder: Path, *arguments: object, patience: float = 120.0) -> Ended:
    """Run the command in a fork of this process, which must have no other thread.

    Args:
        folder: the working folder; what is printed is kept there in the files ``stdout`` and ``stderr``.
        arguments: of the command.
        patience: seconds after which it is killed, as a last resort.
    """
    before = os.times()
    pid = os.fork()
    if pid == 0:
        _become(folder, [str(a) for a in arguments])
    _, status = _waited(pid, patience)
    after = os.times()
    seconds = after.children_user + after.children_system - before.children_user - before.children_system
    printed = [(folder / name).read_text("utf-8", "replace") for name in ("stdout", "stderr")]
    return Ended(os.waitstatus_to_exitcode(status), printed[0], printed[1], seconds)


def _waited(pid: int, patience: float) -> tuple[int, int]:
    limit = time.monotonic() + patience
    while time.monotonic() < limit:
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            return ended, status
        time.sleep(0.002)
    os.killpg(pid, signal.SIGKILL)
    return os.waitpid(pid, 0)


def _standard_streams() -> tuple[IO[str], ...]:
    return tuple(os.fdopen(k, mode, encoding="utf-8", closefd=False) for k, mode in enumerate("rww"))


def _become(folder: Path, arguments: Sequence[str]) -> NoReturn:
    """Be the command, in a process group of its own, and end."""
    code = 70
    try:
        os.setpgid(0, 0)
        os.chdir(folder)
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        for target, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), target)
        sys.stdin, sys.stdout, sys.stderr = _standard_streams()
        sys.argv = ["pymeshfair", *arguments]
        main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)
