"""Cross-validation: runs each candidate with vertices held out and scores its predictions."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from ..execution import Progress, ignore_progress, in_parallel, part_of
from ..mesh import Bools, Floats, Ints
from .verdict import Verdict, judge

Label = TypeVar("Label")

#: After each set only what is within so many standard errors of the best is tried further.
STAYS = 2.0


def starts_of(labels: Sequence[Sequence[Label]]) -> Ints:
    """The number of the first candidate of every family, and that of all candidates."""
    return np.cumsum([0, *map(len, labels)], dtype=np.int32)


def cross_validate(
    held: Sequence[Ints],
    run: Callable[[Ints], Sequence[Iterator[Floats]]],
    deviations: Callable[[int, Floats, Ints], Floats],
    starts: Ints,
    *,
    stays: float = STAYS,
    progress: Progress = ignore_progress,
) -> tuple[Ints, Verdict]:
    """Step 2 of `choose`: run all candidates without each set of held-out vertices, and judge what they say of these.

    Once a single candidate is left no more sets are asked.

    Args:
        held: the sets, none of them empty.
        run: the candidates without a set, by families.
        deviations: of a candidate, by its number and its result, from the vertices of a set.
        starts: `starts_of` the families.
        stays: see `choose`.
        progress: called after every family that was run; may raise to stop.

    Returns:
        The numbers of the candidates that were tried to the end, ascending, and the verdict on these.
    """
    kept = np.ones(starts[-1], dtype=np.bool_)
    scores: list[Floats] = []
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
        scores.append(rows)
        kept[kept] = judge(np.concatenate(scores, axis=1)[kept]).within(stays)
        decided = np.count_nonzero(kept) == 1
        kept[0] = True
        if decided:
            break
    return np.flatnonzero(kept).astype(np.int32), judge(np.concatenate(scores, axis=1)[kept])


def _race(
    runs: Sequence[Iterator[Floats]], starts: Ints, look: Callable[[int, Floats], None], rows: Floats, progress: Progress
) -> Bools:
    """Run the families side by side, and end those that fall behind: which candidates were reached.

    After each result a family ends if it is behind the best so far by more than `STAYS` standard errors and errs more than with
    its result before: families go from little to much, and the errors fall before they rise.
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
        verdict = judge(rows[reached])
        errors, near = np.full(len(reached), np.inf), np.zeros_like(reached)
        errors[reached], near[reached] = verdict.errors, verdict.within(STAYS)
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
