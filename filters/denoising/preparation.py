"""Runs the steps of denoising in order: undo rounding, replace outliers, relax, filter normals, unfold faces.

The relaxation is a number of Taubin steps, which reduce noise that would flip faces in normal filtering.
"""

import math
from collections.abc import Mapping
from itertools import compress
from typing import Any, Literal, TypeAlias

import numpy as np

from ..checks import check_choice, check_whole_number
from ..diffusion.explicit import taubin_fairing
from ..execution import Progress, ignore_progress, part_of, rising
from ..inspection import folded_faces, triangle_shapes
from ..mesh import Bools, Floats, Ints, Whole, normalised_mesh
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices, face_adjacency, faces_across
from .impulses import Outliers, without_outliers
from .noise_level import RINGS_OF_SMOOTH_NORMALS, NoiseEstimate, smooth_normals
from .normal_filtering import normal_filtering
from .rounding import RoundingPolicy, rounding_of

#: "all": Taubin steps move vertices freely, which reduces noise in all directions and evens out the triangles. "normal": they
#: move vertices along the normals only; this suits noise along the normals.
RelaxationDirection: TypeAlias = Literal["all", "normal"]

# The least tangential noise that counts as noise in all directions, as a share of the noise along the normals.
_ALL_DIRECTIONS = 0.85
#: The share of their moves that corners of newly folded faces keep in the first pass of `unfolded` (0 would restore spikes), and
#: the number of rings of faces around a vertex on which its place after one pass depends.
HALF_WAY, RINGS_OF_UNFOLDING = 0.5, 3
# The `triangle_shapes` below which a triangle is a sliver (height about 1/10 of the base); the share of slivers that gets a note.
_SLIVER, _MANY_SLIVERS = 0.2, 0.05


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
    """Returns (n, 3) the vertices after all steps of denoising.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        outliers: see `without_outliers`.
        rounding: "undo" smooths the terraces of rounded coordinates first, see `Rounding.undone`.
        relaxation: number of pairs of Taubin steps, see `relaxed`.
        relaxation_direction: direction of the Taubin steps.
        filtering: arguments of `normal_filtering`; None for no normal filtering.
        border: see `taubin_fairing` and `normal_filtering`.
        movable: (n,) which vertices may move, None for all.
        certain: (n,) which vertices are certainly outliers, None for none.
        progress: called after every pair of Taubin steps and every pass of the normal filter.

    Raises:
        FilterInputError: a parameter out of range.
    """
    check_whole_number("relaxation", relaxation)
    check_choice("border", border, BORDER_POLICIES)
    check_choice("rounding", rounding, RoundingPolicy)
    share = 1.0 if filtering is None else 0.2 if relaxation else 0.0
    report = rising(progress)  # with outliers the steps run several times

    def smooth(points: Floats, moves: Bools | None) -> Floats:
        fair = relaxed(
            points,
            faces,
            iterations=relaxation,
            direction=relaxation_direction,
            border=border,
            movable=moves,
            progress=part_of(report, 0.0, share),
        )
        if filtering is None:
            return fair
        return normal_filtering(fair, faces, **filtering, border=border, movable=moves, progress=part_of(report, share, 1.0))

    if border == "fixed" and (outliers != "keep" or rounding != "keep"):
        inside = ~border_vertices(faces, len(vertices))
        movable = inside if movable is None else movable & inside
    scale = normalised_mesh(vertices, faces).scale  # a power of two
    points = vertices * scale
    levels = rounding_of(points, faces) if rounding == "undo" else None
    start = points if levels is None else levels.undone(points, faces, movable)
    result = unfolded(points, without_outliers(start, faces, outliers, smooth, movable=movable, certain=certain), faces)
    progress(1.0)  # also if no step had to be done
    return np.where(result == points, vertices, result / scale)


def direction_for(noise: NoiseEstimate) -> RelaxationDirection:
    """Returns the direction of relaxation that suits the noise."""
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
    """Returns (n, 3) the vertices after `iterations` pairs of Taubin steps with the factors 0.5 and -0.53.

    With the direction "normal" only the part of each move along the normal of a smoothed copy remains. With "all" the border
    "along" keeps the outline, see `outline_kept`.
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
    """Returns (n, 3) the vertices moved by the normal component of the move from `vertices` to `moved`."""
    return np.asarray(vertices + np.einsum("ij,ij->i", moved - vertices, normals)[:, None] * normals)


def outline_kept(vertices: Floats, moved: Floats, normals: Floats, outline: Bools) -> Floats:
    """Returns (n, 3) the moved vertices; those of the outline keep the share min(1, q / p) of their move along the surface.

    p is the mean square of moves along the surface on the outline, q that at other vertices, where only noise causes such moves.
    """
    across = along_normals(vertices, moved, normals)
    along = moved - across
    squares, went = np.einsum("ij,ij->i", along, along), (moved != vertices).any(axis=1)
    p, q = (float(squares[went & which].mean()) if (went & which).any() else 0.0 for which in (outline, ~outline))
    return np.where(outline[:, None], across + share_along(p, q) * along, moved)


def share_along(p: float, q: float) -> float:
    """Returns the share min(1, q / p) of `outline_kept`; 1 if p is 0."""
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
    """Relaxes a part of a mesh as `relaxed` does, but leaves the share of `outline_kept` to the caller.

    Returns (n, 3) the moved vertices; (n, 3) these vertices without the outline's moves along the surface; and for each of the
    means p and q of `outline_kept` the sum and the number of squares. The sums go over the vertices of the mask `own`; the part
    has `rings_of_relaxation` rings around each vertex of `own`. `is_open` says whether the whole mesh has borders.
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
    """Returns the number of rings of faces around a vertex on which its position after `relaxed_part` depends."""
    return max(2 * iterations, RINGS_OF_SMOOTH_NORMALS)


def unfolded(before: Floats, after: Floats, faces: Ints) -> Floats:
    """Returns (n, 3) the vertices `after` a filter, some moved back if the filter has increased the number of `folded_faces`.

    Vertices go back by half of their move, then by all of it, see `going_back`. Each pass moves a vertex back, so this ends.
    """
    folded, share = folded_faces(before, faces), HALF_WAY
    while np.count_nonzero(now := folded_faces(after, faces)) > np.count_nonzero(folded):
        after = going_back(before, after, faces, now & ~folded, share)
        share = 0.0
    return after


def going_back(before: Floats, after: Floats, faces: Ints, new: Bools, share: float) -> Floats:
    """Returns (n, 3) the vertices `after`, but corners of faces in the (m,) mask `new` keep only the `share` of their move.

    If all corners of a face in `new` are back already, the corners of the faces around it go back, too.
    """
    away = (after != before).any(axis=1)
    stuck = new & ~away[faces].any(axis=1)
    back, around = np.zeros_like(away), np.zeros_like(away)
    back[faces[new]] = around[faces[stuck]] = True
    back[faces[around[faces].any(axis=1)]] = True
    return np.where((back & away)[:, None], before + share * (after - before), after)


def causes_of_folds(vertices: Floats, faces: Ints, inside: Bools) -> tuple[int, int, int]:
    """Returns the numbers of faces, of slivers, and of edges whose two faces are oriented differently.

    Only faces and edges whose lowest vertex is `inside` (n,) count, so that the parts of a mesh add up to the mesh.
    """
    counts = inside[faces.min(axis=1)]
    slivers = counts & (triangle_shapes(vertices, faces) < _SLIVER)
    pairs = inside[face_adjacency(faces)[1][:, 0]]
    coherent = (faces_across(faces) >= 0) & inside[np.minimum(faces, np.roll(faces, -1, axis=1))]
    return int(counts.sum()), int(slivers.sum()), int(pairs.sum()) - int(coherent.sum()) // 2


def notes_on_folds(before: int, after: int, faces: int, slivers: int, turned: int) -> tuple[str, ...]:
    """Notes on the `causes_of_folds`; `before` and `after` are the numbers of folded faces before and after a filter."""
    share = slivers / max(faces, 1)
    why = (
        f"{share:.0%} of the triangles are slivers, which noise folds over: remesh first, or use Taubin Fairing",
        f"{turned:,} edges join faces that are oriented differently: run Re-Orient all faces coherently first",
    )
    causes = compress(why, (share > _MANY_SLIVERS, turned > 0))
    return tuple(f"{after} faces are folded over, {before} were before; {cause}" for cause in causes)
