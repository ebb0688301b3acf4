"""Batches against a loop of runs, with killers, and killed: ``python benchmarks/batch.py [WHAT ...] [--scans N]``.

* speed: scans of 20,000 vertices by a batch and by a loop of ``pymeshfair run``, half of which comes before the batch and half
  after. The batch may take 0.6 of the loop's time.
* hundred: 100 such scans with smooth_taubin by a batch, and every fifth by a loop, whose time is then taken five times; in
  processor time, too. The same bound.
* small: scans of 162 vertices, one at a time. Each may cost 0.15 s beyond its filtering.
* killers: one scan of twenty ends its worker: by a segmentation fault, an abort, a hang, memory, or as a torn file. All others
  are done, these are named, and the batch's own process grows by 20 MB at most after its first tenth.
* kills: the batch is killed at 20 random moments, each time resumed, and compared with one that was not.

Exits with 1 if a bound does not hold.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.batch.batches import (
    KILLERS,
    KINDS,
    contents,
    journal_of,
    run_batch,
    start_batch,
    with_module,
    write_killers,
    write_recipe,
    write_scans,
)
from tests.commands.command_line import run_process
from tests.meshes import torus
from tests.running.runs import ply_bytes, xyz

#: of the loop's time, that the batch may take
RATIO = 0.6
#: seconds that a small scan may cost beyond its filtering
OVERHEAD = 0.15
#: bytes that the batch's own process may grow by
GROWTH = 20e6


def speed(folder: Path, count: int) -> bool:
    """The batch against the loop."""
    scans, good = _scans(folder / "scans", count), True
    for recipe in ("smooth_taubin", "smooth_implicit"):
        run_process("run", recipe, scans / "scan000.ply", "-o", folder / "warm.ply", "--overwrite")
        loop = _loop(recipe, sorted(scans.iterdir())[: count // 2], folder / "loop")
        started = time.perf_counter()
        done = run_batch(recipe, scans, "-o", folder / "batch")
        batch = time.perf_counter() - started
        assert done.returncode == 0, done.stderr
        loop += _loop(recipe, sorted(scans.iterdir())[count // 2 :], folder / "loop")
        print(f"{recipe}: batch {batch:.1f} s, loop {loop:.1f} s, ratio {batch / loop:.3f} (bound {RATIO})")
        good &= batch <= RATIO * loop
        for name in ("batch", "loop"):
            shutil.rmtree(folder / name)
    return good


def hundred(folder: Path, count: int) -> bool:
    """The batch against a fifth of the loop, in processor time and by the clock."""
    scans, every = _scans(folder / "scans", count), 5
    run_process("run", "smooth_taubin", scans / "scan000.ply", "-o", folder / "warm.ply")
    used, began = _processor_seconds(), time.perf_counter()
    some = sorted(scans.iterdir())[::every]
    _loop("smooth_taubin", some, folder / "loop")
    share = count / len(some)
    loop, loop_clock = share * (_processor_seconds() - used), share * (time.perf_counter() - began)
    used, began = _processor_seconds(), time.perf_counter()
    done = run_batch("smooth_taubin", scans, "-o", folder / "batch")
    batch, batch_clock = _processor_seconds() - used, time.perf_counter() - began
    assert done.returncode == 0, done.stderr
    for scan in some:
        assert (folder / "batch" / scan.name).read_bytes() == (folder / "loop" / scan.name).read_bytes()
    print(
        f"{count} scans: batch {batch:.1f} s of processor time, loop {loop:.1f} s, ratio {batch / loop:.3f} (bound {RATIO}); "
        f"by the clock {batch_clock:.1f} s and {loop_clock:.1f} s, ratio {batch_clock / loop_clock:.3f}"
    )
    return batch <= RATIO * loop and batch_clock <= RATIO * loop_clock


def _scans(folder: Path, count: int) -> Path:
    """A folder of so many noisy scans of 20,000 vertices."""
    import numpy as np

    vertices, faces = torus(200, 100)
    first = ply_bytes(xyz(vertices), faces.tolist())
    begin = first.index(b"end_header\n") + len(b"end_header\n")
    folder.mkdir()
    for number in range(count):
        noisy = vertices + np.random.default_rng(number).normal(scale=0.003, size=vertices.shape)
        (folder / f"scan{number:03}.ply").write_bytes(first[:begin] + noisy.tobytes() + first[begin + noisy.nbytes :])
    return folder


def _loop(recipe: str, scans: list[Path], folder: Path) -> float:
    folder.mkdir(exist_ok=True)
    started = time.perf_counter()
    for scan in scans:
        done = run_process("run", recipe, scan, "-o", folder / scan.name)
        assert done.returncode == 0, done.stderr
    return time.perf_counter() - started


def small(folder: Path, count: int) -> bool:
    """What small scans cost beyond their filtering."""
    scans = write_scans(folder / "scans", count)
    started, used = time.perf_counter(), _processor_seconds()
    done = run_batch("smooth_taubin", scans, "-o", folder / "out", "--jobs", "1", "--json")
    seconds, used = time.perf_counter() - started, _processor_seconds() - used
    assert done.returncode == 0, done.stderr
    filtering = sum(step["seconds"] for scan in json.loads(done.stdout)["scans"] for step in scan["steps"])
    each = (seconds - filtering) / count
    print(f"{count} scans of 162 vertices one at a time: {seconds:.1f} s, {each:.3f} s each beyond filtering (bound {OVERHEAD})")
    print(f"  {used / count:.3f} s each of processor time, all included")
    started = time.perf_counter()
    assert run_batch("smooth_taubin", scans, "-o", folder / "both").returncode == 0
    print(f"  on all processors: {time.perf_counter() - started:.1f} s")
    return bool(each <= OVERHEAD)


def _processor_seconds() -> float:
    """What all processes that have ended took, those that they started included."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def killers(folder: Path, count: int) -> bool:
    """What becomes of the others, and of the batch's own process."""
    each = max(1, count // 20 // len(KINDS))
    scans = write_scans(folder / "scans", count - each * len(KINDS))
    write_killers(scans, each)
    environment = with_module(folder / "lib", KILLERS)
    limits = ("--timeout", "20", "--memory", "1GB")
    process = start_batch(
        write_recipe(folder / "recipe.mlx"), scans, "-o", folder / "out", *limits, "--json", environment=environment, quiet=True
    )
    sizes = []
    while process.poll() is None:
        ended = len(journal_of(folder / "out"))
        if ended >= count // 10:
            sizes.append(_resident(process))
        time.sleep(0.2)
    counts = json.loads((folder / "out" / "batch.json").read_text("utf-8"))["counts"]
    growth = max(sizes) - sizes[0]
    print(f"{count} scans with {each * len(KINDS)} killers: {counts}, exit {process.returncode}, grown by {growth / 1e6:.1f} MB")
    return process.returncode == 1 and counts["failed"] == each * len(KINDS) and growth <= GROWTH


def _resident(process: subprocess.Popen[str]) -> int:
    lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmRSS:")), 0)


def kills(folder: Path, count: int) -> bool:
    """Whether batches that were killed at random moments and resumed give what one gives that was not."""
    scans = write_scans(folder / "scans", count)
    recipe = write_recipe(folder / "recipe.mlx", steps=100)
    process = _begun(recipe, scans, folder / "whole")
    started = time.perf_counter()
    process.communicate()
    seconds = time.perf_counter() - started
    expected = contents(folder / "whole")
    good, finished = 0, []
    for seed in range(20):
        out = folder / f"killed{seed}"
        process = _begun(recipe, scans, out)
        time.sleep(random.Random(seed).uniform(0.0, seconds))
        process.kill()
        process.communicate()
        before = len(journal_of(out))
        done = run_batch(recipe, scans, "-o", out, "--resume", "--json")
        lines = [line["output"] for line in journal_of(out)]
        same = done.returncode == 0 and contents(out) == expected and len(lines) == len(set(lines))
        same &= json.loads(done.stdout)["counts"]["resumed"] >= before
        good += same
        finished.append(before)
        shutil.rmtree(out)
    print(f"killed and resumed: {good} of 20 the same byte for byte; finished before the kill, of {count}: {finished}")
    return good == 20


def _begun(recipe: Path, scans: Path, folder: Path) -> subprocess.Popen[str]:
    """A batch whose first scan is under way."""
    process = start_batch(recipe, scans, "-o", folder)
    while process.poll() is None and not any(folder.glob(".pymeshfair-run-*")):
        time.sleep(0.01)
    return process


#: how many scans each takes, unless it is told
BENCHMARKS = {
    "speed": (speed, 100),
    "hundred": (hundred, 100),
    "small": (small, 1000),
    "killers": (killers, 200),
    "kills": (kills, 20),
}


def main() -> int:
    """Measure; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", nargs="*", choices=[*BENCHMARKS, []])
    parser.add_argument("--scans", type=int)
    options = parser.parse_args()
    good = True
    for name in options.what or BENCHMARKS:
        measure, usual = BENCHMARKS[name]
        with tempfile.TemporaryDirectory() as folder:
            good &= measure(Path(folder), options.scans or usual)
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
