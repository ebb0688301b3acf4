"""Denoising without parameters: those of the normal filter follow from the scan alone.

A clean mesh stays as it is; noise that neighbours share, as that of depth cameras, gets a fixed setting; all else the
setting that best predicts vertices which it has not seen.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..evidence import Choice, Looks, Sample, calm_noise, choose, far_from_border, looks, sample_of
from ..execution import Progress, ignore_progress, part_of, rising
from ..mesh import Bools, Floats, check_mesh, check_movable, normalised_mesh
from ..topology import BorderPolicy
from .candidates import AutomaticParameters, Setting, SettingsTried, settings
from .designed import is_designed
from .impulses import replace_outlying
from .noise_level import NoiseEstimate, estimate_noise, smooth_normals
from .relaxation import direction_for
from .shared_noise import neighbours_share_noise

#: Range maps of depth cameras, whose noise neighbours share, so that held-out vertices say nothing: strong, and fixed. One map of
#: a camera and three computed ones prefer it to Huber's kernel and to fewer steps.
RANGE_MAP = Setting(parameters=AutomaticParameters("averaged", "gaussian", 0.4, 0.0, 2.5, "two_ring", 20, 40))

# Noise that leaves the calmest parts with less than this, in mean edges, is the rounding of a file.
_NOTHING = 1e-4
# Even noise is so many times what `calm_noise` says of it: 1.2 to 1.5 on parts, figures and surfaces.
_EVEN = 1.3
# Vertices of clean meshes are up to so many mean edges from where their surroundings expect them, even where the mesh is calm:
# scans smoothed or decimated have 0.007 to 0.03, the same with noise of 0.05 edges 0.04 to 0.05. With less, something must
# predict so much better than nothing, as where a few vertices are off by far, or err by no more than so many times that: even
# noise on a surface that is known well has 1.3 to 1.42, clean scans 1.58 and more.
_MESHING, _FAR_BETTER, _NOISE_ALONE = 0.03, 0.7, 1.45
# More vertices than this stand out of impulsive noise: of Gaussian noise up to 0.003, of clean meshes up to 0.007.
_IMPULSIVE = 0.015


class AutomaticChoice(NamedTuple):
    """How a scan is denoised, and why.

    Attributes:
        kind: "clean", "range map" or "noisy".
        setting: what is done.
        noise: the estimate of the noise.
        evidence: the settings that were tried, and how well they predict; None if none were.
    """

    kind: str
    setting: Setting
    noise: NoiseEstimate
    evidence: Choice[Setting] | None = None


def automatic_choice(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    seed: int = 0,
    progress: Progress = ignore_progress,
) -> AutomaticChoice:
    """Find how a mesh is denoised.

    1. Made of planes without noise: nothing is done. Noise that neighbours share: `RANGE_MAP`.
    2. Otherwise that of `settings`, nothing at all among them, that `choose` finds on the mesh, or on patches of a large one.
       Steps of Taubin's go along the normals alone if the vertices are scattered less along the surface than across it.
    3. With the error e of what predicts best and the standard deviation s of the noise, e^2 = s^2 + d^2, where d is how far the
       result is from the truth, and the scan is s from it. So nothing is done where e^2 >= 2 s^2: s is that of `calm_noise`.
       Where this is no more than that of clean meshes, what is chosen must be far better than nothing, too, or leave nothing
       but even noise.
    4. If more vertices stand out by far than Gaussian noise has, filters that keep edges keep them: the same once more where they
       are replaced by what the others expect, the outlying vertices no evidence. Of both results the one is taken with the least
       product of flatness and movement, see `looks`.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) bool, which vertices may move, None for all. The others are not evidence.
        seed: other vertices are held out for another number.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The same for the mesh moved, turned, scaled or renumbered.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    mesh = normalised_mesh(*check_mesh(vertices, faces), movable)
    noise = estimate_noise(mesh.points, mesh.cells)
    noise = noise._replace(length=noise.length / mesh.scale)
    if is_designed(mesh.points, mesh.cells):
        return AutomaticChoice("clean", Setting(), noise)
    if neighbours_share_noise(mesh.points, mesh.cells, noise):
        return AutomaticChoice("range map", RANGE_MAP, noise)
    sample = sample_of(mesh.points, mesh.cells)
    tell = rising(progress)
    context = _Context(border, None if mesh.movable is None else mesh.movable[sample.origin], seed, tell)
    setting, evidence = _best(sample, noise, None, context)
    calmed, outlying = replace_outlying(sample.points, sample.faces, context.movable)
    if np.count_nonzero(outlying) > _IMPULSIVE * len(outlying):
        others = sample._replace(points=calmed)
        other, its = _best(others, estimate_noise(calmed, sample.faces), outlying, context)
        if setting == Setting() or context.looks(sample, other).product < context.looks(sample, setting).product:
            setting, evidence = other, its
    return AutomaticChoice("clean" if setting == Setting() else "noisy", setting, noise, evidence)


def denoise_automatically(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, AutomaticChoice]:
    """Denoise a mesh with the setting of `automatic_choice`, whose arguments and errors these are.

    Returns:
        (n, 3) float64 the vertices, and how they were found. Clean meshes keep every bit.
    """
    choice = automatic_choice(vertices, faces, border=border, movable=movable, progress=part_of(progress, 0.0, 0.8))
    points, triangles = check_mesh(vertices, faces)
    moves = None if movable is None else check_movable(movable, len(points))
    result = choice.setting.apply(points, triangles, border=border, movable=moves, progress=part_of(progress, 0.8, 1.0))
    progress(1.0)
    return result, choice


class _Context(NamedTuple):
    """What all that is tried on a sample has in common."""

    border: BorderPolicy
    movable: Bools | None
    seed: int
    progress: Progress

    def looks(self, sample: Sample, setting: Setting) -> Looks:
        """What the sample becomes."""
        result = setting.apply(sample.points, sample.faces, border=self.border, movable=self.movable)
        return looks(sample.points, sample.faces, result)


def _best(
    sample: Sample, noise: NoiseEstimate, outlying: Bools | None, context: _Context
) -> tuple[Setting, Choice[Setting] | None]:
    """The setting that held-out vertices speak for, those that are outlying apart, and the evidence."""
    scored = far_from_border(sample.faces, len(sample.points))
    for allowed in (context.movable, None if outlying is None else ~outlying):
        scored = scored if allowed is None else scored & allowed
    normals = smooth_normals(sample.points, sample.faces)
    calm = calm_noise(sample.points, sample.faces, normals=normals, scored=scored)
    nothing = Setting(outliers="keep" if outlying is None else "replace")
    if calm < _NOTHING:
        return nothing, None
    direction = direction_for(noise)
    tried = SettingsTried(sample.faces, normals, direction, border=context.border, movable=context.movable)
    evidence = choose(
        sample.points,
        sample.faces,
        tried,
        settings(direction, nothing.outliers),
        normals=normals,
        scored=scored,
        seed=context.seed,
        progress=context.progress,
    )
    if evidence is None:
        return nothing, None
    nearer = evidence.chosen.error**2 < 2.0 * (_EVEN * calm) ** 2
    sure = evidence.chosen.error < max(_FAR_BETTER * evidence.trials[0].error, _NOISE_ALONE * calm)
    if not nearer or (calm < _MESHING and not sure):
        evidence = evidence._replace(chosen=evidence.trials[0])
    return evidence.chosen.label, evidence
