"""How much of the relief of a surface a filter has taken: of the heights over a smoother surface that are no noise."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite
from ..geometry import mean_edge_length, vertex_normals_by_angle
from ..mesh import Floats, Ints, check_mesh
from .implicit import implicit_fairing, time_step_of_detail_size

#: Waves of so many mean edges have half their height in the relief, shorter ones nearly all of it.
RELIEF = 8.0
# Relief that is less than this share of all heights is not measurable beside noise.
_MEASURABLE = 0.7


def relief_lost(before: ArrayLike, after: ArrayLike, faces: ArrayLike, *, noise: float = 0.0) -> float | None:
    """1 - <h', h> / (|h|^2 - |h_n|^2), h and h' the heights before and after, h_n those of noise alone.

    The heights are n . (p - 2 S p + S S p), n the normals of S p, and S the implicit step that halves waves of 8 mean edges: of a
    ball or a cylinder they are 0. Noise in h is no loss: its energy is that of noise of the stated level on the same surface, and
    is subtracted.

    Args:
        before: (n, 3) coordinates.
        after: (n, 3) those of the same vertices after the filter.
        faces: (m, 3) triangles.
        noise: its standard deviation along the normals before, in mean edges, the same at every vertex and independent.

    Returns:
        From 0, nothing is lost, to 1, all is, and beyond where relief was turned over; None where there is no relief that stands
        out from the noise.

    Raises:
        FilterInputError: not a mesh, or a level below 0.
    """
    level = check_finite("noise", noise, least=0.0)
    points, triangles = check_mesh(before, faces)
    result, _ = check_mesh(after, faces)
    edge = mean_edge_length(points, triangles)
    if not edge > 0.0:
        return None
    smooth = _smoothed(points, triangles, edge)
    normals = vertex_normals_by_angle(smooth, triangles)

    def heights_over(surface: Floats, low: Floats) -> Floats:
        return np.asarray(np.einsum("ij,ij->i", normals, surface - 2.0 * low + _smoothed(low, triangles, edge)))

    def heights_of(surface: Floats) -> Floats:
        return heights_over(surface, _smoothed(surface, triangles, edge))

    heights = heights_over(points, smooth)
    of_noise = 0.0
    if level > 0.0:
        rough = points + np.random.default_rng(0).normal(scale=level * edge, size=(len(points), 1)) * normals
        of_noise = float(np.sum((heights_of(rough) - heights) ** 2))
    whole = float(np.sum(heights**2))
    relief = whole - of_noise
    if not relief > _MEASURABLE * whole:
        return None
    return max(0.0, 1.0 - float(np.sum(heights_of(result) * heights)) / relief)


def _smoothed(points: Floats, faces: Ints, edge: float) -> Floats:
    return implicit_fairing(points, faces, time_step=time_step_of_detail_size(RELIEF * edge), border="along")
