"""Outliers that are off along the surface too: heights tell only half of it, and on a plane they fold faces over."""

from typing import NamedTuple

import numpy as np

from ..evidence import facing, means_of_others
from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import one_rings, referenced_vertices

# Outliers have slid far if half of them are so many times as far from the mean of their neighbours along the surface as the
# others, and by more than this part of an edge: less folds nothing over.
_SLID, _LEAST = 2.0, 0.25
# Less of the ways than this is by chance.
_CHANCE = 0.2
# One vertex is off along the surface by more than that, and than three deviations: the median length of normally distributed
# vectors of a plane over their deviation along an axis is 1.1774.
_FAR, _MEDIAN_IN_PLANE = 3.0, 1.1774
# Faces are folded over if the cosine of their angle to the surface is below this; at narrow edges it may be about 0.
_FOLDED = -0.5


class TangentialShift(NamedTuple):
    """The ways along the surface to the means of those around that are no outliers; of a border, to those next to it there.

    Attributes:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        outlying: (n,) the outliers.
        others: (n,) the vertices of faces that are none.
        ways: (n, 3) from each vertex.
        lengths: (n,) of these in mean edges.
        usual: the median length of the others.
    """

    vertices: Floats
    faces: Ints
    normals: Floats
    outlying: Bools
    others: Bools
    ways: Floats
    lengths: Floats
    usual: float

    @staticmethod
    def of(vertices: Floats, faces: Ints, normals: Floats, outlying: Bools) -> "TangentialShift":
        """Measured once, for all that is asked of them."""
        rings = one_rings(faces, len(vertices))
        along_border = rings.along_border()
        on_border = np.flatnonzero(np.diff(along_border.offsets)).astype(np.int32)
        means = means_of_others(vertices, rings, np.arange(len(vertices), dtype=np.int32), outlying)
        means[on_border] = means_of_others(vertices, along_border, on_border, outlying)
        ways = means - vertices
        ways -= np.einsum("ij,ij->i", ways, normals)[:, None] * normals
        edge = mean_edge_length(vertices, faces)
        lengths = np.linalg.norm(ways / edge, axis=1) if edge > 0.0 else np.zeros(len(vertices))
        others = referenced_vertices(faces, len(vertices)) & ~outlying
        usual = float(np.median(lengths[others])) if others.any() else 0.0
        return TangentialShift(vertices, faces, normals, outlying, others, ways, lengths, usual)

    @property
    def outliers_fold(self) -> bool:
        """Whether the outliers are off along the surface by so much that they fold faces over."""
        if not self.outlying.any():
            return False
        return bool(np.median(self.lengths[self.outlying]) > max(_SLID * self.usual, _LEAST))

    @property
    def far(self) -> Bools:
        """(n,) the vertices that are off along the surface."""
        return np.asarray(self.lengths > max(_FAR * self.usual / _MEDIAN_IN_PLANE, _LEAST))

    @property
    def share(self) -> float:
        """How much of the ways of outliers is due to sliding; 0 if it may be chance.

        Vertices that did not slide are off the mean of their neighbours too, by t in the root mean square. If outliers are off by
        s, (s^2 - t^2) / s^2 of their ways is expected to be slid, which has the least expected square of all shares [james1961].
        """
        if not self.others.any() or not self.outlying.any():
            return 0.0
        of_others, of_outliers = (float(np.mean(self.lengths[which] ** 2)) for which in (self.others, self.outlying))
        return 1.0 - of_others / of_outliers if of_others < (1.0 - _CHANCE) * of_outliers else 0.0

    def evened(self) -> Floats:
        """(n, 3) the vertices, outliers put back along the surface by their `share` of the ways."""
        return np.where(self.outlying[:, None], self.vertices + self.share * self.ways, self.vertices)

    def folding(self, movable: Bools | None = None) -> Bools:
        """(n,) the vertices that are off along the surface so far that they fold faces over; of those that may move."""
        folded = np.zeros(len(self.vertices), dtype=np.bool_)
        folded[self.faces[facing(self.vertices, self.faces, self.normals) < _FOLDED]] = True
        folded &= self.far
        return np.asarray(folded if movable is None else folded & movable)
