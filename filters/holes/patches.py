"""The patches that close the holes of a mesh, while they are made."""

from typing import NamedTuple

import numpy as np

from ..execution import Progress
from ..mesh import Bools, Floats, Ints
from ..topology import OneRings, one_rings
from .polygon import Polygon, joined_corners, polygon, triangulate_polygon
from .refinement import Patch, refined_patch
from .rim_angles import bend_at_rim, bends_around
from .rims import Rim

#: A hole at whose rim the surface bends by more than this many times as much as around it is refined further.
SHARP = 1.2
#: Its edges become as short as this share of what they would be.
FINEST = 0.25


class _Sewn(NamedTuple):
    """A patch, and how it hangs on the mesh.

    Attributes:
        own: (k,) the vertices of the mesh that it hangs on, ascending.
        patch: its first points are those.
        forbidden: (k, k) which of them it must not join.
        sides: (s, 3) the edges of the rim in its own numbers, as `bend_at_rim` takes them, and of the third vertex its place in
            `around`.
        around: (s, 3) coordinates of the third vertices of the faces of the mesh at the rim.
        bend: the mean angle at the edges of the mesh around.
        share: how long its edges are to be as a share of those around.
    """

    own: Ints
    patch: Patch
    forbidden: Bools
    sides: Ints
    around: Floats
    bend: float
    share: float


class Patches:
    """The mesh and what closes its holes so far."""

    def __init__(self, points: Floats, faces: Ints, rims: list[Rim]) -> None:
        """A mesh of which these rims may be closed."""
        self._points = points
        self._rings: OneRings = one_rings(faces, len(points))
        self._place = np.full(len(points), -1, dtype=np.int32)
        met = np.zeros(len(points), dtype=np.int32)
        for rim in rims:
            met[np.unique(rim.vertices)] += 1
        self._shared = met > 1
        self._bends = bends_around(points, faces, np.flatnonzero(met).astype(np.int32))
        self._links: dict[int, set[int]] = {}
        self._sewn: list[_Sewn] = []

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self._sewn)

    def add(self, rim: Rim, islands: list[Rim], refine: bool, progress: Progress) -> bool:
        """Triangulate and refine one more hole and the islands in it; False, and nothing is added, if that cannot be done."""
        outline = polygon(rim, islands, self._points)
        joined = joined_corners(outline.vertices, self._rings, self._place, self._links)
        triangles = None if _is_a_face(outline) else triangulate_polygon(outline, self._points, joined, progress)
        if triangles is None and refine and len(rim.vertices) > 3:
            # Edges that are there already are split by refinement, after which they are no longer doubled.
            triangles = triangulate_polygon(outline, self._points, np.zeros_like(joined), progress)
        if triangles is None:
            return False
        own, first = np.unique(outline.vertices, return_index=True)
        self._place[own] = np.arange(len(own), dtype=np.int32)
        patch = Patch(self._points[own], self._lengths(own), self._place[triangles], len(own))
        self._place[own] = -1
        forbidden = joined[np.ix_(first, first)]
        for loop in (rim, *islands):
            corners, visits = np.unique(loop.vertices, return_counts=True)
            twice = np.searchsorted(own, corners[visits > 1])
            forbidden[twice, twice] = True
        if refine:
            patch = refined_patch(patch, forbidden=forbidden)
            # From now on no edge is to appear that another hole, which has its ends too, may have made meanwhile.
            forbidden |= np.outer(self._shared[own], self._shared[own]) & ~np.eye(len(own), dtype=np.bool_)
        at_mesh = outline.opposite >= 0
        starts, ends = np.searchsorted(own, outline.vertices), np.searchsorted(own, np.roll(outline.vertices, -1))
        sides = np.column_stack([starts, ends, np.cumsum(at_mesh) - 1])[at_mesh].astype(np.int32)
        bend = float(self._bends[0][own].sum() / max(self._bends[1][own].sum(), 1.0))
        self._sewn.append(_Sewn(own, patch, forbidden, sides, self._points[outline.opposite[at_mesh]], bend, 1.0))
        self._note_links(own, patch)
        return True

    def refine_again(self, smooth: bool) -> None:
        """Refine all patches where their points are now; if they are to be smooth at their rims, more those that are not."""
        for k, sewn in enumerate(self._sewn):
            patch = sewn.patch
            everything = np.concatenate([patch.points, sewn.around])
            sides = sewn.sides + np.array([0, 0, len(patch.points)], dtype=np.int32)
            bend = bend_at_rim(everything, patch.triangles, sides)
            finer = np.clip(SHARP * sewn.bend / bend, FINEST / sewn.share, 1.0) if smooth and bend > 0.0 else 1.0
            patch = refined_patch(patch._replace(sizes=patch.sizes * finer), forbidden=sewn.forbidden)
            self._sewn[k] = sewn._replace(patch=patch, share=sewn.share * float(finer))

    def move(self, new_vertices: Floats) -> None:
        """Put the new vertices elsewhere."""
        at = 0
        for k, sewn in enumerate(self._sewn):
            own, patch = sewn.own, sewn.patch
            more = len(patch.points) - len(own)
            moved = np.concatenate([patch.points[: len(own)], new_vertices[at : at + more]])
            self._sewn[k] = sewn._replace(patch=patch._replace(points=moved))
            at += more

    def gathered(self) -> tuple[Floats, Ints, Ints, Ints]:
        """The new vertices, the new faces, and the number of the patch of each vertex and of each face."""
        vertices, faces = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int32)]
        total = len(self._points)
        for own, patch, *_ in self._sewn:
            more = len(patch.points) - len(own)
            numbers = np.concatenate([own, np.arange(total, total + more, dtype=np.int32)]).astype(np.int32)
            vertices.append(patch.points[len(own) :])
            faces.append(numbers[patch.triangles])
            total += more
        holes = np.arange(len(self._sewn), dtype=np.int32)
        return (
            np.concatenate(vertices),
            np.concatenate(faces),
            np.repeat(holes, [len(part) for part in vertices[1:]]),
            np.repeat(holes, [len(part) for part in faces[1:]]),
        )

    def _lengths(self, own: Ints) -> Floats:
        """The mean length of the edges of the mesh at each of the vertices."""
        lengths = np.empty(len(own))
        for i, v in enumerate(own.tolist()):
            ends = self._rings.neighbours[self._rings.offsets[v] : self._rings.offsets[v + 1]]
            lengths[i] = np.linalg.norm(self._points[ends] - self._points[v], axis=1).mean()
        return lengths

    def _note_links(self, own: Ints, patch: Patch) -> None:
        """Remember the edges of the patch between vertices that other holes have too: those must not make them again."""
        shared = np.concatenate([self._shared[own], np.zeros(len(patch.points) - len(own), dtype=np.bool_)])
        for k in range(3):
            a, b = patch.triangles[:, k], patch.triangles[:, (k + 1) % 3]
            both = shared[a] & shared[b]
            for i, j in zip(own[a[both]].tolist(), own[b[both]].tolist(), strict=True):
                self._links.setdefault(i, set()).add(j)
                self._links.setdefault(j, set()).add(i)


def _is_a_face(outline: Polygon) -> bool:
    """Whether the polygon is a triangle of the mesh, seen from behind."""
    return len(outline.vertices) == 3 and bool(outline.opposite[0] == outline.vertices[2])
