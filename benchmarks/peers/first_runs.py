"""The part of docs/performance.md about first runs, from what ``benchmarks/first_run.py`` has saved."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SAVED = Path(__file__).parents[1] / "first_run.json"
_HEAD = """
## First runs

In a fresh environment, with an empty cache of compiled code, every recipe on a small scan (5,000 vertices): the first run, and
the second. Seconds by the clock and of processor time of all processes; the number of kernels that the run compiled; and how many
processors other work kept busy. Written by `python benchmarks/first_run.py`, {machine}, {date}.

| recipe | first, seconds | processor | compiled | second, seconds | processor | compiled | other work |
|---|---:|---:|---:|---:|---:|---:|---:|"""


def first_runs() -> Iterator[str]:
    """The lines of the part; none if nothing has been saved."""
    if not SAVED.exists():
        return
    found: dict[str, Any] = json.loads(SAVED.read_text("utf-8"))
    yield _HEAD.format(machine=found["machine"], date=found["date"])
    for recipe, row in found["recipes"].items():
        cells = [
            cell
            for run in (row["first"], row["second"])
            for cell in (f"{run['seconds']:.1f}", f"{run['processor']:.1f}", str(run["compiled"]))
        ]
        load = max(row[run]["load"] for run in ("first", "second"))
        yield f"| {recipe} | {' | '.join(cells)} | {load:.1f} |"
    yield "\n| command | seconds | processor | other work |\n|---|---:|---:|---:|"
    for question, row in found["questions"].items():
        yield f"| `pymeshfair {question}` | {row['seconds']:.2f} | {row['processor']:.2f} | {row['load']:.1f} |"
    if "install" in found:
        clock, processor = found["install"]["seconds"], found["install"]["processor"]
        yield f"\n`python -m pip install .`, which compiles what recipes use: {clock:.0f} s, {processor:.0f} s of processor time."
