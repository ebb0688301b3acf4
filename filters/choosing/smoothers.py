"""How much a scan is smoothed, found from the scan alone, and the families of smoothers side by side on one scan."""

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
    """The amount whose result has the slopes that are expected to be nearest to the true ones; see `Scan.choose_by_risk`.

    Tried on the mesh, or on patches of a large one, scaled to a mean edge of 1. Where neighbours agree, so that noise is not
    certain, it is `Scan.choose` that decides, and `Scan.or_nothing`. What slides along the surface is not judged.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        smooth: the smoother.
        amounts: what it is tried with, from little to much; 0, doing nothing, is tried too.
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

    def candidates(points: Floats, _: Ints) -> list[Iterator[Floats]]:
        return [iter([points]), (smooth(points, scan.faces, amount, scan.movable) for amount in amounts)]

    labels = [[0.0], list(amounts)]
    if not scan.shows_surface:
        return scan.choose_by_risk(candidates, labels)
    found = scan.choose(candidates, labels)
    return None if found is None else scan.or_nothing(found)


#: the families
SmootherName: TypeAlias = Literal["taubin", "implicit", "bilaplacian", "spectral", "normal_filtering"]


class Smoothing(NamedTuple):
    """A smoother and how much of it; without values doing nothing."""

    smoother: SmootherName | None = None
    amount: float = 0.0  # the detail size in mean edges, or the number of pairs of Taubin's steps; 0 for normal filtering
    setting: Setting | None = None  # that of normal filtering


#: the low-pass filters with their defaults, and the amounts that are tried
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
    """Which predicts unseen vertices best: nothing, one of the `SMOOTHERS`, or the setting of `automatic_choice`.

    Arguments and errors as of `chosen_amount`; `setting` is that of normal filtering, if it has been found, None finds it.

    Returns:
        The winner, and of every family what comes nearest, with its error and standard error, nothing first; see `Scan.choose`.
        A family whose equations cannot be solved on the mesh is left out. None where the scan is clean, or no vertex can be held
        out.
    """
    tell = rising(progress)
    scan = Scan.of(vertices, faces, movable=movable, seed=seed)
    if scan.clean:
        return None
    best = [Smoothing()]
    for number, (name, (smooth, amounts)) in enumerate(SMOOTHERS.items()):
        share = part_of(tell, 0.1 * number, 0.1 * (number + 1))
        try:
            found = amount_on(replace(scan, progress=share), smooth, amounts)
        except ConvergenceError:  # on some meshes with needles
            continue
        if found is not None and len(found.trials) > 1:
            # Where nothing is to be done what comes nearest is shown beside it.
            best.append(Smoothing(name, found.chosen.label or min(found.trials[1:], key=lambda trial: trial.error).label))
    if setting is None:
        setting = automatic_choice(vertices, faces, movable=movable, seed=seed, progress=part_of(tell, 0.4, 0.8)).setting
    if setting != Setting():
        best.append(Smoothing("normal_filtering", setting=setting))

    def result(smoothing: Smoothing, points: Floats, held: Ints) -> Floats:
        if smoothing.setting is not None:
            certain = mask_of(held, len(points))
            return smoothing.setting.apply(points, scan.faces, border="along", movable=scan.movable, certain=certain)
        if smoothing.smoother is None:
            return points
        return SMOOTHERS[smoothing.smoother][0](points, scan.faces, smoothing.amount, scan.movable)

    last = replace(scan, progress=part_of(tell, 0.8, 1.0))
    return last.choose(lambda p, held: [iter([result(of, p, held)]) for of in best], [[of] for of in best], stays=1e12)
