"""Coordinates rounded, as depths to steps of disparity, or all three: terraces on the surface, and how they are taken back.

Everywhere here `points` are (n, 3) coordinates, `faces` (m, 3) triangles, and `movable` says which of (n,) vertices may move,
None for all.
"""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..evidence import tuned
from ..geometry import face_normals, mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import edges, referenced_vertices
from .noise_level import FourthOrder, ring_means

#: "keep": rounded coordinates are filtered as they are. "undo": terraces are smoothed first, see `Rounding.undone`.
RoundingPolicy: TypeAlias = Literal["keep", "undo"]

# Faces of one level are parallel up to this angle in radians, and its vertices as many mean edges apart.
_FLAT = 1e-3


class Rounding(NamedTuple):
    """Rounding along one axis, as of depths, or along up to three at right angles, as of coordinates."""

    directions: tuple[Floats, ...]  # (3,) the unit vectors of the axes
    levels: tuple[Floats, ...]  # (k,) for each the coordinates along it that vertices have, ascending

    @property
    def step(self) -> float:
        """The largest usual step; it is noise with a deviation of step / sqrt(12) along any direction."""
        return max(float(np.median(np.diff(levels))) for levels in self.levels)

    def undone(self, points: Floats, faces: Ints, movable: Bools | None = None) -> Floats:
        """(n, 3) a smoother surface that has these levels when it is rounded: less bi-Laplacian energy, within half a step."""
        means, result = ring_means(edges(faces), len(points)), points
        for direction, levels in zip(*self, strict=True):
            heights = points @ direction
            middles = 0.5 * (levels[1:] + levels[:-1])
            ends = 2.0 * levels[[0, -1]] - middles[[0, -1]]
            at, limits = np.searchsorted(middles, heights), np.concatenate([ends[:1], middles, ends[1:]])
            low, high = limits[at], limits[at + 1]
            if movable is not None:
                low, high = np.where(movable, low, heights), np.where(movable, high, heights)
            now = heights
            for _ in range(100 // len(self.directions)):  # of three axes a hundred steps shrink tubes to the ends of theirs
                # Descent on the squares of (I - W)^2 of W = (I + 2 U) / 3, which is (2/3)^2 (I - U)^2
                differences = (now - means @ now) * (2.0 / 3.0)
                now = np.clip(now - 0.9 * (2.0 / 3.0) * (differences - means @ differences), low, high)
            result = result + (now - heights)[:, None] * direction
        return np.asarray(result)

    def left(self, points: Floats, rounded: Floats, normals: Floats) -> Floats:
        """(n,) by how much other (n, 3) points are out of the steps of the rounded ones, in steps: no truth is.

        Of several axes along them or along (n, 3) unit normals, whichever is less, since all vertices slide.
        """
        moves, out, reach = points - rounded, np.zeros(len(points)), np.zeros(len(points))
        for direction, levels in zip(self.directions, self.levels, strict=True):
            step = np.gradient(levels)[np.searchsorted(0.5 * (levels[1:] + levels[:-1]), rounded @ direction)]
            out = np.maximum(out, np.abs(moves @ direction) / step - 0.5)
            reach += 0.5 * step * np.abs(normals @ direction)
        if len(self.directions) > 1:
            out = np.minimum(out, np.maximum(np.abs(np.einsum("ij,ij->i", moves, normals)) - reach, 0.0) / self.step)
        return np.asarray(out)


def rounding_of(points: Floats, faces: Ints) -> Rounding | None:
    """The rounding of a mesh; None of one that was not rounded.

    Faces of vertices that were rounded alike have one normal, the axis: along it vertices lie on few levels, and the surface is
    rough. Other axes are at right angles to it.
    """
    edge = mean_edge_length(points, faces)
    if edge == 0.0 or not len(faces):
        return None
    used, found = points[referenced_vertices(faces, len(points))], []
    fourth: FourthOrder | None = None
    for axis in _axes(face_normals(points, faces)):
        levels = _levels(used @ axis, _FLAT * edge)
        if levels is not None:
            fourth = fourth or FourthOrder.of(faces, len(points))
            squares = fourth.differences((points @ axis)[:, None])[fourth.inner] ** 2
            # The standard deviation of rounding to steps of 1 is 1 / sqrt(12).
            noise = np.sqrt(12.0 * squares.mean()) / np.median(np.diff(levels)) if len(squares) else 0.0
            if 1.0 / tuned.ROUNDED < noise < tuned.ROUNDED:
                found.append((axis, levels))
        if not found:
            return None
    return Rounding(*map(tuple, zip(*found, strict=True))) if found else None


def _axes(normals: Floats) -> list[Floats]:
    """(3,) the most frequent of (m, 3) normals, the most frequent across it, and what is across both, as far as there are."""
    normals = normals * np.sign(normals[np.arange(len(normals)), np.abs(normals).argmax(axis=1)])[:, None]
    width = 2 * int(1.0 / _FLAT) + 3
    keys, axes = np.round(normals / _FLAT).astype(np.int64) @ [width**2, width, 1], list[Floats]()
    for _ in range(2):
        across = np.flatnonzero(np.abs(normals @ axes[0]) < _FLAT) if axes else np.arange(len(normals))
        _, first, counts = np.unique(keys[across], return_index=True, return_counts=True)
        if not len(counts) or (not axes and len(counts) < 8):  # stairs have fewer normals
            return axes
        flush = normals[across] @ normals[across[first[counts.argmax()]]] > 1.0 - _FLAT**2
        direction = normals[across][flush].sum(axis=0)
        length = np.linalg.norm(direction)  # 0 where the most frequent normal is that of faces without area
        if length == 0.0 or (not axes and flush.mean() < tuned.FLUSH):
            return axes
        axes.append(direction / length)
    return [*axes, np.cross(axes[0], axes[1])]


def _levels(heights: Floats, width: float) -> Floats | None:
    """The levels of heights, ascending; None if they are not on three at least, none wider than that."""
    heights = np.sort(heights)
    apart = np.flatnonzero(np.diff(heights) > width)
    low, high = heights[np.append(0, apart + 1)], heights[np.append(apart, len(heights) - 1)]
    return None if len(low) < 3 or (high - low).max() > width else 0.5 * (low + high)


def without_rounding(points: Floats, faces: Ints, movable: Bools | None = None) -> Floats:
    """(n, 3) the points with their rounding undone; as they are if there is none."""
    found = rounding_of(points, faces)
    return points.copy() if found is None else found.undone(points, faces, movable)
