"""How noisy a scan is, and whether there is noise at all, seen from the scan alone.

Noise moves neighbouring vertices independently, a surface moves them together. So the noise is what is left of the vertices after
differences of fourth order, in which a surface of moderate curvature nearly cancels out; and residuals that are correlated
between neighbours are surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..diffusion.taubin import taubin_fairing
from ..evidence import Sample, far_from_border, local_means, predicted_heights, tuned
from ..geometry import NORMAL, face_normals, mean_edge_length, measure_faces
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, Whole, check_mesh, normalised_mesh
from ..topology import border_vertices, edges, face_adjacency, one_rings, referenced_vertices, vertex_faces
from .face_neighbourhoods import face_neighbourhoods
from .normal_filters import mean_normals

# Squares of residuals are averaged so many times over the one-rings, and count up to so many times their median: outliers are not
# noise of their neighbourhood.
_AVERAGED, _CLIP = 4, 9.0
# Vertices this near to where the others expect them, in mean edges, lie on an exact plane; angles below it are rounding.
_EXACT = 1e-4


#: how many rings of faces around a vertex decide on its `smooth_normals`
RINGS_OF_SMOOTH_NORMALS = 13


class NoiseEstimate(NamedTuple):
    """The noise of a mesh. All but `length` are pure numbers, the same for the mesh moved, turned or scaled.

    Attributes:
        level: the standard deviation of the vertices along the normals, in mean edges, from the median of the residuals: sharp
            features and outliers count little. 0.1 is a good laser scanner, 0.3 a bad one; from 0.6 faces fold.
        length: the same in mesh units.
        deviation: the same from the mean of the squared residuals, so that outliers count in full.
        tails: `deviation` / `level`, 1 for Gaussian noise and up to 1.1 on shapes with many sharp edges. Above 1.2 noise is
            impulsive: few vertices are moved, but far. 1 where there is no noise.
        tangential: the standard deviation along a tangent, in mean edges. Above `level` the vertices are spread unevenly, as in
            range maps and meshes of machine parts; it says nothing of the surface.
        anisotropy: from 0, no direction stands out in the residuals along the normals, to 1, they are all parallel, as those of a
            range map of a plane are.
        direction: (3,) the unit vector along which they are largest, its largest coordinate positive.
    """

    level: float
    length: float
    deviation: float
    tails: float
    tangential: float
    anisotropy: float
    direction: Floats


def estimate_noise(vertices: ArrayLike, faces: ArrayLike) -> NoiseEstimate:
    """Measure the noise of a mesh from the mesh alone.

    With U the mean over the one-ring and B = (1 - U)^2, the residuals of independent noise of standard deviation s along the
    normals n are h_i = n_i . (B p)_i / |B_i|, |B_i| the Euclidean norm of row i, and have the standard deviation s. The median of
    |h| over the inner vertices, over 0.6745, is robust against the vertices at sharp edges. The normals are those of a smoothed
    copy. Noise that neighbours share, as that of a depth camera with its own filter, is not seen: it looks like a surface.

    Against known noise of 0.2 to 0.5 edges the level is right within 4 % on machine parts and figures. Weak noise is overrated
    where sharp edges are near most vertices: 0.1 edges by 28 % on a cube of 16 edges to a side.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.

    Returns:
        The estimate; all 0, with `tails` 1, of a mesh without inner vertices.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    pairs = edges(triangles)
    edge = mean_edge_length(points, pairs)
    inner = inner_vertices(triangles, pairs, len(points))
    if edge == 0.0 or not inner.any():
        return NoiseEstimate(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, np.array([0.0, 0.0, 1.0]))
    local = (points - points[referenced_vertices(triangles, len(points))].mean(axis=0)) / edge
    residuals = differences_of_fourth_order(local, pairs)[inner]
    normals = smooth_normals(points, triangles)[inner]
    heights = np.einsum("ij,ij->i", residuals, normals)
    across = residuals - heights[:, None] * normals
    level = float(np.median(np.abs(heights))) / tuned.MEDIAN_OF_NORMAL
    deviation = float(np.sqrt((heights**2).mean()))
    anisotropy, direction = _direction(heights[:, None] * normals)
    return NoiseEstimate(
        level=level,
        length=level * edge,
        deviation=deviation,
        tails=deviation / level if level > 1e-9 else 1.0,
        tangential=float(np.sqrt(0.5 * (across**2).sum(axis=1).mean())),
        anisotropy=anisotropy,
        direction=direction,
    )


def inner_vertices(faces: Ints, pairs: Ints, n_vertices: int) -> Bools:
    """The vertices that have neighbours, none of them on a border, where one-rings are half rings."""
    on_border = border_vertices(faces, n_vertices)
    inner = np.zeros(n_vertices, dtype=np.bool_)
    inner[pairs] = True
    near = on_border.copy()
    near[pairs[on_border[pairs[:, 0]], 1]] = True
    near[pairs[on_border[pairs[:, 1]], 0]] = True
    return np.asarray(inner & ~near)


def differences_of_fourth_order(points: Floats, pairs: Ints) -> Floats:
    """(n, 3) (B p)_i / |B_i| for (n, 3) points and (e, 2) edges."""
    return FourthOrder.of(pairs, len(points)).differences(points)


class FourthOrder(NamedTuple):
    """Differences of fourth order on a mesh.

    Attributes:
        means: (n, n) the matrix U of means over the one-rings.
        square: (n, n) the matrix B = (1 - U)^2.
        norms: (n,) the Euclidean norms |B_i| of its rows.
    """

    means: sparse.csr_matrix
    square: sparse.csr_matrix
    norms: Floats

    @staticmethod
    def of(pairs: Ints, n: int) -> FourthOrder:
        """On a mesh of n vertices with (e, 2) edges."""
        means = ring_means(pairs, n)
        first = sparse.identity(n, format="csr") - means
        square = first @ first
        return FourthOrder(means, square, np.sqrt(np.asarray(square.multiply(square).sum(axis=1)).ravel()))

    def differences(self, points: Floats) -> Floats:
        """(n, 3) (B p)_i / |B_i|."""
        differences = points - self.means @ points
        differences -= self.means @ differences
        return np.asarray(differences / np.where(self.norms > 0.0, self.norms, 1.0)[:, None])

    def correlations(self, i: Ints, j: Ints) -> Floats:
        """(k,) those of the differences of independent noise at vertices i and j: (B B^T)_ij / (|B_i| |B_j|)."""
        products = np.asarray(self.square[i].multiply(self.square[j]).sum(axis=1)).ravel()
        return np.asarray(products / (self.norms[i] * self.norms[j]))


def ring_means(pairs: Ints, n: int) -> sparse.csr_matrix:
    """(n, n) the matrix U of means over the one-rings."""
    rows = np.concatenate([pairs[:, 0], pairs[:, 1]])
    columns = np.concatenate([pairs[:, 1], pairs[:, 0]])
    degrees = np.maximum(np.bincount(rows, minlength=n), 1)
    return sparse.csr_matrix((1.0 / degrees[rows], (rows, columns)), shape=(n, n))


def smooth_normals(points: Floats, faces: Ints, *, whole: Whole | None = None) -> Floats:
    """(n, 3) unit normals of the vertices of a smoothed copy of the mesh; 0 where no face is.

    Five pairs of Taubin's steps and two means over the faces at the vertices of a face leave normals within a few degrees of the
    truth up to noise of 0.8 edges, and a cosine hardly sees these.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        whole: the mesh that this is a part of, see `taubin_fairing`; then vertices with `RINGS_OF_SMOOTH_NORMALS` rings of faces
            around them in the part get the bits of the whole.
    """
    smooth = taubin_fairing(points, faces, iterations=5, border="along", whole=whole)
    around = face_neighbourhoods(faces, vertex_faces(faces, len(points)), "vertex")
    mesh = normalised_mesh(points, faces, whole=whole)
    table = measure_faces((smooth - mesh.middle) * mesh.scale, faces)
    normals = np.ascontiguousarray(table[:, NORMAL])
    for _ in range(2):
        normals = mean_normals(normals, table, around, overwrite=True)
    rows = faces.ravel()
    columns = np.repeat(np.arange(len(faces)), 3)
    sums = sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(points), len(faces))) @ normals
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(sums / np.where(lengths > 0.0, lengths, 1.0))


def residual_correlation(vertices: ArrayLike, faces: ArrayLike, calmest: float = 1.0) -> float:
    """How much the residuals h of `estimate_noise` of neighbouring vertices agree, more than those of independent noise would.

    It is the mean of h_i h_j over the edges, over the mean of h^2, less what independent noise gives, about -0.3. Edges and
    details add to it, the less the more noise there is; in the calmest part they hardly do.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        calmest: the share of the inner vertices that count: those with the least h^2 around them. In a small part of noise
            neighbours are alike, which is why they are in it: a third of it has up to 0.07.

    Returns:
        Near 0 for independent noise, above 0 if neighbours share it; 0 of a mesh without inner vertices or residuals.

    Raises:
        FilterInputError: not a mesh.
    """
    return _agreement(vertices, faces, (calmest,))[0]


class Agreement(NamedTuple):
    """How much residuals of neighbours agree; see `residual_correlation`.

    Attributes:
        whole: of all inner vertices.
        calm: of the calmest third, where edges and details do not hide weak noise.
    """

    whole: float
    calm: float

    @staticmethod
    def of(vertices: ArrayLike, faces: ArrayLike) -> Agreement:
        """Of a mesh."""
        return Agreement(*_agreement(vertices, faces, (1.0, 1.0 / 3.0)))

    @property
    def shows_surface(self) -> bool:
        """Whether the residuals are of edges and details, too."""
        return self.whole > tuned.SURFACE

    @property
    def is_surface(self) -> bool:
        """Whether they are of the surface alone: neighbours agree where it is calm, too."""
        return self.shows_surface and self.calm > tuned.SURFACE_WHERE_CALM


def _agreement(vertices: ArrayLike, faces: ArrayLike, shares: Sequence[float]) -> list[float]:
    """`residual_correlation` of several shares of the vertices."""
    points, triangles = check_mesh(vertices, faces)
    pairs = edges(triangles)
    inner = inner_vertices(triangles, pairs, len(points))
    edge = mean_edge_length(points, triangles)
    if edge == 0.0 or not inner.any():
        return [0.0] * len(shares)
    fourth = FourthOrder.of(pairs, len(points))
    local = (points - points[np.unique(pairs)].mean(axis=0)) / edge
    heights = np.einsum("ij,ij->i", fourth.differences(local), smooth_normals(points, triangles))
    squares = heights**2

    def calmest(share: float) -> Bools:
        means = local_means(np.minimum(squares, _CLIP * np.median(squares[inner])), inner, pairs, times=_AVERAGED)
        return np.asarray(inner & (means <= np.quantile(means[inner], share)))

    def correlation(counted: Bools) -> float:
        between = counted[pairs].all(axis=1)
        square = float(squares[counted].mean()) if counted.any() else 0.0
        if square == 0.0 or not between.any():
            return 0.0
        i, j = pairs[between].T
        return float((heights[i] * heights[j]).mean()) / square - float(fourth.correlations(i, j).mean())

    return [correlation(calmest(share) if share < 1.0 else inner) for share in shares]


def noise_floor(points: Floats, faces_or_edges: Ints, *, normals: Floats, scored: Bools) -> float:
    """The level of noise along the normals that a twentieth of the vertices stays below.

    With h the height at which its surroundings expect a vertex, and g the share of their noise in that, h^2 / (1 + g^2) estimates
    the variance of the noise at the vertex; it is averaged over the vertices around. Details and edges add to it, but not
    everywhere: where the surface is calm noise alone is left.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges, each once.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that count.

    Returns:
        The level in the unit of the points; a fifth to a third below the standard deviation of even noise, since it is that of
        the calmest part. Exact planes do not count unless they are half of the mesh. 0 if no vertex counts.
    """
    which = np.flatnonzero(scored).astype(np.int32)
    if not len(which):
        return 0.0
    heights, gains = predicted_heights(points, one_rings(faces_or_edges, len(points)), normals, which)
    squares = heights**2 / (1.0 + gains**2)
    rough = squares > _EXACT**2
    if rough.mean() > 0.5:
        # Planes that a program has put in, such as the base of a scan, say nothing of the rest.
        which, squares = which[rough], squares[rough]
    clipped, counted = np.zeros(len(points)), np.zeros(len(points), dtype=np.bool_)
    clipped[which], counted[which] = np.minimum(squares, _CLIP * np.median(squares)), True
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    return float(np.sqrt(np.quantile(local_means(clipped, counted, pairs, times=_AVERAGED)[which], tuned.CALMEST)))


def is_designed(points: Floats, faces: Ints) -> bool:
    """Whether the mesh is made of planes of two faces and more, without noise: one vertex in a hundred moved spoils it.

    Args:
        points: (n, 3) coordinates of ordinary size.
        faces: (m, 3) triangles.
    """
    pairs, _ = face_adjacency(faces)
    normals = face_normals(points, faces)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    flat = (np.linalg.norm(np.cross(first, second), axis=1) < _EXACT) & (np.einsum("ij,ij->i", first, second) > 0.0)
    return len(np.unique(pairs[flat])) >= 0.99 * len(faces)


def surface_noise(sample: Sample, noise: NoiseEstimate | None = None) -> float:
    """The standard deviation of the noise along the normals in mean edges, as recipes name it: the smaller of two estimates.

    `estimate_noise` takes fine details for noise everywhere; `noise_floor` sees noise alone where the surface is calm, and 1.3
    times that is even noise. So fur and hair do not count as noise where the face is smooth.

    Args:
        sample: of `sample_of`.
        noise: of `estimate_noise` on it, if the caller has it; that saves time.

    Returns:
        0 of planes as they were designed, and of a mesh without inner vertices.
    """
    if not len(sample.faces) or is_designed(sample.points, sample.faces):
        return 0.0
    level = (noise or estimate_noise(sample.points, sample.faces)).level
    scored = far_from_border(sample.faces, len(sample.points))
    if not np.any(scored):
        return level
    normals = smooth_normals(sample.points, sample.faces)
    return min(level, tuned.EVEN * noise_floor(sample.points, sample.faces, normals=normals, scored=scored))


def _direction(moves: Floats) -> tuple[float, Floats]:
    """How much the largest eigenvalue of the covariance stands out, from 0 to 1, and its direction."""
    values, vectors = np.linalg.eigh(moves.T @ moves)
    total = float(values.sum())
    axis = vectors[:, -1]
    axis = axis * (1.0 if axis[np.argmax(np.abs(axis))] > 0.0 else -1.0)
    share = float(values[-1]) / total if total > 0.0 else 1.0 / 3.0
    return max(0.0, 1.5 * (share - 1.0 / 3.0)), axis
