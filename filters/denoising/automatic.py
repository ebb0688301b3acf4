"""Denoising without parameters: those of the normal filter follow from the scan alone.

A clean mesh stays as it is; noise that neighbours share, as that of depth cameras, gets a fixed setting; all else the
setting that best predicts vertices which it has not seen.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..evidence import Choice, calm_noise, choose, far_from_border, sample_of
from ..execution import Progress, ignore_progress, part_of
from ..geometry import face_normals
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable, normalised_mesh
from ..topology import BorderPolicy, face_adjacency
from .candidates import SETTINGS, AutomaticParameters, Setting, SettingsTried
from .noise_level import NoiseEstimate, estimate_noise, smooth_normals
from .shared_noise import neighbours_share_noise

#: Range maps of depth cameras, whose noise neighbours share, so that held-out vertices say nothing: strong, and fixed. One map of
#: a camera and three computed ones prefer it to Huber's kernel and to fewer steps.
RANGE_MAP = Setting(0, AutomaticParameters("averaged", "gaussian", 0.4, 0.0, 2.5, "two_ring", 20, 40))

# Vertices of clean meshes are up to so many mean edges from where their surroundings expect them, even where the mesh is calm:
# scans smoothed or decimated have 0.007 to 0.03, the same with noise of 0.05 edges 0.04 to 0.05. With less, something must
# predict so much better than nothing, as where a few vertices are off by far.
_MESHING, _FAR_BETTER = 0.03, 0.7
# Noise below this, in mean edges, and angles below this, in radians, are the rounding of a file.
_NOTHING, _FLAT = 1e-6, 1e-4
# A model of planes as it was designed: more of its faces than this share a plane with a neighbour. One vertex in a hundred moved
# spoils six faces in a hundred.
_DESIGNED = 0.99


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
    progress: Progress = ignore_progress,
) -> AutomaticChoice:
    """Find how a mesh is denoised.

    1. Made of planes without noise, or without any noise: nothing is done.
    2. Noise that neighbours share: `RANGE_MAP`.
    3. Otherwise that of `SETTINGS`, nothing at all among them, that `choose` finds on the mesh, or on patches of a large one.
       Where the calm parts of the mesh have no more noise than clean meshes do, it must be far better than nothing.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) bool, which vertices may move, None for all. The others are not evidence.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The same for the mesh moved, turned, scaled or renumbered.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    moves = None if movable is None else check_movable(movable, len(points))
    noise = estimate_noise(points, triangles)
    if noise.deviation < _NOTHING or _is_designed(points, triangles):
        return AutomaticChoice("clean", Setting(), noise)
    if neighbours_share_noise(points, triangles, noise):
        return AutomaticChoice("range map", RANGE_MAP, noise)
    evidence = held_out_evidence(points, triangles, border=border, movable=moves, progress=progress)
    if evidence is None or evidence.chosen.label == Setting():
        return AutomaticChoice("clean", Setting(), noise, evidence)
    return AutomaticChoice("noisy", evidence.chosen.label, noise, evidence)


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


def held_out_evidence(
    points: Floats,
    faces: Ints,
    *,
    border: BorderPolicy = "along",
    movable: Bools | None = None,
    seed: int = 0,
    progress: Progress = ignore_progress,
) -> Choice[Setting] | None:
    """What held-out vertices say of `SETTINGS`, on a sample of the mesh; None if they cannot say anything.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        border: see `normal_filtering`.
        movable: (n,) which vertices may move; the others are not held out.
        seed: other vertices are held out for another number.
        progress: called with the share that is done; may raise to stop.
    """
    sample = sample_of(points, faces)
    moves = None if movable is None else movable[sample.origin]
    scored = far_from_border(sample.faces, len(sample.points))
    tried = SettingsTried(sample.faces, len(sample.points), border=border, movable=moves)
    normals = smooth_normals(sample.points, sample.faces)
    scored = scored if moves is None else scored & moves
    evidence = choose(sample.points, sample.faces, tried, SETTINGS, normals=normals, scored=scored, seed=seed, progress=progress)
    if evidence is None or calm_noise(sample.points, sample.faces, normals=normals, scored=scored) > _MESHING:
        return evidence
    nothing = evidence.trials[0]
    return evidence if evidence.chosen.error < _FAR_BETTER * nothing.error else evidence._replace(chosen=nothing)


def _is_designed(points: Floats, faces: Ints) -> bool:
    """Whether the mesh is made of planes of two faces and more, without noise."""
    mesh = normalised_mesh(points, faces)
    pairs, _ = face_adjacency(mesh.cells)
    normals = face_normals(mesh.points, mesh.cells)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    flat = (np.linalg.norm(np.cross(first, second), axis=1) < _FLAT) & (np.einsum("ij,ij->i", first, second) > 0.0)
    return len(np.unique(pairs[flat])) > _DESIGNED * len(mesh.cells)
