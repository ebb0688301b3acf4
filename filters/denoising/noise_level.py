"""Estimates the noise of a mesh of (n, 3) vertices and (m, 3) triangles from the mesh alone, and detects clean meshes.

Noise is independent between neighbouring vertices, the surface is not. In differences of fourth order (residuals) a surface
of moderate curvature nearly cancels out and noise remains.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..diffusion.explicit import taubin_fairing
from ..evidence import far_from_border, local_means, predicted_heights, tuned
from ..geometry import NORMAL, face_normals, mean_edge_length, mean_normals_at_vertices, measure_faces
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, Whole, check_mesh, normalised_mesh
from ..topology import edges, face_adjacency, one_rings, referenced_vertices, vertex_faces
from .face_neighbourhoods import face_neighbourhoods
from .normal_filter import mean_normals

# Squared residuals are clipped at `CLIP` times their median and averaged over the one-rings `AVERAGED` times.
AVERAGED, CLIP = 4, 9.0
# A smaller prediction error (in mean edges) or angle between faces (in radians) is due to rounding: the surface is a plane there.
_EXACT = 1e-4
#: number of rings of faces around a vertex on which its `smooth_normals` depend
RINGS_OF_SMOOTH_NORMALS = 13


class NoiseEstimate(NamedTuple):
    """The noise of a mesh. All but `length` are pure numbers.

    Attributes:
        level: the standard deviation of the vertices along the normals, in mean edges, from the median of the residuals: sharp
            features and outliers count little. A good laser scanner has 0.1, a bad one 0.3; from 0.6 on, faces fold.
        length: the level in mesh units.
        deviation: the level computed from the mean square, in which outliers count in full. It is over 1.2 times `level` if a few
            vertices are far off, and up to 1.1 times on shapes with many sharp edges.
        tangential: the standard deviation along a tangent, in mean edges. It exceeds `level` where vertices are spaced unevenly,
            whatever the noise of the surface.
    """

    level: float
    length: float
    deviation: float
    tangential: float


def estimate_noise(vertices: ArrayLike, faces: ArrayLike) -> NoiseEstimate:
    """Estimates the noise of a mesh.

    Independent noise keeps its standard deviation in the differences of `FourthOrder`. The level is the median of their absolute
    values along `smooth_normals`, divided by 0.6745. Spatially correlated noise, as of depth cameras, counts as surface. The
    error for noise of 0.2 to 0.5 edges is within 4 % on machine parts and statues. Weak noise is overestimated where most
    vertices are near sharp edges: noise of 0.1 edges by 28 % on a cube with 16 edges to a side.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Returns:
        The estimate; all 0 for a mesh without inner vertices.

    Raises:
        FilterInputError: not a mesh.
    """
    residuals = _residuals(vertices, faces)
    if residuals is None:
        return NoiseEstimate(0.0, 0.0, 0.0, 0.0)
    fourth, edge, *parts = residuals
    heights, across = (part[fourth.inner] for part in parts)
    level = float(np.median(np.abs(heights))) / tuned.MEDIAN_OF_NORMAL
    deviation, tangential = np.sqrt((heights**2).mean()), np.sqrt(0.5 * (across**2).sum(axis=1).mean())
    return NoiseEstimate(level, level * edge, float(deviation), float(tangential))


class FourthOrder(NamedTuple):
    """Differences of fourth order (B p)_i / |B_i|, where B = (1 - U)^2 and U is the mean over the one-ring."""

    pairs: Ints  # (e, 2) the edges
    inner: Bools  # (n,) which vertices have complete one-rings, and only neighbours with complete one-rings
    means: sparse.csr_matrix  # (n, n) the matrix U
    square: sparse.csr_matrix  # (n, n) the matrix B
    norms: Floats  # (n,) the norms |B_i| of the rows of B

    @staticmethod
    def of(faces: Ints, n: int) -> FourthOrder:
        pairs = edges(faces)
        means = ring_means(pairs, n)
        first = sparse.identity(n, format="csr") - means
        square = first @ first
        norms = np.sqrt(np.asarray(square.multiply(square).sum(axis=1)).ravel())
        return FourthOrder(pairs, far_from_border(faces, n, rings=1), means, square, norms)

    def differences(self, points: Floats) -> Floats:
        differences = points - self.means @ points
        differences -= self.means @ differences
        return np.asarray(differences / np.where(self.norms > 0.0, self.norms, 1.0)[:, None])

    def correlation(self, heights: Floats, counted: Bools) -> float:
        """Returns how far the correlation of the (n,) residuals h between counted neighbours exceeds that of independent noise.

        The correlation of h is the mean of h_i h_j over the edges divided by the mean of h^2; that of independent noise is the
        mean of (B B^T)_ij / (|B_i| |B_j|), about -0.3. Sharp features raise the result, noise lowers it. 0 if all h are 0.
        """
        i, j = self.pairs[counted[self.pairs].all(axis=1)].T
        square = float((heights[counted] ** 2).mean()) if counted.any() else 0.0
        if square == 0.0 or not len(i):
            return 0.0
        products = np.asarray(self.square[i].multiply(self.square[j]).sum(axis=1)).ravel()
        independent = np.asarray(products / (self.norms[i] * self.norms[j]))
        return float((heights[i] * heights[j]).mean()) / square - float(independent.mean())


def _residuals(vertices: ArrayLike, faces: ArrayLike) -> tuple[FourthOrder, float, Floats, Floats] | None:
    """Returns the operator, mean edge, and differences along and across normals, in mean edges; None without inner vertices."""
    points, triangles = check_mesh(vertices, faces)
    edge = mean_edge_length(points, triangles)
    fourth = FourthOrder.of(triangles, len(points)) if edge > 0.0 else None
    if fourth is None or not fourth.inner.any():
        return None
    local = (points - points[referenced_vertices(triangles, len(points))].mean(axis=0)) / edge
    residuals, normals = fourth.differences(local), smooth_normals(points, triangles)
    heights = np.einsum("ij,ij->i", residuals, normals)
    return fourth, edge, heights, residuals - heights[:, None] * normals


def agreement(vertices: ArrayLike, faces: ArrayLike) -> tuple[float, float]:
    """Returns the `FourthOrder.correlation` of all inner vertices, and of a third of them: those with the least residuals nearby.

    In this third no sharp features hide weak noise. Pure noise gives about 0 and 0.07. Without inner vertices both numbers are 0.
    """
    residuals = _residuals(vertices, faces)
    if residuals is None:
        return 0.0, 0.0
    fourth, _, heights, _ = residuals
    means = _means_around(heights**2, fourth.inner, fourth.pairs)
    calm = fourth.inner & (means <= np.quantile(means[fourth.inner], 1.0 / 3.0))
    return fourth.correlation(heights, fourth.inner), fourth.correlation(heights, calm)


def _means_around(squares: Floats, counted: Bools, pairs: Ints) -> Floats:
    return local_means(np.minimum(squares, CLIP * np.median(squares[counted])), counted, pairs, times=AVERAGED)


def ring_means(pairs: Ints, n: int, weight: float = 1.0) -> sparse.csr_matrix:
    """Returns (n, n) the matrix U of the means over the one-rings of (e, 2) edges, times the weight."""
    rows = np.concatenate([pairs[:, 0], pairs[:, 1]])
    columns = np.concatenate([pairs[:, 1], pairs[:, 0]])
    degrees = np.maximum(np.bincount(rows, minlength=n), 1)
    return sparse.csr_matrix((weight / degrees[rows], (rows, columns)), shape=(n, n))


def smooth_normals(points: Floats, faces: Ints, *, whole: Whole | None = None) -> Floats:
    """Returns (n, 3) unit normals of the vertices of a smoothed copy of the mesh, 0 for vertices without faces.

    The copy is smoothed by five pairs of Taubin steps; its face normals are averaged twice over the faces that share a vertex. Up
    to noise of 0.8 edges the normals are within a few degrees of the truth. In a part of the `whole`, see `taubin_fairing`,
    vertices with `RINGS_OF_SMOOTH_NORMALS` rings of faces around them get the same bits as in the whole.
    """
    smooth = taubin_fairing(points, faces, iterations=5, border="along", whole=whole)
    around = face_neighbourhoods(faces, vertex_faces(faces, len(points)), "vertex")
    mesh = normalised_mesh(points, faces, whole=whole)
    table = measure_faces((smooth - mesh.middle) * mesh.scale, faces)
    normals = np.ascontiguousarray(table[:, NORMAL])
    for _ in range(2):
        normals = mean_normals(normals, table, around)
    return mean_normals_at_vertices(normals, faces, len(points))


def noise_floor(points: Floats, faces_or_edges: Ints, *, normals: Floats, scored: Bools) -> float:
    """Returns the noise level along the normals in the calmest twentieth of the (n,) `scored` vertices, in units of the points.

    The squares of `height_residuals`, averaged over the surrounding vertices, estimate the noise variance. Exact planes count
    only if at least half of the scored vertices lie on them. For evenly strong noise the level is a fifth to a third below the
    standard deviation; without scored vertices it is 0. The (n, 3) points have a mean edge of 1, no triangle or edge is listed
    twice, the (n, 3) unit normals are those of a smoothed copy.
    """
    indices = np.flatnonzero(scored).astype(np.int32)
    if not len(indices):
        return 0.0
    heights, gains = predicted_heights(points, one_rings(faces_or_edges, len(points)), normals, indices)
    squares = np.zeros(len(points))
    squares[indices] = heights**2 / (1.0 + gains**2)
    rough = squares > _EXACT**2
    # Planes added by a program, such as the base of a scan, have no noise.
    counted = rough if np.count_nonzero(rough) > 0.5 * len(indices) else scored
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    return float(np.sqrt(np.quantile(_means_around(squares, counted, pairs)[counted], tuned.CALMEST)))


def is_designed(points: Floats, faces: Ints) -> bool:
    """Whether a normalised mesh consists of exact planes: 99 % of its faces have a coplanar neighbour."""
    pairs, _ = face_adjacency(faces)
    first, second = face_normals(points, faces)[pairs.T]
    flat = np.einsum("ij,ij->i", first, second) > np.cos(_EXACT)
    return len(np.unique(pairs[flat])) >= 0.99 * len(faces)
