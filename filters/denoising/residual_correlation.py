"""How much neighbours agree in what is left of a surface after differences of fourth order: noise does not, a surface does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite
from ..evidence import local_means
from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints, check_mesh
from ..topology import edges
from .noise_level import FourthOrder, inner_vertices, smooth_normals

# Squares are averaged so many times over the one-rings, and count up to so many times their median, to find where it is calm.
_AVERAGED, _CLIP = 4, 9.0


@dataclass(frozen=True, eq=False)
class ResidualCorrelation:
    """How much the residuals h of `estimate_noise` of neighbouring vertices agree, more than those of independent noise would.

    Attributes:
        heights: (n,) the residuals.
        inner: (n,) the vertices that have any.
        pairs: (e, 2) the edges.
        independent: (e,) what the correlation of independent noise is along an edge: about -0.3.
    """

    heights: Floats
    inner: Bools
    pairs: Ints
    independent: Floats

    @staticmethod
    def on(vertices: ArrayLike, faces: ArrayLike) -> ResidualCorrelation:
        """On a mesh of (n, 3) vertices and (m, 3) triangles.

        Raises:
            FilterInputError: not a mesh.
        """
        points, triangles = check_mesh(vertices, faces)
        pairs = edges(triangles)
        inner = inner_vertices(triangles, pairs, len(points))
        edge = mean_edge_length(points, triangles)
        if edge == 0.0 or not inner.any():
            return ResidualCorrelation(np.zeros(len(points)), np.zeros_like(inner), pairs, np.zeros(len(pairs)))
        local = (points - points[np.unique(pairs)].mean(axis=0)) / edge
        fourth = FourthOrder.of(pairs, len(points))
        heights = np.einsum("ij,ij->i", fourth.differences(local), smooth_normals(points, triangles))
        between = inner[pairs].all(axis=1)
        independent = np.zeros(len(pairs))
        independent[between] = fourth.correlations(*pairs[between].T)
        return ResidualCorrelation(heights, inner, pairs, independent)

    def within(self, calmest: float = 1.0) -> float:
        """The mean of h_i h_j over the edges, over the mean of h^2, less what independent noise gives.

        Edges and details add to it, the less the more noise there is; in the calmest part they hardly do.

        Args:
            calmest: the share of the inner vertices that count, above 0: those with the least h^2 around them. In a small part of
                noise neighbours are alike, which is why they are in it: a third of it has up to 0.07.

        Returns:
            Near 0 for independent noise, above 0 if neighbours share it; 0 of a mesh without inner vertices or residuals.

        Raises:
            FilterInputError: a share out of range.
        """
        share = check_finite("calmest", calmest, least=0.0)
        counted = self.inner if share >= 1.0 or not self.inner.any() else self.inner & self._calm(share)
        between = counted[self.pairs].all(axis=1)
        square = float((self.heights[counted] ** 2).mean()) if counted.any() else 0.0
        if square == 0.0 or not between.any():
            return 0.0
        i, j = self.pairs[between].T
        return float((self.heights[i] * self.heights[j]).mean()) / square - float(self.independent[between].mean())

    def _calm(self, share: float) -> Bools:
        """(n,) where the mean of the squares around is least."""
        squares = self.heights**2
        clipped = np.minimum(squares, _CLIP * np.median(squares[self.inner]))
        means = local_means(clipped, self.inner, self.pairs, times=_AVERAGED)
        return np.asarray(means <= np.quantile(means[self.inner], share))
