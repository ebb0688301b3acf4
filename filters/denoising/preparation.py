"""What comes before normal filtering: spikes taken away, noise calmed."""

from ..checks import check_choice, check_whole_number
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints
from ..topology import BORDER_POLICIES, BorderPolicy
from .impulses import OUTLIERS, Outliers, replace_outlying
from .relaxation import RelaxationDirection, relaxed


def prepared(
    vertices: Floats,
    faces: Ints,
    *,
    outliers: Outliers = "keep",
    relaxation: int = 0,
    relaxation_direction: RelaxationDirection = "all",
    border: BorderPolicy = "along",
    movable: Bools | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """(n, 3) the vertices to filter.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        outliers: "replace" puts vertices that stand out where the others expect them, see `replace_outlying`.
        relaxation: number of pairs of Taubin's steps after that.
        relaxation_direction: where they go, see `relaxed`.
        border: see `taubin_fairing`.
        movable: (n,) which vertices may move, None for all.
        progress: called after every pair of steps.

    Raises:
        FilterInputError: a parameter out of range.
    """
    check_choice("outliers", outliers, OUTLIERS)
    check_whole_number("relaxation", relaxation)
    check_choice("border", border, BORDER_POLICIES)
    start = replace_outlying(vertices, faces, movable)[0] if outliers == "replace" else vertices
    return relaxed(
        start, faces, iterations=relaxation, direction=relaxation_direction, border=border, movable=movable, progress=progress
    )
