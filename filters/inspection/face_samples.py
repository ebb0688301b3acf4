"""Samples of a surface: places on its faces, by area, at least one on each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import AREA, measure_faces
from ..mesh import Floats, Ints, Longs

#: The steps of the sequence whose points fill a square most evenly of all such sequences: 1 / g and 1 / g^2, g^3 = g + 1
#: [roberts2018].
_STEPS = (0.7548776662466927, 0.5698402909980532)


class FaceSamples(NamedTuple):
    """k places on a surface.

    Attributes:
        places: (k, 3) their coordinates.
        faces: (k,) the face of each, ascending.
        areas: (k,) the area for which each stands; together that of the surface.
    """

    places: Floats
    faces: Longs
    areas: Floats


def face_samples(vertices: Floats, faces: Ints, count: int) -> FaceSamples:
    """About `count` samples, more where there are more faces; the same ones at every call.

    Each face has as many as its share of the area asks for, at least one, at places that are spread evenly and belong to no
    pattern of the mesh. So a mean that is weighted with the areas misses that over the surface by no more than that of as many
    random samples.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        count: how many are asked for.
    """
    measured = measure_faces(vertices, faces)[:, AREA]
    shares = measured * (count / total) if (total := measured.sum()) > 0.0 else measured
    per_face = np.maximum(np.rint(shares), 1.0).astype(np.int64)
    of = np.repeat(np.arange(len(faces)), per_face)
    k = np.arange(1, len(of) + 1)
    s, t = ((step * k) % 1.0 for step in _STEPS)
    over = s + t > 1.0
    s, t = np.where(over, 1.0 - s, s)[:, None], np.where(over, 1.0 - t, t)[:, None]
    a = vertices[faces[of, 0]]
    places = a + s * (vertices[faces[of, 1]] - a)
    places += t * (vertices[faces[of, 2]] - a)
    return FaceSamples(places, of, (measured / per_face)[of])
