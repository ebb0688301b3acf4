"""Coordinates rounded along one axis, as depths to steps of disparity: terraces on the surface, and how they are taken back.

Everywhere here `points` are (n, 3) coordinates, `faces` (m, 3) triangles, and `movable` says which of (n,) vertices may move,
None for all.
"""

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..evidence import tuned
from ..geometry import face_normals, mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import edges, referenced_vertices
from .noise_level import FourthOrder, ring_means

#: "keep": rounded coordinates are filtered as they are. "undo": terraces are smoothed first, see `Rounding.undone`.
RoundingPolicy: TypeAlias = Literal["keep", "undo"]
ROUNDING_POLICIES: tuple[RoundingPolicy, ...] = get_args(RoundingPolicy)

# Faces of one level are parallel up to this angle in radians, and its vertices as many mean edges apart.
_FLAT = 1e-3


class Rounding(NamedTuple):
    """Rounding along an axis."""

    direction: Floats  # (3,) its unit vector
    levels: Floats  # (k,) the coordinates along it that vertices have, ascending

    def undone(self, points: Floats, faces: Ints, movable: Bools | None = None) -> Floats:
        """(n, 3) the smoothest surface that has these levels when it is rounded: least bi-Laplacian energy within half a step."""
        heights = points @ self.direction
        middles = 0.5 * (self.levels[1:] + self.levels[:-1])
        ends = 2.0 * self.levels[[0, -1]] - middles[[0, -1]]
        at, limits = np.searchsorted(middles, heights), np.concatenate([ends[:1], middles, ends[1:]])
        low, high = limits[at], limits[at + 1]
        if movable is not None:
            low, high = np.where(movable, low, heights), np.where(movable, high, heights)
        means, now = ring_means(edges(faces), len(points)), heights
        for _ in range(100):
            # Descent on the squares of (I - W)^2 of W = (I + 2 U) / 3, which is (2/3)^2 (I - U)^2
            differences = (now - means @ now) * (2.0 / 3.0)
            now = np.clip(now - 0.9 * (2.0 / 3.0) * (differences - means @ differences), low, high)
        return np.asarray(points + (now - heights)[:, None] * self.direction)

    def left(self, points: Floats, rounded: Floats) -> Floats:
        """(n,) by how much other (n, 3) points are out of the steps of the rounded ones, in steps: no truth is."""
        heights = rounded @ self.direction
        at = np.searchsorted(0.5 * (self.levels[1:] + self.levels[:-1]), heights)
        steps = np.gradient(self.levels)[at]
        return np.asarray(np.maximum(np.abs(points @ self.direction - heights) / steps - 0.5, 0.0))


def rounding_of(points: Floats, faces: Ints) -> Rounding | None:
    """The rounding of a mesh; None of one that was not rounded.

    Faces whose vertices were rounded alike have one normal, the axis. Along it all vertices lie on few levels, and the roughness
    of the surface is along it.
    """
    edge = mean_edge_length(points, faces)
    normals = face_normals(points, faces)
    if edge == 0.0 or not len(faces):
        return None
    largest = np.abs(normals).argmax(axis=1)
    normals *= np.sign(normals[np.arange(len(normals)), largest])[:, None]
    width = 2 * int(1.0 / _FLAT) + 3
    keys = np.round(normals / _FLAT).astype(np.int64) @ [width**2, width, 1]
    _, first, counts = np.unique(keys, return_index=True, return_counts=True)
    flush = normals @ normals[first[counts.argmax()]] > 1.0 - _FLAT**2
    direction = normals[flush].sum(axis=0)
    length = np.linalg.norm(direction)  # 0 where the most frequent normal is that of faces without area
    if flush.mean() < tuned.FLUSH or len(counts) < 8 or length == 0.0:  # stairs have fewer normals
        return None
    direction /= length
    heights = np.sort(points[referenced_vertices(faces, len(points))] @ direction)
    apart = np.flatnonzero(np.diff(heights) > _FLAT * edge)
    low, high = heights[np.append(0, apart + 1)], heights[np.append(apart, len(heights) - 1)]
    levels = 0.5 * (low + high)
    if len(levels) < 3 or (high - low).max() > _FLAT * edge:
        return None
    fourth = FourthOrder.of(faces, len(points))
    along = (fourth.differences(points) @ direction)[fourth.inner]
    noise = float(np.sqrt((along**2).mean())) / float(np.median(np.diff(levels))) if len(along) else 0.0
    # The standard deviation of rounding to steps of 1 is 1 / sqrt(12).
    return Rounding(direction, levels) if 1.0 / tuned.ROUNDED < noise * np.sqrt(12.0) < tuned.ROUNDED else None


def without_rounding(points: Floats, faces: Ints, movable: Bools | None = None) -> Floats:
    """(n, 3) the points with their rounding undone; as they are if there is none."""
    found = rounding_of(points, faces)
    return points.copy() if found is None else found.undone(points, faces, movable)
