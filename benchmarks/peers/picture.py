"""The picture of a run: seconds against vertices, ours and the peers', both logarithmic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .every import CONTESTS
from .measurement import OURS
from .results import Run

_COLUMNS = 3


def draw(run: Run, path: Path) -> None:
    """Write the picture of all contests that were measured at more than one size, in scan order."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "performance"
    mpl.rcParams["svg.fonttype"] = "none"  # texts, which are shorter than outlines of letters
    from matplotlib import pyplot

    names = [n for n in CONTESTS if len({b.size for b in run.blocks if b.contest == n and b.order == "scan"}) > 1]
    rows = max(1, -(-len(names) // _COLUMNS))
    figure, axes = pyplot.subplots(rows, _COLUMNS, figsize=(4.2 * _COLUMNS, 3.2 * rows), squeeze=False, layout="constrained")
    for axis in axes.flat[len(names) :]:
        axis.set_axis_off()
    for name, axis in zip(names, axes.flat, strict=False):
        _one(run, name, axis)
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)


def _one(run: Run, name: str, axis: Any) -> None:
    for contestant in (OURS, *CONTESTS[name].peers):
        points = []
        for size in CONTESTS[name].sizes:
            block = run.block(name, size, "scan")
            timing = None if block is None else block.timings.get(contestant)
            if timing is not None and not timing.error:
                points.append((size, timing.seconds))
        if points:
            ours = contestant == OURS
            axis.plot(
                *zip(*points, strict=True),
                marker="o",
                linewidth=2.5 if ours else 1.2,
                color="black" if ours else None,
                label=contestant,
            )
    axis.set(xscale="log", yscale="log", title=name)
    axis.set_xlabel("vertices")
    axis.set_ylabel("seconds")
    axis.minorticks_off()
    axis.grid(visible=True, which="major", alpha=0.3)
    axis.legend(fontsize=7)
