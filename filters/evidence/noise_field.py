"""Noise that neighbours share: how much of it there is, over what widths, from the places where the surface is calm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..libraries import optimize, sparse
from ..mesh import Bools, Floats, Ints
from ..topology import edges

# The calmest part: the surface adds to residuals, but hardly there. Squares count up to so many times their median, and are
# averaged over so many rings.
_CALMEST, _CLIP, _AVERAGED = 0.05, 9.0, 4
# Random numbers are the fractions of so many times a length of the geometry, another multiple for every width.
_MULTIPLE, _STEP = 997.0, 137.7


class NoiseField(NamedTuple):
    """Noise as a sum of independent parts, part k smoothed over `widths[k]` steps.

    Attributes:
        widths: (k,) the steps; 0 is noise of the vertex alone, k smooths with a standard deviation of 2/3 sqrt(k) edges.
        variances: (k,) those of the parts, in squared units of the points.
        heights: (n,) one such noise along the normals.
    """

    widths: tuple[int, ...]
    variances: Floats
    heights: Floats

    @property
    def shared(self) -> float:
        """The share of the variance that is not of the vertex alone; 0 without noise."""
        total = float(self.variances.sum())
        return float(self.variances[np.array(self.widths) > 0].sum()) / total if total > 0.0 else 0.0

    @property
    def own(self) -> float:
        """The standard deviation of what is of the vertex alone."""
        return float(np.sqrt(self.variances[np.array(self.widths) == 0].sum()))


def noise_field(
    points: Floats, faces: Ints, *, normals: Floats, scored: Bools, widths: Sequence[int], scales: Sequence[int]
) -> NoiseField:
    """Fit a sum of noises to what differences of several widths leave of a surface.

    With W the mean over the one-ring and twice the weight of its neighbours, (I + 2 U) / 3, the residuals of scale m are those of
    (I - W^m)^2. Their squares, averaged over some rings, have a least part where the surface is calm. Every part of the noise,
    made with a variance of 1 on the same mesh, has such numbers of its own; the variances are the non-negative sum of these that
    is nearest to what was seen, relatively.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that count.
        widths: the steps over which parts of the noise are smoothed.
        scales: the scales of the residuals.

    Returns:
        The noise; nothing if no vertex counts. The same for the mesh moved, turned or renumbered.
    """
    nothing = NoiseField(tuple(widths), np.zeros(len(widths)), np.zeros(len(points)))
    if not scored.any():
        return nothing
    means = _means(faces, len(points))
    seen = np.array([_calm(_residuals(points, means, scale, normals), means, scored) for scale in scales])
    if seen.min() <= 0.0:
        return nothing
    parts = [_unit_noise(points, means, scored, width) for width in widths]
    made = np.array([[_calm(_residuals(part, means, scale), means, scored) for part in parts] for scale in scales])
    variances, _ = optimize.nnls(made / seen[:, None], np.ones(len(scales)))
    heights = np.sum([np.sqrt(variance) * part for variance, part in zip(variances, parts, strict=True)], axis=0)
    return NoiseField(tuple(widths), variances, heights)


def _means(faces: Ints, n: int) -> sparse.csr_matrix:
    a, b = edges(faces).T
    rows, columns = np.concatenate([a, b]), np.concatenate([b, a])
    degrees = np.maximum(np.bincount(rows, minlength=n), 1)
    ring = sparse.csr_matrix((2.0 / 3.0 / degrees[rows], (rows, columns)), shape=(n, n))
    return ring + sparse.diags(np.where(np.bincount(rows, minlength=n) > 0, 1.0 / 3.0, 1.0), format="csr")


def _residuals(values: Floats, means: sparse.csr_matrix, scale: int, normals: Floats | None = None) -> Floats:
    for _ in range(2):
        smooth = values
        for _ in range(scale):
            smooth = means @ smooth
        values = values - smooth
    return values if normals is None else np.asarray(np.einsum("ij,ij->i", values, normals))


def _calm(residuals: Floats, means: sparse.csr_matrix, scored: Bools) -> float:
    """The mean square that a twentieth of the vertices stays below."""
    squares = residuals**2
    sums, weights = np.where(scored, np.minimum(squares, _CLIP * np.median(squares[scored])), 0.0), scored.astype(np.float64)
    for _ in range(_AVERAGED):
        sums, weights = means @ sums, means @ weights
    return float(np.quantile(sums[scored] / weights[scored], _CALMEST))


def _unit_noise(points: Floats, means: sparse.csr_matrix, scored: Bools, width: int) -> Floats:
    """(n,) random numbers, smoothed, with a variance of 1; they are made of the distances from the middle of the mesh."""
    distances = np.linalg.norm(points - points[scored].mean(axis=0), axis=1)
    noise = (distances * (_MULTIPLE + _STEP * width)) % 1.0 - 0.5
    for _ in range(width):
        noise = means @ noise
    deviation = float(np.sqrt((noise[scored] ** 2).mean()))
    return np.asarray(noise / deviation if deviation > 0.0 else noise)
