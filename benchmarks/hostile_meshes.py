"""Awkward meshes from a seed, through every filter of ours: each ends with finite numbers within bounds, or is refused.

    python benchmarks/hostile_meshes.py [--meshes N] [--first K] [--filter NAME] [--choices]

Prints every complaint with the number of the mesh, and every run that takes over 2 s of processor time or 100 MB more than the
process had before (on Linux), then the counts. Every 250 meshes have a process of their own, of at most 3 GB of addresses.
With --choices each filter is run once for every choice that its parameters have besides their defaults, and not with those.
Ends with 1 if there is a complaint or a process dies.
"""

from __future__ import annotations

import argparse
import faulthandler
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.hostile.awkward import awkward_mesh
from tests.hostile.every_filter import complaint_about
from tests.meshes import icosphere

from pymeshfair.declaration import Filter
from pymeshfair.registry import custom_filters

#: seconds of processor time and megabytes after which a filter takes too much of so small a mesh
SLOW, LARGE = 2.0, 100.0
#: meshes of one process, and the bytes of its addresses
AT_ONCE, ADDRESSES = 250, 3 << 30


def main() -> int:
    """Run the filters, print what is wrong, and return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meshes", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--filter", default="")
    parser.add_argument("--choices", action="store_true")
    options = parser.parse_args()
    if options.meshes <= AT_ONCE:
        return _run_all(range(options.first, options.first + options.meshes), options.filter, options.choices)
    ends = []
    for first in range(options.first, options.first + options.meshes, AT_ONCE):
        meshes = min(AT_ONCE, options.first + options.meshes - first)
        rest = ["--meshes", str(meshes), "--first", str(first), "--filter", options.filter, *(["--choices"] * options.choices)]
        ends.append(subprocess.run([sys.executable, __file__, *rest]).returncode)
    return int(any(ends))


def _run_all(numbers: Sequence[int], name: str, choices: bool) -> int:
    faulthandler.enable()
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    filters = [f for f in custom_filters() if f.origin == "pymeshfair" and name in f.python_name]
    vertices, faces = icosphere(2)
    for declared in filters:  # so that all are compiled, holes and all
        for values in _values(declared, choices):
            complaint_about(declared, (vertices, faces[:-9]), values)
    counts: Counter[str] = Counter()
    for number in numbers:
        harms, mesh = awkward_mesh(number)
        for declared in filters:
            for values in _values(declared, choices):
                if number % 20 == 0 and not choices:
                    values = {}  # the choice of parameters tries a hundred of them
                before, started = _memory(forget=True), time.process_time()
                complaint = complaint_about(declared, mesh, values)
                seconds, grown = time.process_time() - started, _memory() - before
                if complaint is None and (seconds > SLOW or grown > LARGE):
                    complaint = f"takes {seconds:.1f} s and {grown:.0f} MB"
                counts["runs"] += 1
                if complaint is not None:
                    counts["complaints"] += 1
                    counts[declared.python_name] += 1
                    print(f"mesh {number} ({harms}): {declared.python_name} {values or ''} {complaint}", flush=True)
    print(f"{numbers[0]} to {numbers[-1]}: {dict(counts)}", flush=True)
    return int(counts["complaints"] > 0)


def _values(declared: Filter, choices: bool) -> list[dict[str, Any]]:
    """The values that a filter is run with: those that spare the choice of parameters, or each other choice by itself."""
    fixed = {"choice": "fixed"} if any(p.name == "choice" for p in declared.parameters) else {}
    if not choices:
        return [fixed]
    found = []
    for p in (p for p in declared.parameters if p.name != "choice"):
        possible = (not p.default,) if isinstance(p.default, bool) else getattr(p, "choices", ())
        found += [fixed | {p.name: value} for value in possible if value != p.default]
    return found


def _memory(*, forget: bool = False) -> float:
    """The most megabytes that this process had, or if that is to be forgotten first, has; 0 where that is not known."""
    if sys.platform != "linux":
        return 0.0
    if forget:
        Path("/proc/self/clear_refs").write_text("5")
    status = Path("/proc/self/status").read_text()
    return float(status.partition("VmHWM:")[2].split()[0]) / 1024


if __name__ == "__main__":
    sys.exit(main())
