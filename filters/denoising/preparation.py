"""All steps of denoising: rounding undone, outliers taken away, noise calmed, normals filtered, folds taken back."""

from collections.abc import Mapping
from typing import Any

from ..checks import check_choice, check_whole_number
from ..execution import Progress, ignore_progress, part_of, rising
from ..mesh import Bools, Floats, Ints
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices
from .impulses import Outliers, without_outliers
from .normal_filtering import normal_filtering
from .relaxation import RelaxationDirection, relaxed
from .rounding import RoundingPolicy, without_rounding
from .unfolding import unfolded


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
