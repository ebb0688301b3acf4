"""How long a newcomer waits: ``python benchmarks/first_run.py [--only WORDS] [--environment FOLDER]``.

Makes a fresh environment, installs the package there as the README says, and runs every shipped recipe on a small scan with an
empty cache of compiled code, twice. The second run finds whatever the first has compiled. Results go to the file
benchmarks/first_run.json; ``python benchmarks/all.py --show`` writes them into docs/performance.md. `--environment` takes an
environment in which the package has been installed.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path
from typing import Any

from first_run_scans import scan_of, write_scans
from peers.machine import description, load_of_others

ROOT = Path(__file__).parents[1]
SAVED = Path(__file__).parent / "first_run.json"
#: commands that run nothing, and how often each is timed
QUESTIONS = ("--help", "list recipes", "check denoise")
_ROUNDS = 5


def main() -> None:
    """Measure, print and save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--only", default="", metavar="WORDS", help="recipes with one of these words in their name")
    parser.add_argument("--environment", type=Path, metavar="FOLDER", help="a virtual environment, instead of a fresh one")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found: dict[str, Any] = {"machine": description(), "date": date.today().isoformat()}
        environment = options.environment or folder / "environment"
        if options.environment is None:
            found["install"] = installed(environment, folder)
        command = environment / "bin" / "pymeshfair"
        scans = write_scans(folder)
        found["questions"] = {question: asked(command, question) for question in QUESTIONS}
        found["recipes"] = {}
        for recipe in recipes(command):
            if any(word in recipe for word in options.only.split() or [""]):
                found["recipes"][recipe] = row = measured(command, recipe, scans[scan_of(recipe)], folder)
                print(recipe, json.dumps(row), flush=True)
                SAVED.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")  # a part is worth something, too


def installed(environment: Path, folder: Path) -> dict[str, float]:
    """Make an environment and install the package from a copy without anything that was built or compiled before."""
    subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
    copy = folder / "copy"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(copy)], check=True)
    return timed([str(environment / "bin" / "python"), "-m", "pip", "install", "-q", str(copy)], {})


def recipes(command: Path) -> list[str]:
    """The names of the shipped recipes."""
    done = subprocess.run([str(command), "list", "recipes", "--json"], capture_output=True, text=True, check=True)
    return [recipe["name"] for recipe in json.loads(done.stdout)["recipes"]]


def asked(command: Path, question: str) -> dict[str, float]:
    """The medians of some calls of a command that runs nothing."""
    rounds = [timed([str(command), *question.split()], {}) for _ in range(_ROUNDS)]
    return {name: statistics.median(each[name] for each in rounds) for name in rounds[0]}


def measured(command: Path, recipe: str, scan: Path, folder: Path) -> dict[str, Any]:
    """A first and a second run with a home of their own."""
    home = folder / "home"
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    environment = {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    words = [str(command), "run", recipe, str(scan), "-o", str(home / "out.ply"), "--overwrite"]
    row: dict[str, Any] = {"scan": scan.stem}
    for name in ("first", "second"):
        before = len([*home.glob("cache/pymeshfair/kernels/*/*")])
        row[name] = timed(words, environment)
        row[name]["compiled"] = len([*home.glob("cache/pymeshfair/kernels/*/*")]) - before
    return row


def timed(words: list[str], environment: dict[str, str]) -> dict[str, float]:
    """Seconds by the clock and of processor time of a process with all its children, and the load by others before."""
    load = load_of_others(0.3)
    inherited = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(words, env={**inherited, **environment}, capture_output=True, text=True, check=False)
    seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        print(" ".join(words), done.stderr, file=sys.stderr)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"seconds": seconds, "processor": processor, "load": load, "status": done.returncode}


if __name__ == "__main__":
    main()
