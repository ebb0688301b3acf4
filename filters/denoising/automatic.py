"""Denoising without parameters: those of the normal filter follow from the scan alone.

A clean mesh stays as it is; noise that neighbours share, as that of depth cameras, gets a strong setting of its own; all else
the setting that best predicts vertices which it has not seen.
"""

from dataclasses import replace
from typing import NamedTuple

from numpy.typing import ArrayLike

from ..evidence import Choice
from ..execution import Progress, ignore_progress, part_of, rising
from ..mesh import Floats, check_mesh, check_movable, normalised_mesh
from ..topology import BorderPolicy
from .compared_settings import ComparedSettings
from .correlated_noise import correlated_setting
from .designed import is_designed
from .noise_level import NoiseEstimate, estimate_noise
from .repertoire import REPERTOIRE, Repertoire, Setting
from .scan import Scan


class AutomaticChoice(NamedTuple):
    """How a scan is denoised, and why.

    Attributes:
        kind: "clean", "correlated", with noise that neighbours share, or "noisy".
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

    1. Made of planes without noise: nothing is done. Noise that neighbours share: that of `correlated_setting`,
       if that does anything: where noise is uneven the calmest places, by which it goes, may have none.
    2. Otherwise that of `settings`, nothing at all among them, that `choose` finds on the mesh, or on patches of a large one.
       Steps of Taubin's go along the normals alone if the vertices are scattered less along the surface than across it.
    3. A surface without noise stays: residuals of differences that agree between neighbours rule noise out, see `Scan`, and what
       predicts best must be nearer to the truth than the scan is, see `Scan.or_nothing`.
    4. Vertices that stand out from those around them are kept by filters that keep edges. If there are more of them than Gaussian
       noise has, they are replaced before step 2, and what is found is compared with the same setting that keeps them: see
       `ComparedSettings`.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) bool, which vertices may move, None for all. The others are not evidence.
        seed: other vertices are held out for another number.
        repertoire: what is chosen from; `Repertoire.narrowed` leaves what agrees with given parameters. Noise that neighbours
            share gets its own settings whatever is chosen from.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The same for the mesh moved, turned, scaled or renumbered.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    mesh = normalised_mesh(*check_mesh(vertices, faces), movable)
    noise = estimate_noise(mesh.points, mesh.cells)
    noise = noise._replace(length=noise.length / mesh.scale)
    correlated = correlated_setting(mesh, noise, border=border, progress=part_of(progress, 0.0, 0.3))
    if correlated is not None and correlated[0] != Setting():
        progress(1.0)
        return AutomaticChoice("correlated", correlated[0], noise, correlated[1])
    if is_designed(mesh.points, mesh.cells):
        return AutomaticChoice("clean", Setting(), noise)
    progress = part_of(progress, 0.3, 1.0)
    scan = Scan.of(vertices, faces, movable=movable, seed=seed, progress=rising(progress))
    few = ComparedSettings(scan, border, repertoire)
    found = few.found()
    allowed = [setting for setting in found if repertoire.outliers in (None, setting.outliers)]
    if allowed:
        setting = few.best_of(allowed)
        return AutomaticChoice("clean" if setting == Setting() else "noisy", setting, noise, found[setting])
    setting, evidence = next(iter(found.items()))
    return AutomaticChoice("noisy", replace(setting, outliers=repertoire.outliers or "keep"), noise, evidence)


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
