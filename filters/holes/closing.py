"""Hole filling in the three steps of [liepa2003]: rims triangulated, patches refined to the density of the rim, then faired."""

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice, check_whole_number
from ..execution import Progress, ignore_progress, part_of, rising
from ..fairing.region import ENERGIES, Energy, fair_region
from ..geometry import angles_between, cross_products
from ..mesh import Bools, Floats, Ints, Longs, check_mesh, check_vertex_mask, mask_of, scaled_to_unit
from ..topology import BoundaryLoop, border_vertices, boundary_loops, connected_components, face_adjacency, one_rings
from .refinement import MOST_VERTICES, ForbiddenEdges, Patch, refined_patch, uniform_width
from .rims import ISLAND_IN_IT, MOST_JOINED, OpenRim, broken_left_open, left_open_as, sorted_rims
from .triangulation import joined_corners, polygon, triangulate_polygon, vertex_pairs

#: How new vertices are placed: by `fair_region` with this energy, or for "none" by refinement. From the lowest order on.
HoleEnergy: TypeAlias = Literal["none", "membrane", "thin_plate", "minimum_variation"]
HOLE_ENERGIES: tuple[HoleEnergy, ...] = get_args(HoleEnergy)
# The shares of the progress that triangulation takes, of all and of a refined patch.
_TRIANGULATION, _PATCH_TRIANGULATION = 0.4, 0.3
#: A hole at whose rim the surface bends by more than this many times as much as around gets edges down to this share.
SHARP, FINEST = 1.2, 0.25
#: The most new vertices of patches that are solved for together.
MOST_AT_ONCE = 100_000
#: The largest distance of new vertices from the box of their rim, in diagonals of that box. Fillings of smooth surfaces reach
#: 0.2. One that goes further is not the lost surface, and refining it would take triangles for all that area.
FURTHEST = 1.0
#: The most edges of the rim of a region that is remeshed.
LARGEST_RIM = 10_000


class HoleFilling(NamedTuple):
    """Vertices and faces that close the holes of a mesh of n vertices and m faces.

    The closed mesh is ``np.concatenate([vertices, new_vertices])`` and ``np.concatenate([faces, new_faces])``.
    """

    new_vertices: Floats  # (a, 3)
    new_faces: Ints  # (b, 3) oriented as the faces around; indices from n on mean `new_vertices`
    hole_of_face: Ints  # (b,) ascending, the index in `closed` of the hole that each new face closes
    hole_of_vertex: Ints  # (a,) ascending, the same of each new vertex
    closed: tuple[Ints, ...]  # of every closed hole (k,) the vertices of its rim in order, in the direction of the new faces
    islands: tuple[Ints, ...]  # of every closed hole (k,) the vertices of the rims of islands that its faces join; mostly none
    left_open: tuple[OpenRim, ...]  # the other rims, and why they were left
    # of every closed hole the energy that placed its new vertices: `energy`, or if its equations are too ill-conditioned or throw
    # the filling out, the highest lower one that does not, or "none"
    energies: tuple[HoleEnergy, ...]
    thrown_out: tuple[bool, ...]  # whether a higher energy would have put them further than `FURTHEST` from the box of the rim


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
    at the rim (`refined_patch`), and the new vertices are placed by `fair_region`; refinement and fairing alternate, since
    fairing depends on the triangulation, which each round makes more regular. Where the surface then bends more than `SHARP`
    times as much at the rim as around it, edges get shorter: a narrow hole between sides that do not match needs more of them to
    be smooth. Fillings of more than `MOST_VERTICES` get larger triangles away from the rim, so that time and memory grow with the
    rim alone. One that an energy would throw out of its rim by more than `FURTHEST`, as beside a spike, is placed by the next
    lower energy.

    The closed mesh is a manifold where the mesh was one, and oriented like it. Outer borders of open sheets are no holes and stay
    open, of any size (`outer_borders`): the cap of a ball up to 109 degrees from its pole has one, a ball of which less is
    missing has a hole, a tube longer than three quarters of its width has two. `selected` closes those that are outer borders by
    their area alone. A sheet that lies in a hole without touching its rim is an island, which the new faces join.

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
    original, triangles = check_mesh(vertices, faces)
    check_choice("energy", energy, HOLE_ENERGIES)
    check_choice("islands", islands, ("join", "leave"))
    check_whole_number("max_edges", max_edges, least=3)
    check_whole_number("rounds", rounds, least=1)
    selection = None if selected is None else check_vertex_mask("selected", selected, len(original))
    points, scale = scaled_to_unit(np.where(mask_of(triangles, len(original))[:, None], original, 0.0))
    forwards = rising(progress)  # work that is repeated in another way counts again
    rims, broken = boundary_loops(points, triangles)
    holes, others = sorted_rims(rims, points, triangles, max_edges, selection, islands == "join")
    left_open = [*map(broken_left_open, broken), *others]
    patches = Patches(points, triangles, rims)
    closed, with_islands = [], []
    for k, (hole, inside) in enumerate(holes):
        partial = part_of(forwards, _TRIANGULATION * k / len(holes), _TRIANGULATION * (k + 1) / len(holes))
        too_many = bool(inside) and sum(len(rim.vertices) for rim in (hole, *inside)) > max(MOST_JOINED, max_edges)
        if not too_many and patches.add(hole, inside, refine, partial):
            closed.append(hole.vertices)
            with_islands.append(np.concatenate([np.empty(0, dtype=np.int32), *(rim.vertices for rim in inside)]))
        elif inside:
            left_open += [left_open_as(hole, "island", ISLAND_IN_IT), *(left_open_as(rim, "island") for rim in inside)]
        else:
            left_open.append(left_open_as(hole, "no_triangulation"))
    energies: list[HoleEnergy] = ["none"] * len(closed)
    thrown_out = [False] * len(closed)
    if refine and energy != "none":
        energies, thrown_out = patches.fair(energy, rounds, part_of(forwards, _TRIANGULATION, 1.0))
    new_vertices, new_faces, hole_of_vertex, hole_of_face = patches.gathered()
    left_open.sort(key=lambda rim: int(rim.vertices.min()))
    progress(1.0)
    of_holes = tuple(closed), tuple(with_islands), tuple(left_open), tuple(energies), tuple(thrown_out)
    return HoleFilling(new_vertices / scale, new_faces, hole_of_face, hole_of_vertex, *of_holes)


class _PlacedPatch(NamedTuple):
    """A patch with its place in the mesh."""

    own: Ints  # (k,) the vertices of the mesh on its rim, ascending: the first k points of the patch
    patch: Patch
    forbidden: ForbiddenEdges  # which of them it must not join
    uniform: float  # the width of the band at the rim with triangles as small as there, in edges
    sides: Longs  # (s, 2) the edges of the mesh at the rim, in the direction of the patch, by numbers of its points
    normals: Floats  # (s, 3) of the faces of the mesh there, of any length
    bend: float  # the mean angle between the faces at the edges of the mesh around it, in radians
    share: float  # the target length of its edges as a share of the edges around


class Patches:
    """A mesh, of which some rims may be closed, and the patches that close its holes so far."""

    def __init__(self, points: Floats, faces: Ints, rims: list[BoundaryLoop]) -> None:
        self._points, self._faces = points, faces
        self._rings = one_rings(faces, len(points))
        met = np.zeros(len(points), dtype=np.int32)
        for rim in rims:
            met[np.unique(rim.vertices)] += 1
        self._shared = met > 1
        self._bends = bends_around(points, faces, met > 0)
        self._links: dict[int, list[int]] = {}  # by edges of patches between vertices that several holes share
        self._placed: list[_PlacedPatch] = []

    def add(self, rim: BoundaryLoop, islands: list[BoundaryLoop], refine: bool, progress: Progress) -> bool:
        """Triangulate and refine a hole with the islands in it; False, and nothing is added, if there is no triangulation."""
        triangulating = part_of(progress, 0.0, _PATCH_TRIANGULATION if refine else 1.0)
        outline = polygon(rim, islands, self._points)
        own, first = np.unique(outline.vertices, return_index=True)
        rings = [self._rings.neighbours[slice(*self._rings.offsets[v : v + 2])] for v in own]
        joined = joined_corners(
            outline.vertices, [[*ring, *self._links.get(v, ())] for v, ring in zip(own.tolist(), rings, strict=True)]
        )
        is_a_face = len(outline.vertices) == 3 and outline.opposite[0] == outline.vertices[2]  # in the other orientation
        triangles = None if is_a_face else triangulate_polygon(outline, self._points, joined, triangulating)
        if triangles is None and refine and len(rim.vertices) > 3:
            # Here diagonals may double edges of the mesh, since refinement splits such diagonals.
            triangles = triangulate_polygon(outline, self._points, vertex_pairs(joined.size), triangulating)
        if triangles is None:
            return False
        points = self._points[own]
        sizes = np.array([np.linalg.norm(self._points[ring] - p, axis=1).mean() for ring, p in zip(rings, points, strict=True)])
        patch = Patch(points, sizes, np.searchsorted(own, triangles).astype(np.int32), len(own))
        alone = np.zeros(len(own), dtype=np.bool_)
        for loop in (rim, *islands):
            distinct, visits = np.unique(loop.vertices, return_counts=True)
            alone[np.searchsorted(own, distinct[visits > 1])] = True
        forbidden = ForbiddenEdges(joined.restricted(first.astype(np.int32)), np.zeros(len(own), dtype=np.bool_), alone)
        uniform = uniform_width(patch)
        if refine:
            refining = part_of(progress, _PATCH_TRIANGULATION, 1.0)
            patch = refined_patch(patch, forbidden=forbidden, uniform=uniform, progress=refining)
            # Another hole with the same two vertices may join them later, so no flip of this one may.
            forbidden = forbidden._replace(apart=self._shared[own])
        faces = np.column_stack([outline.vertices, np.roll(outline.vertices, -1), outline.opposite])[outline.opposite >= 0]
        sides, normals = np.searchsorted(own, faces[:, :2]), -cross_products(self._points, faces)
        bend = float(self._bends[0][own].sum() / max(self._bends[1][own].sum(), 1.0))
        self._placed.append(_PlacedPatch(own, patch, forbidden, uniform, sides, normals, bend, 1.0))
        # Patches of other holes that share vertices must not repeat its edges between them.
        corners = own[np.where(patch.triangles < len(own), patch.triangles, 0)]
        shared = (patch.triangles < len(own)) & self._shared[corners]
        for k in range(3):
            both = shared[:, k] & shared[:, k - 1]
            for i, j in corners[both][:, [k, k - 1]].tolist():
                self._links.setdefault(i, []).append(j)
                self._links.setdefault(j, []).append(i)
        return True

    def fair(self, energy: HoleEnergy, rounds: int, progress: Progress) -> tuple[list[HoleEnergy], list[bool]]:
        """Fairs and refines the patches in turn; of each the energy that placed it last, and whether a higher one threw it out.

        Patches of one energy are solved for together, the highest first; a set that cannot be solved is halved until each cause
        stands alone. Such a patch, and one that leaves the box of its rim by more than `FURTHEST`, gets the next lower energy
        from then on.
        """
        energies, thrown_out = [energy] * len(self._placed), [False] * len(self._placed)
        for done in range(rounds):
            partial = part_of(progress, done / rounds, (done + 1) / rounds)
            if done > 0:
                self.refine_again(energy != "membrane", partial)
            for lower, level in zip(HOLE_ENERGIES[-2::-1], ENERGIES[::-1], strict=True):
                new, total = self._new_counts(), 0
                parts: list[list[int]] = []
                for k in (k for k, each in enumerate(energies) if each == level):
                    total += new[k]
                    if not parts or total > MOST_AT_ONCE:
                        parts.append([])
                        total = new[k]
                    parts[-1].append(k)
                for part in parts:
                    for k, far in self._place(part, level, partial).items():
                        energies[k], thrown_out[k] = lower, thrown_out[k] or far
        return energies, thrown_out

    def _place(self, group: list[int], energy: Energy, progress: Progress) -> dict[int, bool]:
        """Places the new vertices of these patches; returns those that failed, and whether they were thrown out."""
        new_vertices, new_faces, patch_of_vertex, _ = self.gathered()
        n = len(self._points)
        free = np.concatenate([np.zeros(n, dtype=np.bool_), np.isin(patch_of_vertex, group)])
        if not free.any():
            return {}
        everything, closed = np.concatenate([self._points, new_vertices]), np.concatenate([self._faces, new_faces])
        try:
            moved = fair_region(everything, closed, free, energy=energy, dense=True, progress=progress).vertices[n:]
        except (ConvergenceError, FilterInputError):
            if len(group) == 1:
                return {group[0]: False}
            half = len(group) // 2
            return self._place(group[:half], energy, progress) | self._place(group[half:], energy, progress)
        far = [k for k, new in enumerate(self._parts(moved)) if _reach(self._points[self._placed[k].own], new) > FURTHEST]
        if not far:
            self.move(moved)
            return {}
        # Where patches meet, one that is thrown out takes others along: they are placed without it.
        return dict.fromkeys(far, True) | self._place([k for k in group if k not in far], energy, progress)

    def refine_again(self, smooth: bool, progress: Progress) -> None:
        """Refine all patches with their current points; if `smooth`, more where the surface bends at the rim."""
        for k, placed in enumerate(self._placed):
            patch = placed.patch
            bend = bend_at_rim(patch, placed.sides, placed.normals)
            finer = np.clip(SHARP * placed.bend / bend, FINEST / placed.share, 1.0) if smooth and bend > 0.0 else 1.0
            finer = max(finer, min(1.0, float(np.sqrt(len(patch.points) / MOST_VERTICES))))
            patch = patch._replace(sizes=patch.sizes * finer)
            # A filling that bulges has a larger area than the one whose width was chosen.
            uniform = min(placed.uniform, uniform_width(patch))
            patch = refined_patch(patch, forbidden=placed.forbidden, uniform=uniform, progress=part_of(progress, 0.0, 0.0))
            self._placed[k] = placed._replace(patch=patch, uniform=uniform, share=placed.share * float(finer))

    def move(self, new_vertices: Floats) -> None:
        for k, (own, new) in enumerate(zip(self._placed, self._parts(new_vertices), strict=True)):
            points = np.concatenate([own.patch.points[: len(own.own)], new])
            self._placed[k] = own._replace(patch=own.patch._replace(points=points))

    def _parts(self, new_vertices: Floats) -> list[Floats]:
        return np.split(new_vertices, np.cumsum(self._new_counts())[:-1])

    def _new_counts(self) -> list[int]:
        return [len(placed.patch.points) - len(placed.own) for placed in self._placed]

    def gathered(self) -> tuple[Floats, Ints, Ints, Ints]:
        """The new vertices, the new faces, and the index of the patch of each of these vertices and faces."""
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int32)]
        counts, total = self._new_counts(), len(self._points)
        for (own, patch, *_), more in zip(self._placed, counts, strict=True):
            numbers = np.concatenate([own, np.arange(total, total + more, dtype=np.int32)]).astype(np.int32)
            vertices.append(patch.points[len(own) :])
            faces.append(numbers[patch.triangles])
            total += more
        holes = np.arange(len(counts), dtype=np.int32)
        sizes = [len(part) for part in faces[1:]]
        return np.concatenate(vertices), np.concatenate(faces), np.repeat(holes, counts), np.repeat(holes, sizes)


def _reach(rim: Floats, new: Floats) -> float:
    """The distance by which new vertices leave the box of their rim, in diagonals of that box."""
    low, high = rim.min(axis=0), rim.max(axis=0)
    outside = np.linalg.norm(np.maximum(np.maximum(low - new, new - high), 0.0), axis=1)
    return float(outside.max(initial=0.0)) / (float(np.linalg.norm(high - low)) or 1.0)


def bends_around(points: Floats, faces: Ints, marked: Bools) -> tuple[Floats, Floats]:
    """(n,) the sum and (n,) the number of the angles between the two faces of each edge at the (n,) `marked` vertices."""
    n = len(points)
    near = faces[marked[faces].any(axis=1)]
    pairs, shared = face_adjacency(near)
    pairs, shared = pairs[marked[shared].any(axis=1)], shared[marked[shared].any(axis=1)]
    normals = cross_products(points, near)
    angles = angles_between(normals[pairs[:, 0]], normals[pairs[:, 1]])
    total = np.asarray(np.bincount(shared.T.ravel(), np.tile(angles, 2), n), dtype=np.float64)
    return total, np.asarray(np.bincount(shared.ravel(), minlength=n), dtype=np.float64)


def bend_at_rim(patch: Patch, sides: Longs, normals: Floats) -> float:
    """The mean angle between the normals of the patch and of the mesh along the rim, in radians; see `_PlacedPatch`."""
    n, triangles = len(patch.points), patch.triangles
    keys = (triangles * np.int64(n) + np.roll(triangles, -1, axis=1)).ravel()
    order = np.argsort(keys)
    inside = triangles[order[np.searchsorted(keys[order], sides[:, 0] * n + sides[:, 1])] // 3]
    return float(angles_between(cross_products(patch.points, inside), normals).mean())


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
    n = len(points)
    border = border_vertices(triangles, n)
    labels, _ = connected_components(triangles, n)
    used = labels >= 0  # not by triangles alone that name a vertex twice
    chosen = check_vertex_mask("region", region, n) & ~mask_of(triangles[border[triangles].any(axis=1)], n) & used
    if not chosen.any():
        raise FilterInputError(
            "nothing can be remade: all of the region lies at an open border, whose triangles stay, or has no triangle"
        )
    if not np.isin(labels[chosen], labels[used & ~chosen]).all():
        raise FilterInputError("a whole component is selected, so that its place is undetermined: select less")
    gone = chosen[triangles].any(axis=1)
    rim = mask_of(triangles[gone], n) & ~chosen & ~border
    filling = close_holes(
        points,
        triangles[~gone],
        max_edges=LARGEST_RIM,
        energy=energy,
        rounds=rounds,
        selected=rim if rim.any() else None,
        progress=progress,
    )
    for left in filling.left_open:
        if left.reason != "selection" and rim[left.vertices].any():
            raise FilterInputError(f"the region cannot be remade: {left.message}; select a ring more or less")
    return chosen, filling
