"""The part of a mesh that is a surface, in a frame where its size is ordinary: where spectra are computed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..mesh import Floats, Frame, Ints, enter, leave, ordered_frame
from ..topology import referenced_vertices
from .problem import SpectralProblem


class FramedSurface(NamedTuple):
    """The vertices that triangles use.

    Attributes:
        used: (k,) ascending, which vertices of the mesh these are.
        given: (k, 3) their coordinates.
        points: (k, 3) these in the frame.
        faces: (m, 3) triangles in the numbers of `used`.
        frame: how `points` came from `given`.
    """

    used: NDArray[np.intp]
    given: Floats
    points: Floats
    faces: Ints
    frame: Frame

    def moved_to(self, points: Floats) -> Floats:
        """(k, 3) the coordinates for other points of the frame; what has not moved keeps every bit."""
        return leave(self.given, self.points, points, self.frame)


def framed_surface(vertices: Floats, faces: Ints) -> FramedSurface | None:
    """The surface of a checked mesh; None if there is no triangle with three corners."""
    used = np.flatnonzero(referenced_vertices(faces, len(vertices)))
    if len(used) == 0:
        return None
    given = vertices[used]
    if len(used) < len(vertices):
        number = np.full(len(vertices), -1, dtype=np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        renamed = number[faces]
        faces = np.ascontiguousarray(renamed[(renamed >= 0).all(axis=1)])
    frame = ordered_frame(given, None)
    return FramedSurface(used, given, enter(given, frame), faces, frame)


def about_centroids(points: Floats, problem: SpectralProblem) -> tuple[Floats, Floats]:
    """(n, 3) points about the centroid of their component, which no filter moves, and (n, 3) that centroid."""
    parts, mass = problem.components, problem.mass
    weight = np.bincount(parts, mass)
    means = np.stack([np.bincount(parts, mass * points[:, c]) / weight for c in range(3)], axis=1)
    return points - means[parts], means[parts]
