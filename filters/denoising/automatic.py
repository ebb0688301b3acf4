"""Denoising without parameters: those of the normal filter follow from the scan alone.

Settings of the interleaved filter, for flat parts that meet at edges, for figures, for surfaces with creases and for range maps,
and a rule that chooses. The rule is that the vertices move by noise and by nothing else. Noise of neighbouring vertices is
independent; a detail moves them together. So what was taken away, along the normals, is correlated between neighbours to the
extent that it was detail.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..diffusion.taubin import taubin_fairing
from ..execution import Progress, ignore_progress
from ..geometry import face_normals, mean_edge_length
from ..mesh import Floats, Ints, check_mesh, enter, normalised_mesh, ordered_frame
from ..robust import KernelName
from ..topology import BorderPolicy, border_vertices, edges, face_adjacency
from .face_neighbourhoods import Neighborhood
from .noise_level import NoiseEstimate, estimate_noise, shared_noise, smooth_normals
from .normal_filter import NormalFilterMethod
from .normal_filtering import normal_filtering
from .surroundings import Surroundings


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


#: `normal_filtering` of the mesh at hand: vertices, parameters and where to tell the progress, to new vertices.
_Run: TypeAlias = Callable[[Floats, AutomaticParameters, Progress], Floats]

#: Flat parts that meet at edges. Of the settings tried on machine parts with Gaussian, impulsive and very strong noise it has the
#: best mean, and no failure: two normals that differ by more than a quarter, of the mean normals round the faces, do not mix.
SHARP = AutomaticParameters("averaged", "truncated_l2", 0.25, 1.5, "two_ring", 1, 10, 20)
#: Figures. The Huber kernel lets every normal have a say; how many outer iterations is up to the residuals. Measuring the
#: deviation on mean normals is worth 1 to 9 % of the mean angle on ten figures and scans, and costs 2 % on a bone.
SMOOTH = AutomaticParameters("averaged", "huber", 0.1, 1.5, "vertex", 1, 4, 1)
#: Surfaces with creases, which mean normals round: 0.9 for 1.1 times the best published on a sphere of facets, 0.87 for 1.02 of
#: Taubin's best on a cow whose horns and hooves have some.
CREASED = AutomaticParameters("bilateral", "huber", 0.1, 1.5, "vertex", 1, 5, 1)
#: Range maps of depth cameras, whose noise neighbours share, so that the residuals say nothing: strong, and fixed. One map of a
#: camera and five computed ones all prefer two rings to the faces at the vertices.
RANGE_MAP = AutomaticParameters("bilateral", "huber", 0.1, 2.5, "two_ring", 1, 10, 30)

# Correlation of the residuals, and variance that neighbours share in squared mean edges, above which `SHARP` has taken details
# away. From machine parts it takes -0.04 to 0.012 and at most 0.002, from figures with noise up to 0.3 edges 0.03 to 0.8. Strong
# noise hides the details in the correlation: a figure with 0.5 edges has 0.013, but 0.008. It is asked every few rounds, since
# both grow with them: figures need 8 to 12 of the 20 rounds to be told.
_DETAIL_LOST, _SHARED, _ASKED = 0.015, 0.004, 4
# Filters keep a little of the noise of low frequency, so that even what they take from planes is correlated by this.
_OF_NOISE = -0.035
# `SMOOTH` goes on as long as the correlation is below this, or for at most so many outer iterations. On eleven figures and scans
# with noise of 0.1 to 0.3 edges the mean angle to the truth is least between -0.13 and -0.05, and within 2 % of that here.
_WHITE, _MOST_ITERATIONS = -0.07, 16
# After so many rounds of `CREASED`, an edge among the 2 % that bend most bends this much more than the median. The sphere of
# facets has 20, the cow 13 to 14, eleven figures, scans and an aeroplane 4 to 11.5.
_LOOKED, _BENDS_MOST, _CREASES = 6, 0.98, 12.5
# A range map is sampled on a grid seen from one side: its vertices are spread along the surface, while their residuals lie along
# the view. A depth camera's map has 3.9 and 0.37, computed ones 12 and more and 0.2 to 0.7. Scans and parts with noise from 0.06
# edges have up to 2.5, whatever the direction.
# With less noise than that an uneven scan from one side looks alike and would lose its details: it has tails up to 1.08, and
# `shared_noise` up to 0.06 from 0.03 edges; the maps have 1.14 to 1.7, and 0.078 to 0.1.
_SPREAD, _ONE_SIDED, _TAILS, _AGREE_SPREAD = 3.0, 0.3, 1.11, 0.068
# So is a mesh whose mean normal is longer than this and whose `shared_noise` is above both of these, the second over the squared
# level, since details count the less the stronger the noise is. Four computed maps of a depth camera with its steps, at 0.19 to
# 0.28 edges, have 0.017 to 0.045 and 0.0013 to 0.0022; figures and scans with independent noise at most 0.01, and at most
# 0.0007. Their mean angle falls from 1.16 to 0.5 times that of Taubin's best.
_FACING, _AGREE, _AGREE_WEAK = 0.4, 0.011, 0.0009
# Noise in all directions moves the vertices along the surface too, and filters of normals leave that as it is. Seven of Taubin's
# steps first take the mean angle of machine parts with 0.3 edges to a quarter, and the displacement below that of Taubin's best;
# three leave more displacement, fifteen a larger angle. Along the normals noise leaves 0.05 to 0.8 of the level, on meshes with
# uneven faces the most, in all directions 0.9 to 1.2. Below the level said here uneven faces alone look like it.
RELAXATION, _STRONG, _SCATTERED = 7, 0.15, 0.87
# Noise below this, in mean edges, and angles below this, in radians, are the rounding of a file.
_NOTHING, _FLAT = 1e-6, 1e-4
# A model of planes as it was designed: more of its faces than this share a plane with a neighbour. One vertex in a hundred moved
# spoils six faces in a hundred.
_DESIGNED = 0.99


class AutomaticChoice(NamedTuple):
    """How a scan is denoised, and why.

    Attributes:
        parameters: for `normal_filtering`; None if there is no noise to take away.
        kind: "sharp", "smooth", "range map", "scattered" or "clean"; scattered is smooth with noise in all directions.
        noise: the estimate of the noise.
        correlation: of what `SHARP` has taken from neighbouring vertices when its verdict was clear; 0 if it was not asked.
        relaxation: pairs of Taubin's steps, of 0.5 and -0.53, before the normals are filtered, where noise is in all directions.
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
    3. Filter with `SHARP`, and correlate what it takes away, along the normals, between neighbours. If it is not correlated, this
       is the result; with noise in all directions, the same after `RELAXATION` of Taubin's steps.
    4. Otherwise, if it is seen from one side and neighbours share the noise, `RANGE_MAP`.
    5. Otherwise `CREASED` if a few edges bend much more than most, or else `SMOOTH`, one outer iteration after the other as long
       as what is taken away is less correlated than details are; with noise in all directions, after the same steps.

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
    known = Surroundings.of(normalised_mesh(points, triangles))

    def run(start: Floats, setting: AutomaticParameters, share: Progress) -> Floats:
        return normal_filtering(
            start, triangles, **vars(setting), border=border, movable=movable, surroundings=known, progress=share
        )

    seen = noise.tangential > _SPREAD * noise.level and noise.anisotropy > _ONE_SIDED and noise.tails > _TAILS
    if seen and shared_noise(points, triangles) > _AGREE_SPREAD:
        return AutomaticChoice(RANGE_MAP, "range map", noise, 0.0), run(points, RANGE_MAP, progress)
    residuals = _Residuals.of(points, triangles)
    sharp, correlation = _sharp(points, residuals, run, lambda share: progress(0.6 * share))
    scattered = noise.level > _STRONG and noise.tangential > _SCATTERED * noise.level
    relaxation = RELAXATION if scattered else 0
    start = taubin_fairing(points, triangles, iterations=relaxation, border=border, movable=movable) if scattered else points
    if sharp is not None:
        if scattered:
            sharp = run(start, SHARP, lambda share: progress(0.6 + 0.4 * share))
        return AutomaticChoice(SHARP, "sharp", noise, correlation, relaxation), sharp
    if not scattered and _is_shared(points, triangles, noise):
        result = run(points, RANGE_MAP, lambda share: progress(0.6 + 0.4 * share))
        return AutomaticChoice(RANGE_MAP, "range map", noise, correlation), result
    fair = run(start, replace(CREASED, outer_iterations=_LOOKED), ignore_progress)
    setting = CREASED if _is_creased(fair, triangles) else SMOOTH
    now, done = start, 0
    while done < _MOST_ITERATIONS:
        further = run(now, setting, ignore_progress)
        if done > 0 and residuals.correlation(further) > _WHITE:
            break
        now = further
        done += 1
        progress(0.6 + 0.4 * done / _MOST_ITERATIONS)
    chosen = replace(setting, outer_iterations=done)
    return AutomaticChoice(chosen, "scattered" if scattered else "smooth", noise, correlation, relaxation), now


def _sharp(points: Floats, residuals: "_Residuals", run: _Run, progress: Progress) -> tuple[Floats | None, float]:
    """What `SHARP` makes of the mesh, None as soon as it takes details away; and the correlation by then."""
    part = replace(SHARP, outer_iterations=_ASKED)
    now, correlation = points, 0.0
    for done in range(0, SHARP.outer_iterations, _ASKED):

        def partial(share: float, done: int = done) -> None:
            progress((done + share * _ASKED) / SHARP.outer_iterations)

        now = run(now, part, partial)
        correlation = residuals.correlation(now)
        if correlation > _DETAIL_LOST or (correlation - _OF_NOISE) * residuals.variance(now) > _SHARED:
            return None, correlation
    return now, correlation


def _is_shared(points: Floats, faces: Ints, noise: NoiseEstimate) -> bool:
    """Whether the mesh is seen from one side and neighbours share the noise."""
    corners = points[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if np.linalg.norm(areas.sum(axis=0)) < _FACING * np.linalg.norm(areas, axis=1).sum() or noise.level == 0.0:
        return False
    return shared_noise(points, faces) > max(_AGREE, _AGREE_WEAK / noise.level**2)


def _is_creased(points: Floats, faces: Ints) -> bool:
    """Whether a few edges bend much more than most; of a mesh that the noise is off."""
    pairs, _ = face_adjacency(faces)
    normals = face_normals(enter(points, ordered_frame(points[np.unique(faces)], None)), faces)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    angles = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), np.einsum("ij,ij->i", first, second))
    return bool(len(angles)) and bool(np.quantile(angles, _BENDS_MOST) > _CREASES * np.median(angles))


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
    edge: float

    @staticmethod
    def of(points: Floats, faces: Ints) -> "_Residuals":
        pairs = edges(faces)
        on_border = border_vertices(faces, len(points))
        pairs = pairs[~on_border[pairs].any(axis=1)]
        return _Residuals(points, smooth_normals(points, faces), np.unique(pairs), pairs, mean_edge_length(points, faces))

    def heights(self, result: Floats) -> Floats:
        """In mean edges."""
        return np.asarray(np.einsum("ij,ij->i", (self.points - result) / self.edge, self.normals))

    def variance(self, result: Floats) -> float:
        """The mean of h^2 over the inner vertices, in squared mean edges."""
        return float((self.heights(result)[self.inner] ** 2).mean()) if len(self.inner) else 0.0

    def correlation(self, result: Floats) -> float:
        """The mean over edges of h_i h_j, over that of h^2 (Moran's I, the mean not taken off); 0 if nothing moved."""
        heights = self.heights(result)
        square = self.variance(result)
        return float((heights[self.pairs[:, 0]] * heights[self.pairs[:, 1]]).mean()) / square if square > 0.0 else 0.0
