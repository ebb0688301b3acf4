"""Places the new vertices of all patches by fairing; in a patch whose equations cannot be solved, by a lower energy."""

import numpy as np

from ..checks import ConvergenceError, FilterInputError
from ..execution import Progress
from ..fairing.region import fair_region
from ..linear_solvers import DirectMethod
from ..mesh import Floats, Ints
from .filling import HOLE_ENERGIES, HoleEnergy
from .patches import Patches

#: Patches with more new vertices than this together are not solved for at once.
MOST_AT_ONCE = 100_000
#: With more free vertices than this the factors by Cholesky come first: they take half the memory, but cannot be interrupted.
_LARGE = 20_000


def fair_patches(
    patches: Patches, points: Floats, faces: Ints, *, energy: HoleEnergy, rounds: int, progress: Progress
) -> list[HoleEnergy]:
    """Fairs and refines the patches in turn, and moves their new vertices; the energy that placed each patch in the end.

    All patches of one energy are solved for together. If their equations cannot be solved, the set is halved until each patch
    that causes it stands alone. Such a patch gets the next lower energy, in this round and all later ones.

    Args:
        patches: the patches, refined once.
        points: (n, 3) the vertices of the mesh.
        faces: (m, 3) its triangles.
        energy: the energy to begin with.
        rounds: how often to fair.
        progress: called with the share that is done, which falls where patches are solved for again.
    """
    energies: list[HoleEnergy] = [energy] * patches.count
    for done in range(rounds):

        def partial(share: float, done: int = done) -> None:
            progress((done + share) / rounds)

        if done > 0:
            patches.refine_again(energy != "membrane", partial)
        # Grouped before any patch falls to a lower energy: `_lower` places those that do.
        groups = [[k for k in range(patches.count) if energies[k] == level] for level in HOLE_ENERGIES[:0:-1]]
        for level, group in zip(HOLE_ENERGIES[:0:-1], groups, strict=True):
            for part in _parts(patches, group):
                for k in _place(patches, points, faces, part, level, partial):
                    energies[k] = _lower(patches, points, faces, k, level, partial)
    return energies


def _parts(patches: Patches, group: list[int]) -> list[list[int]]:
    """The patches of a group in parts of up to `MOST_AT_ONCE` new vertices, or of one patch."""
    counts = np.bincount(patches.gathered()[2], minlength=patches.count)
    parts: list[list[int]] = []
    total = 0
    for k in group:
        total += int(counts[k])
        if not parts or total > MOST_AT_ONCE:
            parts.append([])
            total = int(counts[k])
        parts[-1].append(k)
    return parts


def _lower(patches: Patches, points: Floats, faces: Ints, k: int, energy: HoleEnergy, progress: Progress) -> HoleEnergy:
    """Places one patch by the highest energy below this one that can be solved for, and returns that."""
    for level in HOLE_ENERGIES[HOLE_ENERGIES.index(energy) - 1 : 0 : -1]:
        if not _place(patches, points, faces, [k], level, progress):
            return level
    return "none"


def _place(patches: Patches, points: Floats, faces: Ints, group: list[int], energy: HoleEnergy, progress: Progress) -> list[int]:
    """Places the new vertices of these patches; returns the patches whose equations cannot be solved."""
    new_vertices, new_faces, patch_of_vertex, _ = patches.gathered()
    free = np.concatenate([np.zeros(len(points), dtype=np.bool_), np.isin(patch_of_vertex, group)])
    if energy == "none" or not free.any():
        return []
    everything, closed = np.concatenate([points, new_vertices]), np.concatenate([faces, new_faces])
    methods: tuple[DirectMethod, ...] = ("cholesky", "superlu") if free.sum() > _LARGE else ("superlu",)
    for method in methods:
        try:
            faired = fair_region(everything, closed, free, energy=energy, dense=True, method=method, progress=progress)
        except (ConvergenceError, FilterInputError):
            continue
        patches.move(faired.vertices[len(points) :])
        return []
    if len(group) == 1:
        return group
    half = len(group) // 2
    return [k for part in (group[:half], group[half:]) for k in _place(patches, points, faces, part, energy, progress)]
