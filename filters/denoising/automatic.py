"""Denoising without parameters: those of the normal filter follow from the scan alone.

Two settings of the interleaved filter, one for flat parts that meet at edges and one for figures, and a rule that chooses. The
rule is that the vertices move by noise and by nothing else. Noise of neighbouring vertices is independent; a detail moves them
together. So what was taken away, along the normals, is correlated between neighbours to the extent that it was detail.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..diffusion.border import BorderPolicy
from ..mesh import Floats, Ints, check_mesh
from ..progress import Progress, ignore_progress
from ..topology import border_vertices, edges
from .face_neighbourhoods import Neighborhood
from .m_estimators import KernelName
from .noise_level import NoiseEstimate, estimate_noise, smooth_normals
from .normal_filtering import NormalFilterMethod, normal_filtering


@dataclass(frozen=True)
class AutomaticParameters:
    """What `normal_filtering` is to be called with, by its names."""

    method: NormalFilterMethod
    range_kernel: KernelName
    range_sigma: float
    space_sigma: float
    neighborhood: Neighborhood
    normal_iterations: int
    vertex_iterations: int
    outer_iterations: int


#: Flat parts that meet at edges. Of the settings tried on machine parts with Gaussian, impulsive and very strong noise it has the
#: best mean, and no failure: two normals that differ by more than a quarter, of the mean normals round the faces, do not mix.
SHARP = AutomaticParameters("averaged", "truncated_l2", 0.25, 1.5, "two_ring", 1, 10, 20)
#: Figures. The Huber kernel lets every normal have a say; how many outer iterations is up to the residuals.
SMOOTH = AutomaticParameters("bilateral", "huber", 0.2, 1.5, "vertex", 1, 5, 1)
#: A cheap filter that keeps flat parts and edges, and flattens figures: it tells the two apart.
PROBE = AutomaticParameters("bilateral", "lorentzian", 0.12, 1.5, "vertex", 1, 5, 20)

# Correlation of the residuals of the probe above which it has taken details away. Machine parts have -0.08 to -0.03, since a
# filter also keeps some of the noise of low frequency; figures 0.07 to 0.1.
_DETAIL_LOST = 0.0
# Smoothing goes on until the correlation is above this, or for at most so many outer iterations.
_WHITE, _MOST_ITERATIONS = -0.06, 12
# Noise below this, in mean edges, is the rounding of a file: a model as it was designed, to be left as it is.
_NOTHING = 1e-6


class AutomaticChoice(NamedTuple):
    """How a scan is denoised, and why.

    Attributes:
        parameters: for `normal_filtering`; None if there is no noise to take away.
        kind: "sharp", "smooth" or "clean".
        noise: the estimate of the noise.
        correlation: of the residuals of neighbouring vertices under the probe; above 0 the shape is taken for smooth.
    """

    parameters: AutomaticParameters | None
    kind: str
    noise: NoiseEstimate
    correlation: float


def automatic_parameters(
    vertices: ArrayLike, faces: ArrayLike, *, border: BorderPolicy = "along", movable: ArrayLike | None = None
) -> AutomaticChoice:
    """The parameters that `denoise_automatically` uses.

    Raises:
        FilterInputError: not a mesh.
    """
    return _denoise(vertices, faces, border, movable, ignore_progress)[0]


def denoise_automatically(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, AutomaticChoice]:
    """Denoise a mesh with parameters that are found from it.

    1. Estimate the noise. Without any the mesh is returned as it is.
    2. Filter with `PROBE`, and correlate what it took away, along the normals, between neighbours. Not correlated: `SHARP`.
    3. Otherwise `SMOOTH`, one outer iteration after the other until what is taken away begins to be correlated.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) bool, which vertices may move, None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n, 3) float64 the vertices, and how they were found. The same choice for the mesh moved, turned, scaled or renumbered.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    choice, result = _denoise(vertices, faces, border, movable, progress)
    if choice.kind == "sharp" and choice.parameters is not None:
        result = normal_filtering(
            vertices,
            faces,
            **vars(choice.parameters),
            border=border,
            movable=movable,
            progress=lambda share: progress(0.3 + 0.7 * share),
        )
    progress(1.0)
    return result, choice


def _denoise(
    vertices: ArrayLike, faces: ArrayLike, border: BorderPolicy, movable: ArrayLike | None, progress: Progress
) -> tuple[AutomaticChoice, Floats]:
    """The choice, and the result if finding the choice has computed it: that of a sharp shape has not been."""
    points, triangles = check_mesh(vertices, faces)
    noise = estimate_noise(points, triangles)
    residuals = _Residuals.of(points, triangles)
    if noise.deviation < _NOTHING or len(residuals.pairs) == 0:
        return AutomaticChoice(None, "clean", noise, 0.0), points.copy()
    probed = normal_filtering(
        points, triangles, **vars(PROBE), border=border, movable=movable, progress=lambda share: progress(0.3 * share)
    )
    correlation = residuals.correlation(probed)
    if correlation < _DETAIL_LOST:
        return AutomaticChoice(SHARP, "sharp", noise, correlation), points
    now = points
    done = 0
    while done < _MOST_ITERATIONS:
        now = normal_filtering(now, triangles, **vars(SMOOTH), border=border, movable=movable)
        done += 1
        progress(0.3 + 0.7 * done / _MOST_ITERATIONS)
        if residuals.correlation(now) > _WHITE:
            break
    chosen = AutomaticParameters(**(vars(SMOOTH) | {"outer_iterations": done}))
    return AutomaticChoice(chosen, "smooth", noise, correlation), now


class _Residuals(NamedTuple):
    """What a filter has taken away: the heights of the vertices over the result, and the edges between inner vertices."""

    points: Floats
    normals: Floats
    inner: Ints
    pairs: Ints

    @staticmethod
    def of(points: Floats, faces: Ints) -> "_Residuals":
        pairs = edges(faces)
        on_border = border_vertices(faces, len(points))
        pairs = pairs[~on_border[pairs].any(axis=1)]
        return _Residuals(points, smooth_normals(points, faces), np.unique(pairs), pairs)

    def correlation(self, result: Floats) -> float:
        """The sum over edges of h_i h_j / number of edges, over the mean of h^2 (Moran's I, mean not taken off); 0 if none moved."""
        heights = np.einsum("ij,ij->i", self.points - result, self.normals)
        square = float((heights[self.inner] ** 2).mean())
        return float((heights[self.pairs[:, 0]] * heights[self.pairs[:, 1]]).mean()) / square if square > 0.0 else 0.0
