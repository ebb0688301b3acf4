"""Cross-validation: runs each candidate with vertices held out and scores its predictions [batson2019]."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, compress
from typing import Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings
from . import tuned
from .held_out import means_of_others, without
from .quadric_prediction import predicted_heights, put_where_expected

Label = TypeVar("Label")
Measure = TypeVar("Measure")

#: One iterator a family of filters over its (n, 3) results. They are read in threads, each only as far as is needed.
Runs: TypeAlias = Sequence[Iterator[Floats]]
#: These, given (n, 3) vertices and the numbers of those that are held out.
Candidates: TypeAlias = Callable[[Floats, Ints], Runs]


@dataclass(frozen=True)
class Trial(Generic[Label]):
    """One candidate and its score."""

    label: Label  # which it is
    error: float  # the root mean square of its deviations at the held-out vertices, outliers clipped, in mean edges
    excess: float  # how much its mean square exceeds that of the best, in squared mean edges
    uncertainty: float  # the standard error of the excess


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
    """How well k candidates predict: (k,) each as of `Trial`, in the unit of the deviations, and the one with the least error."""

    errors: Floats
    excess: Floats
    uncertainty: Floats
    best: int

    def within(self, standard_errors: float) -> Bools:
        """(k,) the candidates whose excess is at most that many of its standard errors."""
        return np.asarray(self.excess <= standard_errors * self.uncertainty)

    def choice(self, labels: Sequence[Sequence[Label]], chosen: int | None = None) -> Choice[Label]:
        """The trials of the candidates with these k labels, by families, the best of them chosen, or another one."""
        columns = (values.tolist() for values in self[:3])
        trials = tuple(Trial(*row) for row in zip(chain.from_iterable(labels), *columns, strict=True))
        return Choice(trials[self.best if chosen is None else chosen], trials)


def scores_of(deviations: Floats) -> Scores:
    """Score (k, h) deviations of k candidates at h held-out vertices, in mean edges.

    With m the least of the candidates' median |r|, the squares are q = min(|r|, max(4 m, 0.05))^2: outliers are no evidence, and
    where most of a mesh is exact planes the median is 0. The best candidate b has the least mean q; the excess of candidate k is
    the mean of q_k - q_b, vertex by vertex, and its standard error that of a mean of such differences.
    """
    sizes = np.abs(deviations)
    squares = np.minimum(sizes, max(tuned.WEAK, tuned.CLIP * float(np.median(sizes, axis=1).min()))) ** 2
    means = squares.mean(axis=1)
    best = int(means.argmin())
    differences = squares - squares[best]
    uncertainty = differences.std(axis=1) / np.sqrt(sizes.shape[1])
    return Scores(np.sqrt(means), differences.mean(axis=1), uncertainty, best)


def initial_positions(
    points: Floats, faces: Ints, *, normals: Floats, scored: Bools, by_means: bool = False
) -> Callable[[Ints], Floats]:
    """From numbers of held-out vertices (n, 3) points: these at the mean of their neighbours, or the quadric through two rings.

    Means pass less noise on. That is taken which predicts all vertices that are scored, (n,), better; `by_means` takes means in
    any case. The (n, 3) points have a mean edge of 1, the (n, 3) unit normals are those of a smoothed copy.
    """
    rings, which = one_rings(faces, len(points)), np.flatnonzero(scored).astype(np.int32)
    if not by_means:
        by_quadrics, _ = predicted_heights(points, rings, normals, which)
        ways = means_of_others(points, rings, which, np.zeros_like(scored)) - points[which]
        by_means = scores_of(np.stack([np.einsum("ij,ij->i", ways, normals[which]), by_quadrics])).best == 0
    return lambda held: without(points, rings, held) if by_means else put_where_expected(points, faces, normals, held)


def cross_validate(
    held: Sequence[Ints],
    run: Callable[[Ints], Runs],
    deviations: Callable[[Ints, int, Floats], Floats],
    labels: Sequence[Sequence[Label]],
    *,
    stays: float = tuned.STAYS,
    progress: Progress = ignore_progress,
) -> Choice[Label]:
    """Run all candidates without each set of held-out vertices, and choose by what they say of these.

    After each set candidates that are worse than the best by more than two standard errors, or as many as `stays` says, are
    dropped, but the very first one, which should be that of doing nothing. Once a single candidate is left no more sets are
    asked.

    `run` gives the candidates without a set, by families, `labels` their labels; the deviations, in mean edges, are from the
    vertices of a set, of a candidate by its number and its result. `progress` is called after every family; it may raise to stop.
    """
    kept, sets = np.ones(sum(map(len, labels)), dtype=np.bool_), list[Floats]()
    shares = np.concatenate([[0.0], np.linspace(0.55, 1.0, len(held))])
    for number, mask in enumerate(held):
        sets.append(np.full((len(kept), len(mask)), np.inf))
        share, deviate = part_of(progress, shares[number], shares[number + 1]), partial(deviations, mask)
        if number == 0:
            kept = _race(run(mask), labels, deviate, sets[0], share)
        else:
            sets[-1][kept] = measured(run(mask), labels, deviate, share, kept)
        kept[kept] = scores_of(np.hstack(sets)[kept]).within(stays)
        decided = np.count_nonzero(kept) == 1
        kept[0] = True
        if decided:
            break
    return scores_of(np.hstack(sets)[kept]).choice([list(compress(chain.from_iterable(labels), kept))])


def _race(
    runs: Runs, labels: Sequence[Sequence[Label]], deviate: Callable[[int, Floats], Floats], rows: Floats, progress: Progress
) -> Bools:
    """Run the families side by side, fill the rows of their candidates, and end those that fall behind: which were reached.

    A family ends if it is behind the best so far by more than two standard errors and errs more than with its result before:
    families go from little to much, and the errors fall before they rise.
    """
    reached, starts = np.zeros(len(rows), dtype=np.bool_), np.cumsum([0, *map(len, labels)])
    going, longest = list(range(len(runs))), max(map(len, labels))
    for step in range(longest):

        def advance(family: int, step: int = step) -> None:
            at = int(starts[family]) + step
            rows[at] = deviate(at, next(runs[family]))

        going = [k for k in going if step < len(labels[k])]
        in_parallel(advance, [(k,) for k in going], part_of(progress, step / longest, (step + 1) / longest))
        latest = starts[going] + step
        reached[latest] = True
        scores = scores_of(rows)
        errors, near = scores.errors, scores.within(tuned.STAYS)
        going = [k for k, at in zip(going, latest, strict=True) if step == 0 or near[at] or errors[at] < errors[at - 1]]
    return reached


def measured(
    runs: Runs,
    labels: Sequence[Sequence[Label]],
    measure: Callable[[int, Floats], Measure],
    progress: Progress = ignore_progress,
    kept: Bools | None = None,
) -> list[Measure]:
    """Measure candidates by their numbers and results: those that are kept, all by default; no family runs beyond its last."""
    starts, found = np.cumsum([0, *map(len, labels)]), dict[int, Measure]()
    wanted = np.ones(starts[-1], dtype=np.bool_) if kept is None else kept

    def work(family: int) -> None:
        numbers = np.flatnonzero(wanted[: starts[family + 1]])
        for at, result in zip(range(int(starts[family]), int(numbers[-1]) + 1), runs[family], strict=False):
            if wanted[at]:
                found[at] = measure(at, result)

    families = [(k,) for k in range(len(runs)) if wanted[starts[k] : starts[k + 1]].any()]
    in_parallel(work, families, progress)
    return [found[at] for at in np.flatnonzero(wanted).tolist()]
