"""Taubin's steps before normal filtering: they calm noise that would turn faces over."""

from typing import Literal, TypeAlias, get_args

import numpy as np

from ..checks import check_choice
from ..diffusion.taubin import taubin_fairing
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints
from ..topology import BorderPolicy, border_vertices
from .noise_level import NoiseEstimate, smooth_normals

#: "all": vertices go wherever the steps take them, which evens out noise in all directions, and triangles. "normal": they keep
#: their place along the surface, so that noise along the normals alone does not make them slide.
RelaxationDirection: TypeAlias = Literal["all", "normal"]
RELAXATION_DIRECTIONS: tuple[RelaxationDirection, ...] = get_args(RelaxationDirection)

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
    check_choice("relaxation_direction", direction, RELAXATION_DIRECTIONS)
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
    return np.where(outline[:, None], across + (min(1.0, q / p) if p > 0.0 else 1.0) * along, moved)
