"""Denoising without parameters: those of the normal filter follow from the scan alone.

Three settings of the interleaved filter, for flat parts that meet at edges, for figures and for range maps, and a rule that
chooses. The rule is that the vertices move by noise and by nothing else. Noise of neighbouring vertices is independent; a detail
moves them together. So what was taken away, along the normals, is correlated between neighbours to the extent that it was detail.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..diffusion.border import BorderPolicy
from ..diffusion.frame import enter, ordered_frame
from ..diffusion.taubin import taubin_fairing
from ..mesh import Floats, Ints, check_mesh
from ..progress import Progress, ignore_progress
from ..topology import border_vertices, edges, face_adjacency
from .face_neighbourhoods import Neighborhood
from .face_normals import face_normals
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
#: Figures with noise in all directions, after `RELAXATION` of Taubin's steps.
SCATTERED = AutomaticParameters("bilateral", "huber", 0.2, 1.5, "vertex", 1, 5, 3)
#: Range maps of depth cameras, whose noise neighbours share, so that the residuals say nothing: strong, and fixed.
RANGE_MAP = AutomaticParameters("bilateral", "huber", 0.1, 1.5, "vertex", 1, 10, 30)
#: A cheap filter that keeps flat parts and edges, and flattens figures: it spares figures the dear `SHARP`.
PROBE = AutomaticParameters("bilateral", "lorentzian", 0.12, 1.5, "vertex", 1, 5, 20)

# Correlations of the residuals above which a filter has taken details away. What `SHARP` takes from machine parts has -0.03 to 0,
# since a filter keeps some of the noise of low frequency; from a sphere of facets 0.07, from figures 0.1 to 0.3. `PROBE` is
# weaker: -0.08 to 0.1. It only decides where it is sure.
_DETAIL_LOST, _PROBE_LOST = 0.015, 0.03
# `SMOOTH` goes on until the correlation is above this, or for at most so many outer iterations. On two figures with noise of
# 0.19 and 0.28 edges and on a sphere of facets the mean angle to the truth was least between -0.07 and -0.04.
_WHITE, _MOST_ITERATIONS = -0.06, 12
# A range map is sampled on a grid seen from one side: its vertices are spread along the surface, while their residuals lie along
# the view. A depth camera's map has 3.9 and 0.37, scans and machine parts up to 2.1 or at most 0.25.
_SPREAD, _ONE_SIDED = 2.5, 0.3
# Noise in all directions moves the vertices along the surface too, and filters of normals leave that as it is. Ten steps of
# Taubin and three of `SCATTERED` take the mean angle from 1.2 to 0.9 times that of Taubin's best on a figure with noise of 0.3
# edges, from 2.3 to 1.15 on a sphere, and the displacement to Taubin's. Along the normals noise leaves 0.1 to 0.75 of the level.
RELAXATION, _STRONG, _SCATTERED = 10, 0.1, 0.85
# Noise below this, in mean edges, and angles below this, in radians, are the rounding of a file.
_NOTHING, _FLAT = 1e-6, 1e-4
# A model of planes as it was designed: more of its faces than this share a plane with a neighbour. One vertex in a hundred moved
# spoils six faces in a hundred.
_DESIGNED = 0.99


class AutomaticChoice(NamedTuple):
    """How a scan is denoised, and why.

    Attributes:
        parameters: for `normal_filtering`; None if there is no noise to take away.
        kind: "sharp", "smooth", "range map", "scattered" or "clean"; scattered is noise in all directions.
        noise: the estimate of the noise.
        correlation: of what the last filter that was asked about edges has taken from neighbouring vertices; 0 if none was.
        relaxation: pairs of Taubin's steps, of 0.5 and -0.53, before the normals are filtered.
    """

    parameters: AutomaticParameters | None
    kind: str
    noise: NoiseEstimate
    correlation: float
    relaxation: int = 0


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

    1. Estimate the noise. Without any, and if the mesh is made of planes without noise, it is returned as it is.
    2. A range map of a depth camera: `RANGE_MAP`.
    3. Filter with `PROBE`, and correlate what it took away, along the normals, between neighbours. If it is not correlated, do
       the same with `SHARP`, and if it is not then either, this is the result.
    4. Otherwise, with noise in all directions, `RELAXATION` of Taubin's steps and then `SCATTERED`.
    5. Otherwise `SMOOTH`, one outer iteration after the other until what is taken away begins to be correlated.

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
    progress(1.0)
    return result, choice


def _denoise(
    vertices: ArrayLike, faces: ArrayLike, border: BorderPolicy, movable: ArrayLike | None, progress: Progress
) -> tuple[AutomaticChoice, Floats]:
    """The choice, and the result that finding it has computed."""
    points, triangles = check_mesh(vertices, faces)
    noise = estimate_noise(points, triangles)
    if noise.deviation < _NOTHING or _is_designed(points, triangles):
        return AutomaticChoice(None, "clean", noise, 0.0), points.copy()
    residuals = _Residuals.of(points, triangles)
    if noise.tangential > _SPREAD * noise.level and noise.anisotropy > _ONE_SIDED:
        result = normal_filtering(points, triangles, **vars(RANGE_MAP), border=border, movable=movable, progress=progress)
        return AutomaticChoice(RANGE_MAP, "range map", noise, 0.0), result
    probed = normal_filtering(
        points, triangles, **vars(PROBE), border=border, movable=movable, progress=lambda share: progress(0.2 * share)
    )
    correlation = residuals.correlation(probed)
    if correlation < _PROBE_LOST:
        sharp = normal_filtering(
            points, triangles, **vars(SHARP), border=border, movable=movable, progress=lambda share: progress(0.2 + 0.5 * share)
        )
        correlation = residuals.correlation(sharp)
        if correlation < _DETAIL_LOST:
            return AutomaticChoice(SHARP, "sharp", noise, correlation), sharp
    if noise.level > _STRONG and noise.tangential > max(_STRONG, _SCATTERED * noise.level):
        fair = taubin_fairing(points, triangles, iterations=RELAXATION, border=border, movable=movable)
        result = normal_filtering(
            fair, triangles, **vars(SCATTERED), border=border, movable=movable, progress=lambda share: progress(0.7 + 0.3 * share)
        )
        return AutomaticChoice(SCATTERED, "scattered", noise, correlation, RELAXATION), result
    now = points
    done = 0
    while done < _MOST_ITERATIONS:
        now = normal_filtering(now, triangles, **vars(SMOOTH), border=border, movable=movable)
        done += 1
        progress(0.7 + 0.3 * done / _MOST_ITERATIONS)
        if residuals.correlation(now) > _WHITE:
            break
    chosen = AutomaticParameters(**(vars(SMOOTH) | {"outer_iterations": done}))
    return AutomaticChoice(chosen, "smooth", noise, correlation), now


def _is_designed(points: Floats, faces: Ints) -> bool:
    """Whether the mesh is made of planes of two faces and more, without noise."""
    pairs, _ = face_adjacency(faces)
    normals = face_normals(enter(points, ordered_frame(points[np.unique(faces)], None)), faces)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    flat = (np.linalg.norm(np.cross(first, second), axis=1) < _FLAT) & (np.einsum("ij,ij->i", first, second) > 0.0)
    return len(np.unique(pairs[flat])) > _DESIGNED * len(faces)


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
        """The mean over edges of h_i h_j, over that of h^2 (Moran's I, the mean not taken off); 0 if nothing moved."""
        heights = np.einsum("ij,ij->i", self.points - result, self.normals)
        square = float((heights[self.inner] ** 2).mean())
        return float((heights[self.pairs[:, 0]] * heights[self.pairs[:, 1]]).mean()) / square if square > 0.0 else 0.0
