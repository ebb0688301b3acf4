"""Chooses the amount of smoothing from the scan alone, and compares the families of smoothers on one scan."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, TypeAlias

from numpy.typing import ArrayLike

from ..checks import ConvergenceError
from ..denoising import Scan, Setting, automatic_choice
from ..diffusion import implicit_fairing, taubin_fairing, time_step_of_detail_size
from ..evidence import Choice
from ..execution import Progress, ignore_progress, part_of, rising
from ..fairing import bilaplacian_smoothing
from ..mesh import Bools, Floats, Ints, mask_of
from ..spectral import spectral_filter

#: Takes (n, 3) points of mean edge 1, (m, 3) faces, an amount, and the (n,) mask of movable points (None: all); returns points.
Smoother: TypeAlias = Callable[[Floats, Ints, float, Bools | None], Floats]

#: detail sizes to try, in mean edges: 2 damps all waves of a regular mesh by less than half, 32 is far longer than bumps of noise
DETAIL_SIZES: tuple[float, ...] = tuple(2.0 ** (k / 2.0) for k in range(2, 11))
#: numbers of pairs of Taubin steps to try
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
    """Chooses the amount by the expected error of the edge vectors; see `Scan.choose_by_risk`.

    Each amount is tried on the mesh, or on patches of a large mesh, scaled to a mean edge of 1. If fourth-order differences show
    sharp edges or details (`Scan.shows_surface`), `Scan.choose` and `Scan.or_nothing` decide. Errors are measured along normals.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        smooth: the smoother; its exceptions are raised.
        amounts: the amounts to try, ascending; 0 (no smoothing) is tried, too.
        movable: (n,) bool, which vertices may move, None for all. Errors at fixed vertices do not count.
        seed: selects the held-out vertices and the noise that `Scan.choose_by_risk` adds.
        progress: called while amounts are tried; may raise to stop.

    Returns:
        The choice; None if the scan has too few vertices to judge by or is clean (`Scan.clean`).

    Raises:
        FilterInputError: not a mesh, or `movable` does not fit.
    """
    return amount_on(Scan.of(vertices, faces, movable=movable, seed=seed, progress=progress), smooth, amounts)


def amount_on(scan: Scan, smooth: Smoother, amounts: Sequence[float]) -> Choice[float] | None:
    """Returns `chosen_amount` on a scan."""
    if scan.clean:
        return None

    def candidates(points: Floats, _: Ints) -> list[Iterator[Floats]]:
        return [iter([points]), (smooth(points, scan.faces, amount, scan.movable) for amount in amounts)]

    labels = [[0.0], list(amounts)]
    if not scan.shows_surface:
        return scan.choose_by_risk(candidates, labels)
    choice = scan.choose(candidates, labels)
    return None if choice is None else scan.or_nothing(choice)


SmootherName: TypeAlias = Literal["taubin", "implicit", "bilaplacian", "spectral", "normal_filtering"]


class Smoothing(NamedTuple):
    """A smoother and its amount or setting; the default does nothing."""

    smoother: SmootherName | None = None
    amount: float = 0.0  # detail size in mean edges, or number of pairs of Taubin steps; 0 for normal filtering
    setting: Setting | None = None  # of normal filtering


#: the low-pass filters, and the amounts to try
SMOOTHERS: Mapping[SmootherName, tuple[Smoother, Sequence[float]]] = {
    "taubin": (lambda p, f, k, m: taubin_fairing(p, f, iterations=int(k), movable=m), PASSES),
    "implicit": (lambda p, f, d, m: implicit_fairing(p, f, time_step=time_step_of_detail_size(d), movable=m), DETAIL_SIZES),
    "bilaplacian": (lambda p, f, d, m: bilaplacian_smoothing(p, f, detail_size=d, movable=m), DETAIL_SIZES),
    "spectral": (lambda p, f, d, m: spectral_filter(p, f, detail_size=d, method="polynomial", movable=m).vertices, DETAIL_SIZES),
}


def compare_smoothers(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    setting: Setting | None = None,
    movable: ArrayLike | None = None,
    seed: int = 0,
    progress: Progress = ignore_progress,
) -> Choice[Smoothing] | None:
    """Compares doing nothing, the `SMOOTHERS` and the setting of `automatic_choice` by their prediction of held-out vertices.

    Arguments and exceptions are those of `chosen_amount`. `setting` is the setting of normal filtering; None chooses it.

    Returns the choice. Its trials: no smoothing; each family with its best amount, unless its equations cannot be solved or all
    its amounts are dropped; normal filtering, unless it does nothing. None if the scan is clean or no vertex can be held out.
    """
    report = rising(progress)
    scan = Scan.of(vertices, faces, movable=movable, seed=seed)
    if scan.clean:
        return None
    best = [Smoothing()]
    for number, (name, (smooth, amounts)) in enumerate(SMOOTHERS.items()):
        share = part_of(report, 0.1 * number, 0.1 * (number + 1))
        try:
            choice = amount_on(replace(scan, progress=share), smooth, amounts)
        except ConvergenceError:  # on some meshes with needle-shaped triangles
            continue
        if choice is not None and len(choice.trials) > 1:
            # A family that loses to doing nothing is shown with its best amount.
            best.append(Smoothing(name, choice.chosen.label or min(choice.trials[1:], key=lambda trial: trial.error).label))
    if setting is None:
        setting = automatic_choice(vertices, faces, movable=movable, seed=seed, progress=part_of(report, 0.4, 0.8)).setting
    if setting != Setting():
        best.append(Smoothing("normal_filtering", setting=setting))

    def result(smoothing: Smoothing, points: Floats, held: Ints) -> Floats:
        if smoothing.setting is not None:
            certain = mask_of(held, len(points))
            return smoothing.setting.apply(points, scan.faces, border="along", movable=scan.movable, certain=certain)
        if smoothing.smoother is None:
            return points
        return SMOOTHERS[smoothing.smoother][0](points, scan.faces, smoothing.amount, scan.movable)

    last = replace(scan, progress=part_of(report, 0.8, 1.0))
    # No family is dropped, since none is 1e12 standard errors behind the best.
    return last.choose(lambda p, held: [iter([result(s, p, held)]) for s in best], [[s] for s in best], stays=1e12)
