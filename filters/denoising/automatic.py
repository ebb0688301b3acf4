"""Denoising without parameters: the setting is chosen from the scan alone."""

from dataclasses import replace
from typing import NamedTuple

from numpy.typing import ArrayLike

from ..evidence import Choice, tuned
from ..execution import Progress, ignore_progress, part_of, rising
from ..geometry import seen_from_one_side
from ..mesh import Floats, NormalisedMesh, check_mesh, check_movable, normalised_mesh
from ..topology import BorderPolicy
from .candidates import REPERTOIRE, Repertoire, Setting, SettingsTried
from .correlated_noise import on_lines_of_sight, setting_by_balls, setting_of_rounded, setting_of_shared
from .noise_level import NoiseEstimate, estimate_noise, is_designed
from .rounding import rounding_of
from .scan import Scan


class AutomaticChoice(NamedTuple):
    """The setting for a scan, and the evidence for it."""

    kind: str  # "clean", "noisy", or "correlated" (neighbours share the noise)
    setting: Setting
    noise: NoiseEstimate
    evidence: Choice[Setting] | None = None  # the scores of the settings that were tried; None if they do not decide
    # True if noise is independent, no outlier was replaced, and at most one other setting is as good, see `tuned.SURE`.
    sure: bool = False


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
    """Chooses the denoising setting of a mesh.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) bool, which vertices may move, None for all. Errors at fixed vertices do not count.
        seed: selects the held-out vertices.
        repertoire: the settings for cross-validation, see `Repertoire.narrowed`.
        progress: called with the finished share; may raise to stop.

    Returns:
        The choice. Moving, turning, scaling or renumbering the mesh does not change the setting.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    mesh = normalised_mesh(*check_mesh(vertices, faces), movable)
    noise, rounding = estimate_noise(mesh.points, mesh.cells), rounding_of(mesh.points, mesh.cells)
    noise = noise._replace(length=noise.length / mesh.scale)
    is_depth_map = seen_from_one_side(mesh.points, mesh.cells) > tuned.FACING and on_lines_of_sight(mesh.points, mesh.cells)
    first, last = part_of(progress, 0.0, 0.3), part_of(progress, 0.7, 1.0)
    # 1. Correlated noise. This step comes first only on unrounded depth maps; else it comes last, unless step 4 finds such noise.
    if rounding is None and is_depth_map and (evidence := setting_of_shared(mesh, noise, border=border, progress=first)):
        progress(1.0)
        return AutomaticChoice("correlated", evidence.chosen.label, noise, evidence)
    scan, _ = Scan.sampled(mesh.points, mesh.cells, mesh.movable, seed=seed, progress=rising(progress, 0.3, 0.7))
    choice = _cross_validated(mesh, scan, noise, border, repertoire, is_rounded=rounding is not None)
    if rounding is not None:
        evidence = setting_of_rounded(mesh, rounding, choice.setting, border=border, progress=last)
    else:
        is_final = is_depth_map or choice.kind == "correlated"
        evidence = None if is_final else setting_of_shared(mesh, noise, border=border, progress=last)
    progress(1.0)
    return choice if evidence is None else AutomaticChoice("correlated", evidence.chosen.label, noise, evidence)


def _cross_validated(
    mesh: NormalisedMesh, scan: Scan, noise: NoiseEstimate, border: BorderPolicy, repertoire: Repertoire, *, is_rounded: bool
) -> AutomaticChoice:
    """Returns the choice by steps 2 to 5."""
    # 2. Impulse noise: outliers are replaced first, and are not evidence.
    calmed, uneven = (scan, False) if repertoire.outliers == "keep" else scan.without_impulses
    is_even, setting, evidence = calmed is scan and not uneven, Setting(), None
    # 3. A model of planes counts as free of noise. So does a mesh with little noise, equally strong everywhere, without impulses.
    if not is_designed(mesh.points, mesh.cells) and not (is_even and scan.noise.level < tuned.NO_NOISE):
        # 4. Cross-validation. With outliers it also tries settings that move only the outliers, without Taubin steps.
        alone = calmed is not scan and 0 in repertoire.relaxations
        tried = SettingsTried(calmed, border=border, of=repertoire, alone=alone)
        setting = Setting(outliers="keep" if calmed is scan else "only")
        evidence = calmed.choose(tried, tried.labels, by_means=alone, progress=part_of(scan.progress, 0.0, 0.5))
        if evidence is not None:
            shared = setting_by_balls(scan, tried, evidence, border=border) if calmed is scan and not is_rounded else None
            if shared is not None:
                of_shared = replace(shared.chosen.label, outliers=repertoire.outliers or "keep")
                return AutomaticChoice("correlated", of_shared, noise, shared)
            # 5. In doubt the mesh stays as it is, unless it has outliers.
            evidence = scan.or_nothing(evidence) if calmed is scan else evidence
            setting = evidence.chosen.label
        if is_even and scan.is_surface:  # what looks like noise is the surface itself
            setting, evidence = Setting(), None
    setting = replace(setting, outliers=repertoire.outliers or setting.outliers)
    sure = evidence is not None and len(evidence.rivals) <= tuned.RIVALS and calmed is scan and scan.agreement[0] < tuned.SURE
    return AutomaticChoice("clean" if setting == Setting() else "noisy", setting, noise, evidence, sure)


def denoise_automatically(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, AutomaticChoice]:
    """Denoises a mesh with the setting of `automatic_choice`; see there for the arguments and errors.

    Returns (n, 3) float64 the vertices, and the choice. Clean meshes keep every bit.
    """
    choice = automatic_choice(vertices, faces, border=border, movable=movable, progress=part_of(progress, 0.0, 0.8))
    points, triangles = check_mesh(vertices, faces)
    moves = None if movable is None else check_movable(movable, len(points))
    return choice.setting.apply(points, triangles, border=border, movable=moves, progress=part_of(progress, 0.8, 1.0)), choice
