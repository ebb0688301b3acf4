"""The patches that close the holes of a mesh: triangulated, then refined as their vertices move."""

from typing import NamedTuple

import numpy as np

from ..execution import Progress
from ..mesh import Floats, Ints
from ..topology import BoundaryLoop, OneRings, one_rings
from .grading import MOST_VERTICES, uniform_width
from .polygon import Polygon, joined_corners, polygon, triangulate_polygon
from .refinement import Patch, refined_patch
from .rim_angles import bend_at_rim, bends_around
from .vertex_pairs import ForbiddenEdges, vertex_pairs

#: A hole at whose rim the surface bends by more than this many times as much as around it is refined further.
SHARP = 1.2
#: Its edges become as short as this share of what they would be.
FINEST = 0.25
# The share of the progress that triangulation takes, of a patch that is refined.
_TRIANGULATION = 0.3


class _PlacedPatch(NamedTuple):
    """A patch with its place in the mesh.

    Attributes:
        own: (k,) the vertices of the mesh on its rim, ascending.
        patch: the patch; its first k points are these vertices.
        forbidden: which of them it must not join.
        uniform: how wide its part at the rim is where triangles are as small as there, in edges.
        sides: (s, 3) the edges of the rim in the numbers of the patch, as `bend_at_rim` takes them, but of the third vertex the
            index in `around`.
        around: (s, 3) coordinates of the third vertices of the faces of the mesh at the rim.
        bend: the mean angle between the faces at the edges of the mesh around it, in radians.
        share: the target length of its edges as a share of the edges around.
    """

    own: Ints
    patch: Patch
    forbidden: ForbiddenEdges
    uniform: float
    sides: Ints
    around: Floats
    bend: float
    share: float


class Patches:
    """A mesh and the patches that close its holes so far."""

    def __init__(self, points: Floats, faces: Ints, rims: list[BoundaryLoop]) -> None:
        """No patches yet, for a mesh of which these rims may be closed."""
        self._points = points
        self._rings: OneRings = one_rings(faces, len(points))
        self._place = np.full(len(points), -1, dtype=np.int32)
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
        """Triangulate and refine a hole with the islands in it; False, and nothing is added, if that cannot be done."""

        def triangulating(share: float) -> None:
            progress(share * (_TRIANGULATION if refine else 1.0))

        def refining(share: float) -> None:
            progress(_TRIANGULATION + (1.0 - _TRIANGULATION) * share)

        outline = polygon(rim, islands, self._points)
        joined = joined_corners(outline.vertices, self._rings, self._place, self._links)
        triangles = None if _is_a_face(outline) else triangulate_polygon(outline, self._points, joined, triangulating)
        if triangles is None and refine and len(rim.vertices) > 3:
            # Here diagonals may double edges of the mesh, since refinement splits such diagonals.
            triangles = triangulate_polygon(outline, self._points, vertex_pairs(joined.size), triangulating)
        if triangles is None:
            return False
        own, first = np.unique(outline.vertices, return_index=True)
        self._place[own] = np.arange(len(own), dtype=np.int32)
        patch = Patch(self._points[own], self._lengths(own), self._place[triangles], len(own))
        self._place[own] = -1
        alone = np.zeros(len(own), dtype=np.bool_)
        for loop in (rim, *islands):
            distinct, visits = np.unique(loop.vertices, return_counts=True)
            alone[np.searchsorted(own, distinct[visits > 1])] = True
        forbidden = ForbiddenEdges(joined.restricted(first.astype(np.int32)), np.zeros(len(own), dtype=np.bool_), alone)
        uniform = uniform_width(patch.points, patch.sizes, patch.triangles, patch.n_rim)
        if refine:
            patch = refined_patch(patch, forbidden=forbidden, uniform=uniform, progress=refining)
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
        """Refine all patches with their points where they are now; if `smooth`, more where the surface bends at the rim.

        `progress` is called now and then with a share of 0, and may raise to stop.
        """

        def still(share: float) -> None:
            progress(0.0)

        for k, placed in enumerate(self._placed):
            patch = placed.patch
            everything = np.concatenate([patch.points, placed.around])
            sides = placed.sides + np.array([0, 0, len(patch.points)], dtype=np.int32)
            bend = bend_at_rim(everything, patch.triangles, sides)
            finer = np.clip(SHARP * placed.bend / bend, FINEST / placed.share, 1.0) if smooth and bend > 0.0 else 1.0
            finer = max(finer, min(1.0, float(np.sqrt(len(patch.points) / MOST_VERTICES))))
            patch = patch._replace(sizes=patch.sizes * finer)
            # A filling that bulges has a larger area than the one whose width was chosen.
            uniform = min(placed.uniform, uniform_width(patch.points, patch.sizes, patch.triangles, patch.n_rim))
            patch = refined_patch(patch, forbidden=placed.forbidden, uniform=uniform, progress=still)
            self._placed[k] = placed._replace(patch=patch, uniform=uniform, share=placed.share * float(finer))

    def reach(self, new_vertices: Floats) -> Floats:
        """(count,) how far each patch would leave the box of its rim, in diagonals of that box.

        `new_vertices` are coordinates of the new vertices, in the order of `gathered`.
        """
        found = np.zeros(self.count)
        at = 0
        for k, (own, patch, *_) in enumerate(self._placed):
            new = new_vertices[at : (at := at + len(patch.points) - len(own))]
            low, high = patch.points[: len(own)].min(axis=0), patch.points[: len(own)].max(axis=0)
            outside = np.linalg.norm(np.maximum(np.maximum(low - new, new - high), 0.0), axis=1)
            diagonal = float(np.linalg.norm(high - low))
            found[k] = outside.max(initial=0.0) / (diagonal or 1.0)
        return found

    def move(self, new_vertices: Floats) -> None:
        """Set the coordinates of the new vertices, in the order of `gathered`."""
        at = 0
        for k, placed in enumerate(self._placed):
            own, patch = placed.own, placed.patch
            more = len(patch.points) - len(own)
            moved = np.concatenate([patch.points[: len(own)], new_vertices[at : at + more]])
            self._placed[k] = placed._replace(patch=patch._replace(points=moved))
            at += more

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


def _is_a_face(outline: Polygon) -> bool:
    """Whether the polygon is a face of the mesh in the other orientation."""
    return len(outline.vertices) == 3 and bool(outline.opposite[0] == outline.vertices[2])
