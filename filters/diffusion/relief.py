"""Measures the share of the relief that a filter removes: relief is the height above a smoothed surface, without noise."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_finite
from ..geometry import mean_edge_length, vertex_normals_by_angle
from ..mesh import Floats, Ints, check_mesh
from .implicit import implicit_fairing, time_step_of_detail_size

#: The bands of relief as shortest and longest wavelengths in mean edges. Waves of the longest wavelength count with about a
#: quarter of their height; in the first band shorter waves count with more. The second band omits short waves, and so most noise.
BANDS = ((0.0, 8.0), (6.0, 16.0))
# Relief is measurable if its share of the energy of all heights, noise included, is above this.
_MEASURABLE = 0.7


class ReliefLoss(NamedTuple):
    """A loss of relief."""

    share: float  # 0 if nothing is lost, 1 if all is lost, above 1 if relief is inverted
    shortest: float  # the shortest wavelength that counts, in mean edges; 0 for all, above 0 if noise hides shorter relief


def relief_lost(before: ArrayLike, after: ArrayLike, faces: ArrayLike, *, noise: float = 0.0) -> ReliefLoss | None:
    """Returns the lost share of relief, 1 - <h', h> / (|h|^2 - |h_n|^2): heights h before, h' after, and h_n of noise alone.

    The heights are n . (q - 2 S q + S S q). q are the coordinates, S is the implicit step that halves waves of 8 mean edges, and
    n are the normals of S q before the filter, also in h'. On balls and cylinders h is nearly 0. Noise in h is not relief:
    the energy of noise of the stated level on the same surface is subtracted. If less than 0.7 of the energy is left, S halves
    waves of 16 mean edges, and q are first smoothed by the step that halves waves of 6 mean edges, which removes most noise.

    Args:
        before: (n, 3) coordinates.
        after: (n, 3) coordinates of the same vertices after the filter.
        faces: (m, 3) triangles.
        noise: the noise level in `before`: the standard deviation along the normals, in mean edges, independent at each vertex.

    Returns:
        The loss; None if no relief stands out from the noise, or if smoothing fails, as with collapsed triangles.

    Raises:
        FilterInputError: not a mesh, different numbers of vertices, or a level below 0.
    """
    level = check_finite("noise", noise, least=0.0)
    points, triangles = check_mesh(before, faces)
    result, _ = check_mesh(after, faces)
    if len(result) != len(points):
        raise FilterInputError(f"after must have the {len(points)} vertices of before, got {len(result)}")
    edge = mean_edge_length(points, triangles)
    if not edge > 0.0:
        return None
    with suppress(ConvergenceError):
        for band in BANDS:
            if (lost := _lost_in(band, points, result, triangles, edge, level)) is not None:
                return ReliefLoss(lost, band[0])
    return None


def _lost_in(band: tuple[float, float], before: Floats, after: Floats, faces: Ints, edge: float, level: float) -> float | None:
    shortest, longest = (edge * length for length in band)
    band_limited = _smoothed(before, faces, shortest)
    smooth = _smoothed(band_limited, faces, longest)
    normals = vertex_normals_by_angle(smooth, faces)

    def heights_over(q: Floats, low: Floats) -> Floats:
        return np.asarray(np.einsum("ij,ij->i", normals, q - 2.0 * low + _smoothed(low, faces, longest)))

    def heights_of(surface: Floats) -> Floats:
        q = _smoothed(surface, faces, shortest)
        return heights_over(q, _smoothed(q, faces, longest))

    heights = heights_over(band_limited, smooth)
    of_noise = 0.0
    if level > 0.0:
        rough = before + np.random.default_rng(0).normal(scale=level * edge, size=(len(before), 1)) * normals
        of_noise = float(np.sum((heights_of(rough) - heights) ** 2))
    whole = float(np.sum(heights**2))
    relief = whole - of_noise
    if not relief > _MEASURABLE * whole:
        return None
    return max(0.0, 1.0 - float(np.sum(heights_of(after) * heights)) / relief)


def _smoothed(points: Floats, faces: Ints, length: float) -> Floats:
    if length == 0.0:
        return points
    return implicit_fairing(points, faces, time_step=time_step_of_detail_size(length), border="along")
