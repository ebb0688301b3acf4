"""Rounded coordinates, such as depths rounded to steps of disparity: finds the terraces that they form, and smooths them.

In this module `points` are (n, 3) coordinates, `faces` (m, 3) triangles, `movable` (n,) the vertices that may move, None for all.
"""

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..evidence import tuned
from ..geometry import face_normals, mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import edges, referenced_vertices
from .noise_level import FourthOrder, ring_means

#: "keep" filters rounded coordinates as they are. "undo" smooths the terraces first.
RoundingPolicy: TypeAlias = Literal["keep", "undo"]

# The largest angle between normals of one level, in radians (about); and the largest thickness of a level, in mean edge lengths.
_FLAT = 1e-3


class Rounding(NamedTuple):
    """Rounding along one axis (depths) or along up to three perpendicular axes (coordinates)."""

    directions: tuple[Floats, ...]  # (3,) unit vectors of the axes
    levels: tuple[Floats, ...]  # for each axis, the (k,) coordinates along it at which vertices lie, ascending

    @property
    def step(self) -> float:
        """The median step between levels, the largest of all axes. Rounding is noise of standard deviation step / sqrt(12)."""
        return max(float(np.median(np.diff(levels))) for levels in self.levels)

    @property
    def equal_steps(self) -> bool:
        """Whether on each axis most steps are multiples of the median step. Steps of disparity grow with the distance instead."""
        steps = [np.diff(levels) / np.median(np.diff(levels)) for levels in self.levels]
        return all(np.median(np.abs(step - np.round(step))) < _FLAT for step in steps)

    def undone(self, points: Floats, faces: Ints, movable: Bools | None = None) -> Floats:
        """Returns (n, 3) points that round to the same levels, but on a smoother surface: one of less bi-Laplacian energy."""
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
            for _ in range(100 // len(self.directions)):  # 100 steps on each of three axes would shrink tubes
                # The heights x become x - 0.9 (I - W)^2 x with W = (I + 2 U) / 3 and U = `means`, so I - W = 2/3 (I - U).
                differences = (now - means @ now) * (2.0 / 3.0)
                now = np.clip(now - 0.9 * (2.0 / 3.0) * (differences - means @ differences), low, high)
            result = result + (now - heights)[:, None] * direction
        return np.asarray(result)

    def deviations(self, rounded: Floats) -> Floats:
        """Returns (n, axes) the standard deviations of the rounding along the axes at (n, 3) rounded points: step / sqrt(12)."""
        axes = zip(*self, strict=True)
        steps = [np.gradient(at)[np.searchsorted(0.5 * (at[1:] + at[:-1]), rounded @ direction)] for direction, at in axes]
        return np.asarray(np.column_stack(steps) / np.sqrt(12.0))


def rounding_of(points: Floats, faces: Ints) -> Rounding | None:
    """Returns the rounding of a mesh, None if it was not rounded.

    On a rounded mesh all faces within a level have the same normal, which is the axis. The vertices lie on few levels along the
    axis, and the surface is rough in this direction. Further axes are perpendicular to the first.
    """
    edge = mean_edge_length(points, faces)
    if edge == 0.0 or not len(faces):
        return None
    used, roundings = points[referenced_vertices(faces, len(points))], []
    fourth: FourthOrder | None = None
    for axis in _axes(face_normals(points, faces)):
        levels = _levels(used @ axis, _FLAT * edge)
        if levels is not None:
            fourth = fourth or FourthOrder.of(faces, len(points))
            sizes = np.abs(fourth.differences((points @ axis)[:, None])[fourth.inner]) * np.sqrt(12.0) / tuned.MEDIAN_OF_NORMAL
            noise = np.median(sizes) / np.median(np.diff(levels)) if len(sizes) else 0.0
            if 1.0 / tuned.ROUNDED < noise < tuned.ROUNDED:
                roundings.append((axis, levels))
        if not roundings:
            return None
    return Rounding(*map(tuple, zip(*roundings, strict=True))) if roundings else None


def _axes(normals: Floats) -> list[Floats]:
    """Returns up to three axes: the most frequent normal, the most frequent one perpendicular to it, and the cross product."""
    normals = normals * np.sign(normals[np.arange(len(normals)), np.abs(normals).argmax(axis=1)])[:, None]
    width = 2 * int(1.0 / _FLAT) + 3
    keys, axes = np.round(normals / _FLAT).astype(np.int64) @ [width**2, width, 1], list[Floats]()
    for _ in range(2):
        across = np.flatnonzero(np.abs(normals @ axes[0]) < _FLAT) if axes else np.arange(len(normals))
        _, first, counts = np.unique(keys[across], return_index=True, return_counts=True)
        if not len(counts) or (not axes and len(counts) < 8):  # a designed staircase has fewer different normals
            return axes
        flush = normals[across] @ normals[across[first[counts.argmax()]]] > 1.0 - _FLAT**2
        direction = normals[across][flush].sum(axis=0)
        length = np.linalg.norm(direction)  # 0 if the most frequent normal is 0, the normal of faces without area
        if length == 0.0 or (not axes and flush.mean() < tuned.FLUSH):
            return axes
        axes.append(direction / length)
    return [*axes, np.cross(axes[0], axes[1])]


def _levels(heights: Floats, width: float) -> Floats | None:
    """Returns the middles of the levels of heights, ascending; None for fewer than three levels, or any thicker than `width`."""
    heights = np.sort(heights)
    apart = np.flatnonzero(np.diff(heights) > width)
    low, high = heights[np.append(0, apart + 1)], heights[np.append(apart, len(heights) - 1)]
    return None if len(low) < 3 or (high - low).max() > width else 0.5 * (low + high)
