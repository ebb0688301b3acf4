"""Impulses taken away: few vertices that are off by far, as those of stray measurements."""

from typing import Literal, TypeAlias, get_args

import numpy as np

from ..evidence import outlying_vertices, without
from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings, referenced_vertices
from .noise_level import smooth_normals

#: "keep": vertices that stand out are filtered like the others. "replace": they are first put where the others expect them.
Outliers: TypeAlias = Literal["keep", "replace"]
OUTLIERS: tuple[Outliers, ...] = get_args(Outliers)


def replace_outlying(vertices: Floats, faces: Ints, movable: Bools | None = None) -> tuple[Floats, Bools]:
    """Put the vertices that stand out where a quadric through those around them expects them.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        movable: (n,) which vertices may move, None for all.

    Returns:
        vertices: (n, 3); those that do not stand out keep every bit.
        outlying: (n,) which do, see `outlying_vertices`.
    """
    edge = mean_edge_length(vertices, faces)
    used = referenced_vertices(faces, len(vertices))
    if edge == 0.0 or not used.any():
        return vertices.copy(), np.zeros(len(vertices), dtype=np.bool_)
    points = (vertices - vertices[used].mean(axis=0)) / edge
    normals = smooth_normals(vertices, faces)
    outlying = outlying_vertices(points, faces, normals)
    if movable is not None:
        outlying &= movable
    which = np.flatnonzero(outlying).astype(np.int32)
    result = vertices.copy()
    result[which] += edge * (without(points, one_rings(faces, len(points)), normals, which) - points)[which]
    return result, outlying
