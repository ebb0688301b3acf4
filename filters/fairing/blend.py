"""Joins two parts: a band of triangles between two facing rims, whose interior is then faired."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..execution import Progress, ignore_progress
from ..mesh import check_mesh
from .bridge import Blend, bridge_rims
from .facing_rims import facing_rims
from .region import Energy, fair_region

__all__ = ["Blend", "blend_parts"]


def blend_parts(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    energy: Energy = "thin_plate",
    among: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Blend:
    """A smooth neck between the two rims that face each other.

    The band of `bridge_rims` with its new vertices placed by `fair_region`; the vertices of the mesh stay.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles of both parts.
        energy: "membrane" meets the parts with a crease, as a soap film would; "thin_plate" continues their tangent planes,
            "minimum_variation" their curvatures too.
        among: as in `facing_rims`.
        progress: called with the share that is done; may raise to stop.

    Raises:
        FilterInputError: as `facing_rims` and `bridge_rims`.
    """
    points, triangles = check_mesh(vertices, faces)
    first, second = facing_rims(points, triangles, among=among, progress=lambda done: progress(0.1 * done))
    band = bridge_rims(points, triangles, first, second, progress=lambda done: progress(0.1 + 0.4 * done))
    if len(band.vertices) == 0:
        progress(1.0)
        return band
    joined = np.concatenate([points, band.vertices])
    free = np.arange(len(joined)) >= len(points)
    everything = np.concatenate([triangles, band.faces])
    fair = fair_region(joined, everything, free, energy=energy, progress=lambda done: progress(0.5 + 0.5 * done))
    return replace(band, vertices=fair.vertices[len(points) :])
