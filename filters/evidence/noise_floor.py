"""A lower bound of the noise: the level of the quietest 5 % of the vertices."""

import numpy as np

from ..mesh import Bools, Floats, Ints
from ..topology import edges, one_rings
from .local_means import local_means
from .quadric_prediction import predicted_heights

# The calmest part, and how many times the squares are averaged over the one-rings: about sixty vertices then have a say.
_CALMEST, _AVERAGED = 0.05, 4
# Squares count up to so many times their median: outliers are not noise of their surroundings.
_CLIP = 9.0
# Vertices this near to where the others expect them, in the unit of the points, lie on an exact plane; and most of the others.
_EXACT, _MOST = 1e-4, 0.5


def noise_floor(points: Floats, faces_or_edges: Ints, *, normals: Floats, scored: Bools) -> float:
    """The level of noise along the normals that a twentieth of the vertices stays below.

    With h the height at which its surroundings expect a vertex, and g the share of their noise in that, h^2 / (1 + g^2) estimates
    the variance of the noise at the vertex; it is averaged over the vertices around. Details and edges add to it, but not
    everywhere: where the surface is calm noise alone is left.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges, each once.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that count.

    Returns:
        The level in the unit of the points; a fifth to a third below the standard deviation of even noise, since it is that of
        the calmest part. Exact planes do not count unless they are half of the mesh. 0 if no vertex counts.
    """
    which = np.flatnonzero(scored).astype(np.int32)
    if not len(which):
        return 0.0
    heights, gains = predicted_heights(points, one_rings(faces_or_edges, len(points)), normals, which)
    squares = heights**2 / (1.0 + gains**2)
    rough = squares > _EXACT**2
    if rough.mean() > _MOST:
        # Planes that somebody has put in, such as the base of a scan, say nothing of the rest.
        which, squares = which[rough], squares[rough]
    clipped, counted = np.zeros(len(points)), np.zeros(len(points), dtype=np.bool_)
    clipped[which], counted[which] = np.minimum(squares, _CLIP * np.median(squares)), True
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    return float(np.sqrt(np.quantile(local_means(clipped, counted, pairs, times=_AVERAGED)[which], _CALMEST)))
