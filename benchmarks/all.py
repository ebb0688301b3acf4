"""Every operation against its peers: ``python benchmarks/all.py [--quick]``. Writes docs/performance.md.

    python benchmarks/all.py [--quick] [--sizes 10k,100k,1M,5M] [--only WORDS] [--orders scan,random] [--rounds N] [--show]

Ours and the peers in turn, in one process for each block of operation, size and order; medians by the clock and of processor
time, the memory of a call, the share of the memory's bandwidth, how times grow with size. Before each block the load by other
work is printed: above half a core the run is not called quiet. The results go to benchmarks/all.json, together with what that
file holds of other blocks; from it the page and its picture are written, and a ratio that fell since the saved run is marked.
--quick takes 10k and 100k; --show writes the page from the saved results alone. Ends with 1 if a ratio fell. Peers that are not
installed (the extra `bench`) are named.
"""

from __future__ import annotations

import argparse
import datetime
import importlib.metadata
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from peers import machine
from peers.contest import ORDERS
from peers.every import CONTESTS
from peers.measurement import OURS, Block, measured
from peers.page import page
from peers.picture import draw
from peers.results import Run, fallen, ratio
from peers.subjects import kept_subject

ROOT = Path(__file__).parent.parent
SAVED, PAGE = ROOT / "benchmarks" / "all.json", ROOT / "docs" / "performance.md"
PICTURE = ROOT / "docs" / "pictures" / "performance.svg"
#: whose versions the page tells
LIBRARIES = (
    *("numpy", "scipy", "numba", "pymeshlab", "vtk", "meshlib", "libigl", "cgal", "trimesh", "open3d", "PyNomaly"),
    *("pyamg", "pykdtree"),
)


def sizes_of(text: str) -> tuple[int, ...]:
    """Numbers such as 10k and 5M."""
    units = {"k": 1_000, "M": 1_000_000}
    return tuple(int(word[:-1]) * units[word[-1]] if word[-1] in units else int(word) for word in text.split(","))


def versions() -> dict[str, str]:
    """Of the libraries that are installed."""
    return {name: version_of(name) for name in LIBRARIES}


def version_of(name: str) -> str:
    """Of a library."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def tell(block: Block, saved: Run | None) -> bool:
    """Print a block; whether a ratio fell."""
    ours, fell = block.timings[OURS], False
    heard = "" if block.is_quiet else ": NOT QUIET"
    print(
        f"{block.contest}, {block.size:,} {block.order} (load {block.load_before:.2f}, meanwhile {block.load_during:.2f}{heard})"
    )
    for name, timing in block.timings.items():
        if timing.error:
            print(f"    {name:22} {timing.error}")
            continue
        line = f"    {name:22} {timing.seconds:9.4f} s {timing.processor:9.4f} s of processor {timing.megabytes or 0:7.0f} MB"
        if name != OURS and not ours.error:
            before = fallen(block, name, saved)
            fell |= before is not None
            line += f"  {ratio(block, name):6.2f} ({ratio(block, name, 'processor'):.2f})"
            line += "" if timing.apart is None else f"  apart {timing.apart:.0e}"
            line += "" if before is None else f"  FELL from {before:.2f}"
        print(line, flush=True)
    return fell


def main() -> int:
    """Measure, print, write; 1 if a ratio fell."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="10k and 100k alone")
    parser.add_argument("--sizes", default="10k,100k,500k,1M,5M")
    parser.add_argument("--orders", default=",".join(ORDERS))
    parser.add_argument("--only", default="", help="contests whose name has these words")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--show", action="store_true", help="measure nothing: write the page from the saved results")
    options = parser.parse_args()
    sizes = sizes_of("10k,100k" if options.quick else options.sizes)
    saved, fell = Run.load(SAVED), False
    if options.show and saved is not None:
        run = saved
    else:
        today = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
        run = Run(machine.description(), today, versions(), machine.triad_bandwidth(), machine.threads())
        with tempfile.TemporaryDirectory() as folder:
            for contest in (c for c in CONTESTS.values() if options.only in c.name):
                for order in (o for o in contest.orders if o in options.orders.split(",")):
                    for size in (s for s in contest.sizes if s in sizes):
                        path = kept_subject(Path(folder), contest.subject, size, order)
                        small = kept_subject(Path(folder), contest.subject, contest.tiny, "scan")
                        run.blocks.append(measured(contest, size, order, path, small, options.rounds))
                        fell |= tell(run.blocks[-1], saved)
                        # After every block, so that a run that is ended keeps what it has measured.
                        replace(run, blocks=[*run.blocks]).together_with(saved).saved(SAVED)
        run.together_with(saved)
    PAGE.write_text(page(run, None), encoding="utf-8")
    draw(run, PICTURE)
    print(f"written: {SAVED}, {PAGE}, {PICTURE}; the machine was {'quiet' if run.is_quiet else 'NOT QUIET'}")
    return int(fell)


if __name__ == "__main__":
    sys.exit(main())
