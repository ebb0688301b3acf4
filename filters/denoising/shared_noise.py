"""Noise that neighbours share, as that of a depth camera with its own filter: it looks like a surface."""

from __future__ import annotations

import numpy as np

from ..evidence import far_from_border, noise_field, sample_of
from ..geometry import edge_lengths, normal_differences, seen_from_one_side
from ..mesh import Floats, Ints
from ..topology import edges
from .noise_level import NoiseEstimate, differences_of_fourth_order, inner_vertices, smooth_normals

# A map is seen from one side: the mean of its normals is longer than this. Of noisy maps it is 0.5 and more.
_FACING = 0.4
# The vertices of a depth map lie on lines of sight, and so do their residuals: this share of their squares and more is along one
# direction. Maps of lenses of up to 45 degrees have 0.9 and more, other meshes with noise, terrain among them, up to 0.6.
_ON_LINES = 0.75
# Such noise is shared if more than half of its variance is, by a fit of noise of single vertices and of noise smoothed over two
# steps, seen by differences of one step and of four.
_WIDTHS, _SCALES, _HALF = (0, 2), (1, 4), 0.5
# Every camera has some noise of its own at each vertex: 0.033 mean edges and more. Without noise maps have up to 0.012, a laser
# scanner's map of a face: what is left of them are details. Fused maps mostly have more than the second; those with less gain
# nothing by a strong setting, and a fused scan that was smoothed by a single Laplacian step has up to 0.015.
_OWN, _OWN_FUSED = 0.03, 0.02
# Rounded depths are flush at so many edges. Maps of steps of a fifth to a sixteenth of a pixel of disparity are at 0.42 to 0.69,
# those of millimetres by a time-of-flight camera at up to 0.33, others at less than 0.1.
_FLUSH, _ROUNDING = 0.4, 1e-3
#: Residuals of vertices so many edges from the border are whole enough.
RINGS = 3

# A fused map is a level set in a grid of cubes, which cuts off corners anywhere: 7 to 10 % of its edges are shorter than a
# quarter of the mean; of other meshes, uneven ones among them, at most 3 %, and up to 5.5 % of a fused map that was decimated.
_SHORT, _CUT_OFF = 0.25, 0.06


def neighbours_share_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> bool:
    """Whether the mesh is a depth camera's map, or fused from such maps, with noise that neighbours share.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        noise: of `estimate_noise`.
    """
    if noise.level == 0.0 or seen_from_one_side(points, faces) <= _FACING:
        return False
    on_lines = on_lines_of_sight(points, faces)
    if not on_lines and not _corners_cut_off(points, faces):
        return False
    sample = sample_of(points, faces)
    normals, scored = smooth_normals(sample.points, sample.faces), far_from_border(sample.faces, len(sample.points), rings=RINGS)
    field = noise_field(sample.points, sample.faces, normals=normals, scored=scored, widths=_WIDTHS, scales=_SCALES)
    if field.own < (_OWN if on_lines else _OWN_FUSED):
        return False
    return field.shared > _HALF or (on_lines and in_steps(points, faces))


def _corners_cut_off(points: Floats, faces: Ints) -> bool:
    lengths = edge_lengths(points, edges(faces))
    return bool(np.mean(lengths < _SHORT * lengths.mean()) > _CUT_OFF)


def on_lines_of_sight(points: Floats, faces: Ints) -> bool:
    """Whether the vertices are pixels: differences of fourth order are along the view alone, the rest being evenly spaced."""
    pairs = edges(faces)
    inner = inner_vertices(faces, pairs, len(points))
    residuals = differences_of_fourth_order(points, pairs)[inner]
    squares = np.linalg.eigvalsh(residuals.T @ residuals)
    return bool(squares[-1] > _ON_LINES * squares.sum())


def in_steps(points: Floats, faces: Ints) -> bool:
    """Whether the depth was rounded so coarsely that many adjacent faces are flush."""
    flush = normal_differences(points, faces) < _ROUNDING
    return bool(len(flush) and flush.mean() > _FLUSH)
