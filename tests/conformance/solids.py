"""Solids of known area, volume and box, matrices, and what a file made of them must be read as."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]

#: a box of 1 x 2 x 3 with one corner at (1, 0.5, 0.25): no axis, no side and no turn of it can be taken for another
POINTS = np.array([[x, y, z] for z in (0.25, 3.25) for y in (0.5, 2.5) for x in (1.0, 2.0)])
QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])
#: a prism over a polygon with two notches: a fan of its first corner would leave it
_OUTLINE = ((0, 0), (4, 0), (4, 3), (3, 1), (2, 3), (1, 1), (0, 3))
CONCAVE_POINTS = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in _OUTLINE], float)
CONCAVE_FACES = (tuple(range(6, -1, -1)), tuple(range(7, 14)), *((k, (k + 1) % 7, (k + 1) % 7 + 7, k + 7) for k in range(7)))
#: of that prism
CONCAVE_AREA, CONCAVE_VOLUME = 2 * 8.0 + (4 + 3 + 3) + 4 * 5**0.5, 8.0


@dataclass(frozen=True)
class Made:
    """A file and what is in it.

    Attributes:
        name: of the file.
        data: its bytes.
        area, volume, low, high: of the surface, its volume signed by the direction of its faces, and its box; None of what
            is not asked.
        tolerance: a share by which they may be off; of curved surfaces that become triangles.
        named: words of which one must be among what is not held, or in the refusal, if the file may be read otherwise.
        beside: files beside it.
        more: other facts: ``vertices``, ``faces``, ``edges`` (counts), ``colour`` (mean red, green, blue over the area),
            ``uv`` (mean texture coordinate over the area), ``unit``, ``image`` (whether the texture has its bytes).
    """

    name: str
    data: bytes
    area: float | None = None
    volume: float | None = None
    low: tuple[float, ...] | None = None
    high: tuple[float, ...] | None = None
    tolerance: float = 1e-5
    named: tuple[str, ...] = ()
    beside: Mapping[str, bytes] = field(default_factory=dict)
    more: Mapping[str, Any] = field(default_factory=dict)


def facts(parts: Sequence[tuple[Array, Array]]) -> dict[str, Any]:
    """Area, volume and box of surfaces together, each of (n, 3) vertices and (m, 3) triangles."""
    area = volume = 0.0
    for vertices, faces in parts:
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        area += float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
        volume += float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    points = np.concatenate([v for v, _ in parts])
    return {"area": area, "volume": volume, "low": tuple(points.min(axis=0)), "high": tuple(points.max(axis=0))}


def boxes(*matrices: Array) -> dict[str, Any]:
    """The facts of the box placed by each of these (4, 4) matrices; one that mirrors turns its faces with it."""
    parts = []
    for matrix in matrices:
        faces = TRIANGLES if np.linalg.det(matrix[:3, :3]) > 0 else TRIANGLES[:, ::-1]
        parts.append((POINTS @ matrix[:3, :3].T + matrix[:3, 3], faces))
    return facts(parts)


ONE = np.eye(4)


def moved(x: float, y: float, z: float) -> Array:
    """A translation."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scaled(x: float, y: float, z: float) -> Array:
    """A scale along the axes."""
    return np.diag([x, y, z, 1.0])


def turned(x: float, y: float, z: float, degrees: float) -> Array:
    """A rotation about an axis through the origin [rodrigues]."""
    a = np.array([x, y, z]) / np.linalg.norm([x, y, z])
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    t = np.radians(degrees)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross
    return matrix


def quaternion(x: float, y: float, z: float, degrees: float) -> list[float]:
    """The same rotation as x, y, z, w."""
    a = np.array([x, y, z]) / np.linalg.norm([x, y, z])
    t = np.radians(degrees) / 2
    return [*(np.sin(t) * a).tolist(), float(np.cos(t))]


def words(values: Any) -> str:
    """Numbers with a blank between any two."""
    return " ".join(f"{v:.10g}" for v in np.asarray(values, float).ravel())
