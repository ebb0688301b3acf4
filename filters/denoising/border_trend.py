"""Normals at borders by a local linear fit: a one-sided mean is biased inwards."""

import math

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..mesh import Bools, Floats, Ints
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, FaceNeighbourhoods, Neighborhood
from .neighbour_weights import Weighting, make_room, neighbour_weights, room_for

# To the second moments of the centres is added this share of their sum, so that faces in a row have a trend along it alone.
_RIDGE = 0.02
# The part of the shift by the trend that is taken away is 1 - this times its variance over its square, or none [james1961].
_DOUBT = 2.0
# A trend has three numbers a component.
_NUMBERS = 3.0
# In a radius of two mean distances of centres lies about one ring of faces at a vertex.
_DISTANCES_OF_RING = 2.0


def cut_off_by_border(faces: Ints, on_border: Bools, kind: Neighborhood, radius: float) -> Ints:
    """The faces, ascending, whose neighbourhoods a border cuts off.

    Args:
        faces: (m, 3) triangles.
        on_border: (n,) the vertices on a border.
        kind: of the neighbourhoods.
        radius: for "radius" and "geodesic", in mean distances of the centres.
    """
    if not on_border.any():
        return np.empty(0, dtype=np.int32)
    near = on_border
    found = near[faces].any(axis=1)
    for _ in range(1, RINGS_OF_NEIGHBORHOOD.get(kind, math.ceil(radius / _DISTANCES_OF_RING))):
        near = near.copy()
        near[faces[found]] = True
        found = near[faces].any(axis=1)
    return np.flatnonzero(found).astype(np.int32)


def follow_trend(
    result: Floats, which: Ints, normals: Floats, rows: Floats, neighbourhoods: FaceNeighbourhoods, weighting: Weighting
) -> None:
    """Put the value of a fit of first degree at the centre of some faces in the place of weighted means of normals.

    With the weights w_j of the mean and x_j = c_j - c_i, the normals n_j are fitted by b + G x_j, least squares, a ridge on
    G [cleveland1979]. The mean a lies off the fit at the face by G times the mean x, which is far from 0 at a border. With s^2
    the variance of b - a by the residuals, a goes to a + max(0, 1 - 2 s^2 / |b - a|^2) (b - a): where the normals scatter so
    much that no trend can be seen it stays.

    Args:
        result: (m, 3) unit normals, those of the faces are written to.
        which: (k,) the faces.
        normals: (m, 3) the normals that are averaged.
        rows: (m, 8) of `measure_faces`, with the normals on which deviations are measured.
        neighbourhoods: which faces are averaged over.
        weighting: the weights.
    """
    if len(which):
        size = room_for(neighbourhoods.offsets, weighting.itself)
        over_range(_follow, len(which), which, normals, rows, neighbourhoods, weighting, size, result)


@compiled(nogil=True)
def _follow(
    which: Ints,
    normals: Floats,
    rows: Floats,
    neighbourhoods: FaceNeighbourhoods,
    weighting: Weighting,
    size: int,
    result: Floats,
    first: int,
    last: int,
) -> None:
    room = make_room(size)
    x, mean_x, solved, mean, at_face = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    second, mixed, trend = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for at in range(first, last):
        i = which[at]
        count = neighbour_weights(i, i + 1, rows, neighbourhoods, weighting, room)
        cx, cy, cz = rows[i, 4], rows[i, 5], rows[i, 6]
        total = squares = 0.0
        # Numbers of their own stay in registers.
        ax = ay = az = px = py = pz = xx = xy = xz = yy = yz = zz = 0.0
        bxx = bxy = bxz = byx = byy = byz = bzx = bzy = bzz = 0.0
        for k in range(count):
            j, weight = room.near[k], room.weights[k]
            if weight == 0.0:
                continue
            dx, dy, dz = rows[j, 4] - cx, rows[j, 5] - cy, rows[j, 6] - cz
            total += weight
            squares += weight * weight
            nx, ny, nz = normals[j, 0], normals[j, 1], normals[j, 2]
            wx, wy, wz = weight * dx, weight * dy, weight * dz
            ax, ay, az = ax + weight * nx, ay + weight * ny, az + weight * nz
            px, py, pz = px + wx, py + wy, pz + wz
            xx, xy, xz, yy, yz, zz = xx + wx * dx, xy + wx * dy, xz + wx * dz, yy + wy * dy, yz + wy * dz, zz + wz * dz
            bxx, bxy, bxz = bxx + wx * nx, bxy + wx * ny, bxz + wx * nz
            byx, byy, byz = byx + wy * nx, byy + wy * ny, byz + wy * nz
            bzx, bzy, bzz = bzx + wz * nx, bzy + wz * ny, bzz + wz * nz
        ridge = _RIDGE * (xx + yy + zz)
        mean[0], mean[1], mean[2] = ax, ay, az
        mean_x[0], mean_x[1], mean_x[2] = px, py, pz
        second[0, 0], second[1, 0], second[2, 0] = xx + ridge, xy, xz
        second[1, 1], second[2, 1], second[2, 2] = yy + ridge, yz, zz + ridge
        mixed[0, 0], mixed[0, 1], mixed[0, 2] = bxx, bxy, bxz
        mixed[1, 0], mixed[1, 1], mixed[1, 2] = byx, byy, byz
        mixed[2, 0], mixed[2, 1], mixed[2, 2] = bzx, bzy, bzz
        # As many neighbours of equal weight would have a mean of the same variance.
        number = total * total / squares if squares > 0.0 else 0.0
        if not (number > _NUMBERS and ridge > 0.0):
            continue
        _factor(second)
        _solve(second, mean_x, solved)
        leverage = (solved[0] * mean_x[0] + solved[1] * mean_x[1] + solved[2] * mean_x[2]) / total
        if not leverage < 1.0:
            continue
        shift = residual = 0.0
        for v in range(3):
            pulled = solved[0] * mixed[0, v] + solved[1] * mixed[1, v] + solved[2] * mixed[2, v]
            at_face[v] = (mean[v] - pulled) / (total * (1.0 - leverage))
            for u in range(3):
                x[u] = mixed[u, v] - mean_x[u] * at_face[v]
            _solve(second, x, trend[v])
            for u in range(3):
                residual -= trend[v, u] * (x[u] + ridge * trend[v, u])
            mean[v] /= total
            # The normals have a length of 1, so that their squares sum up to the weights.
            residual += total * (at_face[v] * at_face[v] - 2.0 * at_face[v] * mean[v])
            shift += (at_face[v] - mean[v]) * (at_face[v] - mean[v])
        residual = max(0.0, (residual + total) / total)
        variance = residual / (number - _NUMBERS) * leverage / (1.0 - leverage)
        share = 1.0 - _DOUBT * variance / shift if shift > 0.0 else 0.0
        if not share > 0.0:
            continue
        for v in range(3):
            mean[v] += share * (at_face[v] - mean[v])
        length = math.sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2])
        if length > 1e-300:
            for v in range(3):
                result[i, v] = mean[v] / length


@compiled(nogil=True)
def _factor(matrix: Floats) -> None:
    """Cholesky's factor of a positive definite matrix, in the place of its lower triangle."""
    for a in range(3):
        for b in range(a + 1):
            rest = matrix[a, b]
            for c in range(b):
                rest -= matrix[a, c] * matrix[b, c]
            matrix[a, b] = math.sqrt(rest) if a == b else rest / matrix[b, b]


@compiled(nogil=True)
def _solve(factor: Floats, side: Floats, solution: Floats) -> None:
    for a in range(3):
        solution[a] = side[a]
        for b in range(a):
            solution[a] -= factor[a, b] * solution[b]
        solution[a] /= factor[a, a]
    for a in range(2, -1, -1):
        for b in range(a + 1, 3):
            solution[a] -= factor[b, a] * solution[b]
        solution[a] /= factor[a, a]
