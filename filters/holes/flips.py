"""Flips of the edges inside a patch towards Delaunay triangles."""

import numpy as np
from numba import njit

from ..mesh import Bools, Floats, Ints

# The sum of the angles opposite an edge has to be above pi by this before it is flipped, and to fall by as much: a flip back and
# forth between equals would not end, and rounding must not decide.
_GAIN = 1e-7
_THINNEST = 1e-7  # doubled area by summed squares of two sides; no flip makes such a triangle
_MOST_SWEEPS = 200


@njit(cache=True)
def flip_towards_delaunay(points: Floats, corners: Ints, across: Ints, forbidden: Bools) -> None:
    """Flip edges of a patch, in place, until none has opposite angles of more than pi that a flip would lessen.

    Args:
        points: (n, 3) coordinates.
        corners: (b, 3) the triangles.
        across: (b, 3) for every triangle the one across the edge from corner k to the next, -1 at the rim.
        forbidden: (k, k) which of the first k points must not be joined; on the diagonal, which must not be joined to any other.
    """
    for _ in range(_MOST_SWEEPS):
        flips = 0
        for t in range(corners.shape[0]):
            for k in range(3):
                if across[t, k] > t and _flip(points, corners, across, forbidden, t, k):
                    flips += 1
        if flips == 0:
            break


@njit(cache=True)
def _angle(points: Floats, a: int, b: int, c: int) -> float:
    """The angle at a between b and c."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    angle: float = np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), ux * vx + uy * vy + uz * vz)
    return angle


@njit(cache=True)
def _is_thin(points: Floats, a: int, b: int, c: int) -> bool:
    """Whether a triangle has next to no area for its sides."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    squares = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz
    return not nx * nx + ny * ny + nz * nz > (_THINNEST * squares) ** 2


@njit(cache=True)
def _facing(points: Floats, a: int, b: int, c: int, d: int, e: int, f: int) -> float:
    """The cosine of the angle between the normals of two triangles, times their doubled areas."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    sx, sy, sz = points[e, 0] - points[d, 0], points[e, 1] - points[d, 1], points[e, 2] - points[d, 2]
    tx, ty, tz = points[f, 0] - points[d, 0], points[f, 1] - points[d, 1], points[f, 2] - points[d, 2]
    product: float = (
        (uy * vz - uz * vy) * (sy * tz - sz * ty)
        + (uz * vx - ux * vz) * (sz * tx - sx * tz)
        + (ux * vy - uy * vx) * (sx * ty - sy * tx)
    )
    return product


@njit(cache=True)
def _flip(points: Floats, corners: Ints, across: Ints, forbidden: Bools, t: int, k: int) -> bool:
    """Turn the edge from a to b, k-th of triangle t = (a, b, c), into that from c to d, if it should and may be."""
    s = across[t, k]
    a, b, c = corners[t, k], corners[t, (k + 1) % 3], corners[t, (k + 2) % 3]
    m = 0
    while not (corners[s, m] == b and corners[s, (m + 1) % 3] == a):
        m += 1
    d = corners[s, (m + 2) % 3]
    now = _angle(points, c, a, b) + _angle(points, d, b, a)
    if not now > np.pi + _GAIN:
        return False
    if not now > _angle(points, a, d, c) + _angle(points, b, c, d) + _GAIN:
        return False
    # The new triangles must not be folded over each other, unless the old ones are so and more.
    after = _facing(points, a, d, c, d, b, c)
    if after <= 0.0 and after < _facing(points, a, b, c, b, a, d):
        return False
    if _is_thin(points, a, d, c) or _is_thin(points, d, b, c):
        return False
    n = forbidden.shape[0]
    if (c < n and forbidden[c, c]) or (d < n and forbidden[d, d]) or (c < n and d < n and forbidden[c, d]):
        return False
    if c == d or _joined(corners, across, t, (k + 2) % 3, d):
        return False
    beyond_bc, beyond_ca = across[t, (k + 1) % 3], across[t, (k + 2) % 3]
    beyond_ad, beyond_db = across[s, (m + 1) % 3], across[s, (m + 2) % 3]
    corners[t, 0], corners[t, 1], corners[t, 2] = a, d, c
    across[t, 0], across[t, 1], across[t, 2] = beyond_ad, s, beyond_ca
    corners[s, 0], corners[s, 1], corners[s, 2] = d, b, c
    across[s, 0], across[s, 1], across[s, 2] = beyond_db, beyond_bc, t
    relink(across, corners, beyond_ad, a, d, t)
    relink(across, corners, beyond_bc, b, c, s)
    return True


@njit(cache=True)
def _joined(corners: Ints, across: Ints, t: int, k: int, d: int) -> bool:
    """Whether the vertex at corner k of triangle t has an edge of the patch to vertex d."""
    v = corners[t, k]
    for way in range(2):
        f, i = t, k
        while True:
            if corners[f, (i + 1) % 3] == d or corners[f, (i + 2) % 3] == d:
                return True
            # Round v by its edge that leaves it, or by the one that comes back.
            g = across[f, i] if way == 0 else across[f, (i + 2) % 3]
            if g == t:
                return False
            if g < 0:
                break
            f = g
            i = 0
            while corners[f, i] != v:
                i += 1
    return False


@njit(cache=True)
def relink(across: Ints, corners: Ints, t: int, a: int, b: int, now: int) -> None:
    """Tell triangle t that beyond its edge from b to a there is `now`."""
    if t < 0:
        return
    for k in range(3):
        if corners[t, k] == b and corners[t, (k + 1) % 3] == a:
            across[t, k] = now
