"""Waves of a known length on a surface, and what a recipe leaves of them: what recipes with a detail size are judged by."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import igl
import numpy as np
from denoising_metrics import Floats, Ints
from scipy.sparse.linalg import splu

from pymeshfair.filters.geometry import mean_edge_length, vertex_normals_by_area

#: detail sizes that are asked of recipes, in mean edges; ripples of half of it are to go, and waves of three times it to stay
SIZES, RIPPLES, SHAPE = (8.0, 12.0), 0.5, 3.0
#: how often the modes that are nearest are brought out, and the height of waves over their length
_STEPS, _HEIGHT = 4, 0.01


def waves(vertices: Floats, faces: Ints, length: float) -> Floats:
    """(n,) heights of waves of one length, in mesh units: modes -C u = k M u with k near (2 pi / length)^2, mixed.

    (-C - k M)^-1 M, applied again and again to random heights, leaves the modes that are nearest.
    """
    stiffness = igl.cotmatrix(vertices, faces)
    mass = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI)
    solver = splu((-stiffness - (2.0 * np.pi / length) ** 2 * mass).tocsc())
    mixed = np.random.default_rng(0).normal(size=len(vertices))
    for _ in range(_STEPS):
        mixed = solver.solve(mass @ mixed)
        mixed /= np.abs(mixed).max()
    return np.asarray(mixed * (_HEIGHT * length / np.sqrt((mixed**2).mean())))


def waves_of_sizes(vertices: Floats, faces: Ints) -> dict[float, tuple[Floats, Floats]]:
    """Ripples and long waves on a surface, (n,) heights each, by the detail size that lies between them, in mesh units."""
    edge = mean_edge_length(vertices, faces)
    return {
        size * edge: (waves(vertices, faces, RIPPLES * size * edge), waves(vertices, faces, SHAPE * size * edge))
        for size in SIZES
    }


def wrong(
    clean: Callable[[Floats, float], Floats], vertices: Floats, faces: Ints, given: Mapping[float, tuple[Floats, Floats]]
) -> float:
    """The largest share of ripples that is left, or of long waves that is lost or gained.

    0 of a filter that tells them apart, 1 of one that does nothing. Both are measured on the surface with such waves, against
    what the filter makes of the surface without them.

    Args:
        clean: vertices and a detail size, in mesh units, to the vertices after the filter.
        vertices: (n, 3) of a surface without noise.
        faces: (m, 3) triangles.
        given: of `waves_of_sizes`.
    """
    normals = vertex_normals_by_area(vertices, faces)
    mass = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI).diagonal()

    def share(heights: Floats, size: float) -> float:
        moved = clean(vertices + heights[:, None] * normals, size) - clean(vertices, size)
        return float((mass * heights * np.einsum("ij,ij->i", moved, normals)).sum() / (mass * heights**2).sum())

    return max(max(abs(share(ripples, size)), abs(1.0 - share(shape, size))) for size, (ripples, shape) in given.items())
