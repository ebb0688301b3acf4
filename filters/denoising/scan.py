"""A scan on which filters are tried: which of its vertices are evidence, and whether they say that it is noisy at all."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..evidence import (
    Candidates,
    Choice,
    choose,
    choose_by_risk,
    far_from_border,
    guess_by_means,
    heights_of_means,
    judge,
    noise_floor,
    random_signs,
    sample_of,
)
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import edges, one_rings
from .noise_level import NoiseEstimate, estimate_noise, smooth_normals
from .residual_correlation import ResidualCorrelation

Label = TypeVar("Label")

# The agreement of surfaces without noise is 0.1 to 1.3, with noise of 0.2 edges and more below 0.05, however uneven it is. In the
# calmest third, where edges and details do not hide weak noise, it is 0.148 and more without noise, up to 0.122 with 0.03 edges.
_INDEPENDENT, _SURFACE, _CALMEST, _SURFACE_THERE = 0.05, 0.2, 1.0 / 3.0, 0.13
# Noise that is weaker moves no vertex by a hundredth of an edge.
_NONE = 0.01
# Noise of 0.05 edges has more than this by `noise_floor`, 0.036 to 0.053. Scans smoothed or decimated have less.
_SMOOTHED = 0.035
# Where spikes have been replaced and the other vertices are exact, or nearly so, these have up to 0.049 edges of noise by
# `noise_floor`, and mostly agree in the calmest third by more than this. Where they have noise too, they have more of it or agree
# by less; on a ball with bumps they do not agree without noise either, but hardly anything is left.
_NEARLY_EXACT, _AGREES_THERE, _EXACT = 0.05, 0.07, 0.005
# Even noise is so many times what `noise_floor` says of it: 1.2 to 1.5 on parts, figures and surfaces.
_EVEN = 1.3
# A vertex of a plane with even noise s is sqrt(1 + 1/6) s from the mean of its six neighbours, and s from the plane: 0.93 of it.
_BETTER = 0.95


@dataclass(frozen=True)
class Scan:
    """A mesh with a mean edge of 1, or patches of a large one.

    Attributes:
        points: (n, 3) coordinates around 0.
        faces: (m, 3) triangles.
        movable: (n,) which vertices may move, None for all. The others are not evidence.
        seed: other vertices are held out for another number.
        progress: called while filters are tried; may raise to stop.
        replaced: (n,) outliers that were replaced and are not evidence, None for none.
        whole: whether it is all of the mesh.
    """

    points: Floats
    faces: Ints
    movable: Bools | None = None
    seed: int = 0
    progress: Progress = ignore_progress
    replaced: Bools | None = None
    whole: bool = True

    @staticmethod
    def of(
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        movable: ArrayLike | None = None,
        seed: int = 0,
        progress: Progress = ignore_progress,
    ) -> "Scan":
        """Of a mesh, see `sample_of`; its arguments are those of the attributes.

        Raises:
            FilterInputError: not a mesh, or `movable` does not fit.
        """
        mesh = normalised_mesh(*check_mesh(vertices, faces), movable)
        sample = sample_of(mesh.points, mesh.cells)
        moves = None if mesh.movable is None else mesh.movable[sample.origin]
        return Scan(sample.points, sample.faces, moves, seed, progress, whole=len(sample.faces) == len(mesh.cells))

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
        scored = far_from_border(self.faces, len(self.points))
        for allowed in (self.movable, None if self.replaced is None else ~self.replaced):
            scored = scored if allowed is None else scored & allowed
        return scored

    @cached_property
    def quietest(self) -> float:
        """The noise of its quietest parts."""
        return noise_floor(self.points, self.faces, normals=self.normals, scored=self.scored)

    @cached_property
    def residuals(self) -> ResidualCorrelation:
        """What is left after differences of fourth order, and how much neighbours agree in it: noise does not, a surface does."""
        return ResidualCorrelation.on(self.points, self.faces)

    @cached_property
    def correlation(self) -> float:
        """How much neighbours agree in all of it."""
        return self.residuals.within()

    @property
    def clean(self) -> bool:
        """Whether there is no noise to speak of: hardly any, or what is left is surface, where it is calm too."""
        if self.noise.level < _NONE:
            return True
        if self.correlation > _SURFACE:
            # Edges and details agree beside weak noise too: where it is calm noise does not.
            return self.quietest < _EXACT or self.residuals.within(_CALMEST) > _AGREES_THERE
        smoothed = self.correlation > _INDEPENDENT and self.quietest < _SMOOTHED
        return smoothed and self.residuals.within(_CALMEST) > _SURFACE_THERE

    @property
    def independent(self) -> bool:
        """Whether neighbours hardly agree in what is left: then it is noise."""
        return self.correlation < _INDEPENDENT

    @property
    def exact(self) -> bool:
        """Whether there is so little noise that most vertices are best left where they are, uneven noise not being clean."""
        nearly = self.correlation > _INDEPENDENT and self.quietest < _NEARLY_EXACT
        return self.quietest < _EXACT or (nearly and self.residuals.within(_CALMEST) > _AGREES_THERE)

    def choose(
        self,
        candidates: Candidates,
        labels: Sequence[Sequence[Label]],
        *,
        all_stay: bool = False,
        spikes: bool = False,
    ) -> Choice[Label] | None:
        """`choose`, on this scan.

        Args:
            candidates: what is tried.
            labels: the names of their results.
            all_stay: all candidates are tried to the end.
            spikes: what is tried differs in what it makes of spikes: held-out vertices start at the mean of their neighbours,
                since a quadric is bent by spikes, and hides what it costs to move vertices that are exact. The least error
                decides alone: slopes are expected for noise that is alike everywhere.
        """
        return choose(
            self.points,
            self.faces,
            candidates,
            labels,
            normals=self.normals,
            scored=self.scored,
            guess=guess_by_means(self.points, self.faces) if spikes else None,
            seed=self.seed,
            slopes=not spikes,
            progress=self.progress,
            **({"stays": 1e12} if all_stay else {}),
        )

    def choose_by_risk(self, candidates: Candidates, labels: Sequence[Sequence[Label]]) -> Choice[Label] | None:
        """`choose_by_risk` on it, for filters that take noise and shape alike; the noise is as strong as `noise` says."""
        return choose_by_risk(
            self.points,
            self.faces,
            candidates,
            labels,
            normals=self.normals,
            scored=self.scored,
            noise=self.noise.level * random_signs(self.points, edges(self.faces), self.seed),
            progress=self.progress,
        )

    def or_nothing(self, choice: Choice[Label]) -> Choice[Label]:
        """The choice, or the first of its candidates, which is to do nothing, where what predicts best is no nearer to the truth.

        Where neighbours hardly agree there is noise. Otherwise, with the error e of what predicts best and the standard deviation
        s of the noise, e^2 = s^2 + d^2, where d is how far the result is from the truth, and the scan is s from it: nothing is
        done where e^2 >= 2 s^2, s that of `quietest`, or where the mean of the neighbours predicts nearly as well.
        """
        if self.independent:
            return choice
        error, which = choice.chosen.error, np.flatnonzero(self.scored).astype(np.int32)
        of_means = heights_of_means(self.points, one_rings(self.faces, len(self.points)), self.normals, which)
        nearer = error**2 < 2.0 * (_EVEN * self.quietest) ** 2
        better = error < _BETTER * judge(of_means[None]).errors[0]
        return choice if nearer and better else replace(choice, chosen=choice.trials[0])
