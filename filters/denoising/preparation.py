"""All steps of denoising: rounding undone, outliers taken away, noise calmed, normals filtered, folds taken back.

Taubin's steps before normal filtering calm noise that would turn faces over.
"""

import math
from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

import numpy as np

from ..checks import check_choice, check_whole_number
from ..diffusion.explicit import taubin_fairing
from ..execution import Progress, ignore_progress, part_of, rising
from ..inspection import folded_faces
from ..mesh import Bools, Floats, Ints, Whole
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices
from .impulses import Outliers, without_outliers
from .noise_level import RINGS_OF_SMOOTH_NORMALS, NoiseEstimate, smooth_normals
from .normal_filtering import normal_filtering
from .rounding import RoundingPolicy, without_rounding

#: "all": vertices go wherever the steps take them, which evens out noise in all directions, and triangles. "normal": they keep
#: their place along the surface, so that noise along the normals alone does not make them slide.
RelaxationDirection: TypeAlias = Literal["all", "normal"]

# Noise in all directions scatters the vertices as much along the surface as along its normals; an uneven mesh only adds to that.
_ALL_DIRECTIONS = 0.85
#: The share of the way back from a fold, of which all would put spikes back; and the rings of faces that decide on it.
HALF_WAY, RINGS_OF_UNFOLDING = 0.5, 3


def denoised(
    vertices: Floats,
    faces: Ints,
    *,
    outliers: Outliers = "keep",
    rounding: RoundingPolicy = "keep",
    relaxation: int = 0,
    relaxation_direction: RelaxationDirection = "all",
    filtering: Mapping[str, Any] | None = None,
    border: BorderPolicy = "along",
    movable: Bools | None = None,
    certain: Bools | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """(n, 3) the vertices after Taubin's steps and normal filtering, which outliers do not mislead, and `unfolded`.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        outliers: what becomes of vertices that stand out, see `without_outliers`.
        rounding: "undo" smooths the terraces of rounded coordinates first, see `without_rounding`.
        relaxation: number of pairs of Taubin's steps, see `relaxed`.
        relaxation_direction: where they go.
        filtering: what `normal_filtering` is called with then; None for no such filtering.
        border: see `taubin_fairing` and `normal_filtering`.
        movable: (n,) which vertices may move, None for all.
        certain: (n,) which are outliers for certain, None for none.
        progress: called after every pair of steps and every pass.

    Raises:
        FilterInputError: a parameter out of range.
    """
    check_whole_number("relaxation", relaxation)
    check_choice("border", border, BORDER_POLICIES)
    check_choice("rounding", rounding, RoundingPolicy)
    share = 1.0 if filtering is None else 0.2 if relaxation else 0.0
    # Where outliers are taken away all steps are done twice.
    tell = rising(progress)

    def smooth(points: Floats, moves: Bools | None) -> Floats:
        fair = relaxed(
            points,
            faces,
            iterations=relaxation,
            direction=relaxation_direction,
            border=border,
            movable=moves,
            progress=part_of(tell, 0.0, share),
        )
        if filtering is None:
            return fair
        return normal_filtering(fair, faces, **filtering, border=border, movable=moves, progress=part_of(tell, share, 1.0))

    if border == "fixed" and (outliers != "keep" or rounding != "keep"):
        inside = ~border_vertices(faces, len(vertices))
        movable = inside if movable is None else movable & inside
    start = without_rounding(vertices, faces, movable) if rounding == "undo" else vertices
    result = unfolded(vertices, without_outliers(start, faces, outliers, smooth, movable=movable, certain=certain), faces)
    progress(1.0)  # also where there was nothing to do
    return result


def direction_for(noise: NoiseEstimate) -> RelaxationDirection:
    """That of the noise: "normal" where the vertices are scattered less along the surface than across it."""
    return "all" if noise.tangential > _ALL_DIRECTIONS * noise.deviation else "normal"


def relaxed(
    vertices: Floats,
    faces: Ints,
    *,
    iterations: int,
    direction: RelaxationDirection,
    border: BorderPolicy,
    movable: Bools | None,
    progress: Progress = ignore_progress,
) -> Floats:
    """(n, 3) the vertices after as many pairs of Taubin's steps, of 0.5 and -0.53.

    With the border "along" a jagged outline is `outline_kept`. In the direction "normal" every vertex keeps the part of its way
    along the normal of a smoothed copy.
    """
    check_choice("relaxation_direction", direction, RelaxationDirection)
    if iterations == 0:
        return vertices.copy()
    fair = taubin_fairing(vertices, faces, iterations=iterations, border=border, movable=movable, progress=progress)
    outline = border_vertices(faces, len(vertices)) & (border == "along")
    if direction == "all" and not outline.any():
        return fair
    normals = smooth_normals(vertices, faces)
    return along_normals(vertices, fair, normals) if direction == "normal" else outline_kept(vertices, fair, normals, outline)


def along_normals(vertices: Floats, moved: Floats, normals: Floats) -> Floats:
    """(n, 3) the vertices moved by that part of their way that lies along their unit normals."""
    return np.asarray(vertices + np.einsum("ij,ij->i", moved - vertices, normals)[:, None] * normals)


def outline_kept(vertices: Floats, moved: Floats, normals: Floats, outline: Bools) -> Floats:
    """(n, 3) the moved vertices, of the way along the surface of those of the outline only what noise explains.

    With p the mean square of these ways and q that of other vertices, which noise has scattered, they keep min(1, q / p) of them.
    """
    across = along_normals(vertices, moved, normals)
    along = moved - across
    squares, went = np.einsum("ij,ij->i", along, along), (moved != vertices).any(axis=1)
    p, q = (float(squares[went & which].mean()) if (went & which).any() else 0.0 for which in (outline, ~outline))
    return np.where(outline[:, None], across + share_along(p, q) * along, moved)


def share_along(p: float, q: float) -> float:
    """What vertices of the outline keep of their way along the surface, see `outline_kept`."""
    return min(1.0, q / p) if p > 0.0 else 1.0


def relaxed_part(
    vertices: Floats,
    faces: Ints,
    own: Bools,
    *,
    iterations: int,
    direction: RelaxationDirection,
    border: BorderPolicy,
    whole: Whole,
    is_open: bool,
) -> tuple[Floats, Floats, tuple[tuple[float, int], tuple[float, int]]]:
    """What `relaxed` makes of the vertices of a part of a mesh, but for one number.

    They are where the (n, 3) first say, and those of the outline without their way along the surface where the second say. Of p
    and of q of `outline_kept` the sums over the `own` vertices follow, which have `rings_of_relaxation` around them, and how many
    these are. `is_open` says whether the whole has borders.
    """
    fair, nothing = taubin_fairing(vertices, faces, iterations=iterations, border=border, whole=whole), ((0.0, 0), (0.0, 0))
    if direction == "all" and (border != "along" or not is_open):
        return fair, fair, nothing
    across = along_normals(vertices, fair, smooth_normals(vertices, faces, whole=whole))
    if direction == "normal":
        return across, across, nothing
    along, outline = fair - across, border_vertices(faces, len(vertices))
    squares, went = np.einsum("ij,ij->i", along, along), (fair != vertices).any(axis=1) & own
    p, q = ((math.fsum(squares[went & which]), int((went & which).sum())) for which in (outline, ~outline))
    return fair, np.where(outline[:, None], across, fair), (p, q)


def rings_of_relaxation(iterations: int) -> int:
    """How many rings of faces around a vertex decide where they take it."""
    return max(2 * iterations, RINGS_OF_SMOOTH_NORMALS)


def unfolded(before: Floats, after: Floats, faces: Ints) -> Floats:
    """(n, 3) the vertices `after` a filter, if it leaves more `folded_faces` than `before` some of them on their way back.

    While there are more, vertices go back, see `going_back`: half of their way, then all of it. That ends: at least one goes back
    each time.
    """
    folded, share = folded_faces(before, faces), HALF_WAY
    while np.count_nonzero(now := folded_faces(after, faces)) > np.count_nonzero(folded):
        after = going_back(before, after, faces, now & ~folded, share)
        share = 0.0
    return after


def going_back(before: Floats, after: Floats, faces: Ints, new: Bools, share: float) -> Floats:
    """(n, 3) the vertices `after`, corners of the (m,) faces that are newly folded with a share of their way.

    A face whose corners are all back is folded by the normals around it: the corners of the faces at its corners go back.
    """
    away = (after != before).any(axis=1)
    stuck = new & ~away[faces].any(axis=1)
    back, around = np.zeros_like(away), np.zeros_like(away)
    back[faces[new]] = around[faces[stuck]] = True
    back[faces[around[faces].any(axis=1)]] = True
    return np.where((back & away)[:, None], before + share * (after - before), after)
