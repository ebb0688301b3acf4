"""Wall thickness of closed surfaces: the largest ball inside that touches a place and another wall."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import face_normals
from ..mesh import Floats, check_mesh
from .distances import face_samples, sample_places
from .surface import Surface

#: A wall is opposite if its normal is turned by this angle at least, in radians: two faces at an edge are not.
LEAST_ANGLE = 2.0 * np.pi / 3.0
_STEPS, _SAME = 30, 1e-9


class Thickness(NamedTuple):
    """The thickness at k places of a surface, in mesh units."""

    values: Floats  # (k,) the diameters of the balls; infinite where no other wall is opposite
    places: Floats  # (k, 3) where they touch
    areas: Floats  # (k,) the area for which each stands

    def below(self, share: float) -> float:
        """The thickness that this share of the area stays below, of the area where there is one; infinite without any."""
        order = np.argsort(self.values)
        reached = np.cumsum(self.areas[order]) >= share * self.areas[np.isfinite(self.values)].sum()
        return float(self.values[order][reached.argmax()])


def wall_thickness(vertices: ArrayLike, faces: ArrayLike, *, count: int = 20_000) -> Thickness:
    """The thickness of the body inside a closed surface, at places spread evenly over it [ma2012].

    A ball of the size of the box touches the place p with normal n, its centre c = p - r n. While the surface comes nearer to c
    than r, at q, it is replaced by the ball that touches both, r = |p - q|^2 / (2 n . (p - q)). The last of these counts whose q
    lies on a wall that is opposite, by `LEAST_ANGLE`: a sheet is as thick as it is near its rim, too.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles that look outwards, at least one.
        count: of places, about; twice as many at most.

    Raises:
        FilterInputError: not a mesh.
    """
    points, triangles = check_mesh(vertices, faces)
    surface = Surface.of(points, triangles)
    samples = face_samples(points, triangles, count)
    step = -(-len(samples.faces) // (2 * count))
    places = sample_places(points, triangles, samples.faces, np.arange(0, len(samples.faces), step))
    of_faces = face_normals(points, triangles)
    normals = of_faces[samples.faces[::step]]
    radii = np.full(len(normals), float(np.linalg.norm(np.ptp(points, axis=0))))
    thickness = np.full(len(normals), np.inf)
    active = np.flatnonzero((normals != 0.0).any(axis=1))
    for _ in range(_STEPS):
        to_place = radii[active, None] * normals[active]
        nearest = surface.nearest(places[active] - to_place, vectors=True)
        inside = nearest.distances < (1.0 - _SAME) * radii[active]
        active, way = active[inside], to_place[inside] + nearest.vectors[inside]
        rise = np.einsum("ij,ij->i", way, normals[active])
        opposite = np.einsum("ij,ij->i", of_faces[nearest.elements[inside]], normals[active]) <= np.cos(LEAST_ANGLE)
        active, way, rise, opposite = (a[rise > 0.0] for a in (active, way, rise, opposite))
        if not len(active):
            break
        radii[active] = np.einsum("ij,ij->i", way, way) / (2.0 * rise)
        thickness[active[opposite]] = 2.0 * radii[active[opposite]]
    return Thickness(thickness, places, step * samples.areas[::step])
