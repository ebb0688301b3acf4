"""Fits vertices to target normals of the faces: by averaged projections, or by descent on an energy."""

import math
from typing import Literal, TypeAlias

import numpy as np

from ..checks import check_choice
from ..compilation import compiled, prange
from ..execution import over_range, threads_for
from ..geometry import NORMAL, cross_product
from ..mesh import Bools, Floats, Ints
from ..topology import VertexFaces

#: "sun": the mean of the projections onto the planes of the faces around a vertex [sun2007]. "ohtake": their area-weighted mean
#: [ohtake2001]. "conjugate_gradient": descent on the `fitting_energy`.
VertexUpdate: TypeAlias = Literal["sun", "ohtake", "conjugate_gradient"]

# A step that would flip a face is halved up to this number of times, then left out.
_HALVINGS = 3
# The squared length of the longest step without a flip is multiplied by this factor, because of rounding errors.
_SAFE = 0.999
# A row for each face: target normal m, m . c for the centre c, weight, squared length of the longest step without a flip.
_OFFSET, _WEIGHT, _REACH, _COLUMNS = 3, 4, 5, 6


def fit_vertices(
    vertices: Floats,
    faces: Ints,
    at_vertices: VertexFaces,
    normals: Floats,
    *,
    update: VertexUpdate = "sun",
    iterations: int = 10,
    moves: Bools,
    along_normal: Bools | None = None,
    overwrite: Floats | None = None,
) -> Floats:
    """Returns (n, 3) the vertices after `iterations` steps towards faces with the given target normals.

    "sun" and "ohtake" move all p_i at once to p_i + sum_j w_j m_j (m_j . (c_j - p_i)) / sum_j w_j, over the faces j at i with
    target normals m_j and centres c_j; w_j is 1 or the area of j. A step that turns a face away from its target normal is halved
    up to three times, then left out, except by "conjugate_gradient". Vertices that are `along_normal`, as on borders, move along
    the mean target normal only. `overwrite` is an (m, 6) or wider array, whose memory is reused.
    """
    check_choice("vertex_update", update, VertexUpdate)
    bound = np.zeros(len(vertices), dtype=np.bool_) if along_normal is None else along_normal
    if update == "conjugate_gradient":
        return _descend(vertices, at_vertices, normals, iterations, moves, bound, faces)
    now, then = vertices.copy(), np.empty_like(vertices)
    planes = np.empty((len(faces), _COLUMNS)) if overwrite is None else overwrite
    planes[:, NORMAL] = normals
    for _ in range(iterations):
        over_range(_measure, len(faces), now, faces, update == "ohtake", planes)
        over_range(_step, len(vertices), now, at_vertices, planes, moves, bound, then)
        now, then = then, now
    return now


def fitting_energy(vertices: Floats, faces: Ints, normals: Floats) -> float:
    """Returns E = sum over the faces of A |n - m|^2, with normals n and target normals m, in squared units of length."""
    terms = np.empty(len(faces))
    with threads_for(len(faces)):
        _energies(vertices, faces, normals, terms)
    return float(terms.sum())


def _descend(
    vertices: Floats, at_vertices: VertexFaces, normals: Floats, iterations: int, moves: Bools, bound: Bools, faces: Ints
) -> Floats:
    """Polak-Ribiere conjugate gradients with a backtracking line search."""
    now = vertices.copy()
    gradient, direction = np.zeros_like(now), np.zeros_like(now)
    energy = fitting_energy(now, faces, normals)
    before = step = 0.0
    for iteration in range(iterations):
        fresh = np.zeros_like(now)
        with threads_for(len(vertices)):
            _gradients(now, at_vertices, normals, moves, bound, fresh)
        square = float((fresh * fresh).sum())
        if not square > 0.0:
            break
        share = max(0.0, (square - float((fresh * gradient).sum())) / before) if iteration else 0.0
        direction = share * direction - fresh
        slope = float((direction * fresh).sum())
        if slope >= 0.0:
            direction, slope = -fresh, -square
        gradient, before = fresh, square
        # The Hessian of the energy is of the order of 1 for a mesh of any size.
        step = min(1.0, 2.0 * step) if step > 0.0 else 0.25
        for _ in range(30):
            trial = now + step * direction
            lower = fitting_energy(trial, faces, normals)
            if lower <= energy + 1e-4 * step * slope:
                break
            step *= 0.5
        else:
            break
        now, energy = np.where(direction != 0.0, trial, now), lower
    return now


@compiled(parallel=True)
def _energies(vertices: Floats, faces: Ints, normals: Floats, terms: Floats) -> None:
    for f in prange(faces.shape[0]):
        x, y, z = cross_product(vertices, faces[f, 0], faces[f, 1], faces[f, 2])
        # A |n - m|^2 = 2 A - 2 A n . m
        terms[f] = math.sqrt(x * x + y * y + z * z) - (x * normals[f, 0] + y * normals[f, 1] + z * normals[f, 2])


@compiled(parallel=True)
def _gradients(now: Floats, around: VertexFaces, normals: Floats, moves: Bools, bound: Bools, result: Floats) -> None:
    """Writes the gradient; the derivative of A |n - m|^2 with respect to a corner is (n - m) x (the opposite side)."""
    offsets, rows = around
    for i in prange(now.shape[0]):
        if not moves[i]:
            continue
        x = y = z = 0.0
        mx = my = mz = 0.0
        for k in range(offsets[i], offsets[i + 1]):
            f, a, b = rows[k, 0], rows[k, 1], rows[k, 2]
            ux, uy, uz = now[a, 0] - now[i, 0], now[a, 1] - now[i, 1], now[a, 2] - now[i, 2]
            wx, wy, wz = now[b, 0] - now[a, 0], now[b, 1] - now[a, 1], now[b, 2] - now[a, 2]
            cx, cy, cz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
            length = math.sqrt(cx * cx + cy * cy + cz * cz)
            nx, ny, nz = -normals[f, 0], -normals[f, 1], -normals[f, 2]
            mx -= nx
            my -= ny
            mz -= nz
            if length > 0.0:
                nx, ny, nz = nx + cx / length, ny + cy / length, nz + cz / length
            x += ny * wz - nz * wy
            y += nz * wx - nx * wz
            z += nx * wy - ny * wx
        if bound[i]:
            squared = mx * mx + my * my + mz * mz
            if squared > 0.0:
                share = (x * mx + y * my + z * mz) / squared
                x, y, z = share * mx, share * my, share * mz
        result[i, 0], result[i, 1], result[i, 2] = x, y, z


@compiled(nogil=True, error_model="numpy")
def _measure(now: Floats, faces: Ints, by_area: bool, planes: Floats, first: int, last: int) -> None:
    for f in range(np.uint64(first), np.uint64(last)):
        a, b, c = np.uint32(faces[f, 0]), np.uint32(faces[f, 1]), np.uint32(faces[f, 2])
        px, py, pz = now[a, 0], now[a, 1], now[a, 2]
        ux, uy, uz = now[b, 0] - px, now[b, 1] - py, now[b, 2] - pz
        vx, vy, vz = now[c, 0] - px, now[c, 1] - py, now[c, 2] - pz
        wx, wy, wz = vx - ux, vy - uy, vz - uz
        nx, ny, nz = planes[f, 0], planes[f, 1], planes[f, 2]
        cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        planes[f, _OFFSET] = nx * px + ny * py + nz * pz + (nx * (ux + vx) + ny * (uy + vy) + nz * (uz + vz)) / 3.0
        planes[f, _WEIGHT] = math.sqrt(cx * cx + cy * cy + cz * cz) if by_area else 1.0
        # A step s of a corner changes (u x v) . m by at most |s| times the length of the opposite side.
        side = cx * nx + cy * ny + cz * nz
        longest = max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz)
        planes[f, _REACH] = side * side / longest if side > 0.0 else math.inf


# Unsigned indices save the test for negative indices.
@compiled(nogil=True, error_model="numpy")
def _step(now: Floats, at: VertexFaces, planes: Floats, moves: Bools, bound: Bools, then: Floats, first: int, last: int) -> None:
    offsets, rows = at
    for i in range(np.uint64(first), np.uint64(last)):
        px, py, pz = now[i, 0], now[i, 1], now[i, 2]
        x = y = z = total = 0.0
        least = math.inf
        if moves[i]:
            start, stop = np.uint64(offsets[i]), np.uint64(offsets[i + 1])
            for k in range(start, stop):
                f = np.uint32(rows[k, 0])
                nx, ny, nz, weight = planes[f, 0], planes[f, 1], planes[f, 2], planes[f, _WEIGHT]
                height = weight * (planes[f, _OFFSET] - (nx * px + ny * py + nz * pz))
                x += height * nx
                y += height * ny
                z += height * nz
                total += weight
                if planes[f, _REACH] < least:
                    least = planes[f, _REACH]
        if total > 0.0:
            x, y, z = x / total, y / total, z / total
            if bound[i]:
                x, y, z = _along_mean_normal(x, y, z, rows, int(start), int(stop), planes)
            if not x * x + y * y + z * z < _SAFE * least:
                share = _share_without_flips(now, i, rows, int(start), int(stop), planes, (x, y, z))
                x, y, z = share * x, share * y, share * z
        then[i, 0] = px + x if x != 0.0 else px
        then[i, 1] = py + y if y != 0.0 else py
        then[i, 2] = pz + z if z != 0.0 else pz


@compiled(nogil=True)
def _along_mean_normal(
    x: float, y: float, z: float, rows: Ints, start: int, stop: int, planes: Floats
) -> tuple[float, float, float]:
    """Returns the part of a step along the weighted mean of the target normals; the whole step if this mean is 0."""
    mx = my = mz = 0.0
    for k in range(start, stop):
        f = np.uint32(rows[k, 0])
        weight = planes[f, _WEIGHT]
        mx += weight * planes[f, 0]
        my += weight * planes[f, 1]
        mz += weight * planes[f, 2]
    squared = mx * mx + my * my + mz * mz
    if not squared > 0.0:
        return x, y, z
    share = (x * mx + y * my + z * mz) / squared
    return share * mx, share * my, share * mz


@compiled(nogil=True)
def _share_without_flips(
    now: Floats, i: int, rows: Ints, start: int, stop: int, planes: Floats, step: tuple[float, float, float]
) -> float:
    """Returns the largest of the shares 1, 1/2, 1/4, 1/8 of a step of vertex i that flips no face; 0 if each flips a face."""
    px, py, pz = now[i, 0], now[i, 1], now[i, 2]
    share = 1.0
    for _ in range(_HALVINGS + 1):
        x, y, z = share * step[0], share * step[1], share * step[2]
        for k in range(start, stop):
            f, a, b = np.uint32(rows[k, 0]), np.uint32(rows[k, 1]), np.uint32(rows[k, 2])
            nx, ny, nz = planes[f, 0], planes[f, 1], planes[f, 2]
            ux, uy, uz = now[a, 0] - px, now[a, 1] - py, now[a, 2] - pz
            vx, vy, vz = now[b, 0] - px, now[b, 1] - py, now[b, 2] - pz
            before = (uy * vz - uz * vy) * nx + (uz * vx - ux * vz) * ny + (ux * vy - uy * vx) * nz
            # (u - s) x (v - s) = u x v - s x (v - u)
            wx, wy, wz = vx - ux, vy - uy, vz - uz
            change = (y * wz - z * wy) * nx + (z * wx - x * wz) * ny + (x * wy - y * wx) * nz
            if before > 0.0 and before - change <= 0.0:
                break
        else:
            return share
        share *= 0.5
    return 0.0
