"""Places the new vertices of all patches by fairing; by a lower energy where that fails or throws a patch far out."""

from typing import NamedTuple

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
#: The new vertices of a patch lie at most so many diagonals of the box of its rim outside of that box. Fillings of smooth
#: surfaces reach 0.2 of them; one that goes further was thrown out, and refining it would take triangles for all that area.
FURTHEST = 1.0


class Placement(NamedTuple):
    """How the new vertices of a patch were placed.

    Attributes:
        energy: by which energy.
        thrown_out: whether a higher one would have put them further than `FURTHEST` outside of the box of the rim.
    """

    energy: HoleEnergy
    thrown_out: bool


def fair_patches(
    patches: Patches, points: Floats, faces: Ints, *, energy: HoleEnergy, rounds: int, progress: Progress
) -> list[Placement]:
    """Fairs and refines the patches in turn, and moves their new vertices; how each patch was placed in the end.

    All patches of one energy are solved for together. If their equations cannot be solved, the set is halved until each patch
    that causes it stands alone. Such a patch gets the next lower energy, in this round and all later ones, and so does one that
    leaves the box of its rim by more than `FURTHEST`. The last energy, "none", leaves vertices among those around.

    Args:
        patches: the patches, refined once.
        points: (n, 3) the vertices of the mesh.
        faces: (m, 3) its triangles.
        energy: the energy to begin with.
        rounds: how often to fair.
        progress: called with the share that is done, which falls where patches are solved for again.
    """
    placements = [Placement(energy, False)] * patches.count
    for done in range(rounds):

        def partial(share: float, done: int = done) -> None:
            progress((done + share) / rounds)

        if done > 0:
            patches.refine_again(energy != "membrane", partial)
        # Grouped before any patch falls to a lower energy: `_lower` places those that do.
        groups = [[k for k in range(patches.count) if placements[k].energy == level] for level in HOLE_ENERGIES[:0:-1]]
        for level, group in zip(HOLE_ENERGIES[:0:-1], groups, strict=True):
            for part in _parts(patches, group):
                for k, thrown_out in _place(patches, points, faces, part, level, partial).items():
                    placements[k] = _lower(patches, points, faces, k, Placement(level, thrown_out), partial)
    return placements


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


def _lower(patches: Patches, points: Floats, faces: Ints, k: int, failed: Placement, progress: Progress) -> Placement:
    """Places one patch by the highest energy below the failed one that can be solved for and stays near the rim."""
    thrown_out = failed.thrown_out
    for level in HOLE_ENERGIES[HOLE_ENERGIES.index(failed.energy) - 1 : 0 : -1]:
        again = _place(patches, points, faces, [k], level, progress)
        if not again:
            return Placement(level, thrown_out)
        thrown_out |= again[k]
    return Placement("none", thrown_out)


def _place(
    patches: Patches, points: Floats, faces: Ints, group: list[int], energy: HoleEnergy, progress: Progress
) -> dict[int, bool]:
    """Places the new vertices of these patches; returns those that it cannot place, and whether it would throw them out."""
    new_vertices, new_faces, patch_of_vertex, _ = patches.gathered()
    free = np.concatenate([np.zeros(len(points), dtype=np.bool_), np.isin(patch_of_vertex, group)])
    if energy == "none" or not free.any():
        return {}
    everything, closed = np.concatenate([points, new_vertices]), np.concatenate([faces, new_faces])
    methods: tuple[DirectMethod, ...] = ("cholesky", "superlu") if free.sum() > _LARGE else ("superlu",)
    for method in methods:
        try:
            faired = fair_region(everything, closed, free, energy=energy, dense=True, method=method, progress=progress)
        except (ConvergenceError, FilterInputError):
            continue
        moved = faired.vertices[len(points) :]
        far = np.flatnonzero(patches.reach(moved) > FURTHEST).tolist()
        if not far:
            patches.move(moved)
            return {}
        # Where patches meet, one that is thrown out takes others along: they are placed without it.
        rest = [k for k in group if k not in far]
        return dict.fromkeys(far, True) | _place(patches, points, faces, rest, energy, progress)
    if len(group) == 1:
        return {group[0]: False}
    half = len(group) // 2
    parts = (group[:half], group[half:])
    return {k: far for part in parts for k, far in _place(patches, points, faces, part, energy, progress).items()}
