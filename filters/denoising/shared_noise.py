"""Noise that neighbours share, as that of a depth camera with its own filter: it looks like a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..evidence import calm_noise, far_from_border, sample_of
from ..geometry import mean_edge_length
from ..libraries import sparse
from ..mesh import Floats, Ints, check_mesh
from ..topology import edges
from .noise_level import NoiseEstimate, differences_of_fourth_order, inner_vertices, ring_means, smooth_normals

# A map is seen from one side: the mean of its normals is longer than this.
_FACING = 0.4
# A range map is sampled on a grid: its vertices are spread along the surface, while their residuals lie along the view. A depth
# camera's map has 3.9 and 0.37. Scans and parts with noise from 0.06 edges have up to 2.5, in any direction.
# With less noise than that an uneven scan from one side looks alike and would lose its details: it has tails up to 1.08, and
# `shared_noise` up to 0.06 from 0.03 edges; the maps have 1.14 to 1.7, and 0.078 to 0.1. Residuals that agree still more are the
# details of a surface without noise: a decimated scan has 0.24.
_SPREAD, _ONE_SIDED, _TAILS, _AGREE_SPREAD, _DETAILS = 3.0, 0.3, 1.11, 0.068, 0.15
# So is a mesh whose `shared_noise` is above both of these, the second over the squared level, since details count the less the
# stronger the noise is. Four computed maps of a depth camera with its steps, at 0.19 to 0.28 edges, have 0.017 to 0.045 and
# 0.0013 to 0.0022; figures and scans with independent noise at most 0.01, and at most 0.0007. Their mean angle falls from 1.16 to
# 0.5 times that of Taubin's best. Rough land with independent noise has as much; but there a vertex is no better known to its
# neighbours than even noise is, `calm_noise` being 0.73 to 0.8 of the level, and 0.36 to 0.58 in computed maps.
_AGREE, _AGREE_WEAK, _CALM = 0.011, 0.0009, 0.6


def neighbours_share_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> bool:
    """Whether the mesh is a depth camera's map: seen from one side, with noise that neighbours share.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        noise: of `estimate_noise`.
    """
    corners = points[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if noise.level == 0.0 or np.linalg.norm(areas.sum(axis=0)) < _FACING * np.linalg.norm(areas, axis=1).sum():
        return False
    if noise.tangential > _SPREAD * noise.level and noise.anisotropy > _ONE_SIDED and noise.tails > _TAILS:
        return _AGREE_SPREAD < shared_noise(points, faces) < _DETAILS
    if shared_noise(points, faces) < max(_AGREE, _AGREE_WEAK / noise.level**2):
        return False
    sample = sample_of(points, faces)
    normals, scored = smooth_normals(sample.points, sample.faces), far_from_border(sample.faces, len(sample.points))
    return calm_noise(sample.points, sample.faces, normals=normals, scored=scored) < _CALM * noise.level


def shared_noise(vertices: ArrayLike, faces: ArrayLike) -> float:
    """How much more the residuals h of `estimate_noise` of neighbouring vertices agree than those of independent noise would.

    The mean of h_i h_j over the edges between inner vertices, over the mean of h^2, less the mean of (B B^T)_ij / (|B_i| |B_j|),
    which is what independent noise gives: about -0.3. Details and flat parts add to it the less, the more noise there is.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Returns:
        Near 0 for independent noise, above 0 if neighbours share it; 0 of a mesh without inner vertices or residuals.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    pairs = edges(triangles)
    inner = inner_vertices(triangles, pairs, len(points))
    edge = mean_edge_length(points, triangles)
    between = pairs[inner[pairs].all(axis=1)]
    if edge == 0.0 or not len(between):
        return 0.0
    local = (points - points[np.unique(pairs)].mean(axis=0)) / edge
    heights = np.einsum("ij,ij->i", differences_of_fourth_order(local, pairs), smooth_normals(points, triangles))
    square = float((heights[inner] ** 2).mean())
    if square == 0.0:
        return 0.0
    means = ring_means(pairs, len(points))
    first = sparse.identity(len(points), format="csr") - means
    second = first @ first
    norms = np.sqrt(np.asarray(second.multiply(second).sum(axis=1)).ravel())
    i, j = between.T
    independent = np.asarray(second[i].multiply(second[j]).sum(axis=1)).ravel() / (norms[i] * norms[j])
    return float((heights[i] * heights[j]).mean()) / square - float(independent.mean())
