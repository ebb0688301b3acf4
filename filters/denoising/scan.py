"""A scan on which filters are tried: which of its vertices are evidence, and whether they say that it is noisy at all."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

from numpy.typing import ArrayLike

from ..evidence import (
    Candidates,
    Choice,
    choose,
    choose_by_risk,
    far_from_border,
    random_signs,
    sample_of,
    tuned,
)
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import edges
from .noise_level import Agreement, NoiseEstimate, estimate_noise, smooth_normals

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
    def agreement(self) -> Agreement:
        """How much the residuals of neighbours agree: those of edges and details do, those of noise do not."""
        return Agreement.of(self.points, self.faces)

    @property
    def clean(self) -> bool:
        """Whether there is no noise to speak of: hardly any, or neighbours agree, also where it is calm."""
        return self.noise.level < tuned.NO_NOISE or self.agreement.is_surface

    def or_nothing(self, choice: Choice[Label]) -> Choice[Label]:
        """The choice, or the first of its candidates, which is to do nothing, where what predicts best takes details.

        Where neighbours agree the residuals are of details, too. A filter takes details if it errs by more than what the
        differences of fourth order leave.
        """
        takes_details = self.agreement.shows_surface and choice.chosen.error >= tuned.LARGER * self.noise.level
        return replace(choice, chosen=choice.trials[0]) if takes_details else choice

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
