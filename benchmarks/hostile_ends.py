"""Runs that are killed, interrupted, cut off from their reader or out of disk, at random moments: what is there afterwards.

    python benchmarks/hostile_ends.py [--kills N] [--signals N] [--pipes N] [--disks N]

An output is torn if it is none of the two that a whole run makes; a success is false if the exit code is 0 and the new output is
not there; left behind is whatever is in the folder besides both files once the command has ended, after SIGKILL
once the next run has. Disks need the superuser of a Linux system. Ends with 1 if anything of that happened.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import pymeshlab

from pymeshfair.files.provenance import provenance_path, read_provenance, recorded_digest, sha256_of

SCAN = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "bunny.obj"
_STEPS = ("3", "4")


def command(output: Path, steps: str) -> list[str]:
    """A run that makes one of two results."""
    run = [sys.executable, "-m", "pymeshfair", "run", "smooth_taubin", str(SCAN), "-o", str(output), "--json"]
    return [*run, "--set", f"1.stepSmoothNum={steps}"]


def whole(output: Path, digests: dict[str, str]) -> list[str]:
    """What is wrong with an output and what lies beside it."""
    wrong = []
    if output.exists():
        digest = sha256_of(output)
        record = read_provenance(output)
        if digest not in digests.values():
            wrong.append("the output is torn")
        elif record is not None and recorded_digest(record, output) != digest:
            wrong.append("the provenance is another one's")
        elif provenance_path(output).exists() and record is None:
            wrong.append("the provenance is torn")
    return wrong


def left_behind(output: Path) -> list[str]:
    """What is there that should not be."""
    return [p.name for p in output.parent.iterdir() if p not in (output, provenance_path(output))]


def made(folder: Path) -> tuple[dict[str, str], float]:
    """The digests of both results, and how long a run takes."""
    digests, seconds = {}, 0.0
    for steps in _STEPS:
        started = time.perf_counter()
        subprocess.run(command(folder / "out.ply", steps), check=True, capture_output=True)
        seconds = time.perf_counter() - started
        digests[steps] = sha256_of(folder / "out.ply")
    return digests, seconds


def ended_at_random(folder: Path, way: str, digests: dict[str, str], seconds: float, choose: random.Random) -> list[str]:
    """What is wrong after a run was ended in that way."""
    output, steps = folder / "out.ply", choose.choice(_STEPS)
    process = subprocess.Popen(command(output, steps), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    time.sleep(choose.uniform(0, 1.1 * seconds))
    if way == "pipes":
        process.stdout.close()
        process.wait()
    elif way == "kills":
        process.kill()
        process.wait()
        time.sleep(0.3 + 0.5 * seconds)  # in which the worker sees that it is alone
    else:
        for _ in range(choose.randrange(1, 6)):
            process.send_signal(choose.choice((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)))
            time.sleep(choose.choice((0.0, 0.0, 0.05)))
        process.communicate()
    wrong = whole(output, digests)
    if process.returncode == 0 and (not output.exists() or sha256_of(output) != digests[steps]):
        wrong.append("a false success")
    if way == "kills":
        subprocess.run(command(output, steps), check=True, capture_output=True)
    return wrong + [f"{name} is left behind" for name in left_behind(output)]


def on_small_disk(folder: Path, digests: dict[str, str], choose: random.Random) -> list[str]:
    """What is wrong after a run on a disk of a random size about what it takes."""
    disk = folder / "disk"
    disk.mkdir(exist_ok=True)
    size = (folder / "out.ply").stat().st_size + 20_000
    mount = ["mount", "-t", "tmpfs", "-o", f"size={int(choose.uniform(0.1, 2.2) * size / 4096) * 4096}", "tmpfs", str(disk)]
    subprocess.run(mount, check=True)
    try:
        output = disk / "out.ply"
        done = subprocess.run(command(output, "3"), capture_output=True, text=True)
        wrong = whole(output, digests)
        if done.returncode == 0 and not output.exists():
            wrong.append("a false success")
        if done.returncode:
            told = json.loads(done.stdout)["error"]
            if told["kind"] != "OutputError":
                wrong.append(f"says {told['kind']}: {told['message'][:150]}")
        return wrong + [f"{name} is left behind" for name in left_behind(output)]
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def main() -> int:
    """Try all ways, print what is wrong, and return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for way, number in (("kills", 100), ("signals", 100), ("pipes", 40), ("disks", 40)):
        parser.add_argument(f"--{way}", type=int, default=number)
    options = parser.parse_args()
    choose, counts = random.Random(3), Counter[str]()
    folder = Path(tempfile.mkdtemp(prefix="hostile-"))
    try:
        digests, seconds = made(folder)
        for way in ("kills", "signals", "pipes"):
            for number in range(getattr(options, way)):
                wrong = ended_at_random(folder, way, digests, seconds, choose)
                counts[way] += 1
                counts["wrong"] += bool(wrong)
                for text in wrong:
                    print(f"{way} {number}: {text}", flush=True)
        for number in range(options.disks if os.name == "posix" and os.geteuid() == 0 else 0):
            wrong = on_small_disk(folder, digests, choose)
            counts["disks"] += 1
            counts["wrong"] += bool(wrong)
            for text in wrong:
                print(f"disks {number}: {text}", flush=True)
        print(dict(counts))
    finally:
        shutil.rmtree(folder)
    return int(counts["wrong"] > 0)


if __name__ == "__main__":
    sys.exit(main())
