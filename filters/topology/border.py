"""The border of an open mesh, and how it may move while the rest is smoothed."""

from typing import Literal, TypeAlias, get_args

import numpy as np

from ..mesh import Bools, Ints
from .edge_lists import edge_face_counts

#: "fixed": border vertices stay. "along": only neighbours on the border count for them, so the border is smoothed as a curve.
#: "free": they are vertices like any other, and the border shrinks.
BorderPolicy: TypeAlias = Literal["fixed", "along", "free"]
BORDER_POLICIES: tuple[BorderPolicy, ...] = get_args(BorderPolicy)


def border_edges(faces: Ints) -> Ints:
    """(b, 2) the edges with exactly one face, lower vertex first, rows ascending."""
    pairs, counts = edge_face_counts(faces)
    border: Ints = pairs[counts == 1]
    return border


def border_vertices(faces: Ints, n_vertices: int) -> Bools:
    """(n,) whether a vertex lies on a border edge."""
    on_border = np.zeros(n_vertices, dtype=np.bool_)
    on_border[border_edges(faces)] = True
    return on_border
