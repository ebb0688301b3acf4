"""Awkward meshes from a seed, through every filter of ours: each ends with finite numbers within bounds, or is refused.

    python benchmarks/hostile_meshes.py [--meshes N] [--first K] [--filter NAME]

Prints every complaint with the number of the mesh, then the counts. Ends with 1 if there is a complaint.
"""

from __future__ import annotations

import argparse
import faulthandler
import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.hostile.awkward import awkward_mesh
from tests.hostile.every_filter import complaint_about

from pymeshfair.registry import custom_filters

#: seconds after which a filter counts as hanging on so small a mesh
SLOW = 10.0


def main() -> int:
    """Run the filters, print what is wrong, and return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meshes", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--filter", default="")
    options = parser.parse_args()
    faulthandler.enable()
    filters = [f for f in custom_filters() if f.origin == "pymeshfair" and options.filter in f.python_name]
    counts: Counter[str] = Counter()
    for number in range(options.first, options.first + options.meshes):
        harms, mesh = awkward_mesh(number)
        for declared in filters:
            # The choice of parameters tries a hundred of them, and is tried itself on every twentieth mesh.
            values = {"choice": "fixed"} if any(p.name == "choice" for p in declared.parameters) and number % 20 else {}
            started = time.perf_counter()
            complaint = complaint_about(declared, mesh, values)
            seconds = time.perf_counter() - started
            if complaint is None and seconds > SLOW:
                complaint = f"takes {seconds:.0f} s"
            counts["runs"] += 1
            if complaint is not None:
                counts["complaints"] += 1
                counts[declared.python_name] += 1
                print(f"mesh {number} ({harms}): {declared.python_name} {complaint}", flush=True)
    print(dict(counts))
    return int(counts["complaints"] > 0)


if __name__ == "__main__":
    sys.exit(main())
