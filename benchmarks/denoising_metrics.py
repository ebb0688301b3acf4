"""How near a denoised mesh is to the true one, whose faces and vertices have the same numbers.

The measures of the literature (its MAD, AAD, E_a and MSAE are the same) and three that it lacks: angles weighted by area, since
small true faces rule an unweighted mean, and two distances, since a surface that has moved as a whole has perfect normals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import igl
import numpy as np
from numpy.typing import NDArray

from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import referenced_vertices

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]

#: what a face that the denoiser has squashed to nothing is off: it has no normal, and must not count as a right one
WITHOUT_NORMAL = 90.0


class NoisyPair(NamedTuple):
    """A noisy mesh and its truth."""

    name: str
    noisy: Floats
    truth: Floats
    faces: Ints


@dataclass(frozen=True)
class Errors:
    """The measures of one denoised mesh.

    Attributes:
        mad: mean over the faces of the angle between the face's normal and the true one, degrees.
        mad_by_area: the same mean weighted by the areas of the true faces, degrees.
        rms: root of the mean square of these angles, degrees.
        flips: the number of faces that are more than 90 degrees off.
        distance: mean distance of the vertices to the true surface, in mean true edges.
        displacement: mean distance of the vertices to their true places, in mean true edges; sees tangential drift too.
    """

    mad: float
    mad_by_area: float
    rms: float
    flips: int
    distance: float
    displacement: float


def errors(vertices: Floats, true_vertices: Floats, faces: Ints) -> Errors:
    """Compares a mesh with the true one of the same faces; vertices that no face uses do not count."""
    angles, areas = angles_to_truth(vertices, true_vertices, faces)
    used = referenced_vertices(faces, len(vertices))
    edge = mean_edge_length(true_vertices, faces)
    squared, _, _ = igl.point_mesh_squared_distance(vertices[used], true_vertices, faces.astype(np.int64))
    return Errors(
        mad=float(angles.mean()),
        mad_by_area=float(angles @ areas / areas.sum()),
        rms=float(np.sqrt(np.mean(angles**2))),
        flips=int(np.count_nonzero(angles > 90.0)),
        distance=float(np.sqrt(squared).mean()) / edge,
        displacement=float(np.linalg.norm(vertices[used] - true_vertices[used], axis=1).mean()) / edge,
    )


def measured(vertices: Floats, truth: Floats, faces: Ints) -> tuple[float, float]:
    """The mean angle in degrees, and the mean displacement in mean true edges."""
    moved = np.linalg.norm(vertices - truth, axis=1).mean() / mean_edge_length(truth, faces)
    return float(angles_to_truth(vertices, truth, faces)[0].mean()), float(moved)


def angles_to_truth(vertices: Floats, true_vertices: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """The angle atan2(|n x m|, n . m) of every face to its true one in degrees, exact for small ones too, and the true areas.

    Faces whose true area is 0 are left out. Normals need no normalisation here, so nothing is divided by a small area.
    """
    found, true = area_vectors(vertices, faces), area_vectors(true_vertices, faces)
    areas = np.linalg.norm(true, axis=1)
    found, true, areas = found[areas > 0], true[areas > 0], areas[areas > 0]
    sine, cosine = np.linalg.norm(np.cross(found, true), axis=1), np.einsum("ij,ij->i", found, true)
    angles = np.degrees(np.arctan2(sine, cosine))
    angles[~found.any(axis=1)] = WITHOUT_NORMAL
    return angles, areas


def area_vectors(vertices: Floats, faces: Ints) -> Floats:
    """Normals of the faces, (m, 3), as long as the faces are large."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2.0


def used_alone(faces: Ints, *points: Floats) -> tuple[Any, ...]:
    """Points, one set or more, without those that no face uses; and the faces, which name what is left, last."""
    kept, numbers = np.unique(faces, return_inverse=True)
    return *(each[kept] for each in points), np.ascontiguousarray(numbers.reshape(-1, 3), dtype=np.int32)
