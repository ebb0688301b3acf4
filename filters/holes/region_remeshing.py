"""Region remeshing: the triangles of a region replaced by a faired filling."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice
from ..execution import Progress, ignore_progress
from ..fairing import ENERGIES, Energy
from ..mesh import Bools, check_mesh, check_vertex_mask, mask_of
from ..topology import border_vertices, connected_components
from .closing import close_holes
from .filling import HoleFilling

#: The most edges of the rim of a region.
LARGEST_RIM = 10_000


def remesh_region(
    vertices: ArrayLike,
    faces: ArrayLike,
    region: ArrayLike,
    *,
    energy: Energy = "thin_plate",
    rounds: int = 3,
    progress: Progress = ignore_progress,
) -> tuple[Bools, HoleFilling]:
    """Deletes the vertices of a region with their triangles, and closes the holes by `close_holes`.

    `fair_region` keeps the triangles, so that over rough damage needles and folds remain, and pull at the solution. Here neither
    the places nor the triangles of the region matter, but for the vertices around it.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        region: (n,) bool, the vertices to delete. Those in a triangle with a vertex on a border stay, so that borders do.
        energy: as for `fair_region`.
        rounds: as for `close_holes`.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n,) the vertices to delete with their faces, which is the region without the triangles at open borders; and the faces to
        add in their place, in the numbers of the whole mesh.

    Raises:
        FilterInputError: not a mesh; a region that is a whole component or all at borders, or whose rim cannot be closed.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("energy", energy, ENERGIES)
    chosen = check_vertex_mask("region", region, len(points))
    border = border_vertices(triangles, len(points))
    beside = mask_of(triangles[border[triangles].any(axis=1)], len(points))
    labels, count = connected_components(triangles, len(points))
    used = labels >= 0  # not by triangles alone that name a vertex twice
    chosen = chosen & ~beside & used
    if not chosen.any():
        raise FilterInputError(
            "nothing can be remade: all of the region lies at an open border, whose triangles stay, or has no triangle"
        )
    remains = np.bincount(labels[used & ~chosen], minlength=count) > 0
    if not remains[labels[used & chosen]].all():
        raise FilterInputError("a whole component is selected, so that its place is undetermined: select less")
    gone = chosen[triangles].any(axis=1)
    rim = mask_of(triangles[gone], len(points)) & ~chosen & ~border
    rest = triangles[~gone]
    filling = close_holes(
        points, rest, max_edges=LARGEST_RIM, energy=energy, rounds=rounds, selected=rim if rim.any() else None, progress=progress
    )
    for left in filling.left_open:
        if left.reason != "selection" and rim[left.vertices].any():
            raise FilterInputError(f"the region cannot be remade: {left.message}; select a ring more or less")
    return chosen, filling
