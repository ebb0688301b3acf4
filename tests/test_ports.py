"""Work on this machine alone opens no ports, which other users and other machines could connect to."""

from __future__ import annotations

import os
import socket
import sys
import time
from pathlib import Path

import pytest

from tests.batch.batches import start_batch, write_recipe, write_scans
from tests.ports import lets_in, listening
from tests.tiles.test_clouds import uneven
from tests.tiles.test_processes import LOOP, started
from tests.tiles.tiling import children_of, write_cloud

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads tables of Linux")


def test_a_batch_opens_no_port(tmp_path: Path) -> None:
    """While scans are cleaned, no process of the batch waits for connections, and another user gets none."""
    scans, recipe = write_scans(tmp_path / "scans", 2), write_recipe(tmp_path / "recipe.mlx", steps=100_000)
    batch = start_batch(recipe, scans, "-o", tmp_path / "out", "--jobs", "2")
    try:
        deadline = time.monotonic() + 60
        while len(list((tmp_path / "out").glob(".pymeshfair-run-*"))) < 2:
            assert batch.poll() is None, batch.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.05)
        assert len(children_of(batch.pid)) > 1
        found = listening(batch.pid)
        assert not [address for address in found if lets_in(address)]
        assert not found
    finally:
        batch.kill()
        batch.communicate()


def test_a_run_by_tiles_opens_no_port(tmp_path: Path) -> None:
    """While tiles are done, no process of the run waits for connections, and another user gets none."""
    recipe = tmp_path / "loop.mlx"
    recipe.write_text(LOOP)
    run = started(recipe, write_cloud(tmp_path / "scan.ply", uneven(5)), tmp_path / "out.ply", slow=1000)
    try:
        assert children_of(run.pid)
        found = listening(run.pid)
        assert not [address for address in found if lets_in(address)]
        assert not found
        workers = children_of(run.pid)
    finally:
        run.kill()
        run.communicate()
    deadline = time.monotonic() + 10
    while any(Path(f"/proc/{pid}/exe").exists() for pid in workers):
        assert time.monotonic() < deadline, "workers outlive a run that was killed"
        time.sleep(0.05)


def test_an_open_port_is_seen() -> None:
    """The test itself: a process that listens on the loopback is seen, and lets another user in."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1 {server.getsockname()[1]}"
        assert address in listening(os.getpid())
        assert lets_in(address)
    assert not lets_in(address)
