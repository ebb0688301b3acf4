"""Which vertices move in a diffusion step, and which neighbours each of them sees."""

from typing import NamedTuple

import numpy as np

from ..checks import check_choice
from ..mesh import Bools, Ints, Longs
from ..topology import BORDER_POLICIES, CLOSED, IRREGULAR, OPEN, BorderPolicy, Stars, one_rings


class MovingVertices(NamedTuple):
    """The vertices that move, ascending, by what they see; every vertex is in one list at most.

    Attributes:
        closed: int32 interior vertices, which see their whole star.
        open: int32 border vertices that see their whole star, under the policy "free".
        irregular: bool for each of `Stars.irregular`, whether it moves and sees its whole star.
        surface: int32 all of these.
        curve: int32 border vertices that see their neighbours on the border, under the policy "along".
        curve_offsets, curve_neighbours: those neighbours, for all n vertices as in `OneRings`.
    """

    closed: Ints
    open: Ints
    irregular: Bools
    surface: Ints
    curve: Ints
    curve_offsets: Longs
    curve_neighbours: Ints


def moving_vertices(stars: Stars, border: BorderPolicy, movable: Bools | None) -> MovingVertices:
    """Sorts the vertices of a mesh by whether they move, and by which neighbours.

    Args:
        stars: the star of every vertex.
        border: what vertices on an edge with exactly one face do.
        movable: (n,) which vertices may move; None for all. The others are seen, and vertices that no face uses never move.

    Raises:
        FilterInputError: an unknown policy.
    """
    check_choice("border", border, BORDER_POLICIES)
    n = len(stars.kinds)
    edges = np.empty((0, 2), dtype=np.int32) if border == "free" else stars.border_edges()
    kinds = stars.kinds if movable is None else np.where(movable, stars.kinds, np.uint8(0))
    inside, curve = kinds, np.empty(0, dtype=np.int32)
    if len(edges):
        on_border = np.zeros(n, dtype=np.bool_)
        on_border[edges] = True
        inside = np.where(on_border, np.uint8(0), kinds)
        if border == "along":
            curve = _where(on_border & (kinds > 0))
    curves = one_rings(edges, n) if len(curve) else None
    return MovingVertices(
        closed=_where(inside == CLOSED),
        open=_where(inside == OPEN),
        irregular=inside[stars.irregular] == IRREGULAR,
        surface=_where(inside > 0),
        curve=curve,
        curve_offsets=np.zeros(n + 1, dtype=np.int64) if curves is None else curves.offsets,
        curve_neighbours=np.empty(0, dtype=np.int32) if curves is None else curves.neighbours,
    )


def _where(mask: Bools) -> Ints:
    return np.flatnonzero(mask).astype(np.int32)
