"""Where the elements of a result come from: of every vertex and face the number that it had in the input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats, Ints
from ..filters.geometry import vector_lengths
from ..filters.inspection import displacement
from ..mesh_data import MeshData


class InputMesh(NamedTuple):
    """The vertices and faces of a mesh, such as that which was read.

    Attributes:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
    """

    vertices: Floats
    faces: Ints


@dataclass(frozen=True, eq=False)
class Origins:
    """What became of a mesh.

    Attributes:
        vertices: (n,) of every vertex of the result its number in the input, -1 for one that was added.
        faces: (m,) of every face the number of the face of the input with the same corners, -1 for one that was added.
        distances: (n,) how far each vertex has moved; of an added one how far it lies from the surface of the input.
        known: whether elements could be followed; else all count as added.
    """

    vertices: NDArray[np.int64]
    faces: NDArray[np.int64]
    distances: Floats
    known: bool

    @property
    def moved(self) -> Bools:
        """(n,) which vertices of the input lie elsewhere now."""
        return (self.vertices >= 0) & (self.distances > 0.0)


@dataclass(frozen=True)
class Displacement:
    """How far vertices have moved, in mesh units: those of the input that are still there, or all where none could be followed.

    Attributes:
        mean: of the distances.
        rms: the root of the mean of their squares.
        largest: of them.
        known: whether elements could be followed; else the distances are those from the input's surface.
    """

    mean: float
    rms: float
    largest: float
    known: bool


def displacement_of(origins: Origins) -> Displacement:
    """The displacement; 0 if no vertex of the input is left."""
    distances = origins.distances[origins.vertices >= 0] if origins.known else origins.distances
    if not len(distances):
        return Displacement(0.0, 0.0, 0.0, origins.known)
    largest = float(distances.max())
    rms = largest and largest * float(np.sqrt(np.mean((distances / largest) ** 2)))  # no square of a distance overflows
    return Displacement(float(distances.mean()), rms, largest, origins.known)


def find_origins(result: MeshData, before: MeshData) -> Origins:
    """What became of the mesh that was read."""
    known = result.source is not None and result.source is before.source
    of_vertices = _numbers(result.vertex_ids, before.vertex_ids, len(result.vertices), known)
    of_faces = _numbers(result.face_ids, before.face_ids, len(result.faces), known)
    known &= bool((of_vertices >= 0).any()) or not len(of_vertices)
    distances = np.zeros(len(result.vertices))
    old = of_vertices >= 0
    distances[old] = vector_lengths(result.vertices[old] - before.vertices[of_vertices[old]])
    if not old.all():
        none = np.empty((0, 3), dtype=np.int32)
        added = displacement(result.vertices[~old], none, before.vertices, before.faces, correspondence="surface")
        distances[~old] = added.distances
    return Origins(of_vertices, of_faces, distances, known)


def _numbers(after: NDArray[np.int64] | None, before: NDArray[np.int64] | None, count: int, known: bool) -> NDArray[np.int64]:
    """(count,) the numbers in the mesh that was read, which may have lost elements of its file already."""
    if not known:
        return np.full(count, -1)
    if before is None:
        return np.arange(count) if after is None else after
    assert after is not None
    place = np.full(int(max(before.max(initial=-1), after.max(initial=-1))) + 1, -1)
    place[before] = np.arange(len(before))
    return np.where(after >= 0, place[np.maximum(after, 0)], -1) if len(place) else after
