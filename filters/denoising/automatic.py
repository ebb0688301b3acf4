"""Denoising without parameters: those of the normal filter follow from the scan alone.

A clean mesh stays as it is; noise that neighbours share, as that of depth cameras, gets a strong setting of its own; all else
the setting that best predicts vertices which it has not seen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..evidence import Choice, folded_share, upright
from ..execution import Progress, ignore_progress, part_of, rising
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable, normalised_mesh
from ..topology import BorderPolicy
from .candidates import SettingsTried
from .designed import is_designed
from .impulses import Outliers, far_from, replace_outlying
from .noise_level import NoiseEstimate, estimate_noise
from .range_map import range_map_setting
from .relaxation import direction_for
from .repertoire import REPERTOIRE, Repertoire, Setting, settings
from .scan import Scan
from .shared_noise import neighbours_share_noise

# More vertices than this stand out of impulsive noise: of Gaussian noise up to 0.003, of clean meshes up to 0.007.
_IMPULSIVE = 0.01


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
    repertoire: Repertoire = REPERTOIRE,
    progress: Progress = ignore_progress,
) -> AutomaticChoice:
    """Find how a mesh is denoised.

    1. Made of planes without noise: nothing is done. Noise that neighbours share: that of `range_map_setting`.
    2. Otherwise that of `settings`, nothing at all among them, that `choose` finds on the mesh, or on patches of a large one.
       Steps of Taubin's go along the normals alone if the vertices are scattered less along the surface than across it.
    3. A surface without noise stays: residuals of differences that agree between neighbours rule noise out, see `Scan`, and what
       predicts best must be nearer to the truth than the scan is, see `Scan.or_nothing`.
    4. If more vertices are far from the result than Gaussian noise has, the same setting is tried with such outliers taken away,
       see `without_outliers`. If more stand out from those around them, filters that keep edges keep them: step 2 once more
       where they are replaced by what the others expect, the outlying vertices no evidence. Where the others are nearly exact,
       see `Scan.exact`, nothing but they is to move: this too is tried. Of these settings, run in full, `choose` takes one, of
       those that do not leave many faces folded over.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) bool, which vertices may move, None for all. The others are not evidence.
        seed: other vertices are held out for another number.
        repertoire: what is chosen from; `Repertoire.narrowed` leaves what agrees with given parameters. A range map gets
            its own setting whatever is chosen from.
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
        setting, by_risk = range_map_setting(mesh, border=border, progress=progress)
        return AutomaticChoice("range map", setting, noise, by_risk)
    trial = _Trial(Scan.of(vertices, faces, movable=movable, seed=seed, progress=rising(progress)), border, repertoire)
    evidence = trial.of_settings()
    setting = _chosen(evidence, Setting())
    found = {setting: evidence}
    if repertoire.outliers != "keep":
        found |= trial.without_outliers(setting, evidence)
    allowed = [candidate for candidate in found if repertoire.outliers in (None, candidate.outliers)]
    if allowed:
        setting = trial.best_of(allowed)
        return AutomaticChoice("clean" if setting == Setting() else "noisy", setting, noise, found[setting])
    return AutomaticChoice("noisy", replace(setting, outliers=repertoire.outliers or "keep"), noise, evidence)


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
    return choice.setting.apply(points, triangles, border=border, movable=moves, progress=part_of(progress, 0.8, 1.0)), choice


class _Trial(NamedTuple):
    """Settings tried on a scan."""

    scan: Scan
    border: BorderPolicy
    repertoire: Repertoire

    def of_settings(self) -> Choice[Setting] | None:
        """What the held-out vertices say of all settings; None if they say nothing, or nothing is to be done."""
        scan, replaced = self.scan, self.scan.replaced
        if replaced is None and scan.clean:
            return None
        direction = self.repertoire.relaxation_direction or direction_for(scan.noise)
        alone = replaced is not None and scan.exact
        tried = SettingsTried(
            scan.faces,
            scan.normals,
            direction,
            border=self.border,
            movable=scan.movable,
            replaced=replaced if alone else None,
            whole=scan.whole,
            of=self.repertoire,
        )
        outliers: Outliers = "keep" if replaced is None else "replace"
        evidence = scan.choose(tried, settings(direction, outliers, alone=alone, of=self.repertoire), spikes=alone)
        return evidence if evidence is None or replaced is not None else scan.or_nothing(evidence)

    def without_outliers(self, setting: Setting, evidence: Choice[Setting] | None) -> dict[Setting, Choice[Setting] | None]:
        """The settings that take outliers away, if there are any, each with what speaks for it: step 4 of `automatic_choice`."""
        scan, found = self.scan, {}
        if np.mean(far_from(scan.points, scan.faces, self.result(scan.points, setting))) > _IMPULSIVE:
            found[replace(setting, outliers="replace")] = evidence
        calmed, outlying = replace_outlying(scan.points, scan.faces, scan.movable)
        if np.mean(outlying) > _IMPULSIVE:
            of_the_rest = self._replace(scan=replace(scan, points=calmed, replaced=outlying)).of_settings()
            found[_chosen(of_the_rest, Setting(outliers="only"))] = of_the_rest
        return found

    def best_of(self, few: Sequence[Setting]) -> Setting:
        """Which of them, run in full, the held-out vertices speak for; none that leaves many faces folded over, see `upright`."""
        if len(few) == 1:
            return few[0]
        scan = self.scan
        shares = [folded_share(self.result(scan.points, setting), scan.faces, scan.normals) for setting in few]
        left = [setting for setting, stays in zip(few, upright(shares), strict=True) if stays or setting == Setting()]

        def candidates(points: Floats, held: Ints) -> list[Iterator[Floats]]:
            certain = np.zeros(len(points), dtype=np.bool_)
            certain[held] = True
            return [iter([self.result(points, setting, certain)]) for setting in left]

        found = scan.choose(candidates, [[setting] for setting in left], spikes=True)
        return left[0] if found is None else found.chosen.label

    def result(self, points: Floats, setting: Setting, certain: Bools | None = None) -> Floats:
        """(n, 3) what the setting makes of the points."""
        return setting.apply(points, self.scan.faces, border=self.border, movable=self.scan.movable, certain=certain)
