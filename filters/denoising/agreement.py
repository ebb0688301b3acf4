"""How much neighbours agree in what is left of a surface after differences of fourth order: noise does not, a surface does."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite
from ..geometry import mean_edge_length
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, check_mesh
from ..topology import edges
from .noise_level import differences_of_fourth_order, inner_vertices, ring_means, smooth_normals

# Squares are averaged so many times over the one-rings, and count up to so many times their median, to find where it is calm.
_AVERAGED, _CLIP = 4, 9.0


def agreement(vertices: ArrayLike, faces: ArrayLike, *, calmest: float = 1.0) -> float:
    """How much more the residuals h of `estimate_noise` of neighbouring vertices agree than those of independent noise would.

    The mean of h_i h_j over the edges between inner vertices, over the mean of h^2, less the mean of (B B^T)_ij / (|B_i| |B_j|),
    which is what independent noise gives: about -0.3. Edges and details add to it, the less the more
    noise there is; in the calmest part they hardly do.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        calmest: the share of the inner vertices that count, above 0: those with the least h^2 around them. In a small part of
            noise neighbours are alike, which is why they are in it: a third of it has up to 0.07.

    Returns:
        Near 0 for independent noise, above 0 if neighbours share it; 0 of a mesh without inner vertices or residuals.

    Raises:
        FilterInputError: not a mesh, or a share out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    share = check_finite("calmest", calmest, least=0.0)
    pairs = edges(triangles)
    counted = inner_vertices(triangles, pairs, len(points))
    edge = mean_edge_length(points, triangles)
    if edge == 0.0 or not counted.any():
        return 0.0
    local = (points - points[np.unique(pairs)].mean(axis=0)) / edge
    heights = np.einsum("ij,ij->i", differences_of_fourth_order(local, pairs), smooth_normals(points, triangles))
    if share < 1.0:
        counted &= _calmest(heights**2, counted, pairs, share)
    i, j = pairs[counted[pairs].all(axis=1)].T
    square = float((heights[counted] ** 2).mean())
    if square == 0.0 or not len(i):
        return 0.0
    means = ring_means(pairs, len(points))
    first = sparse.identity(len(points), format="csr") - means
    second = first @ first
    norms = np.sqrt(np.asarray(second.multiply(second).sum(axis=1)).ravel())
    independent = np.asarray(second[i].multiply(second[j]).sum(axis=1)).ravel() / (norms[i] * norms[j])
    return float((heights[i] * heights[j]).mean()) / square - float(independent.mean())


def _calmest(squares: Floats, counted: Bools, pairs: Ints, share: float) -> Bools:
    """(n,) where the mean of the squares around is least."""
    sums = np.where(counted, np.minimum(squares, _CLIP * np.median(squares[counted])), 0.0)
    weights = counted.astype(np.float64)
    a, b = pairs.T
    for _ in range(_AVERAGED):
        for values in (sums, weights):
            values += np.bincount(a, values[b], len(values)) + np.bincount(b, values[a], len(values))
    means = sums[counted] / weights[counted]
    calm = np.zeros_like(counted)
    calm[counted] = means <= np.quantile(means, share)
    return calm
