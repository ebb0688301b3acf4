"""One pass of edge flips over a mesh: the kernels."""

import numpy as np
from numba import njit

from ..geometry import nearest_by_walk
from ..mesh import Bools, Floats, Ints, Longs

# A flip gains at least this much, far above rounding, so that no two flips undo each other for ever.
_LEAST_GAIN = 1e-6
# The new triangles must keep within this cosine of the old ones and of each other.
_LEAST_COSINE = 0.25


@njit(cache=True)
def flip_pass(
    points: Floats,
    faces: Ints,
    across: Ints,
    valences: Longs,
    may: Bools,
    surface_points: Floats,
    surface_faces: Ints,
    offsets: Longs,
    around: Ints,
    at: Ints,
    near: float,
) -> int:
    """Goes through the faces once and flips, of each, the first edge that is to be; how many were."""
    count = 0
    for f in range(faces.shape[0]):
        for k in range(3):
            g = across[f, k]
            if g < 0:
                continue
            a, b, c = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
            j = _corner(faces, g, b)
            d = faces[g, (j + 2) % 3]
            if c == d or not (may[a] and may[b] and may[c] and may[d]) or not _better(points, a, b, c, d):
                continue
            far = False
            # The new edge, then the new triangles; weights of c, d and of the end of the old edge.
            for u, v, w, end in (
                (0.5, 0.5, 0.0, a),
                (0.75, 0.25, 0.0, a),
                (0.25, 0.75, 0.0, a),
                (1 / 3, 1 / 3, 1 / 3, a),
                (1 / 3, 1 / 3, 1 / 3, b),
            ):
                x = u * points[c, 0] + v * points[d, 0] + w * points[end, 0]
                y = u * points[c, 1] + v * points[d, 1] + w * points[end, 1]
                z = u * points[c, 2] + v * points[d, 2] + w * points[end, 2]
                if nearest_by_walk(surface_points, surface_faces, offsets, around, x, y, z, at[end], near)[4] > near:
                    far = True
                    break
            if far or _joined(faces, across, valences, f, c, d):
                continue
            # (a, b, c) and (b, a, d) become (a, d, c) and (d, b, c).
            ad, db = across[g, (j + 1) % 3], across[g, (j + 2) % 3]
            bc, ca = across[f, (k + 1) % 3], across[f, (k + 2) % 3]
            faces[f, 0], faces[f, 1], faces[f, 2] = a, d, c
            faces[g, 0], faces[g, 1], faces[g, 2] = d, b, c
            across[f, 0], across[f, 1], across[f, 2] = ad, g, ca
            across[g, 0], across[g, 1], across[g, 2] = db, bc, f
            if ad >= 0:
                across[ad, _corner(faces, ad, d)] = f
            if bc >= 0:
                across[bc, _corner(faces, bc, c)] = g
            valences[a] -= 1
            valences[b] -= 1
            valences[c] += 1
            valences[d] += 1
            count += 1
            break
    return count


@njit(cache=True)
def _better(points: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether (a, d, c) and (d, b, c) are better triangles than (a, b, c) and (b, a, d), and look where those do."""
    first, n1x, n1y, n1z = _quality(points, a, b, c)
    second, n2x, n2y, n2z = _quality(points, b, a, d)
    third, n3x, n3y, n3z = _quality(points, a, d, c)
    fourth, n4x, n4y, n4z = _quality(points, d, b, c)
    if not (third + fourth > first + second + _LEAST_GAIN and min(third, fourth) >= min(first, second)):
        return False
    # Old triangles without area, whose normals are 0, look nowhere.
    least = _LEAST_COSINE
    return (
        n1x * n3x + n1y * n3y + n1z * n3z >= least * (n1x * n1x + n1y * n1y + n1z * n1z)
        and n1x * n4x + n1y * n4y + n1z * n4z >= least * (n1x * n1x + n1y * n1y + n1z * n1z)
        and n2x * n3x + n2y * n3y + n2z * n3z >= least * (n2x * n2x + n2y * n2y + n2z * n2z)
        and n2x * n4x + n2y * n4y + n2z * n4z >= least * (n2x * n2x + n2y * n2y + n2z * n2z)
        and n3x * n4x + n3y * n4y + n3z * n4z >= least
    )


@njit(cache=True)
def _quality(points: Floats, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """Shortest edge over sqrt(3) circumradii, and the unit normal; zeros for a triangle without area."""
    ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
    vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
    wx, wy, wz = points[c, 0] - points[b, 0], points[c, 1] - points[b, 1], points[c, 2] - points[b, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    doubled = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not doubled > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    first, second = np.sqrt(ux * ux + uy * uy + uz * uz), np.sqrt(vx * vx + vy * vy + vz * vz)
    third = np.sqrt(wx * wx + wy * wy + wz * wz)
    # R is the product of the edges over four areas.
    return (
        2.0 * doubled * min(first, second, third) / (np.sqrt(3.0) * first * second * third),
        nx / doubled,
        ny / doubled,
        nz / doubled,
    )


@njit(cache=True)
def _corner(faces: Ints, f: int, vertex: int) -> int:
    """At which corner of the face the vertex is."""
    if faces[f, 0] == vertex:
        return 0
    return 1 if faces[f, 1] == vertex else 2


@njit(cache=True)
def _joined(faces: Ints, across: Ints, valences: Longs, f: int, c: int, d: int) -> bool:
    """Whether an edge joins c, a vertex of f, and d; or may do so, because the faces at c are more than one fan."""
    seen, g, closed = 0, f, False
    for turn in range(2):
        while g >= 0 and not closed:
            seen += 1
            k = _corner(faces, g, c)
            if faces[g, (k + 1) % 3] == d or faces[g, (k + 2) % 3] == d:
                return True
            g = across[g, k] if turn == 0 else across[g, (k + 2) % 3]
            closed = g == f
        if turn == 0 and not closed:
            g = across[f, (_corner(faces, f, c) + 2) % 3]
    return bool(seen != valences[c])
