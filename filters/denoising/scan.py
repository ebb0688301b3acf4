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
    heights_of_means,
    random_signs,
    sample_of,
    scores_of,
    tuned,
)
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import edges, one_rings
from .noise_level import NoiseEstimate, estimate_noise, noise_floor, residual_correlation, smooth_normals

Label = TypeVar("Label")


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
    def correlation(self) -> float:
        """How much the residuals of neighbours agree: noise does not, a surface does."""
        return residual_correlation(self.points, self.faces)

    @cached_property
    def correlation_where_calm(self) -> float:
        """The same in the calmest third, where edges and details do not hide weak noise."""
        return residual_correlation(self.points, self.faces, calmest=1.0 / 3.0)

    @property
    def clean(self) -> bool:
        """Whether there is no noise to speak of: hardly any, or what is left is surface, where it is calm too."""
        if self.noise.level < tuned.NO_NOISE:
            return True
        if self.correlation > tuned.SURFACE:
            # Edges and details agree beside weak noise too: where it is calm noise does not.
            return self.quietest < tuned.NO_NOISE or self.correlation_where_calm > tuned.AGREES_WHERE_CALM
        smoothed = not self.independent and self.quietest < tuned.SMOOTHED
        return smoothed and self.correlation_where_calm > tuned.SURFACE_WHERE_CALM

    @property
    def independent(self) -> bool:
        """Whether neighbours hardly agree in what is left: then it is noise."""
        return self.correlation < tuned.INDEPENDENT

    @property
    def exact(self) -> bool:
        """Whether there is so little noise that most vertices are best left where they are, uneven noise not being clean."""
        nearly = not self.independent and self.quietest < tuned.WEAK
        return self.quietest < tuned.NO_NOISE or (nearly and self.correlation_where_calm > tuned.AGREES_WHERE_CALM)

    def choose(
        self, candidates: Candidates, labels: Sequence[Sequence[Label]], *, stays: float = tuned.STAYS, by_means: bool = False
    ) -> Choice[Label] | None:
        """`choose`, on this scan."""
        return choose(
            self.points,
            self.faces,
            candidates,
            labels,
            normals=self.normals,
            scored=self.scored,
            seed=self.seed,
            stays=stays,
            by_means=by_means,
            progress=self.progress,
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
        done where e^2 >= 2 s^2, s that of `quietest`, or where the mean of the neighbours predicts nearly as well: a vertex of a
        plane with even noise s is sqrt(1 + 1/6) s from the mean of its six neighbours, and s from the plane: 0.93 of it.
        """
        if self.independent:
            return choice
        error, which = choice.chosen.error, np.flatnonzero(self.scored).astype(np.int32)
        of_means = heights_of_means(self.points, one_rings(self.faces, len(self.points)), self.normals, which)
        nearer = error**2 < 2.0 * (tuned.EVEN * self.quietest) ** 2
        better = error < tuned.BETTER * scores_of(of_means[None]).errors[0]
        return choice if nearer and better else replace(choice, chosen=choice.trials[0])
