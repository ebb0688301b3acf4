"""Holes closed by a surface that continues the one around: triangulated, refined to the density of the rim, faired."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_choice, check_whole_number
from ..execution import Progress, ignore_progress
from ..mesh import Floats, Ints, check_mesh, check_vertex_mask
from ..topology import boundary_loops
from .filling import HOLE_ENERGIES, HoleEnergy, HoleFilling, OpenRim
from .left_open import ISLAND_IN_IT, broken_left_open, left_open_as
from .patch_fairing import Placement, fair_patches
from .patches import Patches
from .sorted_rims import MOST_JOINED, sorted_rims

__all__ = ["HOLE_ENERGIES", "HoleEnergy", "HoleFilling", "OpenRim", "close_holes"]

# The share of the progress that triangulation takes.
_TRIANGULATION = 0.4


def close_holes(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    max_edges: int = 300,
    energy: HoleEnergy = "thin_plate",
    refine: bool = True,
    rounds: int = 3,
    islands: Literal["join", "leave"] = "join",
    selected: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> HoleFilling:
    """Closes the holes of a mesh with up to `max_edges` border edges [liepa2003].

    Each rim is triangulated (`triangulate_rim`), the triangles are split and their edges flipped until they are as small as those
    at the rim (`refined_patch`), and the new vertices are placed by `fair_region`; refinement and fairing alternate for some
    rounds, since fairing depends on the triangulation, which each round makes more regular. Where the surface then bends more
    than 1.2 times as much at the rim as around it, edges become down to a quarter as long: a narrow hole between two sides that
    do not match needs more of them to be smooth. Where the filling would have more than 60,000 new vertices (`MOST_VERTICES`),
    its triangles get larger away from the rim, so that time and memory grow with the rim alone. No new vertex lies further
    outside of the box of its rim than the diagonal of that box: a filling that an energy would throw out further, as beside a
    spike, is placed by the next lower one.

    The closed mesh is a manifold where the mesh was one, and oriented like it. Outer borders of open sheets are no holes and stay
    open, of whatever size (`outer_borders`): rims with a total geodesic curvature above 1.5 pi, and, unless `selected` contains
    one of their vertices, those that span more than a third of the area of their sheet, as the border of a cap of a ball up to
    109 degrees from its pole does. A rim whose squared length is below the area of its sheet is always a hole. A ball of which
    less is missing has a hole; a tube longer than three quarters of its width has
    two. A sheet that lies in a hole without touching its rim is an island, which the new faces join.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        max_edges: the largest number of edges of the rim of a hole that is closed, from 3. Larger closes more. Outer borders and
            islands do not count.
        energy: how the new vertices are placed. "membrane": the least area, with a crease at the rim. "thin_plate": tangents
            continue across the rim. "minimum_variation": curvatures do too, and the filling bulges as the surface around does;
            it is closest to the lost surface where that was smooth, and the most sensitive to noise at the rim. "none": as
            refinement leaves them.
        refine: whether to split the new faces until they are as dense as the rim. Without, there are no new vertices and so
            nothing to fair.
        rounds: how often to refine and fair, from 1. More let a filling bulge further where the surface around does.
        islands: "join": new faces connect islands with the rim around; they need not be small. If one cannot be joined, its hole
            stays open too. "leave": they stay loose, and the new faces may intersect them.
        selected: (n,) bool: only holes with at least one selected vertex at the rim are closed. A rim with one that would be an
            outer border by its area alone is closed, too. None for all holes.
        progress: called with the share that is done; may raise to stop.

    Returns:
        What to add to the mesh. Vertices and faces of the mesh itself stay as they are. Deterministic.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    given, triangles = check_mesh(vertices, faces)
    check_choice("energy", energy, HOLE_ENERGIES)
    check_choice("islands", islands, ("join", "leave"))
    check_whole_number("max_edges", max_edges, least=3)
    check_whole_number("rounds", rounds, least=1)
    wanted = None if selected is None else check_vertex_mask("selected", selected, len(given))
    points, exponent = _ordinary(given, triangles)
    forwards = _only_forwards(progress)
    rims, broken = boundary_loops(points, triangles)
    holes, inside, unwanted = sorted_rims(rims, points, triangles, max_edges, wanted, islands)
    left_open = [*map(broken_left_open, broken), *unwanted]
    patches = Patches(points, triangles, rims)
    closed, with_islands = [], []
    for k, hole in enumerate(holes):

        def partial(share: float, done: int = k) -> None:
            forwards(_TRIANGULATION * (done + share) / len(holes))

        group = inside[k]
        too_many = bool(group) and sum(len(rim.vertices) for rim in (hole, *group)) > max(MOST_JOINED, max_edges)
        if not too_many and patches.add(hole, group, refine, partial):
            closed.append(hole.vertices)
            with_islands.append(np.concatenate([np.empty(0, dtype=np.int32), *(rim.vertices for rim in group)]))
        elif group:
            left_open += [left_open_as(hole, "island", ISLAND_IN_IT), *(left_open_as(rim, "island") for rim in group)]
        else:
            left_open.append(left_open_as(hole, "no_triangulation"))
    placements = [Placement("none", False)] * len(closed)
    if refine and energy != "none":

        def rest(share: float) -> None:
            forwards(_TRIANGULATION + (1.0 - _TRIANGULATION) * share)

        placements = fair_patches(patches, points, triangles, energy=energy, rounds=rounds, progress=rest)
    new_vertices, new_faces, hole_of_vertex, hole_of_face = patches.gathered()
    left_open.sort(key=lambda rim: int(rim.vertices.min()))
    progress(1.0)
    return HoleFilling(
        np.ldexp(new_vertices, exponent),
        new_faces,
        hole_of_face,
        hole_of_vertex,
        tuple(closed),
        tuple(with_islands),
        tuple(left_open),
        tuple(p.energy for p in placements),
        tuple(p.thrown_out for p in placements),
    )


def _ordinary(given: Floats, triangles: Ints) -> tuple[Floats, int]:
    """The vertices divided by a power of two, and its exponent: exact, and areas and their squares stay in range in any unit.

    Vertices without a face do not count, and become 0.
    """
    used = np.zeros(len(given), dtype=np.bool_)
    used[triangles] = True
    points = np.where(used[:, None], given, 0.0)
    exponent = int(np.frexp(np.abs(points).max(initial=0.0))[1])
    return np.ldexp(points, -exponent), exponent


def _only_forwards(progress: Progress) -> Progress:
    """The progress without shares below the highest so far: work that is tried and then done in another way counts again."""
    furthest = 0.0

    def forwards(share: float) -> None:
        nonlocal furthest
        furthest = max(furthest, share)
        progress(furthest)

    return forwards
