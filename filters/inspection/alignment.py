"""Aligning a surface with another one that it nearly lies on: iterated nearest places, point to plane [chen1992]."""

import math
from dataclasses import dataclass

import numpy as np

from ..libraries import spatial
from ..mesh import Floats, Ints
from .distances import face_samples, sample_places
from .surface import Surface

#: Samples of the surface that is moved.
_SAMPLES = 20_000
#: The share of the samples, the nearest ones, that determines the motion. The others may be places that only one scan has.
_TRUSTED = 0.8
#: The most iterations, and the step at which they end, as a share of the size of the surface.
_ITERATIONS, _SMALLEST = 200, 3e-6


@dataclass(frozen=True, eq=False)
class Alignment:
    """The rigid motion of a surface onto another one."""

    vertices: Floats  # (n, 3) where its vertices are now
    degrees: float  # by which it was turned
    shift: float  # by which its middle was moved, in mesh units
    residual: float  # the root mean square of the distances of the 80 % of its samples that lie nearest
    iterations: int  # how many it took
    converged: bool  # whether the last step was below 3e-6 of the size


def align(vertices: Floats, faces: Ints, to: Surface) -> Alignment:
    """Turn and move a mesh or a cloud so that it lies on a surface. At the start it must be some degrees off at most.

    Args:
        vertices: (n, 3) coordinates, n at least 1.
        faces: (m, 3) triangles; none of a cloud.
        to: the other surface, with faces.
    """
    middle = vertices.mean(axis=0)
    local = vertices - middle
    of = face_samples(local, faces, _SAMPLES).faces
    samples = sample_places(local, faces, of, np.arange(0, len(of), max(1, len(of) // _SAMPLES)))
    size = float(np.linalg.norm(np.ptp(samples, axis=0))) or 1.0
    turn, shift = np.eye(3), np.zeros(3)
    residual, iterations, step = math.inf, 0, math.inf
    while iterations < _ITERATIONS and step > _SMALLEST:
        iterations += 1
        places = samples @ turn.T + shift
        nearest = to.nearest(places + middle, vectors=True)
        trusted = np.argsort(nearest.distances, kind="stable")[: max(6, int(_TRUSTED * len(places)))]
        residual = math.sqrt(float((nearest.distances[trusted] ** 2).mean()))
        normals, p = to.normals_of(nearest.elements[trusted]), places[trusted] / size
        # Least squares of n (p + w x p + t - q): the turn w and the shift t, both small.
        rows = np.column_stack([np.cross(p, normals), normals])
        heights = np.einsum("ij,ij->i", nearest.vectors[trusted], normals) / size
        motion = np.linalg.lstsq(rows.T @ rows, -rows.T @ heights, rcond=1e-12)[0]
        more = spatial.transform.Rotation.from_rotvec(motion[:3]).as_matrix()
        turn, shift = more @ turn, more @ shift + size * motion[3:]
        step = float(np.linalg.norm(motion))
    angle = math.degrees(float(spatial.transform.Rotation.from_matrix(turn).magnitude()))
    moved = local @ turn.T + shift + middle
    return Alignment(moved, angle, float(np.linalg.norm(shift)), residual, iterations, step <= _SMALLEST)
