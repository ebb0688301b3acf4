"""Awkward meshes from a seed, through every filter of ours: each ends with finite numbers within bounds, or is refused.

    python benchmarks/hostile_meshes.py [--meshes N] [--first K] [--filter NAME]

Prints every complaint with the number of the mesh, and every run that takes over 2 s of processor time or 100 MB more than the
process had before (on Linux), then the counts. Every 250 meshes have a process of their own, of at most 3 GB of addresses.
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
    options = parser.parse_args()
    if options.meshes <= AT_ONCE:
        return _run_all(range(options.first, options.first + options.meshes), options.filter)
    ends = []
    for first in range(options.first, options.first + options.meshes, AT_ONCE):
        meshes = min(AT_ONCE, options.first + options.meshes - first)
        rest = ["--meshes", str(meshes), "--first", str(first), "--filter", options.filter]
        ends.append(subprocess.run([sys.executable, __file__, *rest]).returncode)
    return int(any(ends))


def _run_all(numbers: Sequence[int], name: str) -> int:
    faulthandler.enable()
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    filters = [f for f in custom_filters() if f.origin == "pymeshfair" and name in f.python_name]
    vertices, faces = icosphere(2)
    for declared in filters:  # so that all are compiled, holes and all
        complaint_about(declared, (vertices, faces[:-9]), _values(declared, tried=False))
    counts: Counter[str] = Counter()
    for number in numbers:
        harms, mesh = awkward_mesh(number)
        for declared in filters:
            # The choice of parameters tries a hundred of them, and is tried itself on every twentieth mesh.
            values = _values(declared, tried=number % 20 == 0)
            before, started = _memory(forget=True), time.process_time()
            complaint = complaint_about(declared, mesh, values)
            seconds, grown = time.process_time() - started, _memory() - before
            if complaint is None and (seconds > SLOW or grown > LARGE):
                complaint = f"takes {seconds:.1f} s and {grown:.0f} MB"
            counts["runs"] += 1
            if complaint is not None:
                counts["complaints"] += 1
                counts[declared.python_name] += 1
                print(f"mesh {number} ({harms}): {declared.python_name} {complaint}", flush=True)
    print(f"{numbers[0]} to {numbers[-1]}: {dict(counts)}", flush=True)
    return int(counts["complaints"] > 0)


def _values(declared: Filter, *, tried: bool) -> dict[str, str]:
    return {"choice": "fixed"} if any(p.name == "choice" for p in declared.parameters) and not tried else {}


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
