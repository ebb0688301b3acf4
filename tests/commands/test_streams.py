"""Standard streams that are closed or full, and names that would command a terminal."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pymeshfair.commands.streams import printable

from ..running.runs import BONE, names_in
from .command_line import invoke

pytestmark = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")

_COMMAND = [sys.executable, "-m", "pymeshfair"]
_RUN = [*_COMMAND, "run", "smooth_taubin"]


def run(command: str) -> subprocess.CompletedProcess[str]:
    """What a command does whose streams the shell has redirected."""
    return subprocess.run(["bash", "-c", f"set -o pipefail; {command}"], capture_output=True, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("streams", "code"), [(">&-", 0), ("2>&-", 0), ("| true", 0), (">/dev/full", 1), ("--json >/dev/full", 1), ("2>/dev/full", 0)]
)
def test_commands_end_whatever_their_streams_are(streams: str, code: int) -> None:
    """No traceback; the exit code says whether what was printed got lost, but for streams that nobody reads."""
    done = run(f"{' '.join(_COMMAND)} list recipes {streams}")
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert ("got lost: no space left on device" in done.stderr) == (code == 1)
    assert ("smooth_taubin" in done.stdout) == streams.startswith("2")


def test_a_run_without_any_stream(tmp_path: Path) -> None:
    """Its files do not get the numbers of the streams, and nothing of what it says ends up in them."""
    assert run(f"{' '.join(_RUN)} {BONE} -o {tmp_path / 'out.ply'} <&- >&- 2>&-").returncode == 0
    assert names_in(tmp_path) == {"out.ply", "out.ply.provenance.json"}
    assert (tmp_path / "out.ply").read_bytes().startswith(b"ply\nformat binary")


@pytest.mark.parametrize("environment", [{}, {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}], ids=["usual", "without UTF-8"])
def test_a_locale_without_letters(environment: dict[str, str], tmp_path: Path) -> None:
    """File names beyond ASCII are read and written in the locale C, even if Python is told not to use UTF-8 there."""
    source, output = tmp_path / "é.ply", tmp_path / "è.ply"
    source.write_bytes(BONE.read_bytes())
    done = subprocess.run([*_RUN, source, "-o", output], env={**os.environ, "LC_ALL": "C", **environment}, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert output.exists()


def test_names_do_not_command_a_terminal() -> None:
    """Every control character is shown and none is sent; letters of all languages and line feeds stay."""
    assert printable("é\x1b[31m\x07\n\x9b2J") == "é\\x1b[31m\\x07\n\\x9b2J"
    assert printable(Path("a\u202eb")) == "a\\u202eb"


def test_texts_of_scripts_do_not_either(tmp_path: Path) -> None:
    """The description of a recipe, the name of a script and of a scan are shown with their control characters escaped."""
    script, scan = tmp_path / "x\x9b2J.mlx", tmp_path / "y\x9b2J.ply"
    head = "<!DOCTYPE FilterScript>\n<!--\nTitle\x9b2J\n\nWords\x9b2J.\n-->\n"
    script.write_text(f'{head}<FilterScript><filter name="Taubin Smooth"/></FilterScript>', "utf-8")
    shutil.copy(BONE, scan)
    batch = ("batch", script, scan, "-o", tmp_path / "out", "--dry-run")
    for command in (("info", script), ("check", script), ("compare", scan, scan), batch):
        told = invoke(*command).output
        assert "\x9b" not in told, command
        assert "\\x9b2J" in told or command[0] == "compare"


def test_an_error_about_a_name_does_not_either(tmp_path: Path) -> None:
    """What a terminal is sent about a file of such a name has no escape but those of the command's own colours."""
    import pty

    main, terminal = pty.openpty()
    command = [*_RUN, str(tmp_path / "x\x1b]0;owned\x07.ply"), "-o", str(tmp_path / "out.ply")]
    subprocess.run(command, stdin=terminal, stdout=terminal, stderr=terminal)
    os.close(terminal)
    sent = os.read(main, 1 << 20)
    os.close(main)
    assert b"owned" in sent
    assert b"\x1b]" not in sent
    assert b"\x07" not in sent
