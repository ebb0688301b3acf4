"""How far the vertices of a mesh have moved."""

from __future__ import annotations

import numpy as np

from pymeshfair.declaration import Floats


def displacement(before: Floats, after: Floats) -> dict[str, float]:
    """What a filter reports of the vertices: how many moved, and how far the furthest went, in mesh units."""
    way = after - before
    unit = float(np.abs(way).max(initial=0.0)) or 1.0  # in which squares are ordinary numbers
    furthest = unit * float(np.linalg.norm(way / unit, axis=1).max(initial=0.0))
    return {"moved": int((way != 0.0).any(axis=1).sum()), "largest_displacement": furthest}


def irregular_note(count: int) -> str:
    """What to say of vertices that were placed by connectivity alone, as `filters.fairing` does where it must."""
    return (
        f"The triangles around {count:,} vertices are so uneven that their angles and areas would throw some out: these parts "
        "were smoothed by connectivity alone. Better triangles (Tangential Smoothing, remeshing) give a better surface."
    )
