"""Which vertices move in a diffusion step, and which neighbours each of them sees."""

from typing import NamedTuple

import numpy as np

from ..errors import FilterInputError
from ..stars import CLOSED, IRREGULAR, OPEN, Stars
from ..topology import Bools, Ints, Longs, OneRings, edge_face_counts, one_rings
from .border import BORDER_POLICIES, BorderPolicy


class Roles(NamedTuple):
    """The vertices that move, ascending, by what they see; every vertex is in one list at most.

    Attributes:
        closed: int32 interior vertices, which see their whole star.
        open: int32 border vertices that see their whole star, under the policy "free".
        irregular: int32 vertices with an irregular star that see all of it.
        curve: int32 border vertices that see their neighbours on the border, under the policy "along".
        curve_offsets, curve_neighbours: those neighbours, for all n vertices as in `OneRings`.
    """

    closed: Ints
    open: Ints
    irregular: Ints
    curve: Ints
    curve_offsets: Longs
    curve_neighbours: Ints

    @property
    def surface(self) -> Ints:
        """All that see their whole star."""
        if len(self.open) == 0 and len(self.irregular) == 0:
            return self.closed
        return np.sort(np.concatenate([self.closed, self.open, self.irregular]))


def assign_roles(stars: Stars, faces: Ints, border: BorderPolicy, movable: Bools | None) -> Roles:
    """The roles of the vertices of a mesh.

    Args:
        stars: the star of every vertex.
        faces: (m, 3) triangles.
        border: what vertices on an edge with exactly one face do.
        movable: (n,) which vertices may move; None for all. The others are seen, and vertices that no face uses never move.

    Raises:
        FilterInputError: an unknown policy.
    """
    if border not in BORDER_POLICIES:
        raise FilterInputError(f"border {border!r} is not one of {', '.join(map(repr, BORDER_POLICIES))}")
    n = len(stars.kinds)
    kinds = stars.kinds if movable is None else np.where(movable, stars.kinds, np.uint8(0))
    empty = np.empty(0, dtype=np.int32)
    curves = OneRings(np.zeros(n + 1, dtype=np.int64), empty, empty)
    on_border = np.zeros(n, dtype=np.bool_)
    if border != "free":
        edges = _border_edges(stars, faces)
        on_border[edges] = True
        if border == "along" and len(edges):
            curves = one_rings(edges, n)
    inside = np.where(on_border, np.uint8(0), kinds) if on_border.any() else kinds
    return Roles(
        closed=_where(inside == CLOSED),
        open=_where(inside == OPEN),
        irregular=_where(inside == IRREGULAR),
        curve=_where(on_border & (kinds > 0)) if border == "along" else empty,
        curve_offsets=curves.offsets,
        curve_neighbours=curves.neighbours,
    )


def _border_edges(stars: Stars, faces: Ints) -> Ints:
    """`topology.border_edges`, found among the few faces with two vertices that are not interior."""
    candidates = stars.kinds > CLOSED
    if not candidates.any():
        return np.empty((0, 2), dtype=np.int32)
    near = faces[candidates[faces].sum(axis=1) >= 2]
    pairs, counts = edge_face_counts(near)
    border: Ints = pairs[(counts == 1) & candidates[pairs].all(axis=1)]
    return border


def _where(mask: Bools) -> Ints:
    return np.flatnonzero(mask).astype(np.int32)
