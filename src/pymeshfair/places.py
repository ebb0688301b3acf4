"""How places are told to people."""

from collections.abc import Iterable


def point_text(point: Iterable[float]) -> str:
    """The coordinates of a point, with more digits far from the origin, where points differ in the last ones."""
    return ", ".join(f"{c:.{6 if abs(c) < 1000.0 else 9}g}" for c in point)
