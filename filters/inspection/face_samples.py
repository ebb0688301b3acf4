"""Samples of a surface: places on its faces, by area, at least one on each."""

from typing import NamedTuple

import numpy as np

from ..compilation import compiled
from ..execution import over_range
from ..geometry import face_areas
from ..mesh import Floats, Ints, Longs

#: The steps of the sequence whose points fill a square most evenly of all such sequences: 1 / g and 1 / g^2, g^3 = g + 1
#: [roberts2018].
_STEPS = (0.7548776662466927, 0.5698402909980532)


class FaceSamples(NamedTuple):
    """k samples of a surface; for their coordinates see `sample_places`."""

    faces: Ints  # (k,) the face of each, ascending; in a cloud the vertex
    areas: Floats  # (k,) the area for which each stands; together that of the surface


def face_samples(vertices: Floats, faces: Ints, count: int) -> FaceSamples:
    """About `count` samples, more where there are more faces; the same ones at every call.

    Each face has as many as its share of the area asks for, at least one, at places that are spread evenly and belong to no
    pattern of the mesh. So a mean that is weighted with the areas misses that over the surface by no more than that of as many
    random samples.

    Args:
        vertices: (n, 3) coordinates, best near the origin.
        faces: (m, 3) triangles; none of a cloud, whose vertices are the samples.
        count: how many, about.
    """
    if not len(faces):
        return FaceSamples(np.arange(len(vertices), dtype=np.int32), np.ones(len(vertices)))
    measured = face_areas(vertices, faces)
    shares = measured * (count / total) if (total := measured.sum()) > 0.0 else measured
    per_face = np.maximum(np.rint(shares), 1.0).astype(np.int64)
    of = np.repeat(np.arange(len(faces), dtype=np.int32), per_face)
    return FaceSamples(of, (measured / per_face)[of])


def sample_places(vertices: Floats, faces: Ints, samples: Ints, rows: Longs) -> Floats:
    """(r, 3) the places of samples.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, or none.
        samples: (k,) the face of every sample.
        rows: (r,) the samples whose places are returned.
    """
    if not len(faces):
        return vertices[samples[rows]]
    places = np.empty((len(rows), 3))
    over_range(_place, len(rows), vertices, faces, samples, rows, places)
    return places


@compiled(nogil=True)
def _place(vertices: Floats, faces: Ints, samples: Ints, rows: Longs, places: Floats, first: int, last: int) -> None:
    """The points of the sequence as weights of corners, those beyond the diagonal of the square mirrored at its middle."""
    for r in range(first, last):
        s, t = (_STEPS[0] * (rows[r] + 1)) % 1.0, (_STEPS[1] * (rows[r] + 1)) % 1.0
        if s + t > 1.0:
            s, t = 1.0 - s, 1.0 - t
        f = samples[rows[r]]
        for d in range(3):
            a = vertices[faces[f, 0], d]
            to_second, to_third = vertices[faces[f, 1], d] - a, vertices[faces[f, 2], d] - a
            places[r, d] = a + s * to_second + t * to_third
