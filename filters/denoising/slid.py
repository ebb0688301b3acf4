"""Outliers that are off along the surface too: their heights tell only half of it, and on a plane they fold faces over."""

import numpy as np

from ..evidence import means_of_others
from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings, referenced_vertices

# Outliers have slid if half of them are so many times as far from the mean of their neighbours along the surface as the others,
# and by more than this part of an edge: less folds nothing over.
_SLID, _LEAST = 2.0, 0.25
# One vertex is off along the surface by more than that, and than three deviations: the median length of normally distributed
# vectors of a plane over their deviation along an axis is 1.1774.
_FAR, _MEDIAN_IN_PLANE = 3.0, 1.1774
# Faces are folded over if the cosine of their angle to the surface is below this; at narrow edges it may be about 0.
_FOLDED = -0.5


def have_slid(vertices: Floats, faces: Ints, normals: Floats, outlying: Bools) -> bool:
    """Whether outliers are off along the surface as well as along the normals.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        outlying: (n,) the outliers.
    """
    if not outlying.any():
        return False
    _, lengths, usual = _ways_back(vertices, faces, normals, outlying)
    return bool(np.median(lengths[outlying]) > max(_SLID * usual, _LEAST * mean_edge_length(vertices, faces)))


def evened(vertices: Floats, faces: Ints, normals: Floats, outlying: Bools) -> Floats:
    """(n, 3) the vertices, outliers off along the surface put back along it, to the mean of those around.

    The arguments are those of `have_slid`.
    """
    ways, lengths, usual = _ways_back(vertices, faces, normals, outlying)
    off = outlying & _off(lengths, usual, vertices, faces)
    return np.where(off[:, None], vertices + ways, vertices)


def folding(vertices: Floats, faces: Ints, normals: Floats, outlying: Bools, movable: Bools | None = None) -> Bools:
    """(n,) the vertices that are off along the surface so far that they fold faces over.

    The arguments are those of `have_slid`; of vertices that are not movable, None for none, there are none.
    """
    _, lengths, usual = _ways_back(vertices, faces, normals, outlying)
    corners, means = vertices[faces], normals[faces].sum(axis=1)
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(sides, axis=1) * np.linalg.norm(means, axis=1)
    folded = np.zeros(len(vertices), dtype=np.bool_)
    folded[faces[np.einsum("ij,ij->i", sides, means) < _FOLDED * sizes]] = True
    folded &= _off(lengths, usual, vertices, faces)
    return np.asarray(folded if movable is None else folded & movable)


def _ways_back(vertices: Floats, faces: Ints, normals: Floats, outlying: Bools) -> tuple[Floats, Floats, float]:
    """The ways along the surface to the means of those around that are no outliers, (n, 3).

    Returns:
        The ways, (n,) their lengths, and the median length of those that are no outliers.
    """
    every = np.arange(len(vertices), dtype=np.int32)
    ways = means_of_others(vertices, one_rings(faces, len(vertices)), every, outlying) - vertices
    ways -= np.einsum("ij,ij->i", ways, normals)[:, None] * normals
    lengths = np.linalg.norm(ways, axis=1)
    others = referenced_vertices(faces, len(vertices)) & ~outlying
    return ways, lengths, float(np.median(lengths[others])) if others.any() else 0.0


def _off(lengths: Floats, usual: float, vertices: Floats, faces: Ints) -> Bools:
    return np.asarray(lengths > max(_FAR * usual / _MEDIAN_IN_PLANE, _LEAST * mean_edge_length(vertices, faces)))
