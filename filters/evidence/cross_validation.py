"""Cross-validation: runs candidates (settings of filters) with vertices held out, and scores their predictions [batson2019]."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, compress
from typing import Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings
from . import tuned
from .held_out import means_of_others, put_at_means
from .quadric_prediction import predicted_heights, put_where_expected

Label = TypeVar("Label")
Measure = TypeVar("Measure")

#: For each family (candidates that smooth more and more), an iterator over its (n, 3) results; a reader may stop before the end.
Runs: TypeAlias = Sequence[Iterator[Floats]]
#: A function that takes (n, 3) vertices and the indices of the held-out vertices, and returns the runs.
Candidates: TypeAlias = Callable[[Floats, Ints], Runs]


@dataclass(frozen=True)
class Trial(Generic[Label]):
    """One candidate and its score, see `scores_of`. Without held-out vertices the score is an expected squared error."""

    label: Label
    error: float  # root of the score with one clipping bound for all vertices, in mean edges
    excess: float  # the score minus that of the best candidate, in squared mean edges
    uncertainty: float  # standard error of the excess


@dataclass(frozen=True)
class Choice(Generic[Label]):
    """The chosen candidate, and all candidates that were not dropped before the end, in the order of their labels."""

    chosen: Trial[Label]
    trials: tuple[Trial[Label], ...]

    @property
    def rivals(self) -> list[Trial[Label]]:
        """The trials within two standard errors of the best, including the best."""
        return [trial for trial in self.trials if trial.excess <= tuned.STAYS * trial.uncertainty]


class Scores(NamedTuple):
    """The scores of k candidates: the numbers of `Trial` as (k,) arrays, and the index of the best candidate."""

    errors: Floats  # as if `scores_of` got no `near`, so that they can be compared with noise levels
    excess: Floats
    uncertainty: Floats
    best: int

    def within(self, standard_errors: float) -> Bools:
        return np.asarray(self.excess <= standard_errors * self.uncertainty)

    def choice(self, labels: Sequence[Sequence[Label]], chosen: int | None = None) -> Choice[Label]:
        """Returns the `Choice` of candidate number `chosen` (None: the best); the k `labels` are grouped by family."""
        columns = (values.tolist() for values in self[:3])
        trials = tuple(Trial(*row) for row in zip(chain.from_iterable(labels), *columns, strict=True))
        return Choice(trials[self.best if chosen is None else chosen], trials)


def scores_of(deviations: Floats, near: Ints | None = None, flipped: Floats | float = 0.0) -> Scores:
    """Scores k candidates by (k, h) deviations r at h held-out vertices, in mean edges.

    A deviation counts as q = min(|r|, max(4 m, 0.05))^2; m is the median of |r| of the candidate with the least median. With
    (h, c) indices `near`, each vertex has its own m: the median of |r| of the same candidate over the vertex's row of `near`.
    Clipping limits the effect of outliers; the bound 0.05 serves meshes of exact planes, whose median is 0. A candidate's share
    of `flipped` faces (one number for all, or (k,) numbers), times 0.3^2, is added to its q. The best candidate b has the least
    mean q. The excess of candidate k is the mean of q_k - q_b over the vertices, its uncertainty the standard error of this mean.
    """
    sizes = np.abs(deviations)
    medians = np.median(sizes, axis=1)
    penalties = tuned.FLIPPED**2 * np.reshape(flipped, (-1, 1))

    def squares_of(scale: Floats) -> Floats:
        return np.asarray(np.minimum(sizes, np.maximum(tuned.WEAK, tuned.CLIP * scale)) ** 2 + penalties)

    alike = squares_of(medians.min())
    squares = alike if near is None else squares_of(np.median(sizes[medians.argmin()][near], axis=1))
    best = int(squares.mean(axis=1).argmin())
    differences = squares - squares[best]
    uncertainty = differences.std(axis=1) / np.sqrt(sizes.shape[1])
    return Scores(np.sqrt(alike.mean(axis=1)), differences.mean(axis=1), uncertainty, best)


def initial_positions(
    points: Floats, faces: Ints, *, normals: Floats, scored: Bools, by_means: bool = False
) -> Callable[[Ints], Floats]:
    """Returns a function from the indices of held-out vertices to (n, 3) points with these vertices at predicted positions.

    A vertex is predicted by the mean of its neighbours or by the quadric fitted to its two rings, whichever has smaller errors on
    the (n,) `scored` vertices; with `by_means`, always by the mean. The (n, 3) points have a mean edge of 1, the (n, 3) unit
    normals are smoothed.
    """
    rings, indices = one_rings(faces, len(points)), np.flatnonzero(scored).astype(np.int32)
    if not by_means:
        by_quadrics, _ = predicted_heights(points, rings, normals, indices)
        offsets = means_of_others(points, rings, indices, np.zeros_like(scored)) - points[indices]
        by_means = scores_of(np.stack([np.einsum("ij,ij->i", offsets, normals[indices]), by_quadrics])).best == 0
    return lambda held: put_at_means(points, rings, held) if by_means else put_where_expected(points, faces, normals, held)


def cross_validate(
    points: Floats,
    held: Sequence[Ints],
    run: Callable[[Ints], Runs],
    deviations: Callable[[Ints, int, Floats], Floats],
    labels: Sequence[Sequence[Label]],
    *,
    share_flipped: Callable[[Floats], float] = lambda _: 0.0,
    stays: float = tuned.STAYS,
    progress: Progress = ignore_progress,
) -> Choice[Label]:
    """Runs the candidates once for each set of held-out vertices and chooses the candidate with the least prediction error.

    After each set, candidates that are more than `stays` standard errors worse than the best are dropped; after the first set,
    also those that `_race` skipped. The first candidate, which should do nothing, always stays. Once all candidates but the best
    are that much worse, the remaining sets are skipped.

    `held` has the vertex indices of each set. The (n, 3) `points` show which held-out vertices are near each other, see
    `scores_of`. `run` takes a set and returns the results of the candidates. Results and `labels` are grouped by family.
    `deviations` takes a set, the number of a candidate and its result, and returns (h,) deviations in mean edges. `share_flipped`
    returns the share of flipped faces of a result; it is measured on the first set. `progress` may raise to stop.
    """
    kept, sets = np.ones(sum(map(len, labels)), dtype=np.bool_), list[Floats]()
    flipped = np.zeros(len(kept))
    shares = np.concatenate([[0.0], np.linspace(0.55, 1.0, len(held))])
    # A vertex may be in several sets. The fourth coordinate sorts its copies by set, so that vertex numbers do not matter.
    set_of = np.repeat(np.arange(len(held)), [len(indices) for indices in held])
    in_order = np.column_stack([points[np.concatenate(held)], 1e-3 * set_of])
    for number, indices in enumerate(held):
        sets.append(np.full((len(kept), len(indices)), np.inf))
        share, deviate = part_of(progress, shares[number], shares[number + 1]), partial(deviations, indices)
        places = in_order[set_of <= number]
        near = spatial.cKDTree(places).query(places * (1, 1, 1, 0), min(tuned.NEAR, len(places)))[1].reshape(len(places), -1)
        if number == 0:
            kept = _race(run(indices), labels, deviate, share_flipped, sets[0], flipped, near, share)
        else:
            sets[-1][kept] = measured(run(indices), labels, deviate, share, kept)
        kept[kept] = scores_of(np.hstack(sets)[kept], near, flipped[kept]).within(stays)
        decided = np.count_nonzero(kept) == 1
        kept[0] = True
        if decided:
            break
    return scores_of(np.hstack(sets)[kept], near, flipped[kept]).choice([list(compress(chain.from_iterable(labels), kept))])


def _race(
    runs: Runs,
    labels: Sequence[Sequence[Label]],
    deviate: Callable[[int, Floats], Floats],
    share_flipped: Callable[[Floats], float],
    rows: Floats,
    flipped: Floats,
    near: Ints,
    progress: Progress,
) -> Bools:
    """Runs the families in parallel, fills in `rows` (deviations) and `flipped` (shares), and returns which candidates ran.

    A family stops once its result is more than two standard errors behind the best so far and worse than its previous result.
    The amount of smoothing rises within a family, so its errors first fall and then rise.
    """
    reached, starts = np.zeros(len(rows), dtype=np.bool_), np.cumsum([0, *map(len, labels)])
    going, longest = list(range(len(runs))), max(map(len, labels))
    for step in range(longest):

        def advance(family: int, step: int = step) -> None:
            at = int(starts[family]) + step
            result = next(runs[family])
            rows[at], flipped[at] = deviate(at, result), share_flipped(result)

        going = [k for k in going if step < len(labels[k])]
        in_parallel(advance, [(k,) for k in going], part_of(progress, step / longest, (step + 1) / longest))
        latest = starts[going] + step
        reached[latest] = True
        scores = scores_of(rows, near, flipped)
        excess, ties = scores.excess, scores.within(tuned.STAYS)
        going = [k for k, at in zip(going, latest, strict=True) if step == 0 or ties[at] or excess[at] < excess[at - 1]]
    return reached


def measured(
    runs: Runs,
    labels: Sequence[Sequence[Label]],
    measure: Callable[[int, Floats], Measure],
    progress: Progress = ignore_progress,
    kept: Bools | None = None,
) -> list[Measure]:
    """Returns `measure(number, result)` of each candidate in `kept` (None: all); a family stops after its last kept candidate."""
    starts, measures = np.cumsum([0, *map(len, labels)]), dict[int, Measure]()
    wanted = np.ones(starts[-1], dtype=np.bool_) if kept is None else kept

    def work(family: int) -> None:
        numbers = np.flatnonzero(wanted[: starts[family + 1]])
        for at, result in zip(range(int(starts[family]), int(numbers[-1]) + 1), runs[family], strict=False):
            if wanted[at]:
                measures[at] = measure(at, result)

    families = [(k,) for k in range(len(runs)) if wanted[starts[k] : starts[k + 1]].any()]
    in_parallel(work, families, progress)
    return [measures[at] for at in np.flatnonzero(wanted).tolist()]
