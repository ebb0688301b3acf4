"""Sections: the outlines of meshes in a plane across an axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..declaration import Floats
from ..errors import ParameterError
from ..mesh_data import MeshData

_AXES = "xyz"


@dataclass(frozen=True)
class Plane:
    """All places whose coordinate along an axis has one value."""

    axis: int  # 0, 1 or 2 for x, y or z
    value: float  # of the coordinate, in mesh units

    @classmethod
    def parse(cls, text: str) -> Plane:
        """Read ``"z=12.5"``."""
        name, sign, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            value = float("nan")
        if name.strip() not in tuple(_AXES) or not sign or not np.isfinite(value):
            raise ParameterError(f"{text!r} is no section: write an axis and a coordinate in mesh units, such as z=12.5")
        return cls(_AXES.index(name.strip()), value)

    def __str__(self) -> str:
        return f"{_AXES[self.axis]} = {self.value:.6g}"


def outline(mesh: MeshData, plane: Plane) -> Floats:
    """(s, 2, 2) the segments in which a plane cuts the faces of a mesh; the other two coordinates, in the order of the axes.

    A vertex in the plane counts as above it, so that every face has no segment or one.
    """
    heights = mesh.vertices[:, plane.axis] - plane.value
    above = heights[mesh.faces] >= 0.0
    cut = mesh.faces[above.any(axis=1) & ~above.all(axis=1)]
    up = heights[cut] >= 0.0
    # The corner that is alone on its side comes first: the plane cuts the two edges there.
    alone = np.where(up.sum(axis=1) == 1, up.argmax(axis=1), (~up).argmax(axis=1))
    first, *others = (cut[np.arange(len(cut)), (alone + k) % 3] for k in range(3))
    flat = np.delete(mesh.vertices, plane.axis, axis=1)
    ends = []
    for other in others:
        share = heights[first] / (heights[first] - heights[other])
        ends.append(flat[first] + share[:, None] * (flat[other] - flat[first]))
    return np.stack(ends, axis=1)
