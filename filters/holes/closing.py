"""Hole filling in three steps [liepa2003]: triangulate each rim, refine the patch to the density of its rim, fair it."""

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice, check_whole_number
from ..execution import Progress, ignore_progress, part_of, rising
from ..fairing.region import ENERGIES, Energy, fair_region
from ..geometry import angles_between, cross_products
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, Longs, check_mesh, check_vertex_mask, mask_of, scaled_to_unit
from ..topology import BoundaryLoop, border_vertices, boundary_loops, connected_components, face_adjacency, one_rings
from .refinement import MOST_VERTICES, ForbiddenEdges, Patch, refined_patch, uniform_width
from .rims import ISLAND_IN_IT, MOST_JOINED, OpenRim, broken_left_open, left_open_as, sorted_rims
from .triangulation import joined_corners, polygon, triangulate_polygon, vertex_pairs

#: The energies that `fair_region` may minimise to place new vertices, from low to high; "none" leaves the vertices in place.
HoleEnergy: TypeAlias = Literal["none", "membrane", "thin_plate", "minimum_variation"]
HOLE_ENERGIES: tuple[HoleEnergy, ...] = get_args(HoleEnergy)
# The share of the first patches in the progress of `close_holes`, and of triangulation in the progress of one refined patch.
_TRIANGULATION, _PATCH_TRIANGULATION = 0.4, 0.3
#: If a patch bends more than `SHARP` times as much at its rim as the mesh, its edges shrink, not below `FINEST` of their length.
SHARP, FINEST = 1.2, 0.25
#: The most new vertices in one linear system; patches are grouped up to this number.
MOST_AT_ONCE = 100_000
#: The largest distance of new vertices from the bounding box of their rim, in diagonals of the box. Patches of smooth surfaces
#: reach 0.2. A patch beyond 1 does not resemble the original surface, and its large area would need many triangles.
FURTHEST = 1.0
#: The most edges in the rim of a remeshed region.
LARGEST_RIM = 10_000


class HoleFilling(NamedTuple):
    """Vertices and faces to append to a mesh of n vertices, so that its holes are closed."""

    new_vertices: Floats  # (a, 3)
    new_faces: Ints  # (b, 3) oriented like the adjacent faces; indices from n on mean `new_vertices`
    hole_of_face: Ints  # (b,) ascending, the hole of each new face as an index in `closed`
    hole_of_vertex: Ints  # (a,) ascending, the hole of each new vertex
    closed: tuple[Ints, ...]  # for each closed hole (k,) its rim vertices in order, in the direction of the new faces
    islands: tuple[Ints, ...]  # for each closed hole (k,) the rim vertices of islands that the new faces join; usually empty
    left_open: tuple[OpenRim, ...]  # the other rims, with the reason
    # for each closed hole the energy that placed its new vertices: `energy`, or the next lower one if the equations are too
    # ill-conditioned or the patch leaves the box of its rim by more than `FURTHEST`; "none" if all fail or without `refine`
    energies: tuple[HoleEnergy, ...]
    thrown_out: tuple[bool, ...]  # for each closed hole whether an energy was rejected because of `FURTHEST`


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
    """Closes the holes with up to `max_edges` border edges [liepa2003].

    `triangulate_rim` triangulates each rim. `refined_patch` splits the triangles and flips their edges until they are as small as
    the triangles at the rim. `fair_region` places the new vertices. Refinement and fairing alternate: fairing depends on the
    triangulation, and each round makes it more regular. Unless `energy` is "membrane", if a patch bends more than `SHARP`
    times as much at its rim as the mesh around, its edges get shorter in the next round. A patch of more than `MOST_VERTICES`
    vertices gets larger triangles away from the rim, so that time and memory grow with the rim alone. If an energy moves new
    vertices out of the box of their rim by more than `FURTHEST`, the next lower energy places them.

    The closed mesh is manifold where the mesh was manifold, and has the same orientation. Outer borders of open sheets are not
    holes and stay open (`outer_borders`): a spherical cap up to 109 degrees from its pole has an outer border, a larger cap has a
    hole, a tube longer than three quarters of its width has two holes. An island is a sheet inside a hole, apart from the rim.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        max_edges: holes with more rim edges stay open; at least 3. Edges of islands do not count, but a hole stays open if its
            rim and islands together have more edges than the larger of `MOST_JOINED` and `max_edges`.
        energy: how the new vertices are placed. "membrane": the least area, with a crease at the rim. "thin_plate": tangents
            continue across the rim. "minimum_variation": curvatures continue too, and the patch bulges like the surface around;
            it is the closest to a smooth original surface, and the most sensitive to noise at the rim. "none": only refinement.
        refine: whether to split the new faces until they are as dense as the rim. Without it there are no new vertices.
        rounds: how often to refine and fair, at least 1. With more rounds a patch bulges further if the surface around bulges.
        islands: "join": new faces connect islands with the rim around; if that is impossible, the hole stays open. "leave":
            islands stay loose, and the new faces may intersect them.
        selected: (n,) bool: only holes with a selected rim vertex are closed. With a selected vertex, a rim that is only
            probably an outer border, see `outer_borders`, is closed too. None for all holes.
        progress: called with the completed share; may raise to stop.

    Returns:
        The vertices and faces to add. Deterministic.

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
    forwards = rising(progress)  # a repeated step reports its share again: progress must not fall
    rims, broken = boundary_loops(points, triangles)
    holes, others = sorted_rims(rims, points, triangles, max_edges, selection, islands == "join")
    left_open = [*map(broken_left_open, broken), *others]
    patches = Patches(points, triangles, rims)
    closed, with_islands = [], []
    for k, (hole, inside) in enumerate(holes):
        partial = part_of(forwards, _TRIANGULATION * k / len(holes), _TRIANGULATION * (k + 1) / len(holes))
        edges, most = sum(len(rim.vertices) for rim in (hole, *inside)), max(MOST_JOINED, max_edges)
        if edges <= most and patches.add(hole, inside, refine, partial):
            closed.append(hole.vertices)
            with_islands.append(np.concatenate([np.empty(0, dtype=np.int32), *(rim.vertices for rim in inside)]))
        elif inside:
            why = f" (the hole and its islands have {edges:,} edges, more than {most:,})" if edges > most else ""
            left_open += [left_open_as(hole, "island", ISLAND_IN_IT + why), *(left_open_as(rim, "island") for rim in inside)]
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
    rim: Ints  # (k,) the rim vertices by their index in the mesh, ascending: the first k points of the patch
    patch: Patch
    forbidden: ForbiddenEdges  # the edges between rim vertices that the patch must not have
    uniform: float  # the width, in edges, of the band along the rim that is as dense as the rim
    sides: Longs  # (s, 2) the rim edges in the direction of the patch, as indices of the patch's points
    normals: Floats  # (s, 3) normals of the mesh faces at the rim edges, of any length
    bend: float  # the mean dihedral angle of the mesh edges at the rim vertices, in radians
    share: float  # the target edge length of the patch over the edge length of the mesh around


class Patches:
    """A mesh with the patches that close its holes."""

    def __init__(self, points: Floats, faces: Ints, rims: list[BoundaryLoop]) -> None:
        self._points, self._faces = points, faces
        self._rings = one_rings(faces, len(points))
        rim_counts = np.zeros(len(points), dtype=np.int32)
        for rim in rims:
            rim_counts[np.unique(rim.vertices)] += 1
        self._shared = rim_counts > 1
        self._bends = bends_around(points, faces, rim_counts > 0)
        self._links: dict[int, list[int]] = {}  # adjacency by patch edges between vertices that several rims share
        self._placed: list[_PlacedPatch] = []

    def add(self, rim: BoundaryLoop, islands: list[BoundaryLoop], refine: bool, progress: Progress) -> bool:
        """Triangulates and refines a hole with its islands; returns False and adds nothing if there is no triangulation."""
        triangulating = part_of(progress, 0.0, _PATCH_TRIANGULATION if refine else 1.0)
        outline = polygon(rim, islands, self._points)
        rim_vertices, first = np.unique(outline.vertices, return_index=True)
        rings = [self._rings.neighbours[slice(*self._rings.offsets[v : v + 2])] for v in rim_vertices]
        joined = joined_corners(
            outline.vertices, [[*ring, *self._links.get(v, ())] for v, ring in zip(rim_vertices.tolist(), rings, strict=True)]
        )
        # A loop round a single face would be closed by the same face, turned over.
        is_a_face = len(outline.vertices) == 3 and outline.opposite[0] == outline.vertices[2]
        triangles = None if is_a_face else triangulate_polygon(outline, self._points, joined, triangulating)
        if triangles is None and refine and len(rim.vertices) > 3:
            # Diagonals may repeat edges of the mesh here, since refinement splits diagonals.
            triangles = triangulate_polygon(outline, self._points, vertex_pairs(joined.size), triangulating)
        if triangles is None:
            return False
        points = self._points[rim_vertices]
        sizes = np.array([np.linalg.norm(self._points[ring] - p, axis=1).mean() for ring, p in zip(rings, points, strict=True)])
        patch = Patch(points, sizes, np.searchsorted(rim_vertices, triangles).astype(np.int32), len(rim_vertices))
        alone = np.zeros(len(rim_vertices), dtype=np.bool_)
        for loop in (rim, *islands):
            distinct, visits = np.unique(loop.vertices, return_counts=True)
            alone[np.searchsorted(rim_vertices, distinct[visits > 1])] = True
        forbidden = ForbiddenEdges(joined.restricted(first.astype(np.int32)), np.zeros(len(rim_vertices), dtype=np.bool_), alone)
        uniform = uniform_width(patch)
        if refine:
            refining = part_of(progress, _PATCH_TRIANGULATION, 1.0)
            patch = refined_patch(patch, forbidden=forbidden, uniform=uniform, progress=refining)
            # Flips in later rounds must not join two shared vertices: the patch of another hole may have joined them by then.
            forbidden = forbidden._replace(apart=self._shared[rim_vertices])
        faces = np.column_stack([outline.vertices, np.roll(outline.vertices, -1), outline.opposite])[outline.opposite >= 0]
        sides, normals = np.searchsorted(rim_vertices, faces[:, :2]), -cross_products(self._points, faces)
        bend = float(self._bends[0][rim_vertices].sum() / max(self._bends[1][rim_vertices].sum(), 1.0))
        self._placed.append(_PlacedPatch(rim_vertices, patch, forbidden, uniform, sides, normals, bend, 1.0))
        # The patch of another hole must not repeat an edge between two shared vertices.
        corners = rim_vertices[np.where(patch.triangles < len(rim_vertices), patch.triangles, 0)]
        shared = (patch.triangles < len(rim_vertices)) & self._shared[corners]
        for k in range(3):
            both = shared[:, k] & shared[:, k - 1]
            for i, j in corners[both][:, [k, k - 1]].tolist():
                self._links.setdefault(i, []).append(j)
                self._links.setdefault(j, []).append(i)
        return True

    def fair(self, energy: HoleEnergy, rounds: int, progress: Progress) -> tuple[list[HoleEnergy], list[bool]]:
        """Fairs and refines in turn; returns the last energy of each patch, and whether `FURTHEST` rejected a higher energy.

        Patches with the same energy are solved together, the highest energy first. A group without a solution is halved until
        the failing patches are alone. A patch that fails or exceeds `FURTHEST` gets the next lower energy from then on.
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
                    for k, rejected in self._place(part, level, partial).items():
                        energies[k], thrown_out[k] = lower, thrown_out[k] or rejected
        return energies, thrown_out

    def _place(self, group: list[int], energy: Energy, progress: Progress) -> dict[int, bool]:
        """Places the new vertices of a group of patches; returns the failed patches, and whether `FURTHEST` rejected them."""
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
        rejected = [k for k, new in enumerate(self._parts(moved)) if _reach(self._points[self._placed[k].rim], new) > FURTHEST]
        if not rejected:
            self.move(moved)
            return {}
        # A rejected patch distorts the patches that meet it.
        return dict.fromkeys(rejected, True) | self._place([k for k in group if k not in rejected], energy, progress)

    def refine_again(self, smooth: bool, progress: Progress) -> None:
        """Refines all patches with their current points; if `smooth`, to shorter edges in patches that bend at their rim."""
        for k, placed in enumerate(self._placed):
            patch = placed.patch
            bend = bend_at_rim(patch, placed.sides, placed.normals)
            finer = np.clip(SHARP * placed.bend / bend, FINEST / placed.share, 1.0) if smooth and bend > 0.0 else 1.0
            finer = max(finer, min(1.0, float(np.sqrt(len(patch.points) / MOST_VERTICES))))
            patch = patch._replace(sizes=patch.sizes * finer)
            # A patch that bulges has a larger area, so its band may have to be narrower.
            uniform = min(placed.uniform, uniform_width(patch))
            patch = refined_patch(patch, forbidden=placed.forbidden, uniform=uniform, progress=part_of(progress, 0.0, 0.0))
            self._placed[k] = placed._replace(patch=patch, uniform=uniform, share=placed.share * float(finer))

    def move(self, new_vertices: Floats) -> None:
        """Moves the new vertices of all patches; (a, 3) in the order of `gathered`."""
        for k, (placed, new) in enumerate(zip(self._placed, self._parts(new_vertices), strict=True)):
            points = np.concatenate([placed.patch.points[: len(placed.rim)], new])
            self._placed[k] = placed._replace(patch=placed.patch._replace(points=points))

    def _parts(self, new_vertices: Floats) -> list[Floats]:
        return np.split(new_vertices, np.cumsum(self._new_counts())[:-1])

    def _new_counts(self) -> list[int]:
        return [len(placed.patch.points) - len(placed.rim) for placed in self._placed]

    def gathered(self) -> tuple[Floats, Ints, Ints, Ints]:
        """Returns the new vertices, the new faces, the patch index of each new vertex, and that of each new face."""
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int32)]
        counts, total = self._new_counts(), len(self._points)
        for (rim, patch, *_), count in zip(self._placed, counts, strict=True):
            numbers = np.concatenate([rim, np.arange(total, total + count, dtype=np.int32)]).astype(np.int32)
            vertices.append(patch.points[len(rim) :])
            faces.append(numbers[patch.triangles])
            total += count
        holes = np.arange(len(counts), dtype=np.int32)
        sizes = [len(part) for part in faces[1:]]
        return np.concatenate(vertices), np.concatenate(faces), np.repeat(holes, counts), np.repeat(holes, sizes)


def _reach(rim: Floats, new: Floats) -> float:
    low, high = rim.min(axis=0), rim.max(axis=0)
    outside = np.linalg.norm(np.maximum(np.maximum(low - new, new - high), 0.0), axis=1)
    return float(outside.max(initial=0.0)) / (float(np.linalg.norm(high - low)) or 1.0)


def bends_around(points: Floats, faces: Ints, marked: Bools) -> tuple[Floats, Floats]:
    """(n,) the sum and (n,) the number of dihedral angles at the edges of each vertex; only edges with a `marked` end count."""
    n = len(points)
    near = faces[marked[faces].any(axis=1)]
    pairs, shared = face_adjacency(near)
    pairs, shared = pairs[marked[shared].any(axis=1)], shared[marked[shared].any(axis=1)]
    normals = cross_products(points, near)
    angles = angles_between(normals[pairs[:, 0]], normals[pairs[:, 1]])
    total = np.asarray(np.bincount(shared.T.ravel(), np.tile(angles, 2), n), dtype=np.float64)
    return total, np.asarray(np.bincount(shared.ravel(), minlength=n), dtype=np.float64)


def bend_at_rim(patch: Patch, sides: Longs, normals: Floats) -> float:
    """The mean angle between the patch and the mesh along the rim, in radians; for the arguments see `_PlacedPatch`."""
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
    """Finds which vertices of a region to delete with their triangles, and closes the holes that this leaves by `close_holes`.

    Unlike `fair_region`, this keeps no needles and folds: the new surface depends only on the vertices around the region.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        region: (n,) bool, the vertices to delete. Vertices of a triangle at a border stay, so that the border does not change.
        energy: as for `fair_region`.
        rounds: as for `close_holes`.
        progress: called with the completed share; may raise to stop.

    Returns:
        (n,) bool, the vertices to delete with their faces; and the filling, whose indices refer to the mesh before the deletion.

    Raises:
        FilterInputError: not a mesh; the region is a whole component, lies only at borders, goes all round, or cannot be closed.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("energy", energy, ENERGIES)
    n = len(points)
    border = border_vertices(triangles, n)
    labels, _ = connected_components(triangles, n)
    used = labels >= 0  # vertices of proper triangles
    chosen = check_vertex_mask("region", region, n) & ~mask_of(triangles[border[triangles].any(axis=1)], n) & used
    if not chosen.any():
        raise FilterInputError(
            "nothing can be remade: all of the region lies at an open border, whose triangles stay, or has no triangle"
        )
    gone = chosen[triangles].any(axis=1)
    if not np.isin(labels[chosen], labels[triangles[~gone]]).all():
        raise FilterInputError("a whole component is selected, so that its place is undetermined: select less")
    chosen = used & ~mask_of(triangles[~gone], n)  # also vertices all of whose triangles go
    rim = mask_of(triangles[gone], n) & ~chosen
    filling = close_holes(
        points, triangles[~gone], max_edges=LARGEST_RIM, energy=energy, rounds=rounds, selected=rim, progress=progress
    )
    for open_rim in filling.left_open:
        if open_rim.reason != "selection" and rim[open_rim.vertices].any():
            raise FilterInputError(f"the region cannot be remade: {open_rim.message}; select one ring more, or one ring less")
    # Each connected part of the removed triangles must leave one hole: two closed holes would cut a body or a handle in two.
    pairs, count = face_adjacency(triangles[gone])[0], int(gone.sum())
    links = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    if len(filling.closed) > sparse.csgraph.connected_components(links, directed=False)[0]:
        raise FilterInputError("the region goes all round the mesh, and each of its rims would be closed by itself: select less")
    return chosen, filling
