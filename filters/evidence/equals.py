"""Which of the candidates that predict alike is taken."""

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from ..geometry import normal_differences
from ..mesh import Bools, Floats, Ints
from .folds import FEW_AMONG_EQUALS, folded_share, upright
from .slopes import SlopeError, slope_errors
from .verdict import EQUAL

#: Runs some candidates, by their numbers, on (n, 3) vertices, and shows each number and its (n, 3) result.
Run: TypeAlias = Callable[[Floats, Sequence[int], Callable[[int, Floats], None]], None]


def among_equals(
    points: Floats, faces: Ints, run: Run, which: Sequence[int], *, normals: Floats, scored: Bools, seed: int = 0
) -> tuple[int, dict[int, SlopeError]]:
    """Steps 3 and 4 of `choose`.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        run: runs candidates.
        which: those that predict alike, the best first.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that count.
        seed: another noise is added for another number.

    Returns:
        The number of the one that is taken, and the expected errors of the slopes of all that are not folded over.
    """
    heights, products, folded = dict[int, Floats](), dict[int, float](), dict[int, float]()

    def along_normals(result: Floats) -> Floats:
        return np.asarray(np.einsum("ij,ij->i", result - points, normals))

    def look(at: int, result: Floats) -> None:
        heights[at] = along_normals(result)
        products[at] = roughness(result, faces) * float(np.abs(heights[at]).mean())
        folded[at] = folded_share(result, faces, normals)

    run(points, which, look)
    stay = upright([folded[at] for at in which], FEW_AMONG_EQUALS)
    left = [at for at, stays in zip(which, stay, strict=True) if stays]

    if len(left) == 1:
        return left[0], {}

    def heights_of(vertices: Floats) -> dict[int, Floats]:
        found = dict[int, Floats]()
        run(vertices, left, lambda at, result: found.update({at: along_normals(result)}))
        return found

    taken = {at: heights[at] for at in left}
    errors = slope_errors(points, faces, taken, heights_of, best=left[0], normals=normals, scored=scored, seed=seed)
    equal = [at for at, slope in errors.items() if slope.excess <= EQUAL * slope.uncertainty]
    return min(equal, key=lambda at: (products[at], at)), errors


def roughness(points: Floats, faces: Ints) -> float:
    """The mean difference |n_f - n_g| of the unit normals of adjacent faces; 0 without any."""
    differences = normal_differences(points, faces)
    return float(differences.mean()) if len(differences) else 0.0
