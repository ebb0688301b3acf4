"""A filter chosen by what it says of vertices that it has not seen."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from ..execution import Progress, ignore_progress, part_of, rising
from ..mesh import Bools, Floats, Ints
from .cross_validation import STAYS, cross_validate, run_to_last, starts_of
from .equals import among_equals
from .first_guess import Guess, first_guess
from .held_out import held_out_vertices
from .slopes import SlopeError
from .verdict import EQUAL, Verdict

Label = TypeVar("Label")

#: Given (n, 3) vertices and the numbers of those that are held out, one iterator a family of filters over (n, 3) results, from
#: the first to the last of the family. They are read in threads, each only as far as is needed.
Candidates: TypeAlias = Callable[[Floats, Ints], Sequence[Iterator[Floats]]]

# Sets of held-out vertices, and as many more on small meshes until so many vertices were held out or so many sets are made.
_MASKS, _ENOUGH, _MOST_MASKS = 4, 1000, 12


@dataclass(frozen=True)
class Trial(Generic[Label]):
    """One candidate and what was found of it.

    Attributes:
        label: which it is.
        error: the root mean square of its deviations at the held-out vertices, outliers clipped, in mean edges.
        excess: how much its mean square exceeds that of the best, in squared mean edges.
        uncertainty: the standard error of the excess.
        slopes: the square of the error that is expected of its slopes, see `slope_errors`; None where it was not
            asked for.
    """

    label: Label
    error: float
    excess: float
    uncertainty: float
    slopes: float | None


@dataclass(frozen=True)
class Choice(Generic[Label]):
    """What was chosen, and the candidates that were tried on all held-out vertices, in the order in which they were given."""

    chosen: Trial[Label]
    trials: tuple[Trial[Label], ...]


def trials_of(
    every: Sequence[Label], tried: Ints, verdict: Verdict, slopes: Mapping[int, float] | None = None
) -> tuple[Trial[Label], ...]:
    """The trials of the candidates that were tried to the end.

    Args:
        every: the labels of all candidates.
        tried: (k,) the numbers of those that were tried.
        verdict: on these.
        slopes: the errors of slopes that are expected of some, by their numbers.
    """
    known = slopes or {}
    return tuple(
        Trial(every[at], float(error), float(excess), float(uncertainty), known.get(int(at)))
        for at, error, excess, uncertainty in zip(tried, verdict.errors, verdict.excess, verdict.uncertainty, strict=True)
    )


def choose(
    points: Floats,
    faces: Ints,
    candidates: Candidates,
    labels: Sequence[Sequence[Label]],
    *,
    normals: Floats,
    scored: Bools,
    guess: Guess | None = None,
    seed: int = 0,
    stays: float = STAYS,
    slopes: bool = True,
    progress: Progress = ignore_progress,
) -> Choice[Label] | None:
    """Choose the filter that best predicts vertices which it has not seen [batson2019].

    Noise of a vertex is independent of its neighbours', the surface is not: what predicts a vertex from the others fits
    the surface.

    1. Hold out some vertices: put them where the others say, `first_guess`.
    2. Run every candidate, and measure n . (y - f) at the held-out vertices y; again with other vertices. After each time
       candidates that are worse than the best by more than two standard errors are dropped, the very first one apart: it is
       what the others are compared with.
    3. Positions hardly tell candidates apart whose normals differ by far. Of those within two standard errors of the best leave
       out those that leave many faces folded over where others do not, see `upright`. Of the others take the one whose slopes
       are expected to be nearest to the true ones [stein1981]: as much as a candidate follows the noise, so much it will follow
       a little more of it, which is added to see that [ramani2008]; see `slope_errors`.
    4. Of those whose slopes are within one standard error take the one with the least product of the mean |n_f - n_g| over
       adjacent faces f, g of its result and of their mean displacement along the normals, as [reginska1996] does for the two
       norms of a regularised solution: flat, but not at any price. The very first wins where it predicts as well as the best.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        candidates: what is tried.
        labels: for each family the labels of its results. The very first should be that of doing nothing.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that may be held out; those near a border see half of their surroundings.
        guess: where held-out vertices start; None for `first_guess`.
        seed: other vertices are held out for another number.
        stays: candidates farther behind than so many standard errors are dropped; a huge number to try them all to the end.
        slopes: whether steps 3 and 4 are done; otherwise the best in step 2 is taken.
        progress: called after every family that was run; may raise to stop.

    Returns:
        The choice, the same for any number of threads; None if no vertex can be held out.
    """
    held = _masks(points, faces, scored, seed)
    if not held:
        return None
    start = guess or first_guess(points, faces, normals=normals, scored=scored)
    every = [label for family in labels for label in family]
    starts = starts_of(labels)

    def deviations(at: int, result: Floats, mask: Ints) -> Floats:
        del at
        return np.asarray(np.einsum("ij,ij->i", points[mask] - result[mask], normals[mask]))

    tried, verdict = cross_validate(
        held,
        lambda mask: candidates(start(mask), mask),
        deviations,
        starts,
        stays=stays,
        progress=part_of(progress, 0.0, 0.8),
    )
    share = rising(part_of(progress, 0.8, 1.0))

    def run(vertices: Floats, which: Sequence[int], look: Callable[[int, Floats], None]) -> None:
        wanted = np.zeros(len(every), dtype=np.bool_)
        wanted[list(which)] = True
        run_to_last(candidates(vertices, np.empty(0, dtype=np.int32)), starts, wanted, look, share)

    chosen, errors = int(tried[verdict.best]), dict[int, SlopeError]()
    near = verdict.within(STAYS)
    alike = [int(tried[at]) for at in np.argsort(verdict.excess, kind="stable") if near[at]]
    if verdict.within(EQUAL)[0]:
        chosen = 0
    elif slopes and len(alike) > 1:
        chosen, errors = among_equals(points, faces, run, alike, normals=normals, scored=scored, seed=seed)
    trials = trials_of(every, tried, verdict, {at: slope.error for at, slope in errors.items()})
    return Choice(trials[int(np.searchsorted(tried, chosen))], trials)


def _masks(points: Floats, faces: Ints, scored: Bools, seed: int) -> list[Ints]:
    """Sets of held-out vertices, four or more until they hold out enough."""
    masks = held_out_vertices(points, faces, scored=scored, masks=_MASKS, seed=seed)
    held = sum(map(len, masks))
    if 0 < held < _ENOUGH:
        wanted = min(_MOST_MASKS, -(-_ENOUGH * _MASKS // held))
        masks = held_out_vertices(points, faces, scored=scored, masks=wanted, seed=seed)
    return [mask for mask in masks if len(mask)]
