"""Where held-out vertices start: a filter cannot be judged by a guess that is worse than what it is to find."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..topology import one_rings
from .held_out import heights_of_means, without
from .outlying import put_where_expected
from .quadric_prediction import predicted_heights
from .verdict import judge

#: (n, 3) the points, those with the given numbers put where the others say
Guess: TypeAlias = Callable[[Ints], Floats]


def first_guess(points: Floats, faces: Ints, *, normals: Floats, scored: Bools) -> Guess:
    """The mean of the neighbours or the quadric through two rings, whichever predicts the vertices along their normals better.

    The mean passes less noise on, the quadric follows a surface that is curved within an edge; which of the two errors is
    larger, `judge` says. A light filter leaves a vertex where it starts: from a poor guess stronger ones look better than
    they are.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that are predicted; any, to choose between the two.
    """
    rings, which = one_rings(faces, len(points)), np.flatnonzero(scored).astype(np.int32)
    by_quadrics, _ = predicted_heights(points, rings, normals, which)
    if len(which) == 0 or judge(np.stack([heights_of_means(points, rings, normals, which), by_quadrics])).best == 0:
        return guess_by_means(points, faces)
    return lambda held: put_where_expected(points, faces, normals, held)


def guess_by_means(points: Floats, faces: Ints) -> Guess:
    """The mean of the neighbours, see `without`."""
    rings = one_rings(faces, len(points))
    return lambda held: without(points, rings, held)
