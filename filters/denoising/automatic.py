"""Denoising without parameters: those of the normal filter follow from the scan alone.

A clean mesh stays as it is; noise that neighbours share, as that of depth cameras, gets a fixed setting; all else the
setting that best predicts vertices which it has not seen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..evidence import Candidates, Choice, calm_noise, choose, far_from_border, sample_of
from ..execution import Progress, ignore_progress, part_of, rising
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable, normalised_mesh
from ..topology import BorderPolicy
from .candidates import AutomaticParameters, Setting, SettingsTried, settings
from .designed import is_designed
from .impulses import far_from, replace_outlying
from .noise_level import NoiseEstimate, estimate_noise, smooth_normals
from .relaxation import direction_for
from .shared_noise import neighbours_share_noise, shared_noise

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
# `shared_noise` of surfaces without noise is 0.1 to 1.3, with noise of 0.2 edges and more below 0.05, however uneven it is.
# Between these bounds the level of the noise decides.
_INDEPENDENT, _SURFACE = 0.05, 0.2
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
    3. A surface without noise stays. What is left of the vertices after differences of fourth order agrees between neighbours if
       it is surface, and does not if it is noise, see `shared_noise`: much agreement rules noise out, hardly any proves it.
       Otherwise, with the error e of what predicts best and the standard deviation s of the noise, e^2 = s^2 + d^2, where d is
       how far the result is from the truth, and the scan is s from it: nothing is done where e^2 >= 2 s^2, s that of
       `calm_noise`. Where this is no more than that of clean meshes, what is chosen must be far better than nothing, too, or
       leave nothing but even noise.
    4. If more vertices are far from the result than Gaussian noise has, the same setting is tried with such outliers taken away,
       see `without_outliers`. If more stand out from those around them, filters that keep edges keep them: step 2 once more
       where they are replaced by what the others expect, the outlying vertices no evidence. Where the others are clean, nothing
       but they is to move: this too is tried. Of these settings, run in full, `choose` takes one.

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
    movable = None if mesh.movable is None else mesh.movable[sample.origin]
    scan = _Scan(sample.points, sample.faces, border, movable, seed, rising(progress))
    evidence = scan.best_of_settings()
    setting = _chosen(evidence, Setting())
    found = {setting: evidence}
    if np.mean(far_from(scan.points, scan.faces, scan.smoothed(setting))) > _IMPULSIVE:
        found[replace(setting, outliers="replace")] = evidence
    calmed, outlying = replace_outlying(scan.points, scan.faces, movable)
    if np.mean(outlying) > _IMPULSIVE:
        others = replace(scan, points=calmed, replaced=outlying).best_of_settings()
        found[_chosen(others, Setting(outliers="only"))] = others
    setting = scan.best_of(list(found))
    return AutomaticChoice("clean" if setting == Setting() else "noisy", setting, noise, found[setting])


def _chosen(evidence: Choice[Setting] | None, nothing: Setting) -> Setting:
    return nothing if evidence is None else evidence.chosen.label


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


@dataclass(frozen=True)
class _Scan:
    """A mesh with a mean edge of 1 to try settings on, which vertices may move, and which were replaced as outliers."""

    points: Floats
    faces: Ints
    border: BorderPolicy
    movable: Bools | None
    seed: int
    progress: Progress
    replaced: Bools | None = None

    @cached_property
    def normals(self) -> Floats:
        return smooth_normals(self.points, self.faces)

    @cached_property
    def scored(self) -> Bools:
        """The vertices that are evidence."""
        scored = far_from_border(self.faces, len(self.points))
        for allowed in (self.movable, None if self.replaced is None else ~self.replaced):
            scored = scored if allowed is None else scored & allowed
        return scored

    def best_of_settings(self) -> Choice[Setting] | None:
        """What the held-out vertices say of all settings; None if they say nothing, or nothing is to be done."""
        calm = calm_noise(self.points, self.faces, normals=self.normals, scored=self.scored)
        agreement = shared_noise(self.points, self.faces)
        if calm < _NOTHING or (agreement > _SURFACE and self.replaced is None):
            return None
        direction = direction_for(estimate_noise(self.points, self.faces))
        tried = SettingsTried(
            self.faces, self.normals, direction, border=self.border, movable=self.movable, replaced=self.replaced
        )
        evidence = self._choose(tried, settings(direction, "keep" if self.replaced is None else "replace"))
        if evidence is None or self.replaced is not None or agreement < _INDEPENDENT:
            return evidence
        error, of_nothing = evidence.chosen.error, evidence.trials[0]
        nearer = error**2 < 2.0 * (_EVEN * calm) ** 2
        sure = calm > _MESHING or error < max(_FAR_BETTER * of_nothing.error, _NOISE_ALONE * calm)
        return evidence if nearer and sure else evidence._replace(chosen=of_nothing)

    def best_of(self, few: Sequence[Setting]) -> Setting:
        """Which of them, run in full, the held-out vertices speak for."""

        def candidates(points: Floats, held: Ints) -> list[Iterator[Floats]]:
            certain = np.zeros(len(points), dtype=np.bool_)
            certain[held] = True
            return [iter([replace(self, points=points).smoothed(setting, certain)]) for setting in few]

        found = None if len(few) == 1 else self._choose(candidates, [[setting] for setting in few])
        return few[0] if found is None else found.chosen.label

    def smoothed(self, setting: Setting, certain: Bools | None = None) -> Floats:
        return setting.apply(self.points, self.faces, border=self.border, movable=self.movable, certain=certain)

    def _choose(self, candidates: Candidates, labels: Sequence[Sequence[Setting]]) -> Choice[Setting] | None:
        return choose(
            self.points,
            self.faces,
            candidates,
            labels,
            normals=self.normals,
            scored=self.scored,
            seed=self.seed,
            progress=self.progress,
        )
