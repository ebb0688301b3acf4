"""Damaged mesh files of every format through the checks, through whole runs in forked processes, and through the command.

    python benchmarks/hostile_files.py [--checks N] [--runs N] [--commands N] [--format NAME]

Prints what is wrong with each file and keeps that file, then the counts by format. A death of a worker is none of the command,
and is counted by itself. Ends with 1 if a check raises or takes over 10 s of processor time, if a run or a command says nothing
of faces that are gone, or if a command dies.
"""

from __future__ import annotations

import argparse
import contextlib
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

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.hostile.mutants import MATERIALS, SEEDS, check, faces_declared, mutant
from tests.running.runs import session_report

from pymeshfair.errors import RunError

SLOW = 10.0
_FINE = ("read", "refused", "worker died")


def by_check(path: Path, folder: Path) -> str:
    """What the check says."""
    return check(path, folder / "given")


def by_run(path: Path, folder: Path) -> str:
    """What a run without steps does, in a process of its own."""
    child = os.fork()
    if child:
        _, status = os.waitpid(child, 0)
        return "worker died" if os.WIFSIGNALED(status) else (folder / "verdict").read_text()
    with contextlib.suppress(BaseException):
        signal.alarm(60)
        nothing = os.open(os.devnull, os.O_RDWR)
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)
        (folder / "verdict").write_text("ended without a word")
        (folder / "verdict").write_text(_verdict_of_run(path, folder))
    os._exit(0)


def _verdict_of_run(path: Path, folder: Path) -> str:
    try:
        report = session_report(path, folder / "out.ply")
    except RunError:
        return "refused"
    except Exception as error:
        return f"raises {type(error).__name__}: {str(error)[:100]}"
    return _told(path, report["after"]["faces"], report["warnings"])


def by_command(path: Path, folder: Path) -> str:
    """What the command does with a recipe of one step."""
    command = [sys.executable, "-m", "pymeshfair", "run", "smooth_taubin", path, "-o", folder / "out.ply", "--json"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode not in (0, 1):
        return f"ends with {done.returncode}"
    document = json.loads(done.stdout)
    if done.returncode:
        kind = document["error"]["kind"]
        return "worker died" if kind == "WorkerDied" else f"says {kind}" if kind == "WorkerError" else "refused"
    return _told(path, document["after"]["faces"], document["warnings"])


def _told(path: Path, faces: int, warnings: list[str]) -> str:
    declared = faces_declared(path)
    if declared is not None and faces < declared and not warnings:
        return f"says nothing of {declared - faces} faces that are gone"
    return "read"


def main() -> int:
    """Try the files, print what is wrong, and return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checks", type=int, default=10_000)
    parser.add_argument("--runs", type=int, default=1_000)
    parser.add_argument("--commands", type=int, default=200)
    parser.add_argument("--format", default="")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    wrong = 0
    kept = Path(tempfile.mkdtemp(prefix="hostile-"))
    for way, number in ((by_check, options.checks), (by_run, options.runs), (by_command, options.commands)):
        for name in (n for n in SEEDS if options.format in n):
            choose, counts, slowest, started = random.Random(f"{options.seed} {name}"), Counter[str](), 0.0, time.time()
            for k in range(number):
                folder = kept / "work"
                folder.mkdir()
                (folder / "a.mtl").write_bytes(MATERIALS)
                path = folder / name
                path.write_bytes(mutant(name, choose))
                begun = sum(os.times()[:4])
                verdict = way(path, folder)
                seconds = sum(os.times()[:4]) - begun
                slowest = max(slowest, seconds)
                if seconds > SLOW and verdict in _FINE:
                    verdict = "takes over 10 s"
                counts[verdict if verdict in _FINE else "WRONG"] += 1
                if verdict not in _FINE[:2]:
                    wrong += verdict not in _FINE
                    shutil.copy(path, kept / f"{way.__name__}-{k}-{name}")
                    print(f"{way.__name__} {name} {k}: {verdict}", flush=True)
                shutil.rmtree(folder)
            if number:
                print(
                    f"{way.__name__} {name}: {dict(counts)}, slowest {slowest:.2f} s, {time.time() - started:.0f} s", flush=True
                )
    print(f"wrong: {wrong}; the files are in {kept}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
