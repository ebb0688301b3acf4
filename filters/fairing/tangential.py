"""Tangential smoothing: better triangles on the same surface, with or without edge flips."""

import math

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite, check_positive, check_whole_number
from ..compilation import compiled
from ..denoising.noise_level import smooth_normals
from ..execution import Progress, ignore_progress, part_of
from ..geometry import (
    WalkableSurface,
    face_normals,
    mean_edge_length,
    nearest_by_walk,
    quality_and_normal,
    vertex_normals_by_area,
)
from ..inspection import sharp_edges
from ..libraries import sparse
from ..linear_solvers import SpdSolver
from ..mesh import Bools, Floats, Ints, Longs, check_mesh, mask_of, normalised_mesh
from ..operators import cotangent_laplacian, mixed_voronoi_areas, uniform_laplacian
from ..topology import border_vertices, diamond, faces_across, fan_size, flip, proper_faces

# The step is projected to the tangent plane and limited in length, so it need not be exact.
_TOLERANCE = 1e-6
# The longest step, as a share of the mean edge at the vertex.
_LONGEST_STEP = 0.5
# How often a step may be halved.
_HALVINGS = 4
# Triangles at sharp edges may deviate from the surface by this share of the usual limit; more would make the edges jagged.
_AT_RIDGES = 0.2
# Smoothed unit normals at the two vertices opposite a sharp edge differ by more than this length (25 degrees); noise causes less.
_TURNED = 2.0 * math.sin(math.radians(12.5))
# The least cosine between the normal of a moved triangle and its former normal, or the normal of the surface below it. After a
# flip: between the normals of a new and an old triangle, or of the two new triangles.
_LEAST_COSINE = 0.25
# The largest number of passes of flips. After this number the gain is negligible.
_FLIP_PASSES = 50
# The least gain of quality by a flip, far above rounding, so that flips do not undo each other forever.
_LEAST_GAIN = 1e-6


def tangential_smoothing(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    weight: float = 0.1,
    iterations: int = 5,
    max_deviation: float | None = None,
    flip_edges: bool = False,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> tuple[Floats, Ints]:
    """Moves vertices along the surface towards min sum_i A_i (|L_uniform p'_i - L_cotan p_i|^2 + w |p'_i - p_i|^2) [nealen2006].

    A_i is the Voronoi area of vertex i, p' are the new points. L_cotan p is nearly normal to the surface. If w is small, so is
    L_uniform p' at the minimum: in the tangent plane each vertex is near the centroid of its neighbours, which makes good
    triangles. The energy alone would also move vertices off the surface. So each iteration minimises it, projects the step to the
    tangent plane, and moves the vertex to the nearest point of the input surface, found by a walk. A step that folds a triangle,
    or brings the middle of an edge or a triangle too far from the input, is halved up to four times, then dropped.

    If triangles are halves of quadrilaterals cut along the wrong diagonal, as in range maps, moving vertices does not help.
    Flipping edges before each step helps [lawson1977, botsch2004remeshing]; see `flip_towards_quality`. Border, orientation and
    topology stay.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        weight: w, above 0, without unit. With a larger weight vertices move less in each iteration.
        iterations: number of steps. More steps give better triangles, up to a point.
        max_deviation: the largest distance of the middles of triangles and edges from the input, in mesh units; a fifth of it at
            sharp edges. Larger allows better triangles. None: 5 % of the mean edge. Vertices stay on the input.
        flip_edges: whether edges are flipped too; all four vertices of their two triangles must be movable.
        movable: (n,) bool, which vertices may move, None for all; border vertices stay.
        progress: called with the finished share; may raise to stop.

    Returns:
        (n, 3) float64, in which fixed vertices keep every bit; and (m, 3) triangles, in which a flip changes only its two rows.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        ConvergenceError: the equations cannot be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    check_positive("weight", weight)
    check_whole_number("iterations", iterations)
    if max_deviation is not None:
        check_finite("max_deviation", max_deviation, least=0.0)
    mesh = normalised_mesh(points, triangles, movable)
    may = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
    moves = may & ~border_vertices(mesh.cells, len(mesh))
    kept = mesh.cells[proper_faces(mesh.cells)]
    if not len(kept) or not (may if flip_edges else moves).any():
        progress(1.0)
        return points.copy(), triangles.copy()
    now = mesh.points
    allowed = 0.05 * mean_edge_length(now, kept) if max_deviation is None else max_deviation * mesh.scale
    surface = KeptSurface(now, kept, allowed)
    energy: TangentialEnergy | None = None
    for iteration in range(iterations):
        partial = part_of(progress, iteration / iterations, (iteration + 0.8) / iterations)
        if flip_edges:
            surface.faces, flipped = flip_towards_quality(now, surface.faces, may, surface.walkable, surface.at, surface.allowed)
            if flipped:
                energy = None
        if moves.any():
            energy = energy or TangentialEnergy(now, surface.faces, moves, weight)
            now = surface.moved(now, energy.step(now, partial), moves)
        progress((iteration + 1) / iterations)
    result = triangles.copy()
    result[proper_faces(triangles)] = mesh.used[surface.faces]
    return mesh.restored(now), result


class TangentialEnergy:
    """The equations of a step d: (L_u^T A L_u + w A) d = L_u^T A (L_cotan p - L_u p), with one matrix for all steps."""

    def __init__(self, points: Floats, faces: Ints, moves: Bools, weight: float) -> None:
        self._faces, self._moves = faces, moves
        self._uniform = uniform_laplacian(faces, len(points))
        area = mixed_voronoi_areas(points, faces)
        area = np.maximum(area / area.mean(), 1e-3) if area.mean() > 0.0 else np.ones(len(points))
        # Border vertices get no row, because L_cotan p has a tangential part there.
        rows = sparse.diags_array(np.where(border_vertices(faces, len(points)), 0.0, area))
        columns = sparse.csr_matrix(self._uniform.matrix()[:, moves])
        self._transposed = sparse.csr_matrix(columns.T @ rows)
        matrix = sparse.csr_matrix(self._transposed @ columns)
        matrix.setdiag(matrix.diagonal() + weight * area[moves])
        self._solver = SpdSolver(matrix)

    def step(self, points: Floats, progress: Progress) -> Floats:
        """(f, 3) the displacement of the f vertices that move, within their tangent planes."""
        target = cotangent_laplacian(points, self._faces).apply(points) - self._uniform.apply(points)
        step = self._solver.solve(self._transposed @ target, tolerance=_TOLERANCE, progress=progress).values
        normals = vertex_normals_by_area(points, self._faces)[self._moves]
        step = step - np.einsum("ij,ij->i", step, normals)[:, None] * normals
        longest = _LONGEST_STEP * _mean_edges(points, self._faces)[self._moves]
        lengths = np.linalg.norm(step, axis=1)
        return np.asarray(step * np.minimum(1.0, longest / np.where(lengths > 0.0, lengths, 1.0))[:, None])


class KeptSurface:
    """The input surface, on which vertices stay, and the current triangles, which must not fold.

    The middles of edges and the centroids of triangles stay near the input: within the least `allowed` distance at the vertices
    of the triangle and of the input's face below it. Vertex i lies on the input's face ``at[i]``.
    """

    def __init__(self, points: Floats, faces: Ints, allowed: float) -> None:
        self.faces = faces
        self.walkable = WalkableSurface.of(points, faces)
        self._normals = face_normals(points, faces)
        sharp, normals = sharp_edges(points, faces), smooth_normals(points, faces)
        first, second = (normals[faces[sharp.faces[:, k]]].sum(axis=1) for k in range(2))
        on_ridge = mask_of(sharp.pairs[np.linalg.norm(first - second, axis=1) > _TURNED], len(points))
        self.allowed = np.where(on_ridge, _AT_RIDGES * allowed, allowed)
        self.at = self.walkable.first_faces()

    def moved(self, points: Floats, step: Floats, moves: Bools) -> Floats:
        """Returns (n, 3) points after the steps of the moving vertices, halved until no triangle folds or leaves the surface."""
        movers = np.flatnonzero(moves)
        scale = np.ones(len(points))
        before = face_normals(points, self.faces)
        tentative, at = points.copy(), self.at.copy()
        pending = movers
        while len(pending):
            position = np.searchsorted(movers, pending)
            tentative[pending], at[pending], _ = self.walkable.closest(
                points[pending] + scale[pending, None] * step[position], self.at[pending]
            )
            stopped = pending[scale[pending] == 0.0]
            tentative[stopped], at[stopped] = points[stopped], self.at[stopped]
            checked = np.flatnonzero(mask_of(pending, len(points))[self.faces].any(axis=1))
            bad = checked[self._folded_or_far(tentative, at, before, checked)]
            pending = np.flatnonzero(mask_of(self.faces[bad], len(points)) & moves & (scale > 0.0))
            scale[pending] *= 0.5
            scale[pending[scale[pending] < 0.5**_HALVINGS]] = 0.0
        self.at = at
        return tentative

    def _folded_or_far(self, points: Floats, at: Ints, before: Floats, checked: Longs) -> Bools:
        """(k,) which checked faces turn too far from their normals `before` or the surface's, or are too far from the surface."""
        faces = self.faces[checked]
        a, b, c = (points[faces[:, k]] for k in range(3))
        normals = face_normals(points, np.ascontiguousarray(faces))
        allowed = self.allowed[faces].min(axis=1)
        under, harmed = self._faces_under((a + b + c) / 3.0, at[faces[:, 0]], allowed)
        harmed |= np.einsum("ij,ij->i", normals, before[checked]) < _LEAST_COSINE
        harmed |= np.einsum("ij,ij->i", normals, self._normals[under]) < _LEAST_COSINE
        for k, (start, end) in enumerate(((a, b), (b, c), (c, a))):
            harmed |= self._faces_under((start + end) / 2.0, at[faces[:, k]], allowed)[1]
        return np.asarray(harmed)

    def _faces_under(self, places: Floats, at: Ints, allowed: Floats) -> tuple[Ints, Bools]:
        """Walks from the input's faces `at` to the faces under the places; returns the faces, and which places are too far."""
        _, under, far = self.walkable.closest(places, at, self.allowed.min())
        return under, far > np.minimum(allowed, self.allowed[self.walkable.faces[under]].min(axis=1))


def _mean_edges(points: Floats, faces: Ints) -> Floats:
    means = np.linalg.norm(points[np.roll(faces, -1, axis=1)] - points[faces], axis=2).mean(axis=1)
    count = np.bincount(faces.ravel(), minlength=len(points))
    return np.asarray(np.bincount(faces.ravel(), np.repeat(means, 3), len(points)) / np.maximum(count, 1))


def flip_towards_quality(
    points: Floats, faces: Ints, may: Bools, surface: WalkableSurface, at: Ints, allowed: Floats
) -> tuple[Ints, int]:
    """Flips each edge whose flip raises the sum of the qualities of the two triangles and does not lower the smaller quality
    [lawson1977].

    The quality of a triangle is l / (sqrt(3) R), l its shortest edge and R its circumradius: 1 if it is equilateral, near 0
    for slivers. A flip is refused if the normal of a new triangle would be more than 75.5 degrees from that of an old or of the
    other new triangle, or if the new edge exists already. It is refused, too, if the middle or a quarter point of the new edge or
    the centroid of a new triangle would be farther from the surface than the least `allowed` of the four vertices and of the
    vertices of the surface's face nearest to that point. Edges without exactly two faces, or whose faces have opposite
    orientations, stay.

    (n,) `may` must be True at all four vertices of a flip. (n,) `at` has the face of the surface at each vertex, where walks to
    the surface start. (n,) `allowed` are distances, one per vertex. Returns the triangles and the number of flips.
    """
    flipped, across = faces.copy(), faces_across(faces)
    valences = np.bincount(faces.ravel(), minlength=len(points))
    # Even on a plane, rounding puts points at a small distance from the surface.
    near = (allowed + 1e-14 * float(np.abs(points[faces]).max(initial=0.0))) ** 2
    total = 0
    for _ in range(_FLIP_PASSES):
        count = int(_flip_pass(points, flipped, across, valences, may, surface, at, near))
        total += count
        if count == 0:
            break
    return flipped, total


@compiled
def _flip_pass(
    points: Floats, faces: Ints, across: Ints, valences: Longs, may: Bools, surface: WalkableSurface, at: Ints, near: Floats
) -> int:
    """Flips the first suitable edge of each face in place; returns the number of flips. (n,) `near` are squared distances."""
    count, least = 0, near.min() if near.size else 0.0
    for f in range(faces.shape[0]):
        for k in range(3):
            if across[f, k] < 0:
                continue
            a, b, c, d = diamond(faces, across, f, k)
            if c == d or not (may[a] and may[b] and may[c] and may[d]) or not _is_better(points, a, b, c, d):
                continue
            far = False
            # Points on the new edge and the centroids of the new triangles, as weights of c, d and an end of the old edge.
            for u, v, w, end in (
                (0.5, 0.5, 0.0, a),
                (0.75, 0.25, 0.0, a),
                (0.25, 0.75, 0.0, a),
                (1 / 3, 1 / 3, 1 / 3, a),
                (1 / 3, 1 / 3, 1 / 3, b),
            ):
                x = u * points[c, 0] + v * points[d, 0] + w * points[end, 0]
                y = u * points[c, 1] + v * points[d, 1] + w * points[end, 1]
                z = u * points[c, 2] + v * points[d, 2] + w * points[end, 2]
                under, square = nearest_by_walk(surface, x, y, z, at[end], least)[3:]
                i, j, m = surface.faces[under]
                if square > min(near[a], near[b], near[c], near[d], near[i], near[j], near[m]):
                    far = True
                    break
            # An edge from c to d must not exist yet: `fan_size` is -1 if f's fan around c has it. No flip if c has other fans.
            if far or fan_size(faces, across, f, (k + 2) % 3, d) != valences[c]:
                continue
            flip(faces, across, f, k)
            valences[a] -= 1
            valences[b] -= 1
            valences[c] += 1
            valences[d] += 1
            count += 1
            break
    return count


@compiled
def _is_better(points: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether (a, d, c) and (d, b, c) are better than (a, b, c) and (b, a, d), and their normals fulfil `_LEAST_COSINE`."""
    first, n1x, n1y, n1z = quality_and_normal(points, a, b, c)
    second, n2x, n2y, n2z = quality_and_normal(points, b, a, d)
    third, n3x, n3y, n3z = quality_and_normal(points, a, d, c)
    fourth, n4x, n4y, n4z = quality_and_normal(points, d, b, c)
    if not (third + fourth > first + second + _LEAST_GAIN and min(third, fourth) >= min(first, second)):
        return False
    # An old triangle without area has the normal 0, which allows any new normal.
    alike = n3x * n4x + n3y * n4y + n3z * n4z >= _LEAST_COSINE
    for x, y, z in ((n1x, n1y, n1z), (n2x, n2y, n2z)):
        least = _LEAST_COSINE * (x * x + y * y + z * z)
        alike &= x * n3x + y * n3y + z * n3z >= least and x * n4x + y * n4y + z * n4z >= least
    return alike
