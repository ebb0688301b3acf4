"""Batches as processes: killers, kill -9, Ctrl-C, and what is left of them."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.tiles.sources import PlyFile
from tests.commands.command_line import run_process
from tests.running.test_supervise import slowness
from tests.tiles.test_clouds import uneven
from tests.tiles.test_processes import SLOW
from tests.tiles.tiling import write_cloud

from .batches import (
    KILLERS,
    KINDS,
    contents,
    journal_of,
    results_of_run,
    run_batch,
    start_batch,
    with_module,
    write_killers,
    write_recipe,
    write_scan,
    write_scans,
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc, and needs signals")


@pytest.mark.slow
def test_killers_cost_themselves_alone(tmp_path: Path) -> None:
    """Five of seven scans die: by a segmentation fault, an abort, a hang, memory and a torn file. All are named, two done."""
    scans = write_scans(tmp_path / "scans", 2)
    recipe = write_recipe(tmp_path / "recipe.mlx")
    expected = results_of_run(recipe, scans, tmp_path / "run")
    write_killers(scans)
    killing = with_module(tmp_path / "lib", KILLERS)
    limits = ("--timeout", "6", "--memory", "800MB", "--jobs", "2")
    done = run_batch(recipe, scans, "-o", tmp_path / "out", *limits, "--json", environment=killing)
    assert done.returncode == 1, done.stderr
    assert contents(tmp_path / "out") == expected
    document = json.loads(done.stdout)
    assert document["counts"] == {"scans": 7, "done": 2, "broken": 0, "failed": 5, "resumed": 0, "left": 0}
    failed = {Path(scan["input"]).stem[:-1]: scan["error"] for scan in document["scans"] if scan["status"] == "failed"}
    assert set(failed) == set(KINDS)
    words = {"segfault": "SIGSEGV", "abort": "SIGABRT", "hang": "6 s", "memory": "memory", "truncated": "cut short"}
    for kind, word in words.items():
        assert word in failed[kind]["message"]
        assert f"{kind}0.ply" in failed[kind]["message"]
        assert failed[kind]["message"] in done.stderr
    assert json.loads((tmp_path / "out" / "batch.json").read_text("utf-8")) == document


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, dict[str, bytes], float]:
    """A recipe, eight scans, what a batch makes of them, and how long that takes."""
    folder = tmp_path_factory.mktemp("uninterrupted")
    scans = write_scans(folder / "scans", 8)
    recipe = write_recipe(folder / "recipe.mlx", steps=300)
    started = time.monotonic()
    done = run_batch(recipe, scans, "-o", folder / "out", "--jobs", "2")
    assert done.returncode == 0, done.stderr
    return recipe, scans, contents(folder / "out"), time.monotonic() - started


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_a_killed_batch_resumes(tmp_path: Path, uninterrupted: tuple[Path, Path, dict[str, bytes], float], seed: int) -> None:
    """Killed at a random moment and resumed, it gives what it gives uninterrupted; nothing is torn, left behind or done twice."""
    recipe, scans, expected, seconds = uninterrupted
    out = tmp_path / "out"
    process = start_batch(recipe, scans, "-o", out, "--jobs", "2")
    time.sleep(random.Random(seed).uniform(0.3, 1.0) * seconds)
    process.send_signal(signal.SIGSTOP)
    time.sleep(0.2)  # a worker that it has asked for is there now, and no other will be
    workers = descendants(process.pid)
    process.kill()
    process.communicate()
    deadline = time.monotonic() + 30.0
    while any(is_alive(worker) for worker in workers) and time.monotonic() < deadline:
        time.sleep(0.05)  # they end by themselves; what they work on is not taken from them before
    before = [line["output"] for line in journal_of(out)]
    done = run_batch(recipe, scans, "-o", out, "--jobs", "2", "--resume", "--json")
    assert done.returncode == 0, done.stderr
    assert contents(out) == expected
    lines = [line["output"] for line in journal_of(out)]
    assert len(lines) == len(set(lines))
    assert set(before) <= set(lines)
    counts = json.loads(done.stdout)["counts"]
    assert counts["resumed"] >= len(before)
    assert counts["done"] == 8


def descendants(pid: int) -> set[int]:
    """All processes that a process has started, and those that they have."""
    parents: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (FileNotFoundError, ProcessLookupError):
                continue
    found = {pid}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found - {pid}


def is_alive(pid: int) -> bool:
    """Whether there is such a process that has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.fixture
def busy(tmp_path: Path, terminal_signals: None) -> Iterator[subprocess.Popen[str]]:
    """A batch whose first scan is done and whose next two take long."""
    write_scans(tmp_path / "scans", 1)
    table = tmp_path / "table.csv"
    slow = "".join(f"scans/scan000.ply,{k}.ply,100000\n" for k in range(2))
    table.write_text(f"input,output,1.stepsmoothnum\nscans/scan000.ply,first.ply,\n{slow}")
    process = start_batch(write_recipe(tmp_path / "recipe.mlx"), table, "-o", tmp_path / "out", "--jobs", "2")
    deadline = time.monotonic() + 60
    while (
        not journal_of(tmp_path / "out")
        or len(list((tmp_path / "out").glob(".pymeshfair-run-*"))) < 2
        or len(descendants(process.pid)) < 2
    ):
        assert time.monotonic() < deadline
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    yield process
    process.kill()
    process.communicate()


def test_ctrl_c_ends_a_batch_soon(tmp_path: Path, busy: subprocess.Popen[str]) -> None:
    """Its processes are gone and their files with them; what is done is told in the tables, and --resume goes on from there.

    That takes a second where kernels are compiled. A process that compiles some for the first time hears of the signal when it is
    done with one: there is room for that here.
    """
    started_by_it = descendants(busy.pid)
    started = time.monotonic()
    busy.send_signal(signal.SIGINT)
    assert busy.wait(20) == 130
    assert time.monotonic() - started < 5.0 + slowness()
    assert not [pid for pid in started_by_it if is_alive(pid)]
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "first.ply",
        "first.ply.provenance.json",
        "batch.json",
        "batch.csv",
        "batch.jsonl",
    }
    counts = json.loads((tmp_path / "out" / "batch.json").read_text("utf-8"))["counts"]
    assert (counts["done"], counts["left"]) == (1, 2)


def test_a_killed_batch_takes_its_processes_along(tmp_path: Path, busy: subprocess.Popen[str]) -> None:
    """When the batch is killed, which it cannot answer, all its processes end in the middle of what they do."""
    started_by_it = descendants(busy.pid)
    os.kill(busy.pid, signal.SIGKILL)
    busy.wait()
    deadline = time.monotonic() + 10
    while any(is_alive(pid) for pid in started_by_it) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not [pid for pid in started_by_it if is_alive(pid)]


def test_two_batches_do_not_share_a_folder(tmp_path: Path, busy: subprocess.Popen[str]) -> None:
    """The second is refused while the first goes on."""
    second = run_batch("smooth_taubin", tmp_path / "scans", "-o", tmp_path / "out")
    assert second.returncode == 1
    assert "another batch is writing to" in second.stderr
    assert busy.poll() is None


def test_a_killed_process_costs_a_second_try(tmp_path: Path) -> None:
    """A scan whose process is killed is done by the next; if that is killed too it failed, and is not called damaged."""
    scans = write_scans(tmp_path / "scans", 1)
    write_scan(scans / "once.ply", 5)
    write_scan(scans / "always.ply", 6)
    program = """
import os, signal
import pymeshfair.files.inputs as inputs

def read(path, *arguments, read=inputs.read_file, **options):
    mark = path.with_name("killed.by")
    if path.name == "always.ply" or (path.name == "once.ply" and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return read(path, *arguments, **options)

inputs.read_file = read
"""
    environment = with_module(tmp_path / "lib", program)
    done = run_batch("smooth_taubin", scans, "-o", tmp_path / "out", "--jobs", "1", "--json", environment=environment)
    statuses = {scan["name"]: scan for scan in json.loads(done.stdout)["scans"]}
    assert statuses["once.ply"]["status"] == statuses["scan000.ply"]["status"] == "done"
    assert "was killed (SIGKILL)" in statuses["always.ply"]["error"]["message"]
    assert "damaged" not in statuses["always.ply"]["error"]["message"]


@pytest.mark.slow
def test_a_scan_without_enough_memory_is_cut(tmp_path: Path) -> None:
    """Where a scan needs more memory than --memory it is cut into tiles, if its recipe can be: to the bytes of one piece."""
    scans = tmp_path / "scans"
    scans.mkdir()
    cloud = write_cloud(scans / "memory.ply", uneven(3, 3000))
    whole = tmp_path / "whole.ply"
    assert run_process("run", "remove_outliers", cloud, "-o", whole).returncode == 0
    environment = with_module(tmp_path / "lib", KILLERS)
    for recipe, status in (("remove_outliers", "done"), ("cloud_to_mesh", "failed")):
        done = run_batch(recipe, scans, "-o", tmp_path / recipe, "--memory", "800MB", "--json", environment=environment)
        (scan,) = json.loads(done.stdout)["scans"]
        assert scan["status"] == status, done.stderr
        assert (tmp_path / recipe / "memory.ply").exists() == (status == "done")
    (scan,) = json.loads((tmp_path / "remove_outliers" / "batch.json").read_text("utf-8"))["scans"]
    assert "the run needed more memory than it was given, so the scan was cut into tiles" in scan["warnings"]
    ours, theirs = (PlyFile(path).vertices for path in (tmp_path / "remove_outliers" / "memory.ply", whole))
    for name in ("x", "y", "z", "quality", "number"):
        np.testing.assert_array_equal(ours.read(0, ours.element.count)[name], theirs.read(0, theirs.element.count)[name])


@pytest.mark.slow
@pytest.mark.usefixtures("terminal_signals")
def test_ctrl_c_ends_a_scan_in_tiles(tmp_path: Path) -> None:
    """A scan that is being cut into tiles ends with its batch, soon, and leaves nothing."""
    (tmp_path / "scans").mkdir()
    write_cloud(tmp_path / "scans" / "memory.ply", uneven(3, 3000))
    program = KILLERS + SLOW
    environment = {**with_module(tmp_path / "lib", program), "BEGUN": str(tmp_path / "begun"), "SLOW": "1000"}
    process = start_batch(
        "remove_outliers", tmp_path / "scans", "-o", tmp_path / "out", "--memory", "800MB", environment=environment
    )
    deadline = time.monotonic() + 100
    while not (tmp_path / "begun").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    workers = descendants(process.pid)
    started = time.monotonic()
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    assert time.monotonic() - started < 5.0 + slowness()
    assert not [pid for pid in workers if is_alive(pid)]
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["batch.jsonl"]
