"""Folded faces taken back: a last line search after denoising, whose result has no more of them than the input."""

import numpy as np

from ..inspection import folded_faces
from ..mesh import Bools, Floats, Ints

#: rings of faces around a vertex that decide whether it goes back
RINGS_OF_UNFOLDING = 3


def unfolded(before: Floats, after: Floats, faces: Ints) -> Floats:
    """(n, 3) the vertices `after` a filter, if that leaves more `folded_faces` than `before` some of them back where they were.

    While there are more, vertices go back, see `going_back`. That ends, at worst with the mesh before: where all vertices around
    a face are back it is as it was, so while more faces are folded at least one vertex goes back.
    """
    folded = folded_faces(before, faces)
    while np.count_nonzero(now := folded_faces(after, faces)) > np.count_nonzero(folded):
        after = np.where(going_back(before, after, faces, now & ~folded)[:, None], before, after)
    return after


def going_back(before: Floats, after: Floats, faces: Ints, new: Bools) -> Bools:
    """(n,) the corners of the (m,) faces that are newly folded, those that are not back where they were.

    A face whose corners are all back is folded by the normals around it: the corners of the faces at its corners go back.
    """
    away = (after != before).any(axis=1)
    stuck = new & ~away[faces].any(axis=1)
    back, around = np.zeros_like(away), np.zeros_like(away)
    back[faces[new]] = around[faces[stuck]] = True
    back[faces[around[faces].any(axis=1)]] = True
    return back & away
