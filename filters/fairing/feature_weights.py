"""Where a surface may bend: weights that spare its ridges from smoothing."""

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..denoising.normal_filtering import filter_face_normals
from ..execution import Progress, ignore_progress
from ..mesh import Floats, check_mesh
from ..topology import face_adjacency

# A kernel that leaves ridges of 45 degrees sharp and takes noise of a tenth of an edge for noise; one twice as wide would bear
# noise of a fifth, and blur such ridges.
_RANGE, _ITERATIONS = 0.25, 10


def feature_weights(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    feature_angle: float = 20.0,
    least: float = 1e-4,
    progress: Progress = ignore_progress,
) -> Floats:
    """W_i = max(least, 1 / (1 + (a_i / a)^8)), a_i the sharpest angle between the filtered normals of faces that meet at vertex
    i.

    The weights for `bilaplacian_smoothing`: inverse to how far the surface bends within an edge. The curvature itself of a noisy
    surface is mostly noise; so the angles are taken between face normals filtered bilaterally [zheng2011], which noise of a tenth
    of an edge does not get through while ridges do; of stronger noise some does, and is kept. The smooth step of the eighth power
    leaves 1 where the surface bends by half the angle, and next to nothing where it bends by twice.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        feature_angle: a, in degrees, between 0 and 180. Smaller spares gentler ridges, and noise.
        least: the least weight, from 0 to 1. Larger smooths ridges more; 0 leaves them to noise altogether.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n,) from `least` to 1; 1 at vertices without two adjacent faces.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    if not 0.0 < feature_angle < 180.0:
        raise FilterInputError(f"feature_angle {feature_angle} is not between 0 and 180 degrees")
    _check_least(least)
    if not len(triangles):
        return np.ones(len(points))
    normals = filter_face_normals(points, triangles, range_sigma=_RANGE, normal_iterations=_ITERATIONS, progress=progress)
    pairs, shared = face_adjacency(triangles)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    angles = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), np.einsum("ij,ij->i", first, second))
    sharpest = np.zeros(len(points))
    for end in (0, 1):
        np.maximum.at(sharpest, shared[:, end], angles)
    return _weights(sharpest / math.radians(feature_angle), 8, least)


def scalar_feature_weights(values: ArrayLike, *, half: float, least: float = 1e-4) -> Floats:
    """W_i = max(least, 1 / (1 + (v_i / half)^2)) for values such as curvatures or what a user has painted.

    Args:
        values: (n,) finite values; their signs do not matter.
        half: the size of a value whose weight is 1/2, above 0. Smaller spares more.
        least: the least weight, from 0 to 1.

    Raises:
        FilterInputError: values that are not finite, or a parameter out of range.
    """
    sizes = np.asarray(values, dtype=np.float64)
    if sizes.ndim != 1 or not np.isfinite(sizes).all():
        raise FilterInputError(f"values must be finite, one a vertex, got shape {sizes.shape}")
    if not (math.isfinite(half) and half > 0.0):
        raise FilterInputError(f"half {half} is not finite and above 0")
    _check_least(least)
    return _weights(sizes / half, 2, least)


def _weights(sizes: Floats, power: int, least: float) -> Floats:
    with np.errstate(over="ignore"):
        return np.maximum(least, 1.0 / (1.0 + np.abs(sizes) ** power))


def _check_least(least: float) -> None:
    if not 0.0 <= least <= 1.0:
        raise FilterInputError(f"least {least} is not between 0 and 1")
