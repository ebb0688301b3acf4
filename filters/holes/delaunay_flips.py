"""Flips of the edges inside a patch towards Delaunay triangles."""

import numpy as np

from ..compilation import compiled
from ..geometry import angle_at, cross_product, squared_length
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import diamond, fan_size, flip
from .vertex_pairs import is_pair

# An edge is flipped if its opposite angles sum to pi and this, and the sum falls by at least this. Without, an edge between two
# equal choices could flip back and forth for ever, and rounding would decide.
_GAIN = 1e-7
# No flip makes a triangle with a doubled area below this share of the sum of two squared sides.
_THINNEST = 1e-7
_MOST_SWEEPS = 200


@compiled
def flip_towards_delaunay(points: Floats, triangles: Ints, across: Ints, keys: Longs, apart: Bools, alone: Bools) -> None:
    """Flip edges of a patch, in place, until no flip lessens a sum of opposite angles that is above pi.

    Args:
        points: (n, 3) coordinates.
        triangles: (b, 3) the patch.
        across: (b, 3) as `faces_across` gives it, -1 at the rim.
        keys: of the pairs of the first k points that must not be joined, as in `VertexPairs`.
        apart: (k,) of which no two must be joined.
        alone: (k,) which must not be joined to any other.
    """
    for _ in range(_MOST_SWEEPS):
        flips = 0
        for t in range(triangles.shape[0]):
            for k in range(3):
                if across[t, k] > t:
                    a, b, c, d = diamond(triangles, across, t, k)
                    if (
                        _is_better(points, a, b, c, d)
                        and not _is_forbidden(keys, apart, alone, c, d)
                        and c != d
                        and fan_size(triangles, across, t, (k + 2) % 3, d) > 0
                    ):
                        flip(triangles, across, t, k)
                        flips += 1
        if flips == 0:
            break


@compiled
def _is_better(points: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether the triangles (a, d, c) and (d, b, c) are to replace (a, b, c) and (b, a, d)."""
    now = angle_at(points, c, a, b) + angle_at(points, d, b, a)
    if not now > np.pi + _GAIN:
        return False
    if not now > angle_at(points, a, d, c) + angle_at(points, b, c, d) + _GAIN:
        return False
    # The new triangles must not be folded over each other, unless the old ones are folded further.
    after = _facing(points, a, d, c, d, b, c)
    if after <= 0.0 and after < _facing(points, a, b, c, b, a, d):
        return False
    return not (_is_thin(points, a, d, c) or _is_thin(points, d, b, c))


@compiled
def _is_forbidden(keys: Longs, apart: Bools, alone: Bools, c: int, d: int) -> bool:
    """Whether the points c and d must not be joined."""
    n = apart.shape[0]
    if (c < n and alone[c]) or (d < n and alone[d]):
        return True
    return bool(c < n and d < n and ((apart[c] and apart[d]) or is_pair(keys, n, c, d)))


@compiled
def _is_thin(points: Floats, a: int, b: int, c: int) -> bool:
    """Whether a triangle is nearly degenerate."""
    nx, ny, nz = cross_product(points, a, b, c)
    squares = squared_length(points, a, b) + squared_length(points, a, c)
    return not nx * nx + ny * ny + nz * nz > (_THINNEST * squares) ** 2


@compiled
def _facing(points: Floats, a: int, b: int, c: int, d: int, e: int, f: int) -> float:
    """The cosine of the angle between the normals of the triangles (a, b, c) and (d, e, f), times their doubled areas."""
    x, y, z = cross_product(points, a, b, c)
    p, q, r = cross_product(points, d, e, f)
    return float(x * p + y * q + z * r)
