"""Feature weights: small at ridges, which are then not smoothed."""

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_positive
from ..denoising.normal_filtering import filter_face_normals
from ..execution import Progress, ignore_progress
from ..geometry import angles_between
from ..mesh import Floats, check_mesh
from ..topology import face_adjacency

# This range kernel keeps ridges of 45 degrees sharp and removes noise of a tenth of an edge. Twice as wide, it would remove noise
# of a fifth, and blur such ridges.
_RANGE, _ITERATIONS = 0.25, 10
# Of a weight, so that sharp ridges do not keep all their noise.
_LEAST = 1e-4


def feature_weights(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    feature_angle: float = 20.0,
    progress: Progress = ignore_progress,
) -> Floats:
    """W_i = max(1e-4, 1 / (1 + (a_i / a)^8)), a_i the largest angle between filtered normals across the edges at vertex i.

    The weights for `bilaplacian_smoothing`: small where the surface bends sharply across an edge. The curvature of a noisy
    surface is mostly noise, so the angles are those between bilaterally filtered face normals [zheng2011]. The filter removes
    noise of up to a tenth of an edge and keeps ridges; part of stronger noise remains and counts as ridges. With the eighth power
    the weight is nearly 1 where the surface bends by half the angle, and nearly 0 where it bends by twice the angle.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        feature_angle: a, in degrees, between 0 and 180. Smaller also keeps gentler ridges, and noise.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n,) from 1e-4 to 1; 1 at vertices without two adjacent faces.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    if not 0.0 < feature_angle < 180.0:
        raise FilterInputError(f"feature_angle {feature_angle} is not between 0 and 180 degrees")
    if not len(triangles):
        return np.ones(len(points))
    normals = filter_face_normals(points, triangles, range_sigma=_RANGE, normal_iterations=_ITERATIONS, progress=progress)
    pairs, shared = face_adjacency(triangles)
    angles = angles_between(normals[pairs[:, 0]], normals[pairs[:, 1]])
    sharpest = np.zeros(len(points))
    for end in (0, 1):
        np.maximum.at(sharpest, shared[:, end], angles)
    return _weights(sharpest / math.radians(feature_angle), 8)


def scalar_feature_weights(values: ArrayLike, *, half: float) -> Floats:
    """W_i = max(1e-4, 1 / (1 + (v_i / half)^2)) for values such as curvatures or scalars that a user has painted.

    Args:
        values: (n,) finite values; their signs do not matter.
        half: the size of a value whose weight is 1/2, above 0. Smaller keeps more from being smoothed.

    Raises:
        FilterInputError: values that are not finite, or a parameter out of range.
    """
    sizes = np.asarray(values, dtype=np.float64)
    if sizes.ndim != 1 or not np.isfinite(sizes).all():
        raise FilterInputError(f"values must be finite, one a vertex, got shape {sizes.shape}")
    check_positive("half", half)
    return _weights(sizes / half, 2)


def _weights(sizes: Floats, power: int) -> Floats:
    with np.errstate(over="ignore"):
        return np.maximum(_LEAST, 1.0 / (1.0 + np.abs(sizes) ** power))
