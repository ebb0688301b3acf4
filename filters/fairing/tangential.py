"""Tangential smoothing: better triangles on the same surface."""

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from ..denoising.face_normals import face_normals
from ..diffusion.frame import enter, leave, ordered_frame
from ..errors import FilterInputError
from ..mesh import Bools, Floats, Ints, Longs, check_mesh, check_movable
from ..operators.cotangent import cotangent_laplacian
from ..operators.mass import mixed_voronoi_areas
from ..operators.uniform import uniform_laplacian
from ..progress import Progress, ignore_progress
from ..solvers import SpdSolver
from ..topology import border_vertices, mean_edge_length, referenced_vertices
from .closest_walk import WalkableSurface

# Conjugate gradients towards a step that is cut short anyway.
_TOLERANCE = 1e-6
# No step is longer than this share of the mean edge at the vertex.
_LONGEST_STEP = 0.5
# Steps that would fold a triangle or leave the surface are halved so often, then not made.
_HALVINGS = 4
# A triangle must keep within this cosine of where it looked before, and of the surface under it.
_LEAST_COSINE = 0.25


def tangential_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    weight: float = 0.1,
    iterations: int = 5,
    max_deviation: float | None = None,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Moves vertices along the surface towards min sum_i A_i (|L_uniform p'_i - L_cotan p_i|^2 + w |p'_i - p_i|^2) [nealen2006].

    L_cotan p has no tangential part, so what is left of L_uniform p' at the minimum has none either: every vertex sits in the
    middle of its neighbours as seen along the normal, which is where triangles are good. The energy alone also moves vertices
    off the surface. Here each iteration solves for it, takes the part of the step within the tangent plane, and puts the vertex
    on the nearest point of the input surface, walked to from where it was. A step that would fold a triangle over, or bring the
    middle of a triangle or of an edge further from the input than allowed, is halved, and not made after four times.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        weight: w, above 0, without unit. Larger moves less in each iteration.
        iterations: number of steps. More are better triangles, up to a point.
        max_deviation: how far the middles of triangles and edges may get from the input, in mesh units: larger allows better
            triangles on curved parts and across edges. None: 5 % of the mean edge. Vertices themselves stay on the input.
        movable: (n,) bool, which vertices may move, None for all. Border vertices stay, whatever is said.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        ConvergenceError: the equations cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    if not (math.isfinite(weight) and weight > 0.0):
        raise FilterInputError(f"weight {weight} is not finite and above 0")
    if iterations != int(iterations) or iterations < 0:
        raise FilterInputError(f"iterations is {iterations}: it is a whole number of at least 0")
    if max_deviation is not None and not max_deviation >= 0.0:
        raise FilterInputError(f"max_deviation {max_deviation} is not at least 0")
    used = referenced_vertices(triangles, len(points))
    moves = check_movable(movable, len(points)) & used & ~border_vertices(triangles, len(points))
    if not moves.any():
        return points.copy()
    frame = ordered_frame(points[used], None)
    start = enter(points, frame)
    edge = mean_edge_length(start, triangles)
    allowed = 0.05 * edge if max_deviation is None else max_deviation * frame.scale
    proper = triangles[
        (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2]) & (triangles[:, 2] != triangles[:, 0])
    ]
    surface = _Surface(start, np.ascontiguousarray(proper), allowed)
    energy = _Energy(start, surface.faces, moves, weight)
    now = start
    for iteration in range(iterations):

        def partial(share: float, done: int = iteration) -> None:
            progress((done + 0.8 * share) / iterations)

        now = surface.moved(now, energy.step(now, partial), moves)
        progress((iteration + 1) / iterations)
    return leave(points, start, now, frame)


class _Energy:
    """The equations of a step d: (L_u^T A L_u + w A) d = L_u^T A (L_cotan p - L_u p), the same matrix in every iteration."""

    def __init__(self, points: Floats, faces: Ints, moves: Bools, weight: float) -> None:
        self._faces, self._moves = faces, moves
        self._uniform = uniform_laplacian(faces, len(points))
        area = mixed_voronoi_areas(points, faces)
        area = np.maximum(area / area.mean(), 1e-3) if area.mean() > 0.0 else np.ones(len(points))
        # A Laplacian at a border vertex is not along a normal.
        rows = sparse.diags_array(np.where(border_vertices(faces, len(points)), 0.0, area))
        columns = sparse.csr_matrix(self._uniform.matrix()[:, moves])
        self._transposed = sparse.csr_matrix(columns.T @ rows)
        matrix = sparse.csr_matrix(self._transposed @ columns)
        matrix.setdiag(matrix.diagonal() + weight * area[moves])
        self._solver = SpdSolver(matrix)

    def step(self, points: Floats, progress: Progress) -> Floats:
        """(f, 3) the displacement of the vertices that move, cut to their tangent planes."""
        wanted = cotangent_laplacian(points, self._faces).apply(points) - self._uniform.apply(points)
        step = self._solver.solve(self._transposed @ wanted, tolerance=_TOLERANCE, progress=progress).values
        normals = _vertex_normals(points, self._faces)[self._moves]
        step = step - np.einsum("ij,ij->i", step, normals)[:, None] * normals
        longest = _LONGEST_STEP * _mean_edges(points, self._faces)[self._moves]
        lengths = np.linalg.norm(step, axis=1)
        return np.asarray(step * np.minimum(1.0, longest / np.where(lengths > 0.0, lengths, 1.0))[:, None])


class _Surface:
    """The input surface, to which vertices keep, and the triangles, which must not fold."""

    def __init__(self, points: Floats, faces: Ints, allowed: float) -> None:
        self.faces, self._allowed = faces, allowed
        self._walkable = WalkableSurface.of(points, faces)
        self._normals = face_normals(points, faces)
        self._at = np.zeros(len(points), dtype=np.int32)
        self._at[faces[::-1].ravel()] = np.repeat(np.arange(len(faces), dtype=np.int32)[::-1], 3)

    def moved(self, points: Floats, step: Floats, moves: Bools) -> Floats:
        """The points after as much of the step as does no harm."""
        which = np.flatnonzero(moves)
        scale = np.ones(len(points))
        before = face_normals(points, self.faces)
        tentative, at = points.copy(), self._at.copy()
        pending = which
        while len(pending):
            position = np.searchsorted(which, pending)
            tentative[pending], at[pending], _ = self._walkable.closest(
                points[pending] + scale[pending, None] * step[position], self._at[pending]
            )
            stopped = pending[scale[pending] == 0.0]
            tentative[stopped], at[stopped] = points[stopped], self._at[stopped]
            changed = np.zeros(len(points), dtype=np.bool_)
            changed[pending] = True
            checked = np.flatnonzero(changed[self.faces].any(axis=1))
            bad = checked[self._harmed(tentative, at, before, checked)]
            guilty = np.zeros(len(points), dtype=np.bool_)
            guilty[self.faces[bad]] = True
            pending = np.flatnonzero(guilty & moves & (scale > 0.0))
            scale[pending] *= 0.5
            scale[pending[scale[pending] < 0.5**_HALVINGS]] = 0.0
        self._at = at
        return tentative

    def _harmed(self, points: Floats, at: Ints, before: Floats, checked: Longs) -> Bools:
        """Which of the checked faces look away from where they looked or from the surface, or are too far from it."""
        faces = self.faces[checked]
        a, b, c = (points[faces[:, k]] for k in range(3))
        normals = face_normals(points, np.ascontiguousarray(faces))
        _, under, far = self._walkable.closest((a + b + c) / 3.0, at[faces[:, 0]], self._allowed)
        harmed = np.einsum("ij,ij->i", normals, before[checked]) < _LEAST_COSINE
        harmed |= np.einsum("ij,ij->i", normals, self._normals[under]) < _LEAST_COSINE
        harmed |= far > self._allowed
        for first, second, corner in ((a, b, 0), (b, c, 1), (c, a, 2)):
            harmed |= self._walkable.closest((first + second) / 2.0, at[faces[:, corner]], self._allowed)[2] > self._allowed
        return np.asarray(harmed)


def _vertex_normals(points: Floats, faces: Ints) -> Floats:
    """(n, 3) unit normals, the faces' weighted by area; 0 where there are none."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    doubled = np.cross(b - a, c - a)
    corners = faces.ravel()
    normals = np.stack([np.bincount(corners, np.repeat(column, 3), len(points)) for column in doubled.T], axis=1)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0.0, lengths, 1.0))


def _mean_edges(points: Floats, faces: Ints) -> Floats:
    """(n,) the mean length of the sides of the faces at each vertex."""
    following = np.roll(faces, -1, axis=1)
    lengths = np.linalg.norm(points[following] - points[faces], axis=2)
    means = lengths.mean(axis=1)
    count = np.bincount(faces.ravel(), minlength=len(points))
    return np.asarray(np.bincount(faces.ravel(), np.repeat(means, 3), len(points)) / np.maximum(count, 1))
