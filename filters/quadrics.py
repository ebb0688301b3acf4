"""Weighted least-squares quadrics of heights over tangential coordinates."""

import math

from .compilation import compiled
from .mesh import Floats

# With fewer samples or a smaller relative pivot (samples on a conic), a plane replaces the quadric.
_LEAST_SAMPLES = 8
_LEAST_PIVOT = 1e-4


@compiled(nogil=True)
def height_of_quadric(samples: Floats, count: int, most: float, work: Floats) -> tuple[float, float]:
    """Fits a quadric to weighted heights; returns its value at u = v = 0, and the standard deviation of this value.

    The heights count as independent, with the standard deviation 1. Fewer than eight samples, or samples on a conic, get a plane
    instead of a quadric; if the plane fails too, the mean.

    Args:
        samples: (4, at least `count`) rows: coordinates u and v, of a size around 1; heights; weights above 0.
        count: number of samples; without samples the value is 0.
        most: the largest standard deviation of the value; above it a plane replaces a quadric, and the mean a plane.
        work: (9, 6) scratch array.
    """
    matrix, terms, solution = work[:7], work[7], work[8]
    u, v, h, w = samples[0], samples[1], samples[2], samples[3]
    for size in (6, 3, 1):
        if count < (_LEAST_SAMPLES if size == 6 else size):
            continue
        matrix[:] = 0.0
        for at in range(count):
            _terms(u[at], v[at], terms)
            for a in range(size):
                for b in range(a + 1):
                    matrix[a, b] += w[at] * terms[a] * terms[b]
        # The solution, row 0 of the inverse matrix, turns the sums of w * terms * h into the value at 0.
        matrix[size, 0] = 1.0
        if not _solve(matrix, size, solution):
            continue
        height = squares = 0.0
        for at in range(count):
            _terms(u[at], v[at], terms)
            share = 0.0
            for a in range(size):
                share += solution[a] * terms[a]
            share *= w[at]
            height += share * h[at]
            squares += share * share
        if size == 1 or squares <= most * most:
            return height, math.sqrt(squares)
    return 0.0, 0.0


@compiled(nogil=True)
def _terms(u: float, v: float, terms: Floats) -> None:
    terms[0], terms[1], terms[2], terms[3], terms[4], terms[5] = 1.0, u, v, u * u, u * v, v * v


@compiled(nogil=True)
def _solve(matrix: Floats, size: int, solution: Floats) -> bool:
    """Solves a system by Cholesky factorisation in the lower triangle; row `size` is the right side. False if nearly singular."""
    for a in range(size + 1):
        for b in range(min(a, size)):
            for c in range(b):
                matrix[a, b] -= matrix[a, c] * matrix[b, c]
            matrix[a, b] /= matrix[b, b]
        if a < size:
            diagonal = matrix[a, a]
            for c in range(a):
                matrix[a, a] -= matrix[a, c] * matrix[a, c]
            if not matrix[a, a] > _LEAST_PIVOT * diagonal:
                return False
            matrix[a, a] = math.sqrt(matrix[a, a])
    for a in range(size - 1, -1, -1):
        solution[a] = matrix[size, a]
        for c in range(a + 1, size):
            solution[a] -= matrix[c, a] * solution[c]
        solution[a] /= matrix[a, a]
    return True


@compiled(nogil=True)
def tangents(x: float, y: float, z: float) -> tuple[float, float, float, float, float, float]:
    """Returns two unit vectors, perpendicular to each other and to a unit normal; zeros for the normal 0."""
    # The first tangent has the component 0 where the normal has its smallest absolute component.
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        ax, ay, az = 0.0, z, -y
    elif abs(y) <= abs(z):
        ax, ay, az = -z, 0.0, x
    else:
        ax, ay, az = y, -x, 0.0
    length = math.sqrt(ax * ax + ay * ay + az * az)
    if length == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ax, ay, az = ax / length, ay / length, az / length
    return ax, ay, az, y * az - z * ay, z * ax - x * az, x * ay - y * ax


__all__ = ["height_of_quadric", "tangents"]
