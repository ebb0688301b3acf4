"""Places the new vertices of all patches by fairing; in a patch whose equations cannot be solved, by a lower energy."""

import numpy as np

from ..checks import ConvergenceError, FilterInputError
from ..execution import Progress
from ..fairing.region import fair_region
from ..mesh import Floats, Ints
from .filling import HOLE_ENERGIES, HoleEnergy
from .patches import Patches


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
            patches.refine_again(energy != "membrane")
        # Grouped before any patch falls to a lower energy: `_lower` places those that do.
        groups = [[k for k in range(patches.count) if energies[k] == level] for level in HOLE_ENERGIES[:0:-1]]
        for level, group in zip(HOLE_ENERGIES[:0:-1], groups, strict=True):
            for k in _place(patches, points, faces, group, level, partial):
                energies[k] = _lower(patches, points, faces, k, level, partial)
    return energies


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
    everything = np.concatenate([points, new_vertices])
    try:
        faired = fair_region(everything, np.concatenate([faces, new_faces]), free, energy=energy, dense=True, progress=progress)
    except (ConvergenceError, FilterInputError):
        if len(group) == 1:
            return group
        half = len(group) // 2
        return [k for part in (group[:half], group[half:]) for k in _place(patches, points, faces, part, energy, progress)]
    patches.move(faired.vertices[len(points) :])
    return []
