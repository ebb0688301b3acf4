"""Hole filling in the three steps of [liepa2003]: rims triangulated, patches refined to the density of the rim, then faired."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice, check_whole_number
from ..execution import Progress, ignore_progress, part_of, rising
from ..fairing.region import ENERGIES, Energy, fair_region
from ..geometry import angles_between, cross_products
from ..mesh import Floats, Ints, check_mesh, check_vertex_mask, mask_of, scaled_to_unit
from ..topology import BoundaryLoop, OneRings, boundary_loops, face_adjacency, one_rings
from .filling import HOLE_ENERGIES, ISLAND_IN_IT, HoleEnergy, HoleFilling, broken_left_open, left_open_as
from .refinement import MOST_VERTICES, Patch, refined_patch, uniform_width
from .rims import MOST_JOINED, sorted_rims
from .triangulation import joined_corners, polygon, triangulate_polygon
from .vertex_pairs import ForbiddenEdges, vertex_pairs

# The share of the progress that triangulation takes.
_TRIANGULATION = 0.4
#: A hole at whose rim the surface bends by more than this many times as much as around it is refined further.
SHARP = 1.2
#: The least share to which its edges are shortened.
FINEST = 0.25
# The share of the progress of a refined patch that triangulation takes.
_PATCH_TRIANGULATION = 0.3
#: The most new vertices of patches that are solved for together.
MOST_AT_ONCE = 100_000
#: The largest distance of new vertices from the box of their rim, in diagonals of that box. Fillings of smooth surfaces reach
#: 0.2. One that goes further is not the lost surface, and refining it would take triangles for all that area.
FURTHEST = 1.0


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
    open, of any size (`outer_borders`): rims with a total geodesic curvature above 1.5 pi, and, unless `selected` contains
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
    original, triangles = check_mesh(vertices, faces)
    check_choice("energy", energy, HOLE_ENERGIES)
    check_choice("islands", islands, ("join", "leave"))
    check_whole_number("max_edges", max_edges, least=3)
    check_whole_number("rounds", rounds, least=1)
    selection = None if selected is None else check_vertex_mask("selected", selected, len(original))
    points, scale = scaled_to_unit(np.where(mask_of(triangles, len(original))[:, None], original, 0.0))
    forwards = rising(progress)  # work that is repeated in another way counts again
    rims, broken = boundary_loops(points, triangles)
    holes, inside, others = sorted_rims(rims, points, triangles, max_edges, selection, islands)
    left_open = [*map(broken_left_open, broken), *others]
    patches = Patches(points, triangles, rims)
    closed, with_islands = [], []
    for k, (hole, group) in enumerate(zip(holes, inside, strict=True)):
        partial = part_of(forwards, _TRIANGULATION * k / len(holes), _TRIANGULATION * (k + 1) / len(holes))
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
        rest = part_of(forwards, _TRIANGULATION, 1.0)
        placements = fair_patches(patches, points, triangles, energy=energy, rounds=rounds, progress=rest)
    new_vertices, new_faces, hole_of_vertex, hole_of_face = patches.gathered()
    left_open.sort(key=lambda rim: int(rim.vertices.min()))
    progress(1.0)
    return HoleFilling(
        new_vertices / scale,
        new_faces,
        hole_of_face,
        hole_of_vertex,
        tuple(closed),
        tuple(with_islands),
        tuple(left_open),
        tuple(p.energy for p in placements),
        tuple(p.thrown_out for p in placements),
    )


class _PlacedPatch(NamedTuple):
    """A patch with its place in the mesh."""

    own: Ints  # (k,) the vertices of the mesh on its rim, ascending
    patch: Patch  # the patch; its first k points are these vertices
    forbidden: ForbiddenEdges  # which of them it must not join
    uniform: float  # the width of the band at the rim with triangles as small as there, in edges
    # (s, 3) the edges of the rim as for `bend_at_rim`: two numbers of points of the patch, and the index of the third vertex in
    # `around`
    sides: Ints
    around: Floats  # (s, 3) coordinates of the third vertices of the faces of the mesh at the rim
    bend: float  # the mean angle between the faces at the edges of the mesh around it, in radians
    share: float  # the target length of its edges as a share of the edges around


class Patches:
    """A mesh and the patches that close its holes so far."""

    def __init__(self, points: Floats, faces: Ints, rims: list[BoundaryLoop]) -> None:
        """No patches yet, for a mesh of which these rims may be closed."""
        self._points = points
        self._rings: OneRings = one_rings(faces, len(points))
        met = np.zeros(len(points), dtype=np.int32)
        for rim in rims:
            met[np.unique(rim.vertices)] += 1
        self._shared = met > 1
        self._bends = bends_around(points, faces, np.flatnonzero(met).astype(np.int32))
        self._links: dict[int, set[int]] = {}
        self._placed: list[_PlacedPatch] = []

    @property
    def count(self) -> int:
        """The number of patches."""
        return len(self._placed)

    def add(self, rim: BoundaryLoop, islands: list[BoundaryLoop], refine: bool, progress: Progress) -> bool:
        """Triangulate and refine a hole with the islands in it; False, and nothing is added, if there is no triangulation."""
        triangulating = part_of(progress, 0.0, _PATCH_TRIANGULATION if refine else 1.0)
        outline = polygon(rim, islands, self._points)
        joined = joined_corners(outline.vertices, self._rings, self._links)
        is_a_face = len(outline.vertices) == 3 and outline.opposite[0] == outline.vertices[2]  # in the other orientation
        triangles = None if is_a_face else triangulate_polygon(outline, self._points, joined, triangulating)
        if triangles is None and refine and len(rim.vertices) > 3:
            # Here diagonals may double edges of the mesh, since refinement splits such diagonals.
            triangles = triangulate_polygon(outline, self._points, vertex_pairs(joined.size), triangulating)
        if triangles is None:
            return False
        own, first = np.unique(outline.vertices, return_index=True)
        patch = Patch(self._points[own], self._lengths(own), np.searchsorted(own, triangles).astype(np.int32), len(own))
        alone = np.zeros(len(own), dtype=np.bool_)
        for loop in (rim, *islands):
            distinct, visits = np.unique(loop.vertices, return_counts=True)
            alone[np.searchsorted(own, distinct[visits > 1])] = True
        forbidden = ForbiddenEdges(joined.restricted(first.astype(np.int32)), np.zeros(len(own), dtype=np.bool_), alone)
        uniform = uniform_width(patch)
        if refine:
            patch = refined_patch(
                patch, forbidden=forbidden, uniform=uniform, progress=part_of(progress, _PATCH_TRIANGULATION, 1.0)
            )
            # Another hole with the same two vertices may join them later, so no flip of this one may.
            forbidden = forbidden._replace(apart=self._shared[own])
        at_mesh = outline.opposite >= 0
        starts, ends = np.searchsorted(own, outline.vertices), np.searchsorted(own, np.roll(outline.vertices, -1))
        sides = np.column_stack([starts, ends, np.cumsum(at_mesh) - 1])[at_mesh].astype(np.int32)
        bend = float(self._bends[0][own].sum() / max(self._bends[1][own].sum(), 1.0))
        around = self._points[outline.opposite[at_mesh]]
        self._placed.append(_PlacedPatch(own, patch, forbidden, uniform, sides, around, bend, 1.0))
        self._record_links(own, patch)
        return True

    def refine_again(self, smooth: bool, progress: Progress) -> None:
        """Refine all patches with their current points; if `smooth`, more where the surface bends at the rim.

        `progress` is called now and then with a share of 0, and may raise to stop.
        """
        for k, placed in enumerate(self._placed):
            patch = placed.patch
            everything = np.concatenate([patch.points, placed.around])
            sides = placed.sides + np.array([0, 0, len(patch.points)], dtype=np.int32)
            bend = bend_at_rim(everything, patch.triangles, sides)
            finer = np.clip(SHARP * placed.bend / bend, FINEST / placed.share, 1.0) if smooth and bend > 0.0 else 1.0
            finer = max(finer, min(1.0, float(np.sqrt(len(patch.points) / MOST_VERTICES))))
            patch = patch._replace(sizes=patch.sizes * finer)
            # A filling that bulges has a larger area than the one whose width was chosen.
            uniform = min(placed.uniform, uniform_width(patch))
            patch = refined_patch(patch, forbidden=placed.forbidden, uniform=uniform, progress=part_of(progress, 0.0, 0.0))
            self._placed[k] = placed._replace(patch=patch, uniform=uniform, share=placed.share * float(finer))

    def reach(self, new_vertices: Floats) -> Floats:
        """(count,) the distance by which each patch leaves the box of its rim, in diagonals of that box.

        `new_vertices` are coordinates of the new vertices, in the order of `gathered`.
        """
        distances = np.zeros(self.count)
        for k, (rim, new) in enumerate(self._rims_and(new_vertices)):
            low, high = rim.min(axis=0), rim.max(axis=0)
            outside = np.linalg.norm(np.maximum(np.maximum(low - new, new - high), 0.0), axis=1)
            distances[k] = outside.max(initial=0.0) / (float(np.linalg.norm(high - low)) or 1.0)
        return distances

    def move(self, new_vertices: Floats) -> None:
        """Set the coordinates of the new vertices, in the order of `gathered`."""
        for k, points in enumerate(self._rims_and(new_vertices)):
            self._placed[k] = self._placed[k]._replace(patch=self._placed[k].patch._replace(points=np.concatenate(points)))

    def _rims_and(self, new_vertices: Floats) -> list[tuple[Floats, Floats]]:
        """The points of each patch: its rim, and its part of the new vertices."""
        patches = [placed.patch for placed in self._placed]
        parts = np.split(new_vertices, np.cumsum([len(patch.points) - patch.n_rim for patch in patches])[:-1])
        return [(patch.points[: patch.n_rim], new) for patch, new in zip(patches, parts, strict=True)]

    def gathered(self) -> tuple[Floats, Ints, Ints, Ints]:
        """The new vertices, the new faces, and the index of the patch of each of these vertices and faces."""
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int32)]
        total = len(self._points)
        for own, patch, *_ in self._placed:
            more = len(patch.points) - len(own)
            numbers = np.concatenate([own, np.arange(total, total + more, dtype=np.int32)]).astype(np.int32)
            vertices.append(patch.points[len(own) :])
            faces.append(numbers[patch.triangles])
            total += more
        holes = np.arange(len(self._placed), dtype=np.int32)
        return (
            np.concatenate(vertices),
            np.concatenate(faces),
            np.repeat(holes, [len(part) for part in vertices[1:]]),
            np.repeat(holes, [len(part) for part in faces[1:]]),
        )

    def _lengths(self, own: Ints) -> Floats:
        """(k,) the mean length of the edges of the mesh at each of the vertices."""
        lengths = np.empty(len(own))
        for i, v in enumerate(own.tolist()):
            ends = self._rings.neighbours[self._rings.offsets[v] : self._rings.offsets[v + 1]]
            lengths[i] = np.linalg.norm(self._points[ends] - self._points[v], axis=1).mean()
        return lengths

    def _record_links(self, own: Ints, patch: Patch) -> None:
        """Record the edges of the patch between vertices that other holes share, so that their patches do not repeat them."""
        shared = np.concatenate([self._shared[own], np.zeros(len(patch.points) - len(own), dtype=np.bool_)])
        for k in range(3):
            a, b = patch.triangles[:, k], patch.triangles[:, (k + 1) % 3]
            both = shared[a] & shared[b]
            for i, j in zip(own[a[both]].tolist(), own[b[both]].tolist(), strict=True):
                self._links.setdefault(i, set()).add(j)
                self._links.setdefault(j, set()).add(i)


class Placement(NamedTuple):
    """The placement of the new vertices of a patch."""

    energy: HoleEnergy  # the energy that placed them
    thrown_out: bool  # whether a higher one would have put them further than `FURTHEST` outside of the box of the rim


def fair_patches(
    patches: Patches, points: Floats, faces: Ints, *, energy: HoleEnergy, rounds: int, progress: Progress
) -> list[Placement]:
    """Fairs and refines the patches in turn, and moves their new vertices; the last placement of each patch.

    All patches of one energy are solved for together, the highest energy first. If their equations cannot be solved, the set is
    halved until each patch that causes it stands alone. Such a patch gets the next lower energy, in this round and all later
    ones, and so does one that leaves the box of its rim by more than `FURTHEST`. The last energy, "none", leaves vertices among
    those around. The progress falls where patches are solved for again.
    """
    placements = [Placement(energy, False)] * patches.count
    for done in range(rounds):
        partial = part_of(progress, done / rounds, (done + 1) / rounds)
        if done > 0:
            patches.refine_again(energy != "membrane", partial)
        for lower, level in zip(HOLE_ENERGIES[-2::-1], ENERGIES[::-1], strict=True):
            group = [k for k in range(patches.count) if placements[k].energy == level]
            for part in _parts(patches, group):
                for k, thrown_out in _place(patches, points, faces, part, level, partial).items():
                    placements[k] = Placement(lower, placements[k].thrown_out or thrown_out)
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


def _place(
    patches: Patches, points: Floats, faces: Ints, group: list[int], energy: Energy, progress: Progress
) -> dict[int, bool]:
    """Places the new vertices of these patches; returns those that failed, and whether they were thrown out."""
    new_vertices, new_faces, patch_of_vertex, _ = patches.gathered()
    free = np.concatenate([np.zeros(len(points), dtype=np.bool_), np.isin(patch_of_vertex, group)])
    if not free.any():
        return {}
    everything, closed = np.concatenate([points, new_vertices]), np.concatenate([faces, new_faces])
    try:
        faired = fair_region(everything, closed, free, energy=energy, dense=True, progress=progress)
    except (ConvergenceError, FilterInputError):
        pass
    else:
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


def bends_around(points: Floats, faces: Ints, at: Ints) -> tuple[Floats, Floats]:
    """The angles between the normals of the two faces of every edge, summed at its ends.

    Args:
        points: (n, 3) the vertices of the mesh.
        faces: (m, 3) its triangles.
        at: (k,) vertices; the sums of all others may be incomplete.

    Returns:
        (n,) the sums in radians, and (n,) how many angles each sums up.
    """
    n = len(points)
    marked = mask_of(at, n)
    near = faces[marked[faces].any(axis=1)]
    pairs, shared = face_adjacency(near)
    pairs, shared = pairs[marked[shared].any(axis=1)], shared[marked[shared].any(axis=1)]
    normals = cross_products(points, near)
    angles = angles_between(normals[pairs[:, 0]], normals[pairs[:, 1]])
    total = np.asarray(np.bincount(shared.T.ravel(), np.tile(angles, 2), n), dtype=np.float64)
    return total, np.asarray(np.bincount(shared.ravel(), minlength=n), dtype=np.float64)


def bend_at_rim(points: Floats, triangles: Ints, sides: Ints) -> float:
    """The mean angle between the normals of the patch and of the mesh along the rim, in radians.

    Args:
        points: (n, 3) the vertices of the patch and of the faces around it.
        triangles: (b, 3) the patch.
        sides: (k, 3) for every edge of the rim its start, its end in the direction of the patch, and the third vertex of the
            face of the mesh.
    """
    n = len(points)
    keys = np.concatenate([triangles[:, k].astype(np.int64) * n + triangles[:, (k + 1) % 3] for k in range(3)])
    order = np.argsort(keys, kind="stable")
    inside = triangles[order[np.searchsorted(keys[order], sides[:, 0].astype(np.int64) * n + sides[:, 1])] % len(triangles)]
    return float(angles_between(cross_products(points, inside), -cross_products(points, sides)).mean())
