"""Holes closed by a surface that continues the one around: triangulated, refined to the density of the rim, faired."""

from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..errors import FilterInputError
from ..fairing.region import Energy, fair_region
from ..mesh import Bools, Floats, Ints, check_mesh
from ..progress import Progress, ignore_progress
from ..topology import connected_components
from .filling import HoleFilling, OpenRim, Reason
from .islands import holes_around, outer_borders
from .patches import Patches
from .rims import Rim, find_rims, is_seam

__all__ = ["HOLE_ENERGIES", "HoleEnergy", "HoleFilling", "OpenRim", "close_holes"]

#: How the new vertices are placed: by `fair_region` with that energy, or "none": where refinement put them.
HoleEnergy: TypeAlias = Literal["none", "membrane", "thin_plate", "minimum_variation"]
HOLE_ENERGIES: tuple[HoleEnergy, ...] = get_args(HoleEnergy)

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
    then bends more than 1.2 times as much at the rim as around it, edges become up to half as long: a narrow hole between two
    sides that do not match needs more of them to be smooth.

    The closed mesh is a manifold where the mesh was one, and oriented like it. Outer borders of open sheets are no holes: rims
    round which the surface turns by more than 1.5 pi (`outer_borders`) stay open, and if such a sheet lies in a hole without
    touching its rim it is an island, which the new faces join.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        max_edges: the largest number of edges of a rim that is closed, from 3. Larger closes more.
        energy: how the new vertices are placed. "membrane": the least area, with a crease at the rim. "thin_plate": tangents
            continue across the rim. "minimum_variation": curvatures do too, the filling bulges as the surroundings suggest; on
            smooth surfaces it is closest to what was there, and it is the most sensitive to noise at the rim. "none": as
            refinement leaves them.
        refine: whether to split the new faces until they are as dense as the rim. Without, there are no new vertices and so
            nothing to fair.
        rounds: how often to refine and fair, from 1. More let a filling bulge further where the rim suggests that.
        islands: "join": new faces connect islands with the rim around; they need not be small. "leave": they stay loose and the
            new faces do not know of them.
        selected: (n,) bool: only holes with at least one selected vertex at the rim are closed. None for all.
        progress: called now and then with the share that is done; may raise to stop.

    Returns:
        What to add to the mesh. Vertices and faces of the mesh itself stay as they are. Deterministic.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        ConvergenceError: the equations of fairing are too ill-conditioned to be solved.
    """
    given, triangles = check_mesh(vertices, faces)
    # By a power of two, which changes no digit: so that areas and their squares are ordinary numbers in any unit.
    exponent = int(np.frexp(np.abs(given).max(initial=0.0))[1])
    points = np.ldexp(given, -exponent)
    _check_choice("energy", energy, HOLE_ENERGIES)
    _check_choice("islands", islands, ("join", "leave"))
    _check_least("max_edges", max_edges, 3)
    _check_least("rounds", rounds, 1)
    wanted = _check_selected(selected, len(points))
    rims, left_open = find_rims(points, triangles)
    holes, outer, unwanted = _sorted_out(rims, outer_borders(rims, points, triangles), points, max_edges, wanted)
    left_open += unwanted
    inside: dict[int, list[Rim]] = {}
    if islands == "join" and outer and holes:
        components, _ = connected_components(triangles, len(points))
        for rim, around in zip(outer, holes_around(outer, holes, points, components), strict=True):
            if around >= 0:
                inside.setdefault(around, []).append(rim)
    joined = {id(rim) for group in inside.values() for rim in group}
    left_open += [_left(rim, "outer") for rim in outer if id(rim) not in joined]
    patches = Patches(points, triangles, rims)
    closed, with_islands = [], []
    for k, hole in enumerate(holes):

        def partial(share: float, done: int = k) -> None:
            progress(_TRIANGULATION * (done + share) / len(holes))

        group = inside.get(k, [])
        if group and not patches.add(hole, group, refine, partial):
            left_open += [_left(rim, "island") for rim in group]
            group = []
        if group or patches.add(hole, [], refine, partial):
            closed.append(hole.vertices)
            with_islands.append(np.concatenate([np.empty(0, dtype=np.int32), *(rim.vertices for rim in group)]))
        else:
            left_open.append(_left(hole, "no_triangulation"))
    if refine and energy != "none":
        _fair(patches, points, triangles, energy, rounds, progress)
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
    )


def _fair(patches: Patches, points: Floats, faces: Ints, energy: Energy, rounds: int, progress: Progress) -> None:
    for done in range(rounds):

        def partial(share: float, done: int = done) -> None:
            progress(_TRIANGULATION + (1.0 - _TRIANGULATION) * (done + share) / rounds)

        if done > 0:
            patches.refine_again(energy != "membrane")
        new_vertices, new_faces, _, _ = patches.gathered()
        if len(new_vertices) == 0:
            return
        free = np.arange(len(points) + len(new_vertices)) >= len(points)
        everything = np.concatenate([points, new_vertices])
        faired = fair_region(everything, np.concatenate([faces, new_faces]), free, energy=energy, progress=partial)
        patches.move(faired.vertices[len(points) :])


def _sorted_out(
    rims: list[Rim], is_outer: list[bool], points: Floats, max_edges: int, selected: Bools
) -> tuple[list[Rim], list[Rim], list[OpenRim]]:
    """The rims of holes to close, the outer borders, and the others with the reason."""
    holes, outer, unwanted = [], [], []
    for rim, outside in zip(rims, is_outer, strict=True):
        if len(rim.vertices) > max_edges:
            unwanted.append(_left(rim, "size", f", more than {max_edges}"))
        elif is_seam(rim, points):
            unwanted.append(_left(rim, "seam"))
        elif outside:
            outer.append(rim)
        elif not selected[rim.vertices].any():
            unwanted.append(_left(rim, "selection"))
        else:
            holes.append(rim)
    return holes, outer, unwanted


_WHY: dict[Reason, str] = {
    "size": "",
    "selection": ", none of whose vertices is selected",
    "outer": ": it is the outer border of an open sheet",
    "island": ": it is the border of an island that no triangulation joins to the hole around it",
    "seam": ": its two sides are in the same places, so merge close vertices",
    "no_triangulation": ": every triangulation of it would have triangles without area, as where its vertices coincide or lie "
    "on a line, or edges with more than two faces",
}


def _left(rim: Rim, reason: Reason, more: str = "") -> OpenRim:
    edges = len(rim.vertices)
    return OpenRim(
        rim.vertices, reason, f"the rim of {edges} edges through vertex {rim.vertices[0]} was left{more}{_WHY[reason]}"
    )


def _check_choice(name: str, value: object, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise FilterInputError(f"{name} {value!r} is not one of {', '.join(map(repr, allowed))}")


def _check_least(name: str, value: int, least: int) -> None:
    if value != int(value) or value < least:
        raise FilterInputError(f"{name} is {value}: it is a whole number of at least {least}")


def _check_selected(selected: ArrayLike | None, n_vertices: int) -> Bools:
    if selected is None:
        return np.ones(n_vertices, dtype=np.bool_)
    mask = np.asarray(selected)
    if mask.dtype != np.bool_ or mask.shape != (n_vertices,):
        raise FilterInputError(
            f"selected must be a boolean array of {n_vertices} values, one a vertex, got shape {mask.shape} of {mask.dtype}"
        )
    return mask
