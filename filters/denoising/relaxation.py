"""Taubin's steps before normal filtering: they calm noise that would turn faces over."""

import math
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks import check_choice
from ..diffusion.explicit import taubin_fairing
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, Whole
from ..topology import BorderPolicy, border_vertices
from .noise_level import RINGS_OF_SMOOTH_NORMALS, NoiseEstimate, smooth_normals

#: "all": vertices go wherever the steps take them, which evens out noise in all directions, and triangles. "normal": they keep
#: their place along the surface, so that noise along the normals alone does not make them slide.
RelaxationDirection: TypeAlias = Literal["all", "normal"]

# Noise in all directions scatters the vertices as much along the surface as along its normals; an uneven mesh only adds to that.
_ALL_DIRECTIONS = 0.85


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

    With the border "along", its vertices go along their normals alone, as in normal filtering: an outline that is jagged by
    itself would be smoothed, and the triangles at it be squashed.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        iterations: number of pairs of steps.
        direction: "normal" keeps of the way of every vertex the part along its normal, that of a smoothed copy.
        border: see `taubin_fairing`.
        movable: (n,) which vertices may move, None for all.
        progress: called after every pair of steps.

    Raises:
        FilterInputError: a parameter out of range.
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

    Vertices go along the surface as far as noise has scattered them. Those of the outline went farther if it has corners; then
    they keep min(1, q / p) of that way, p its mean square and q that of the other vertices.

    Args:
        vertices: (n, 3) coordinates.
        moved: (n, 3) where Taubin's steps took them.
        normals: (n, 3) unit normals.
        outline: (n,) the vertices on the border.
    """
    across = along_normals(vertices, moved, normals)
    along = moved - across
    squares, went = np.einsum("ij,ij->i", along, along), (moved != vertices).any(axis=1)
    p, q = (float(squares[went & which].mean()) if (went & which).any() else 0.0 for which in (outline, ~outline))
    return np.where(outline[:, None], across + share_along(p, q) * along, moved)


def share_along(p: float, q: float) -> float:
    """What vertices of the outline keep of their way along the surface, see `outline_kept`."""
    return min(1.0, q / p) if p > 0.0 else 1.0


class RelaxedPart(NamedTuple):
    """What the vertices of a part of a mesh are after Taubin's steps, as `relaxed` in the whole but for one number.

    Attributes:
        moved: (n, 3) where they are.
        across: (n, 3) where those of the outline are without their way along the surface; the others as `moved`.
        outline: (n,) which are on the outline.
        squares: of p and of q of `outline_kept` the sum over the `own` vertices, and their number.
    """

    moved: Floats
    across: Floats
    outline: Bools
    squares: tuple[tuple[float, int], tuple[float, int]]

    @staticmethod
    def of(
        vertices: Floats,
        faces: Ints,
        own: Bools,
        *,
        iterations: int,
        direction: RelaxationDirection,
        border: BorderPolicy,
        whole: Whole,
        is_open: bool,
    ) -> "RelaxedPart":
        """Take the steps; arguments as of `relaxed`, and whether the whole has borders.

        The `own` vertices of the part have `rings_of_relaxation` around them.
        """
        fair = taubin_fairing(vertices, faces, iterations=iterations, border=border, whole=whole)
        outline = border_vertices(faces, len(vertices)) & (border == "along") & (direction == "all")
        if direction == "all" and (border != "along" or not is_open):
            return RelaxedPart(fair, fair, outline, ((0.0, 0), (0.0, 0)))
        across = along_normals(vertices, fair, smooth_normals(vertices, faces, whole=whole))
        if direction == "normal":
            return RelaxedPart(across, across, outline, ((0.0, 0), (0.0, 0)))
        along = fair - across
        squares, went = np.einsum("ij,ij->i", along, along), (fair != vertices).any(axis=1) & own
        p, q = ((math.fsum(squares[went & which]), int((went & which).sum())) for which in (outline, ~outline))
        return RelaxedPart(fair, np.where(outline[:, None], across, fair), outline, (p, q))


def rings_of_relaxation(iterations: int) -> int:
    """How many rings of faces around a vertex decide where they take it."""
    return max(2 * iterations, RINGS_OF_SMOOTH_NORMALS)
