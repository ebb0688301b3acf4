"""Holes closed by a surface that continues the one around: triangulated, refined to the density of the rim, faired."""

from numbers import Integral
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, check_mesh
from .filling import HOLE_ENERGIES, HoleEnergy, HoleFilling, OpenRim
from .patch_fairing import fair_patches
from .patches import Patches
from .rims import find_rims
from .sorted_rims import ISLAND_IN_IT, MOST_JOINED, left_open_as, sorted_rims

__all__ = ["HOLE_ENERGIES", "HoleEnergy", "HoleFilling", "OpenRim", "close_holes"]

# The share of the work that triangulation is taken to be.
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
    rounds, since a fair surface is that of a parametrisation, which the round before has made a better one. Where the surface
    then bends more than 1.2 times as much at the rim as around it, edges become as short as a quarter: a narrow hole between two
    sides that do not match needs more of them to be smooth.

    The closed mesh is a manifold where the mesh was one, and oriented like it. Outer borders of open sheets are no holes and stay
    open, of whatever size (`outer_borders`): rims round which the surface turns by more than 1.5 pi, and, unless `selected` asks
    for them, those that span more than a third of the area of their sheet, as the border of a cap of a ball up to 109 degrees
    from its pole does. A ball of which less is missing has a hole; a tube longer than three quarters of its width has two. If a
    sheet lies in a hole without touching its rim it is an island, which the new faces join.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        max_edges: the largest number of edges of the rim of a hole that is closed, from 3. Larger closes more. Outer borders and
            islands do not count. A rim of k edges takes about 5 k^2 bytes.
        energy: how the new vertices are placed. "membrane": the least area, with a crease at the rim. "thin_plate": tangents
            continue across the rim. "minimum_variation": curvatures do too, the filling bulges as the surroundings suggest; on
            smooth surfaces it is closest to what was there, and it is the most sensitive to noise at the rim. "none": as
            refinement leaves them.
        refine: whether to split the new faces until they are as dense as the rim. Without, there are no new vertices and so
            nothing to fair.
        rounds: how often to refine and fair, from 1. More let a filling bulge further where the rim suggests that.
        islands: "join": new faces connect islands with the rim around; they need not be small. If one cannot be joined, its hole
            stays open too. "leave": they stay loose and the new faces do not know of them.
        selected: (n,) bool: only holes with at least one selected vertex at the rim are closed, and rims so selected are holes
            where their area alone makes them outer borders. None for all holes.
        progress: called now and then with the share that is done; may raise to stop.

    Returns:
        What to add to the mesh. Vertices and faces of the mesh itself stay as they are. Deterministic.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    given, triangles = check_mesh(vertices, faces)
    _check_choice("energy", energy, HOLE_ENERGIES)
    _check_choice("islands", islands, ("join", "leave"))
    _check_least("max_edges", max_edges, 3)
    _check_least("rounds", rounds, 1)
    rounds = int(rounds)
    wanted = _check_selected(selected, len(given))
    points, exponent = _ordinary(given, triangles)
    forwards = _only_forwards(progress)
    rims, left_open = find_rims(points, triangles)
    holes, inside, unwanted = sorted_rims(rims, points, triangles, max_edges, wanted, islands)
    left_open += unwanted
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
    energies: list[HoleEnergy] = ["none"] * len(closed)
    if refine and energy != "none":

        def rest(share: float) -> None:
            forwards(_TRIANGULATION + (1.0 - _TRIANGULATION) * share)

        energies = fair_patches(patches, points, triangles, energy=energy, rounds=rounds, progress=rest)
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
        tuple(energies),
    )


def _ordinary(given: Floats, triangles: Ints) -> tuple[Floats, int]:
    """The vertices divided by two to a power, which is returned, and which changes no digit.

    So areas and their squares are ordinary numbers in any unit. Vertices without a face have no say in that, and become zero.
    """
    used = np.zeros(len(given), dtype=np.bool_)
    used[triangles] = True
    points = np.where(used[:, None], given, 0.0)
    exponent = int(np.frexp(np.abs(points).max(initial=0.0))[1])
    return np.ldexp(points, -exponent), exponent


def _only_forwards(progress: Progress) -> Progress:
    """The same without shares below one that was told already: some of the work is tried, and done again otherwise."""
    furthest = 0.0

    def forwards(share: float) -> None:
        nonlocal furthest
        furthest = max(furthest, share)
        progress(furthest)

    return forwards


def _check_choice(name: str, value: object, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise FilterInputError(f"{name} {value!r} is not one of {', '.join(map(repr, allowed))}")


def _check_least(name: str, value: object, least: int) -> None:
    whole = isinstance(value, Integral) or (isinstance(value, float) and value.is_integer())
    if not whole or int(value) < least:  # type: ignore[call-overload]
        raise FilterInputError(f"{name} is {value!r}: it is a whole number of at least {least}")


def _check_selected(selected: ArrayLike | None, n_vertices: int) -> Bools | None:
    if selected is None:
        return None
    mask = np.asarray(selected)
    if mask.dtype != np.bool_ or mask.shape != (n_vertices,):
        raise FilterInputError(
            f"selected must be a boolean array of {n_vertices} values, one a vertex, got shape {mask.shape} of {mask.dtype}"
        )
    return mask
