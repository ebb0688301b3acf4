"""Vertices moved by descent on the energy of faces that deviate from the normals that are wanted."""

import math

import numpy as np

from ..compilation import compiled, prange
from ..execution import threads_for
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import VertexFaces


def fitting_energy(vertices: Floats, faces: Ints, normals: Floats) -> float:
    """E = sum over the faces of A |n - m|^2 for the wanted normals m, in squared units of length."""
    terms = np.empty(len(faces))
    with threads_for(len(faces)):
        _energies(vertices, faces, normals, terms)
    return float(terms.sum())


def descend(
    vertices: Floats, at_vertices: VertexFaces, normals: Floats, iterations: int, moves: Bools, bound: Bools, faces: Ints
) -> Floats:
    """(n, 3) the vertices after conjugate gradients of Polak and Ribiere; arguments as of `fit_vertices`.

    Each has a line search that halves until the energy falls enough.
    """
    now = vertices.copy()
    gradient, direction = np.zeros_like(now), np.zeros_like(now)
    energy = fitting_energy(now, faces, normals)
    before = 0.0
    step = 0.0
    for iteration in range(iterations):
        fresh = np.zeros_like(now)
        with threads_for(len(vertices)):
            _gradients(now, at_vertices.offsets, at_vertices.rows, normals, moves, bound, fresh)
        square = float((fresh * fresh).sum())
        if not square > 0.0:
            break
        share = max(0.0, (square - float((fresh * gradient).sum())) / before) if iteration else 0.0
        direction = share * direction - fresh
        slope = float((direction * fresh).sum())
        if slope >= 0.0:
            direction, slope = -fresh, -square
        gradient, before = fresh, square
        # The Hessian of the energy is of the order of 1, whatever the size of the mesh.
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
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy, uz = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
        vx, vy, vz = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        # A |n - m|^2 = 2 A - 2 A n . m
        terms[f] = math.sqrt(x * x + y * y + z * z) - (x * normals[f, 0] + y * normals[f, 1] + z * normals[f, 2])


@compiled(parallel=True)
def _gradients(now: Floats, offsets: Longs, rows: Ints, normals: Floats, moves: Bools, bound: Bools, result: Floats) -> None:
    """The derivative of A |n - m|^2 by a corner is (n - m) x (the opposite side)."""
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
