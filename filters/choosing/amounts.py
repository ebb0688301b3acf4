"""How much a scan is smoothed, found from the scan alone."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from numpy.typing import ArrayLike

from ..denoising import Scan
from ..evidence import Choice
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints

#: Smooths (n, 3) points with a mean edge of 1 and (m, 3) faces by an amount; (n,) which points may move, None for all.
Smoother: TypeAlias = Callable[[Floats, Ints, float, Bools | None], Floats]

#: detail sizes to try, in mean edges: a wave has more than two, and what is longer than 32 is no noise of single vertices
DETAIL_SIZES: tuple[float, ...] = tuple(2.0 ** (k / 2.0) for k in range(2, 11))
#: numbers of pairs of Taubin's steps to try
PASSES: tuple[float, ...] = (1, 2, 3, 5, 8, 12, 18, 28, 42, 64)


def chosen_amount(
    vertices: ArrayLike,
    faces: ArrayLike,
    smooth: Smoother,
    amounts: Sequence[float],
    *,
    movable: ArrayLike | None = None,
    seed: int = 0,
    progress: Progress = ignore_progress,
) -> Choice[float] | None:
    """The amount whose result has the slopes that are expected to be nearest to the true ones; see `choose_by_risk`.

    Tried on the mesh, or on patches of a large one, scaled to a mean edge of 1. Doing nothing, the amount 0, is tried too. Where
    neighbours agree in part, so that noise is not certain, the amount must also predict vertices that the smoother has not seen,
    see `choose`, and be nearer to the truth than the scan is, see `Scan.or_nothing`. What slides along the surface is not judged.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        smooth: the smoother.
        amounts: what it is tried with, from little to much.
        movable: (n,) bool, which vertices may move, None for all. The others are not evidence.
        seed: other vertices are held out for another number.
        progress: called while amounts are tried; may raise to stop.

    Returns:
        The choice; None where no vertex can be held out or there is no noise for certain.

    Raises:
        FilterInputError: not a mesh, or `movable` does not fit.
    """
    return amount_on(Scan.of(vertices, faces, movable=movable, seed=seed, progress=progress), smooth, amounts)


def amount_on(scan: Scan, smooth: Smoother, amounts: Sequence[float]) -> Choice[float] | None:
    """`chosen_amount` on a scan."""
    if scan.clean:
        return None

    def candidates(points: Floats, held: Ints) -> list[Iterator[Floats]]:
        del held
        return [iter([points]), (smooth(points, scan.faces, amount, scan.movable) for amount in amounts)]

    labels = [[0.0], list(amounts)]
    if scan.independent:
        return scan.choose_by_risk(candidates, labels)
    found = scan.choose(candidates, labels)
    return None if found is None else scan.or_nothing(found)
