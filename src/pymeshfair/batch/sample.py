"""A few scans to try a recipe on, spread by size and noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..errors import RunError
from ..running.forks import ForkServer
from ..running.inspect import inspect_mesh
from .plan import Scan

#: so many scans are opened for each one that is chosen
_OPENED = 4


def sample(scans: Sequence[Scan], count: int, *, on_opened: Callable[[int, int], None] = lambda i, n: None) -> list[Scan]:
    """The `count` scans that lie furthest apart in the ranks of their size and of their noise, in the order of the batch.

    Size is that of the file; noise is the mean angle between neighbouring faces, of a few scans that are spread by size. One that
    cannot be opened is chosen for its size alone.

    Args:
        scans: to choose from.
        count: at least 1.
        on_opened: called as scans are opened, with how many and of how many.
    """
    if count >= len(scans):
        return list(scans)
    by_size = sorted(scans, key=lambda scan: (_size(scan.input), scan.number))
    opened = [by_size[i] for i in _spread(len(by_size), min(len(by_size), _OPENED * count))]
    noise = []
    with ForkServer(threads=1) as server:
        for number, scan in enumerate(opened, 1):
            noise.append(_noise(scan.input, server))
            on_opened(number, len(opened))
    ranked = {k: r for r, k in enumerate(sorted(range(len(opened)), key=lambda k: noise[k]))}
    places = [(k / len(opened), ranked[k] / len(opened)) for k in range(len(opened))]
    chosen = [0]  # the smallest
    while len(chosen) < count:
        left = (k for k in range(len(opened)) if k not in chosen)
        chosen.append(max(left, key=lambda k: (min(math.dist(places[k], places[c]) for c in chosen), k)))
    return sorted((opened[k] for k in chosen), key=lambda scan: scan.number)


def _spread(total: int, count: int) -> list[int]:
    """So many different numbers from 0 to `total` - 1, both among them."""
    return sorted({round(i * (total - 1) / max(1, count - 1)) for i in range(count)})


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def _noise(path: Path, server: ForkServer) -> float:
    try:
        measures: dict[str, Any] = inspect_mesh(path, start=server.start)
    except RunError:
        return 0.0
    return float(measures["roughness"] or measures["mean_spacing"] or 0.0)
