"""Vertices moved until their faces have the normals that are wanted."""

import math
from typing import Literal, TypeAlias, get_args

import numpy as np

from ..checks import check_choice
from ..compilation import compiled
from ..execution import over_range
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import VertexFaces
from .vertex_descent import descend

#: "sun": the mean of the projections onto the planes of the faces around a vertex [sun2007]; "ohtake": their mean by area
#: [ohtake2001]; "conjugate_gradient": descent on the energy sum A |n - m|^2.
VertexUpdate: TypeAlias = Literal["sun", "ohtake", "conjugate_gradient"]
VERTEX_UPDATES: tuple[VertexUpdate, ...] = get_args(VertexUpdate)

# A step that would flip a face is halved this often, then left out.
_HALVINGS = 3
# Below 1 by more than rounding: what is called too short to turn a face is so in the sums of `_flips` too.
_SAFE = 0.999


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
    avoid_flips: bool = True,
) -> Floats:
    """(n, 3) the vertices after `iterations` steps towards faces with the given normals.

    "sun" and "ohtake" take p_i to p_i + sum_j w_j n_j (n_j . (c_j - p_i)) / sum_j w_j over the faces j at i, of centre c_j, with
    w_j = 1 or the area of j, all vertices at once. Steps of faces that have no area yet weigh 0 in "ohtake".

    Args:
        vertices: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
        at_vertices: the faces at every vertex, of `vertex_faces`.
        normals: (m, 3) the unit normals that are wanted.
        update: the rule.
        iterations: number of steps. More fit more closely.
        moves: (n,) which vertices move.
        along_normal: (n,) which vertices move along the mean of their faces' wanted normals only, as those of borders.
        avoid_flips: halve, and in the end leave out, a step that turns a face that looks to the side of its wanted normal away
            from it.
    """
    check_choice("vertex_update", update, VERTEX_UPDATES)
    bound = np.zeros(len(vertices), dtype=np.bool_) if along_normal is None else along_normal
    if update == "conjugate_gradient":
        return descend(vertices, at_vertices, normals, iterations, moves, bound, faces)
    now, then = vertices.copy(), np.empty_like(vertices)
    for _ in range(iterations):
        arguments = (now, at_vertices.offsets, at_vertices.rows, normals, moves, bound, update == "ohtake", avoid_flips, then)
        over_range(_step, len(vertices), *arguments)
        now, then = then, now
    return now


@compiled(nogil=True)
def _step(
    now: Floats,
    offsets: Longs,
    rows: Ints,
    normals: Floats,
    moves: Bools,
    bound: Bools,
    by_area: bool,
    avoid_flips: bool,
    then: Floats,
    first: int,
    last: int,
) -> None:
    for i in range(first, last):
        px, py, pz = now[i, 0], now[i, 1], now[i, 2]
        then[i, 0], then[i, 1], then[i, 2] = px, py, pz
        if not moves[i] or offsets[i] == offsets[i + 1]:
            continue
        x = y = z = total = 0.0
        mx = my = mz = 0.0
        smallest, longest = math.inf, 0.0
        for k in range(offsets[i], offsets[i + 1]):
            f, a, b = rows[k, 0], rows[k, 1], rows[k, 2]
            ux, uy, uz = now[a, 0] - px, now[a, 1] - py, now[a, 2] - pz
            vx, vy, vz = now[b, 0] - px, now[b, 1] - py, now[b, 2] - pz
            nx, ny, nz = normals[f, 0], normals[f, 1], normals[f, 2]
            cx, cy, cz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            weight = 1.0
            if by_area:
                weight = math.sqrt(cx * cx + cy * cy + cz * cz)
            side = cx * nx + cy * ny + cz * nz
            if side > 0.0:
                smallest = min(smallest, side)
            wx, wy, wz = vx - ux, vy - uy, vz - uz
            longest = max(longest, wx * wx + wy * wy + wz * wz)
            height = weight * (nx * (ux + vx) + ny * (uy + vy) + nz * (uz + vz)) / 3.0
            x += height * nx
            y += height * ny
            z += height * nz
            mx += weight * nx
            my += weight * ny
            mz += weight * nz
            total += weight
        if not total > 0.0:
            continue
        x, y, z = x / total, y / total, z / total
        if bound[i]:
            squared = mx * mx + my * my + mz * mz
            if squared > 0.0:
                share = (x * mx + y * my + z * mz) / squared
                x, y, z = share * mx, share * my, share * mz
        # A step s changes (u x v) . n by at most |s| |v - u|. Most steps are too short to turn any face: no need to look again.
        if avoid_flips and not (x * x + y * y + z * z) * longest < _SAFE * smallest * smallest:
            for trial in range(_HALVINGS + 1):
                if not _flips(now, offsets[i], offsets[i + 1], rows, normals, px, py, pz, x, y, z):
                    break
                if trial == _HALVINGS:
                    x = y = z = 0.0
                else:
                    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
        if x != 0.0:
            then[i, 0] = px + x
        if y != 0.0:
            then[i, 1] = py + y
        if z != 0.0:
            then[i, 2] = pz + z


@compiled
def _flips(
    now: Floats,
    start: int,
    stop: int,
    rows: Ints,
    normals: Floats,
    px: float,
    py: float,
    pz: float,
    x: float,
    y: float,
    z: float,
) -> bool:
    """Whether the step (x, y, z) of the vertex p turns a face that looks the right way to the other side."""
    for k in range(start, stop):
        f, a, b = rows[k, 0], rows[k, 1], rows[k, 2]
        nx, ny, nz = normals[f, 0], normals[f, 1], normals[f, 2]
        ux, uy, uz = now[a, 0] - px, now[a, 1] - py, now[a, 2] - pz
        vx, vy, vz = now[b, 0] - px, now[b, 1] - py, now[b, 2] - pz
        before = (uy * vz - uz * vy) * nx + (uz * vx - ux * vz) * ny + (ux * vy - uy * vx) * nz
        # (u - s) x (v - s) = u x v - s x (v - u)
        wx, wy, wz = vx - ux, vy - uy, vz - uz
        change = (y * wz - z * wy) * nx + (z * wx - x * wz) * ny + (x * wy - y * wx) * nz
        if before > 0.0 and before - change <= 0.0:
            return True
    return False
