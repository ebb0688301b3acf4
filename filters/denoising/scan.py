"""A scan on which filters are tried: which of its vertices are evidence, whether they say that it is noisy, and what suits it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..compilation import compiled
from ..evidence import (
    Candidates,
    Choice,
    Scores,
    cross_validate,
    far_from_border,
    held_out_vertices,
    initial_positions,
    measured,
    random_signs,
    tuned,
)
from ..execution import Progress, ignore_progress, part_of
from ..geometry import edge_lengths, face_normals, mean_edge_length, roughness
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints, Longs, check_mesh, normalised_mesh
from ..topology import VertexFaces, edges, referenced_vertices, vertex_faces
from .impulses import replace_outlying, sizes_beside
from .noise_level import NoiseEstimate, agreement, estimate_noise, is_designed, noise_floor, smooth_normals

Label = TypeVar("Label")

#: no vertex is held out
NONE_HELD = np.empty(0, dtype=np.int32)
# The noise is added once more, times this: little enough that the filter does not see it, and far more than rounding.
_LITTLE = 0.1
# Standard errors are those of the means of so many regions: neighbours say the same.
_REGIONS = 100
# Larger meshes are sampled: ten large patches have misled, since shapes differ from place to place.
_WHOLE = 20_000


@dataclass(frozen=True)
class Scan:
    """A mesh with a mean edge of 1, or patches of a large one."""

    points: Floats  # (n, 3) coordinates around 0
    faces: Ints  # (m, 3) triangles
    movable: Bools | None = None  # (n,) which vertices may move, None for all; the others are not evidence
    seed: int = 0  # other vertices are held out for another number
    progress: Progress = ignore_progress  # called while filters are tried; may raise to stop
    replaced: Bools | None = None  # (n,) outliers that were replaced and are not evidence, None for none
    whole: bool = True  # whether it is all of the mesh
    rings: int = 2  # so many complete rings are around the vertices that are evidence

    @staticmethod
    def of(vertices: ArrayLike, faces: ArrayLike, *, movable: ArrayLike | None = None, **attributes: Any) -> "Scan":
        """Of a mesh, see `sampled`, with these attributes; `FilterInputError` if it is none or `movable` does not fit."""
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
        """All of a mesh of up to 20,000 faces, or else patches, each of whole rings around a face.

        The faces are those with the least random numbers, made of their perimeters over the mean edge: renumbering, moving,
        turning and scaling the mesh changes none of them by more than rounding. The (n, 3) points are of ordinary size, `edge` is
        the mean edge if it is known, `patches` says how many there are and how many faces they have at least, `attributes` are
        others of the scan.

        Returns the scan, and (k,) which vertices of the mesh it has; one of several patches appears several times.
        """
        whole = len(faces) <= _WHOLE
        chosen, origin = faces, np.arange(len(points), dtype=np.int32)
        if not whole:
            chosen, origin = _grown(points, faces, edge or mean_edge_length(points, faces), *patches)
        local = points[origin]
        used = local[referenced_vertices(chosen, len(local))]
        local -= used.mean(axis=0) if len(used) else 0.0
        local /= mean_edge_length(points[origin], chosen) or 1.0  # a mesh without a size is not to be scaled
        moves = None if movable is None else movable[origin]
        return Scan(local, np.ascontiguousarray(chosen), moves, whole=whole, **attributes), origin

    @cached_property
    def noise(self) -> NoiseEstimate:
        """How noisy it is."""
        return estimate_noise(self.points, self.faces)

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) the unit normals of a smoothed copy."""
        return smooth_normals(self.points, self.faces)

    @cached_property
    def scored(self) -> Bools:
        """(n,) the vertices that are evidence."""
        scored = far_from_border(self.faces, len(self.points), rings=self.rings)
        for allowed in (self.movable, None if self.replaced is None else ~self.replaced):
            scored = scored if allowed is None else scored & allowed
        return scored

    @cached_property
    def agreement(self) -> tuple[float, float]:
        """How much the residuals of neighbours agree, everywhere and where it is calm."""
        return agreement(self.points, self.faces)

    @cached_property
    def surface_noise(self) -> float:
        """The standard deviation of the noise along the normals in mean edges, as recipes name it: the smaller of two estimates.

        `estimate_noise` takes fine details, as fur, for noise; `noise_floor` sees noise alone where the surface is calm, and 1.3
        times that is even noise. 0 of planes as they were designed, and of a mesh without inner vertices.
        """
        if not len(self.faces) or is_designed(self.points, self.faces):
            return 0.0
        if not self.scored.any():
            return self.noise.level
        floor = noise_floor(self.points, self.faces, normals=self.normals, scored=self.scored)
        return min(self.noise.level, tuned.EVEN * floor)

    @cached_property
    def without_impulses(self) -> "tuple[Scan, bool]":
        """The scan with outliers replaced, itself where there is no impulse noise; and whether its noise is uneven instead."""
        replaced, outlying = replace_outlying(self.points, self.faces, self.movable)
        if outlying.sum() <= 0.5 * tuned.IMPULSIVE * len(outlying):  # half a mesh may be calm
            return self, False
        beside, elsewhere = sizes_beside(replaced, self.faces, self.normals, outlying, self.scored)
        uneven = beside > max(tuned.LARGER * elsewhere, tuned.WEAK)
        impulsive = not uneven and np.mean(outlying) > tuned.IMPULSIVE
        return (replace(self, points=replaced, replaced=outlying) if impulsive else self), uneven

    @property
    def has_impulses(self) -> bool:
        """Whether there is impulse noise, whose spikes pass for relief."""
        return self.without_impulses[0] is not self

    @property
    def shows_surface(self) -> bool:
        """Whether the residuals are of edges and details, too."""
        return self.agreement[0] > tuned.SURFACE

    @property
    def is_surface(self) -> bool:
        """Whether they are of the surface alone: neighbours agree where it is calm, too."""
        return self.shows_surface and self.agreement[1] > tuned.SURFACE_WHERE_CALM

    @property
    def clean(self) -> bool:
        """Whether there is no noise to speak of: hardly any, or residuals of the surface alone."""
        return self.noise.level < tuned.NO_NOISE or self.is_surface

    def or_nothing(self, choice: Choice[Label]) -> Choice[Label]:
        """The choice, or the first of its candidates, which is to do nothing, where what predicts best takes details.

        That is where neighbours agree and it errs by more than what the differences of fourth order leave.
        """
        takes_details = self.shows_surface and choice.chosen.error >= tuned.LARGER * self.noise.level
        return replace(choice, chosen=choice.trials[0]) if takes_details else choice

    def few_flipped(self, candidates: Candidates, labels: Sequence[Sequence[Label]], choice: Choice[Label]) -> Choice[Label]:
        """The best of the candidates within two standard errors of it that do not leave many faces flipped.

        Heights along the normals hardly tell of faces folded over, though their normals are all wrong.
        """
        near = {trial.label: trial for trial in choice.rivals}
        means = self.normals[self.faces].sum(axis=1)

        def flipped(_: int, result: Floats) -> float:
            return float(np.mean(np.einsum("ij,ij->i", face_normals(result, self.faces), means) < 0.0))

        wanted = [label in near for family in labels for label in family]
        shares = measured(candidates(self.points, NONE_HELD), labels, flipped, kept=np.array(wanted))
        most = max(tuned.FLIPPED, 2.0 * min(shares))
        left = [trial for trial, share in zip(near.values(), shares, strict=True) if share <= most]
        return replace(choice, chosen=min(left, key=lambda trial: trial.error))

    def choose(
        self, candidates: Candidates, labels: Sequence[Sequence[Label]], *, stays: float = tuned.STAYS, by_means: bool = False
    ) -> Choice[Label] | None:
        """Choose the filter that best predicts vertices which it has not seen [batson2019]; None if no vertex can be held out.

        Noise of a vertex is independent of its neighbours', the surface is not: what predicts a vertex from the others fits the
        surface. Held-out vertices y start at their `initial_positions`, and n . (y - f) is measured at the results f of the
        candidates; `labels` and `stays` are of `cross_validate`. They start at means in any case `by_means`: quadrics hide what
        it costs to move vertices that are exact. The choice is the same for any number of threads.
        """
        held = held_out_vertices(self.points, self.faces, scored=self.scored, masks=tuned.MASKS, seed=self.seed)
        if not held:
            return None
        start = initial_positions(self.points, self.faces, normals=self.normals, scored=self.scored, by_means=by_means)

        def deviations(mask: Ints, _: int, result: Floats) -> Floats:
            return np.asarray(np.einsum("ij,ij->i", self.points[mask] - result[mask], self.normals[mask]))

        return cross_validate(
            held, lambda mask: candidates(start(mask), mask), deviations, labels, stays=stays, progress=self.progress
        )

    def choose_by_risk(
        self, candidates: Candidates, labels: Sequence[Sequence[Label]], noise: Floats | None = None
    ) -> Choice[Label] | None:
        """Choose the result whose slopes are expected to be nearest to the true ones [stein1981], for noise of any covariance.

        What a filter f makes of noise can be seen [ramani2008]: with heights h = n . (f(y) - y), one more noise b of the same
        covariance, (n,) heights or None for noise of single vertices, and g = n . (f(y + e b) - f(y)) / e, the mean over the
        edges of (h_i - h_j)^2 + 2 (b_i - b_j) (g_i - g_j) is the squared error of the differences of heights along the edges, and
        the variance of the noise in these. Of those within one standard error of the best the flattest is taken. The very first
        label should be that of doing nothing; errors are in mean edges. None if no edge counts.
        """
        pairs = edges(self.faces)
        i, j = pairs[self.scored[pairs].all(axis=1)].T
        if not len(i):
            return None
        more = self.noise.level * random_signs(self.points, pairs, self.seed) if noise is None else noise

        def heights_of(result: Floats) -> Floats:
            return np.asarray(np.einsum("ij,ij->i", result - self.points, self.normals))

        first, second = part_of(self.progress, 0.0, 0.5), part_of(self.progress, 0.5, 1.0)
        found = candidates(self.points, NONE_HELD)
        looks = measured(found, labels, lambda _, result: (heights_of(result), roughness(result, self.faces)), first)
        heights, flatness = zip(*looks, strict=True)
        noisier = candidates(self.points + _LITTLE * more[:, None] * self.normals, NONE_HELD)
        passed = measured(noisier, labels, lambda at, result: (heights_of(result) - heights[at]) / _LITTLE, second)
        # Regions are what is nearest to vertices that lie anywhere.
        distances = np.linalg.norm(self.points[i] - self.points[i].mean(axis=0), axis=1)
        middles = i[np.argsort((distances * 1013.0) % 1.0, kind="stable")]
        middles = middles[np.sort(np.unique(middles, return_index=True)[1])][:_REGIONS]
        regions = spatial.cKDTree(self.points[middles]).query(self.points[i])[1]
        squares = ((h[i] - h[j]) ** 2 + 2.0 * (more[i] - more[j]) * (g[i] - g[j]) for h, g in zip(heights, passed, strict=True))
        sums = np.array([np.bincount(regions, values, minlength=_REGIONS) / len(i) for values in squares])
        shares = np.bincount(regions, minlength=_REGIONS) / len(i)
        means = sums.sum(axis=1)
        best = int(means.argmin())
        excess = means - means[best]
        uncertainty = np.sqrt(((sums - sums[best] - excess[:, None] * shares) ** 2).sum(axis=1))
        flattest = int(np.where(excess <= uncertainty, flatness, np.inf).argmin())
        return Scores(np.sqrt(np.maximum(means, 0.0)), excess, uncertainty, best).choice(labels, flattest)


def _grown(vertices: Floats, faces: Ints, edge: float, patches: int, size: int) -> tuple[Ints, Ints]:
    """The faces of the patches, by numbers of their own, and the vertex that each of these numbers stands for."""
    at_vertices, marks = vertex_faces(faces, len(vertices)), np.full(len(faces), -1, dtype=np.int32)
    perimeters = np.sum([edge_lengths(vertices, faces[:, ends]) for ends in ([0, 1], [1, 2], [2, 0])], axis=0)
    numbers = (perimeters / edge * 1013.0) % 1.0  # random
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
    """The face and whole rings of faces around it, until they are as many as said; `marks` differ from `number` before."""
    found = [seed]
    marks[seed] = number
    start, stop = 0, 1
    while start < stop and stop < least:
        for at in range(start, stop):
            for i in faces[found[at]]:
                for f in at_vertices.rows[at_vertices.offsets[i] : at_vertices.offsets[i + 1], 0]:
                    if marks[f] != number:
                        marks[f] = number
                        found.append(int(f))
        start, stop = stop, len(found)
    return np.array(found)
