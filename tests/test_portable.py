"""Clouds by tiles, batches, the page to tune on and compiling do without what only POSIX has."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from websockets.sync.client import connect

from pymeshfair.operating_system import FORCE_PORTABLE
from tests.batch.batches import contents, run_batch, with_module, write_recipe, write_scans
from tests.commands.command_line import COMMAND, document, run_process
from tests.tiles.test_clouds import uneven
from tests.tiles.test_processes import LITTLE, LOOP
from tests.tiles.tiling import write_cloud
from tests.tuning.test_tuning import sent

#: a sitecustomize module: Python without what it has on POSIX alone, as far as other libraries can do without
WITHOUT_POSIX = """
import os, resource, socket

del resource.setrlimit
for name in dir(os):
    if name in "fork forkpty killpg pidfd_open posix_spawn pread preadv pwrite pwritev setsid sendfile".split():
        delattr(os, name)
    if name.startswith(("sched_", "waitid", "P_")):
        delattr(os, name)
for name in ("recv_fds", "send_fds", "SOCK_SEQPACKET"):
    delattr(socket, name)
"""


@pytest.fixture
def portable(tmp_path: Path) -> dict[str, str]:
    """The environment in which every process uses the fallback, and has nothing else.

    It holds no locks, so that other runs would take its temporary folders for abandoned ones: they are in one of its own.
    """
    (tmp_path / "temporary").mkdir()
    return {**with_module(tmp_path / "without", WITHOUT_POSIX), FORCE_PORTABLE: "1", "TMPDIR": str(tmp_path / "temporary")}


@pytest.mark.slow
def test_a_cloud_by_tiles(portable: dict[str, str], tmp_path: Path) -> None:
    """The output is the same to the byte, though several processes write to the same files."""
    recipe, scan = tmp_path / "loop.mlx", write_cloud(tmp_path / "scan.ply", uneven(5))
    recipe.write_text(LOOP)
    made = []
    for name, environment in (("portable.ply", portable), ("posix.ply", {})):
        done = run_process("run", recipe, scan, "-o", tmp_path / name, "--tiles", *LITTLE, environment=environment)
        assert done.returncode == 0, done.stderr
        made.append((tmp_path / name).read_bytes())
    assert made[0] == made[1]


@pytest.mark.slow
def test_a_batch(portable: dict[str, str], tmp_path: Path) -> None:
    """Outputs are the same to the byte, and a batch that is resumed does nothing twice."""
    scans, recipe = write_scans(tmp_path / "scans", 2), write_recipe(tmp_path / "recipe.mlx")
    for name, environment in (("portable", portable), ("posix", {})):
        done = run_batch(recipe, scans, "-o", tmp_path / name, "--jobs", "2", environment=environment)
        assert done.returncode == 0, done.stderr
    assert contents(tmp_path / "portable") == contents(tmp_path / "posix")
    again = run_batch(recipe, scans, "-o", tmp_path / "portable", "--resume", "--json", environment=portable)
    assert json.loads(again.stdout)["counts"]["resumed"] == 2


@pytest.mark.slow
def test_the_page_to_tune_on(portable: dict[str, str], tmp_path: Path) -> None:
    """It is served, shows a scan and the result of a recipe, and ends with Ctrl-C."""
    write_scans(tmp_path / "scans", 1)
    command = [*COMMAND, "tune", str(tmp_path / "scans" / "scan000.ply"), "--no-browser", "--json"]
    with subprocess.Popen(command, env={**os.environ, **portable}, stdout=subprocess.PIPE, text=True) as process:
        try:
            place = urlsplit(document(_printed(process))["address"])
            origin: Any = f"http://{place.netloc}"
            with connect(f"ws://{place.netloc}{place.path}socket", origin=origin, max_size=None) as page:
                said = _said(page)
                assert next(s for s in said if s["is"] == "scan")["measures"]
                page.send(json.dumps({"do": "run", "recipe": "smooth_implicit", "steps": sent("smooth_implicit")}))
                assert next(s for s in said if s["is"] in ("result", "failed"))["is"] == "result"
        finally:
            process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0


@pytest.mark.slow
def test_compiling(portable: dict[str, str], tmp_path: Path) -> None:
    """What is listed is compiled in several processes, and found by the next one."""
    program = (
        "from pymeshfair.filters.compilation import compile_ahead, listed_signatures, stored\n"
        "if __name__ == '__main__':\n"
        "    names = 'pymeshfair.filters.mesh', 'pymeshfair.filters.topology.boundary'\n"
        "    some = {name: listed_signatures()[name] for name in names}\n"
        "    print(compile_ahead(some, processes=2), stored().kept)\n"
    )
    (tmp_path / "compile.py").write_text(program)
    environment = {**os.environ, **portable, "NUMBA_CACHE_DIR": str(tmp_path / "store"), "NUMBA_OPT": "1"}
    done = subprocess.run([sys.executable, tmp_path / "compile.py"], env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    failures, kept = done.stdout.rsplit(" ", 1)
    assert failures == "[]"
    assert int(kept) > 0


def _printed(process: subprocess.Popen[str]) -> str:
    """The JSON document that a process prints, and then goes on."""
    assert process.stdout is not None
    lines = list(iter(process.stdout.readline, "}\n"))
    return "".join([*lines, "}\n"])


def _said(page: Any) -> Iterator[dict[str, Any]]:
    """The documents that come from the server, without the meshes."""
    for message in page:
        if isinstance(message, str):
            yield json.loads(message)
