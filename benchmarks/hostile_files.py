"""Damaged mesh files and scripts through the checks, through whole runs in forked processes, and through the command.

    python benchmarks/hostile_files.py [--checks N] [--runs N] [--commands N] [--format NAME] [--seed K] [--fresh] [--tables]

Prints what is wrong with each file and keeps that file, then the counts by format. A death of a worker is none of the command,
and is counted by itself. Ends with 1 if a check raises, if a run or a command says nothing of faces that are gone, if a command
dies or calls something a defect, or if anything takes over 10 s of processor time. The command is forked from this process, which
has imported it, and so is its worker (`tests.hostile.forked`); with --fresh both are started as in a shell. With --tables the
files of tests/hostile/corpora go through the command, and a line each says what became of it: verdict, seconds and memory.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os

os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")  # to fork
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from hostile_scripts import mutant as script_mutant
from tests.hostile.forked import Ended, run_command
from tests.hostile.mutants import MATERIALS, SEEDS, check, faces_declared, mutant
from tests.running.runs import session_report

import pymeshfair
import pymeshfair.running.session  # loaded once, before forks
from pymeshfair.errors import RunError
from pymeshfair.registry import all_filters

SLOW = 10.0
#: scripts that are damaged: of a small mesh each takes a moment
RECIPES = tuple(
    (Path(pymeshfair.__file__).parent / "mlx_scripts" / f"{n}.mlx").read_bytes() for n in ("smooth_taubin", "smooth_implicit")
)
_FINE = ("read", "refused", "worker died")


def by_check(path: Path, folder: Path) -> str:
    """What the check says."""
    return check(path)


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


#: a step that changes nothing, of meshes and clouds
_NOTHING = """<!DOCTYPE FilterScript>
<FilterScript>
<filter name="Select None">
<Param type="RichBool" name="allFaces" value="true"/>
<Param type="RichBool" name="allVerts" value="true"/>
</filter>
</FilterScript>
"""
#: what a warning says of faces that are gone, or perhaps were there
_OF_FACES = re.compile(r"faces?\b|cut short|holds \d+ meshes")
_FRESH = False


def by_command(path: Path, folder: Path) -> str:
    """What the command does with a recipe that changes nothing, or with a damaged recipe."""
    if path.suffix == ".mlx":
        mesh = folder / "mesh.ply"
        mesh.write_bytes(SEEDS["binary.ply"]())
        ended = _ended(folder, "run", path, mesh, "-o", folder / "out.ply", "--json", "--timeout", "9")
    else:
        recipe = folder / "nothing.mlx"
        recipe.write_text(_NOTHING)
        ended = _ended(folder, "run", recipe, path, "-o", folder / "out.ply", "--json")
    if ended.status not in (0, 1, 2) or (ended.status == 2 and path.suffix != ".mlx"):
        return f"ends with {ended.status}: {ended.stderr[-300:]}"
    left = {p.name for p in folder.iterdir() if p.name.startswith(".pymeshfair")}
    if left or (ended.status and (folder / "out.ply").exists()):
        return f"leaves {left or 'an output'} behind"
    if ended.error is not None:
        kind = ended.error["kind"]
        return {"WorkerDied": "worker died", "WorkerError": f"says {ended.error['message']}"}.get(kind, "refused")
    return "read" if path.suffix == ".mlx" else _told(path, ended.document["before"]["faces"], ended.document["warnings"])


def _ended(folder: Path, *arguments: object) -> Ended:
    if not _FRESH:
        return run_command(folder, *arguments)
    done = subprocess.run([sys.executable, "-m", "pymeshfair", *map(str, arguments)], capture_output=True, text=True)
    return Ended(done.returncode, done.stdout, done.stderr, 0.0)


def _told(path: Path, faces: int, warnings: list[str]) -> str:
    declared = faces_declared(path)
    if declared is not None and faces < declared and not any(map(_OF_FACES.search, warnings)):
        return f"says nothing of {declared - faces} faces that are gone"
    return "read"


def tables() -> int:
    """Run the command on every file of the tables; how many took too long or too much."""
    from tests.hostile.test_corpora import CASES

    wrong = 0
    for name, (data, verdict) in CASES.items():
        folder = Path(tempfile.mkdtemp(prefix="hostile-"))
        (folder / "a.mtl").write_bytes(MATERIALS)
        (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        (folder / "nothing.mlx").write_text(_NOTHING)
        ended = _ended(folder, "run", folder / "nothing.mlx", folder / name, "-o", folder / "out.ply", "--json")
        found = "refused" if ended.error else "read"
        memory = (ended.document.get("peak_memory") or 0) / 1e6
        fine = found == ("refused" if isinstance(verdict, str) else "read") and ended.seconds <= 2 and memory <= 300
        wrong += not fine
        told = ended.error["message"].split(": ", 1)[-1] if ended.error else "; ".join(ended.document["warnings"])
        print(f"{'' if fine else 'WRONG '}{name} | {found} | {told[:160]} | {ended.seconds:.2f} s | {memory:.0f} MB", flush=True)
        shutil.rmtree(folder)
    print(f"{len(CASES)} files, {wrong} wrong")
    return wrong


def _warm_up() -> None:
    """Read a good file of each format, so that forks have the compiled parts loaded."""
    for name, seed in SEEDS.items():
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            path = Path(folder) / name
            path.write_bytes(seed())
            session_report(path, Path(folder) / "out.ply")


def main() -> int:
    """Try the files, print what is wrong, and return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checks", type=int, default=10_000)
    parser.add_argument("--runs", type=int, default=1_000)
    parser.add_argument("--commands", type=int, default=200)
    parser.add_argument("--format", default="")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--fresh", action="store_true")
    parser.add_argument("--tables", action="store_true")
    options = parser.parse_args()
    global _FRESH
    _FRESH = options.fresh
    if options.tables:
        _warm_up()
        return int(tables() > 0)
    all_filters()
    _warm_up()
    wrong = 0
    kept = Path(tempfile.mkdtemp(prefix="hostile-"))
    for way, number in ((by_check, options.checks), (by_run, options.runs), (by_command, options.commands)):
        for name in (n for n in (*SEEDS, *(["a.mlx"] if way is by_command else [])) if options.format in n):
            choose, counts, slowest, started = random.Random(f"{options.seed} {name}"), Counter[str](), 0.0, time.time()
            for k in range(number):
                folder = kept / "work"
                folder.mkdir()
                (folder / "a.mtl").write_bytes(MATERIALS)
                path = folder / name
                path.write_bytes(script_mutant(choose, RECIPES) if name == "a.mlx" else mutant(name, choose))
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
