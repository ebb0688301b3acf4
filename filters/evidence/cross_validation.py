"""Cross-validation: runs each candidate with vertices held out and scores its predictions [batson2019]."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings
from . import tuned
from .held_out import heights_of_means, held_out_vertices, without
from .outlying import put_where_expected
from .quadric_prediction import predicted_heights

Label = TypeVar("Label")

#: Given (n, 3) vertices and the numbers of those that are held out, one iterator a family of filters over (n, 3) results, from
#: the first to the last of the family. They are read in threads, each only as far as is needed.
Candidates: TypeAlias = Callable[[Floats, Ints], Sequence[Iterator[Floats]]]


@dataclass(frozen=True)
class Trial(Generic[Label]):
    """One candidate and its score.

    Attributes:
        label: which it is.
        error: the root mean square of its deviations at the held-out vertices, outliers clipped, in mean edges.
        excess: how much its mean square exceeds that of the best, in squared mean edges.
        uncertainty: the standard error of the excess.
    """

    label: Label
    error: float
    excess: float
    uncertainty: float


@dataclass(frozen=True)
class Choice(Generic[Label]):
    """What was chosen, and the candidates that were tried on all held-out vertices, in their order."""

    chosen: Trial[Label]
    trials: tuple[Trial[Label], ...]

    @property
    def rivals(self) -> list[Trial[Label]]:
        """Those within two standard errors of the best, itself among them."""
        return [trial for trial in self.trials if trial.excess <= tuned.STAYS * trial.uncertainty]


class Scores(NamedTuple):
    """How well k candidates predict, in the unit of the deviations.

    Attributes:
        errors: (k,) the root mean square of the deviations of the held-out vertices, each clipped.
        excess: (k,) the mean of how much the squares exceed those of the best candidate.
        uncertainty: (k,) the standard error of `excess`.
        best: the candidate with the least error.
    """

    errors: Floats
    excess: Floats
    uncertainty: Floats
    best: int

    def within(self, standard_errors: float) -> Bools:
        """(k,) the candidates whose excess is at most that many of its standard errors."""
        return np.asarray(self.excess <= standard_errors * self.uncertainty)


def scores_of(deviations: Floats) -> Scores:
    """Score (k, h) deviations of k candidates at h held-out vertices, in mean edges.

    With m the least of the candidates' median |r|, the squares are q = min(|r|, max(4 m, 0.05))^2: outliers are no evidence, and
    where most of a mesh is exact planes the median is 0. The best candidate b has the least mean q; the excess of candidate k is
    the mean of q_k - q_b, vertex by vertex, and its standard error that of a mean of such differences.
    """
    sizes = np.abs(deviations)
    if sizes.shape[1] == 0:
        nothing = np.zeros(len(sizes))
        return Scores(nothing, nothing, nothing, 0)
    squares = np.minimum(sizes, max(tuned.WEAK, tuned.CLIP * float(np.median(sizes, axis=1).min()))) ** 2
    means = squares.mean(axis=1)
    best = int(means.argmin())
    differences = squares - squares[best]
    uncertainty = differences.std(axis=1) / np.sqrt(sizes.shape[1])
    return Scores(np.sqrt(means), differences.mean(axis=1), uncertainty, best)


def trials_of(every: Sequence[Label], tried: Ints, scores: Scores) -> tuple[Trial[Label], ...]:
    """The trials of the candidates that were tried to the end, by their numbers (k,) among the labels of all candidates."""
    return tuple(
        Trial(every[at], float(error), float(excess), float(uncertainty))
        for at, error, excess, uncertainty in zip(tried, scores.errors, scores.excess, scores.uncertainty, strict=True)
    )


def initial_positions(
    points: Floats, faces: Ints, *, normals: Floats, scored: Bools, by_means: bool = False
) -> Callable[[Ints], Floats]:
    """Where held-out vertices start: the mean of their neighbours or the quadric through two rings.

    Whichever predicts all scored vertices better is taken: the mean passes less noise on, the quadric follows a surface that is
    curved within an edge.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that are predicted.
        by_means: means in any case.

    Returns:
        A function of the numbers of held-out vertices: (n, 3) the points with these moved.
    """
    rings, which = one_rings(faces, len(points)), np.flatnonzero(scored).astype(np.int32)
    if not by_means:
        by_quadrics, _ = predicted_heights(points, rings, normals, which)
        by_means = scores_of(np.stack([heights_of_means(points, rings, normals, which), by_quadrics])).best == 0
    return lambda held: without(points, rings, held) if by_means else put_where_expected(points, faces, normals, held)


def choose(
    points: Floats,
    faces: Ints,
    candidates: Candidates,
    labels: Sequence[Sequence[Label]],
    *,
    normals: Floats,
    scored: Bools,
    seed: int = 0,
    stays: float = tuned.STAYS,
    by_means: bool = False,
    progress: Progress = ignore_progress,
) -> Choice[Label] | None:
    """Choose the filter that best predicts vertices which it has not seen [batson2019].

    Noise of a vertex is independent of its neighbours', the surface is not: what predicts a vertex from the others fits
    the surface. Held-out vertices are put at their `initial_positions`. Every candidate is run, and n . (y - f) is measured at
    the held-out vertices y; again with other vertices. See `cross_validate`.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        candidates: what is tried.
        labels: for each family the labels of its results. The very first should be that of doing nothing.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that may be held out; those near a border see half of their neighbourhoods.
        seed: other vertices are held out for another number.
        stays: see `cross_validate`.
        by_means: held-out vertices start at means in any case: quadrics hide what it costs to move vertices that are exact.
        progress: called after every family that was run; may raise to stop.

    Returns:
        The choice, the same for any number of threads; None if no vertex can be held out.
    """
    held = [mask for mask in held_out_vertices(points, faces, scored=scored, masks=tuned.MASKS, seed=seed) if len(mask)]
    if not held:
        return None
    start = initial_positions(points, faces, normals=normals, scored=scored, by_means=by_means)

    def deviations(at: int, result: Floats, mask: Ints) -> Floats:
        del at
        return np.asarray(np.einsum("ij,ij->i", points[mask] - result[mask], normals[mask]))

    tried, scores = cross_validate(
        held,
        lambda mask: candidates(start(mask), mask),
        deviations,
        starts_of(labels),
        stays=stays,
        progress=progress,
    )
    trials = trials_of([label for family in labels for label in family], tried, scores)
    return Choice(trials[scores.best], trials)


def starts_of(labels: Sequence[Sequence[Label]]) -> Ints:
    """The number of the first candidate of every family, and that of all candidates."""
    return np.cumsum([0, *map(len, labels)], dtype=np.int32)


def cross_validate(
    held: Sequence[Ints],
    run: Callable[[Ints], Sequence[Iterator[Floats]]],
    deviations: Callable[[int, Floats, Ints], Floats],
    starts: Ints,
    *,
    stays: float = tuned.STAYS,
    progress: Progress = ignore_progress,
) -> tuple[Ints, Scores]:
    """Run all candidates without each set of held-out vertices, and score what they say of these.

    After each set candidates that are worse than the best by more than two standard errors are dropped, the very first one apart:
    it is what the others are compared with. Once a single candidate is left no more sets are asked.

    Args:
        held: the sets, none of them empty.
        run: the candidates without a set, by families.
        deviations: of a candidate, by its number and its result, from the vertices of a set.
        starts: `starts_of` the families.
        stays: candidates farther behind than so many standard errors are dropped; a huge number to try them all to the end.
        progress: called after every family that was run; may raise to stop.

    Returns:
        The numbers of the candidates that were tried to the end, ascending, and their scores.
    """
    kept = np.ones(starts[-1], dtype=np.bool_)
    rows_of_sets: list[Floats] = []
    shares = np.concatenate([[0.0], np.linspace(0.55, 1.0, len(held))])
    for number, mask in enumerate(held):
        rows = np.zeros((len(kept), len(mask)))

        def deviate(at: int, result: Floats, mask: Ints = mask, rows: Floats = rows) -> None:
            rows[at] = deviations(at, result, mask)

        share = part_of(progress, shares[number], shares[number + 1])
        if number == 0:
            kept = _race(run(mask), starts, deviate, rows, share)
        else:
            run_to_last(run(mask), starts, kept, deviate, share)
        rows_of_sets.append(rows)
        kept[kept] = scores_of(np.concatenate(rows_of_sets, axis=1)[kept]).within(stays)
        decided = np.count_nonzero(kept) == 1
        kept[0] = True
        if decided:
            break
    return np.flatnonzero(kept).astype(np.int32), scores_of(np.concatenate(rows_of_sets, axis=1)[kept])


def _race(
    runs: Sequence[Iterator[Floats]], starts: Ints, look: Callable[[int, Floats], None], rows: Floats, progress: Progress
) -> Bools:
    """Run the families side by side, and end those that fall behind: which candidates were reached.

    After each result a family ends if it is behind the best so far by more than two standard errors and errs more than with its
    result before: families go from little to much, and the errors fall before they rise.
    """
    reached = np.zeros(starts[-1], dtype=np.bool_)
    going = list(range(len(runs)))
    longest = int(np.diff(starts).max())
    for step in range(longest):

        def advance(family: int, step: int = step) -> None:
            look(int(starts[family]) + step, next(runs[family]))

        going = [k for k in going if starts[k] + step < starts[k + 1]]
        in_parallel(advance, [(k,) for k in going], part_of(progress, step / longest, (step + 1) / longest))
        latest = starts[going] + step
        reached[latest] = True
        scores = scores_of(rows[reached])
        errors, near = np.full(len(reached), np.inf), np.zeros_like(reached)
        errors[reached], near[reached] = scores.errors, scores.within(tuned.STAYS)
        going = [k for k, at in zip(going, latest, strict=True) if step == 0 or near[at] or errors[at] < errors[at - 1]]
    return reached


def run_to_last(
    runs: Sequence[Iterator[Floats]], starts: Ints, kept: Bools, look: Callable[[int, Floats], None], progress: Progress
) -> None:
    """Run each family as far as its last candidate that is kept, and look at those that are."""

    def work(family: int) -> None:
        wanted = np.flatnonzero(kept[starts[family] : starts[family + 1]])
        for at, result in zip(range(int(wanted[-1]) + 1), runs[family], strict=False):
            if at in wanted:
                look(int(starts[family]) + at, result)

    families = [(k,) for k in range(len(runs)) if kept[starts[k] : starts[k + 1]].any()]
    in_parallel(work, families, progress)
