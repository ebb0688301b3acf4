"""The steps of tangential smoothing: the minimum of the energy, and how far vertices can move towards it on the surface."""

from __future__ import annotations

import numpy as np

from ..execution import Progress
from ..geometry import WalkableSurface, face_normals, vertex_normals_by_area
from ..libraries import sparse
from ..linear_solvers import SpdSolver
from ..mesh import Bools, Floats, Ints, Longs
from ..operators import cotangent_laplacian, mixed_voronoi_areas, uniform_laplacian
from ..topology import border_vertices

# The step is cut to the tangent plane and a largest length anyway, so it need not be exact.
_TOLERANCE = 1e-6
# The longest step, as a share of the mean edge at the vertex.
_LONGEST_STEP = 0.5
# Steps that would fold a triangle or leave the surface are halved up to this many times, then not made.
_HALVINGS = 4
# The least cosine of the angle between the normal of a triangle and its normal before, and that of the surface under it.
_LEAST_COSINE = 0.25


class TangentialEnergy:
    """The equations of a step d: (L_u^T A L_u + w A) d = L_u^T A (L_cotan p - L_u p). All iterations have the same matrix."""

    def __init__(self, points: Floats, faces: Ints, moves: Bools, weight: float) -> None:
        self._faces, self._moves = faces, moves
        self._uniform = uniform_laplacian(faces, len(points))
        area = mixed_voronoi_areas(points, faces)
        area = np.maximum(area / area.mean(), 1e-3) if area.mean() > 0.0 else np.ones(len(points))
        # At a border vertex L_cotan p has a tangential part.
        rows = sparse.diags_array(np.where(border_vertices(faces, len(points)), 0.0, area))
        columns = sparse.csr_matrix(self._uniform.matrix()[:, moves])
        self._transposed = sparse.csr_matrix(columns.T @ rows)
        matrix = sparse.csr_matrix(self._transposed @ columns)
        matrix.setdiag(matrix.diagonal() + weight * area[moves])
        self._solver = SpdSolver(matrix)

    def step(self, points: Floats, progress: Progress) -> Floats:
        """(f, 3) the displacement of the f vertices that move, within their tangent planes."""
        wanted = cotangent_laplacian(points, self._faces).apply(points) - self._uniform.apply(points)
        step = self._solver.solve(self._transposed @ wanted, tolerance=_TOLERANCE, progress=progress).values
        normals = vertex_normals_by_area(points, self._faces)[self._moves]
        step = step - np.einsum("ij,ij->i", step, normals)[:, None] * normals
        longest = _LONGEST_STEP * _mean_edges(points, self._faces)[self._moves]
        lengths = np.linalg.norm(step, axis=1)
        return np.asarray(step * np.minimum(1.0, longest / np.where(lengths > 0.0, lengths, 1.0))[:, None])


class KeptSurface:
    """The input surface, on which vertices stay, and the triangles, which must not fold.

    Attributes:
        faces: (m, 3) the current triangles, at first those of the input.
        at: (n,) the face of the input on which each vertex lies.
        walkable: the input.
        allowed: the largest distance of the middles of edges and the centroids of triangles from it.
    """

    def __init__(self, points: Floats, faces: Ints, allowed: float) -> None:
        self.faces, self.allowed = faces, allowed
        self.walkable = WalkableSurface.of(points, faces)
        self._normals = face_normals(points, faces)
        self.at = self.walkable.first_faces()

    def moved(self, points: Floats, step: Floats, moves: Bools) -> Floats:
        """(n, 3) the points after the step of each vertex that moves, halved until it does no harm."""
        which = np.flatnonzero(moves)
        scale = np.ones(len(points))
        before = face_normals(points, self.faces)
        tentative, at = points.copy(), self.at.copy()
        pending = which
        while len(pending):
            position = np.searchsorted(which, pending)
            tentative[pending], at[pending], _ = self.walkable.closest(
                points[pending] + scale[pending, None] * step[position], self.at[pending]
            )
            stopped = pending[scale[pending] == 0.0]
            tentative[stopped], at[stopped] = points[stopped], self.at[stopped]
            changed = np.zeros(len(points), dtype=np.bool_)
            changed[pending] = True
            checked = np.flatnonzero(changed[self.faces].any(axis=1))
            bad = checked[self._harmed(tentative, at, before, checked)]
            guilty = np.zeros(len(points), dtype=np.bool_)
            guilty[self.faces[bad]] = True
            pending = np.flatnonzero(guilty & moves & (scale > 0.0))
            scale[pending] *= 0.5
            scale[pending[scale[pending] < 0.5**_HALVINGS]] = 0.0
        self.at = at
        return tentative

    def _harmed(self, points: Floats, at: Ints, before: Floats, checked: Longs) -> Bools:
        """(k,) which of the checked faces have turned too far from `before` or the surface, or are too far from the latter."""
        faces = self.faces[checked]
        a, b, c = (points[faces[:, k]] for k in range(3))
        normals = face_normals(points, np.ascontiguousarray(faces))
        _, under, far = self.walkable.closest((a + b + c) / 3.0, at[faces[:, 0]], self.allowed)
        harmed = np.einsum("ij,ij->i", normals, before[checked]) < _LEAST_COSINE
        harmed |= np.einsum("ij,ij->i", normals, self._normals[under]) < _LEAST_COSINE
        harmed |= far > self.allowed
        for k, (start, end) in enumerate(((a, b), (b, c), (c, a))):
            harmed |= self.walkable.closest((start + end) / 2.0, at[faces[:, k]], self.allowed)[2] > self.allowed
        return np.asarray(harmed)


def _mean_edges(points: Floats, faces: Ints) -> Floats:
    """(n,) the mean length of the sides of the faces at each vertex."""
    following = np.roll(faces, -1, axis=1)
    lengths = np.linalg.norm(points[following] - points[faces], axis=2)
    means = lengths.mean(axis=1)
    count = np.bincount(faces.ravel(), minlength=len(points))
    return np.asarray(np.bincount(faces.ravel(), np.repeat(means, 3), len(points)) / np.maximum(count, 1))
