"""The token of the page to tune on, which no other user of the machine can get."""

from __future__ import annotations

import os
import shutil
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
import trimesh

from tests.commands.command_line import COMMAND
from tests.meshes import icosphere

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")


@dataclass(frozen=True)
class Opened:
    """A server that has opened a browser: its address, and the one that the browser was given."""

    address: str
    given: str

    @property
    def token(self) -> str:
        """The secret part of the address."""
        return urlsplit(self.address).path.strip("/")

    @property
    def file(self) -> Path:
        """The file that the browser was given."""
        return Path(unquote(urlsplit(self.given).path))


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[Opened]:
    """A server and a browser, which is a program that writes down what it was given, and stays."""
    trimesh.Trimesh(*icosphere(2), process=False).export(tmp_path / "scan.ply")
    browser, given = tmp_path / "browser", tmp_path / "given"
    browser.write_text(f'#!/bin/sh\necho "$$ $1" > {given}.new\nmv {given}.new {given}\nread stays < {tmp_path}/pipe\n')
    browser.chmod(0o755)
    os.mkfifo(tmp_path / "pipe")
    environment = {**os.environ, "BROWSER": f"{browser} %s &"}
    command = [*COMMAND, "tune", str(tmp_path / "scan.ply")]
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        deadline = time.monotonic() + 60
        while not given.exists():
            assert time.monotonic() < deadline
            time.sleep(0.02)
        number, url = given.read_text().split()
        yield Opened(address, url)
        process.send_signal(signal.SIGINT)
        process.wait(20)
        os.kill(int(number), signal.SIGKILL)


def test_the_browser_is_given_a_file_that_leads_to_the_page(opened: Opened) -> None:
    """The file is for this user alone, and holds the address, which the command line does not."""
    assert opened.token not in opened.given
    assert opened.given.startswith("file:///")
    assert stat.S_IMODE(opened.file.stat().st_mode) == 0o600
    assert f'content="0; url={opened.address}"' in opened.file.read_text()


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() != 0, reason="only the superuser can be another user, too")
def test_another_user_cannot_get_the_token(opened: Opened) -> None:
    """He finds it on no command line and in no environment, cannot read the file, and is refused without it."""

    def as_nobody(shell: str, script: str, *arguments: str) -> subprocess.CompletedProcess[bytes]:
        command = [shell, "-c", script, shell, *arguments]
        return subprocess.run(command, capture_output=True, user=65534, group=65534, extra_groups=[])

    seen = as_nobody("sh", "cat /proc/[0-9]*/cmdline /proc/[0-9]*/environ").stdout
    assert opened.given.encode() in seen  # so he does see command lines
    assert opened.token.encode() not in seen
    assert as_nobody("sh", 'cat "$1"', str(opened.file)).returncode != 0
    if shutil.which("bash") is None:
        pytest.skip("this asks by bash")
    place = urlsplit(opened.address)
    ask = 'exec 3<>"/dev/tcp/$1/$2"; printf "GET / HTTP/1.0\\r\\nHost: $1\\r\\n\\r\\n" >&3; cat <&3'
    assert b" 403 " in as_nobody("bash", ask, str(place.hostname), str(place.port)).stdout.splitlines()[0]
