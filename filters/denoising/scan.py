"""A scan to try filters on: the vertices whose errors count as evidence, tests for noise, and the choice of the best filter."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..diffusion import harmonic_continuation
from ..evidence import (
    BALL,
    Candidates,
    Choice,
    Scores,
    cross_validate,
    far_from_border,
    held_out_vertices,
    initial_positions,
    measured,
    middles_of_balls,
    random_signs,
    tuned,
    with_neighbours,
)
from ..execution import Progress, ignore_progress, part_of
from ..geometry import cross_products, edge_lengths, mean_edge_length, roughness
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints, Longs, check_mesh, mask_of, normalised_mesh
from ..topology import VertexFaces, edges, referenced_vertices, vertex_faces
from .impulses import replace_outlying, sizes_beside
from .noise_level import NoiseEstimate, agreement, estimate_noise, is_designed, noise_floor, smooth_normals

Label = TypeVar("Label")

NONE_HELD = np.empty(0, dtype=np.int32)
# Factor of the added noise in `choose_by_risk`: too small to change the weights of a filter, far larger than rounding errors.
_LITTLE = 0.1
_REGIONS = 100  # means of regions give the standard errors, since single edges are not independent of their neighbours
_WHOLE = 20_000  # meshes with more faces are sampled by patches: many small ones, since shapes differ between places


@dataclass(frozen=True)
class Scan:
    """A mesh, or patches of a large mesh, scaled to a mean edge of 1."""

    points: Floats  # (n, 3) coordinates; the mean of the points that faces use is 0
    faces: Ints  # (m, 3) triangles
    movable: Bools | None = None  # (n,) which vertices may move, None for all; fixed vertices are not evidence
    seed: int = 0  # the seed of the random choice of held-out vertices, and of added noise
    progress: Progress = ignore_progress  # called while filters are tried; may raise to stop
    replaced: Bools | None = None  # (n,) outliers that were replaced and are not evidence, None for none
    whole: bool = True  # True for the whole mesh, False for patches
    rings: int = 2  # a vertex is evidence only if it has this number of complete rings

    @staticmethod
    def of(vertices: ArrayLike, faces: ArrayLike, *, movable: ArrayLike | None = None, **attributes: Any) -> "Scan":
        """Returns the scan of a mesh; raises `FilterInputError` for a bad mesh or a bad `movable`."""
        mesh = normalised_mesh(*check_mesh(vertices, faces), movable)
        return Scan.sampled(mesh.points, mesh.cells, mesh.movable, **attributes)[0]

    @staticmethod
    def sampled(
        points: Floats,
        faces: Ints,
        movable: Bools | None = None,
        *,
        edge: float | None = None,
        patches: tuple[int, int] = (40, 450),
        **attributes: Any,
    ) -> "tuple[Scan, Ints]":
        """Returns the scan of a mesh, and (k,) the vertex of the mesh for each vertex of the scan.

        A mesh of up to 20,000 faces is taken whole. A larger mesh is sampled by patches of complete face rings around seed faces.
        A vertex in several patches appears once in each. The seed faces have the smallest pseudo-random numbers, made from
        perimeter / mean edge: renumbering, moving, turning and scaling the mesh change these numbers only by rounding.

        Squares of the (n, 3) points must neither overflow nor underflow. `edge` is the mean edge if known, `patches` the number
        of patches and the least number of faces in each, `attributes` the remaining fields of the scan.
        """
        whole = len(faces) <= _WHOLE
        chosen, origin = faces, np.arange(len(points), dtype=np.int32)
        if not whole:
            chosen, origin = _grown(points, faces, edge or mean_edge_length(points, faces), *patches)
        local = points[origin]
        used = local[referenced_vertices(chosen, len(local))]
        local -= used.mean(axis=0) if len(used) else 0.0
        local /= mean_edge_length(points[origin], chosen) or 1.0  # a mesh of size 0 is not scaled
        moves = None if movable is None else movable[origin]
        return Scan(local, np.ascontiguousarray(chosen), moves, whole=whole, **attributes), origin

    @cached_property
    def noise(self) -> NoiseEstimate:
        return estimate_noise(self.points, self.faces)

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) unit normals of a smoothed copy."""
        return smooth_normals(self.points, self.faces)

    @cached_property
    def scored(self) -> Bools:
        """(n,) the vertices that are evidence: errors are measured only there."""
        scored = far_from_border(self.faces, len(self.points), rings=self.rings)
        for allowed in (self.movable, None if self.replaced is None else ~self.replaced):
            scored = scored if allowed is None else scored & allowed
        return scored

    @cached_property
    def agreement(self) -> tuple[float, float]:
        """How far residuals (fourth-order differences) of neighbours correlate: on the whole scan, and in its calmest third."""
        return agreement(self.points, self.faces)

    @cached_property
    def surface_noise(self) -> float:
        """The standard deviation of the noise along the normals, in mean edges, as recipes use it.

        It is the smaller of two estimates: `estimate_noise`, which takes fine details such as fur for noise, and 1.3 times the
        `noise_floor`, which suits noise of equal strength everywhere and needs `scored` vertices. A mesh of exact planes has 0.
        """
        if not len(self.faces) or is_designed(self.points, self.faces):
            return 0.0
        if not self.scored.any():
            return self.noise.level
        floor = noise_floor(self.points, self.faces, normals=self.normals, scored=self.scored)
        return min(self.noise.level, tuned.EVEN * floor)

    @cached_property
    def without_impulses(self) -> "tuple[Scan, bool]":
        """The scan with its outliers replaced (unchanged if it has no impulse noise), and whether its noise is uneven."""
        replaced, outlying = replace_outlying(self.points, self.faces, self.movable)
        if outlying.sum() <= 0.5 * tuned.IMPULSIVE * len(outlying):  # 0.5: with uneven noise, half of the mesh may be calm
            return self, False
        beside, elsewhere = sizes_beside(replaced, self.faces, self.normals, outlying, self.scored)
        uneven = beside > max(tuned.LARGER * elsewhere, tuned.WEAK)
        impulsive = not uneven and np.mean(outlying) > tuned.IMPULSIVE
        return (replace(self, points=replaced, replaced=outlying) if impulsive else self), uneven

    @property
    def has_impulses(self) -> bool:
        """Whether there is impulse noise, whose spikes can look like relief."""
        return self.without_impulses[0] is not self

    @property
    def shows_surface(self) -> bool:
        """Whether the residuals show edges and details besides noise."""
        return self.agreement[0] > tuned.SURFACE

    @property
    def is_surface(self) -> bool:
        """Whether the residuals show the surface alone: they correlate between neighbours even in the calmest third."""
        return self.shows_surface and self.agreement[1] > tuned.SURFACE_WHERE_CALM

    @property
    def clean(self) -> bool:
        """Whether the noise is negligible."""
        return self.noise.level < tuned.NO_NOISE or self.is_surface

    def or_nothing(self, choice: Choice[Label]) -> Choice[Label]:
        """Returns the choice, changed to its first candidate (do nothing) if the chosen filter removes details.

        A filter removes details if residuals of neighbours correlate and its prediction error is at least 1.2 x the noise level.
        """
        removes_details = self.shows_surface and choice.chosen.error >= tuned.LARGER * self.noise.level
        return replace(choice, chosen=choice.trials[0]) if removes_details else choice

    def choose(
        self,
        candidates: Candidates,
        labels: Sequence[Sequence[Label]],
        *,
        stays: float = tuned.STAYS,
        by_means: bool = False,
        denoised: Callable[[Floats], Floats] | None = None,
        progress: Progress | None = None,
    ) -> Choice[Label] | None:
        """Chooses the filter that best predicts held-out vertices [batson2019]; None if no vertex can be held out.

        Noise is independent between neighbours, the surface is not. So a filter that predicts a vertex well from its neighbours
        fits the surface. Held-out vertices start at `initial_positions`: on fitted quadrics or at means of neighbours. With
        `by_means` they start at means, which favours settings that move only outliers. A result f deviates from a vertex y by
        n . (y - f). `labels` and `stays` are those of `cross_validate`; `progress` None is that of the scan.

        With `denoised`, a filter of (n, 3) points, the middles of held-out balls are predicted: they share hardly any noise with
        vertices outside. `denoised` filters the other vertices, and balls start on the smoothest surface through them.
        """
        held_out, sets = (held_out_vertices, tuned.SETS) if denoised is None else (middles_of_balls, tuned.SETS // 2)
        held = held_out(self.points, self.faces, scored=self.scored, sets=sets, seed=self.seed)
        if not held:
            return None
        start = initial_positions(self.points, self.faces, normals=self.normals, scored=self.scored, by_means=by_means)
        if denoised is not None:
            start = partial(self._with_smooth_balls, denoised)
        sums = self.normals[self.faces].sum(axis=1)

        def deviations(mask: Ints, _: int, result: Floats) -> Floats:
            return np.asarray(np.einsum("ij,ij->i", self.points[mask] - result[mask], self.normals[mask]))

        def share_flipped(result: Floats) -> float:
            return float(np.mean(np.einsum("ij,ij->i", cross_products(result, self.faces), sums) < 0.0))

        return cross_validate(
            self.points,
            held,
            lambda mask: candidates(start(mask), mask),
            deviations,
            labels,
            share_flipped=share_flipped,
            stays=stays,
            progress=progress or self.progress,
        )

    def _with_smooth_balls(self, denoised: Callable[[Floats], Floats], middles: Ints) -> Floats:
        """Returns the (n, 3) points, with the balls on the smoothest surface through the other vertices after `denoised`."""
        ball = with_neighbours(mask_of(middles, len(self.points)), edges(self.faces), BALL)
        continued = harmonic_continuation(self.faces, ~ball, order=2)
        return np.where(ball[:, None], continued(denoised(continued(self.points))), self.points)

    def choose_by_risk(
        self, candidates: Candidates, labels: Sequence[Sequence[Label]], noise: Floats | None = None
    ) -> Choice[Label] | None:
        """Chooses the result with the least expected error of its edge vectors [stein1981], for noise of any covariance.

        A filter f moves the points y along their normals n by h = n n . (f(y) - y). Its response to noise is measured with added
        noise b along the normals [ramani2008]: g = n n . (f(y + e b) - f(y)) / e for a small e. `noise` gives b its (n,)
        heights, with the covariance of the noise in y; None: independent noise. The squared error of an edge vector, plus the
        variance of its noise, is the mean of |h_i - h_j|^2 + 2 (b_i - b_j) . (g_i - g_j). Shrinking is an error, too, since it
        shortens edges. See `flattest` for the choice. Errors are in mean edges. None if no edge joins scored vertices.
        """
        pairs = edges(self.faces)
        i, j = pairs[self.scored[pairs].all(axis=1)].T
        if not len(i):
            return None
        heights = self.noise.level * random_signs(self.points, pairs, self.seed) if noise is None else noise

        def moves_of(result: Floats) -> Floats:
            return np.asarray(np.einsum("ij,ij->i", result - self.points, self.normals)[:, None] * self.normals)

        b, first, second = heights[:, None] * self.normals, part_of(self.progress, 0.0, 0.5), part_of(self.progress, 0.5, 1.0)
        runs = candidates(self.points, NONE_HELD)
        measures = measured(runs, labels, lambda _, result: (moves_of(result), roughness(result, self.faces)), first)
        moves, flatness = zip(*measures, strict=True)
        noisier = candidates(self.points + _LITTLE * b, NONE_HELD)
        responses = measured(noisier, labels, lambda at, result: (moves_of(result) - moves[at]) / _LITTLE, second)
        squares = ((h[i] - h[j]) ** 2 + 2.0 * (b[i] - b[j]) * (g[i] - g[j]) for h, g in zip(moves, responses, strict=True))
        return self.flattest(i, (each.sum(axis=1) for each in squares), flatness, labels)

    def flattest(
        self, at: Ints, squares: Iterable[Floats], flatness: Sequence[float], labels: Sequence[Sequence[Label]], limit: float = 0
    ) -> Choice[Label]:
        """Chooses the flattest result whose error is at most `limit`, or within one standard error of the least.

        `squares` has the (m,) squared errors of each result at the (m,) vertices `at`, `flatness` the roughness of each.
        """
        # Random vertices are the middles of the regions; a vertex belongs to the middle that is nearest to it.
        distances = np.linalg.norm(self.points[at] - self.points[at].mean(axis=0), axis=1)
        middles = at[np.argsort((distances * 1013.0) % 1.0, kind="stable")]
        middles = middles[np.sort(np.unique(middles, return_index=True)[1])][:_REGIONS]
        regions = spatial.cKDTree(self.points[middles]).query(self.points[at])[1]
        sums = np.array([np.bincount(regions, values, minlength=_REGIONS) / len(at) for values in squares])
        shares = np.bincount(regions, minlength=_REGIONS) / len(at)
        means = sums.sum(axis=1)
        best, excess = int(means.argmin()), means - means.min()
        uncertainty = np.sqrt(((sums - sums[best] - excess[:, None] * shares) ** 2).sum(axis=1))
        chosen = int(np.where((excess <= uncertainty) | (means <= limit**2), flatness, np.inf).argmin())
        return Scores(np.sqrt(np.maximum(means, 0.0)), excess, uncertainty, best).choice(labels, chosen)


def _grown(vertices: Floats, faces: Ints, edge: float, patches: int, size: int) -> tuple[Ints, Ints]:
    """Returns the faces of the patches with new vertex numbers, and the mesh vertex of each new number."""
    at_vertices, marks = vertex_faces(faces, len(vertices)), np.full(len(faces), -1, dtype=np.int32)
    perimeters = np.sum([edge_lengths(vertices, faces[:, ends]) for ends in ([0, 1], [1, 2], [2, 0])], axis=0)
    numbers = (perimeters / edge * 1013.0) % 1.0  # pseudo-random
    least = np.flatnonzero(numbers <= np.partition(numbers, patches - 1)[patches - 1])
    parts, origins, count = [], [], 0
    for number, seed in enumerate(least[np.argsort(numbers[least], kind="stable")][:patches]):
        part = faces[np.sort(_rings_around(faces, at_vertices, seed, size, number, marks))]
        origin, local = np.unique(part, return_inverse=True)
        parts.append(local.reshape(-1, 3).astype(np.int32) + np.int32(count))
        origins.append(origin.astype(np.int32))
        count += len(origin)
    return np.concatenate(parts), np.concatenate(origins)


@compiled
def _rings_around(faces: Ints, at_vertices: VertexFaces, seed: int, least: int, number: int, marks: Ints) -> Longs:
    """Returns the seed face and complete rings around it, at least `least` faces if possible. No mark may equal `number`."""
    ring_faces = [seed]
    marks[seed] = number
    start, stop = 0, 1
    while start < stop and stop < least:
        for at in range(start, stop):
            for i in faces[ring_faces[at]]:
                for f in at_vertices.rows[at_vertices.offsets[i] : at_vertices.offsets[i + 1], 0]:
                    if marks[f] != number:
                        marks[f] = number
                        ring_faces.append(int(f))
        start, stop = stop, len(ring_faces)
    return np.array(ring_faces)
