"""Where the elements of a result come from: every vertex and face carries the number that it had in the input.

The numbers are a custom attribute, which MeshLab and pymeshfair keep when elements are removed and leave at 0 in those that are
added. A filter that makes a new mesh, such as a reconstruction, drops them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats, Ints
from ..files.saving import UNSAVED as ORIGIN
from ..filters.geometry import vector_lengths
from ..filters.inspection import displacement


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


def mesh_of(mesh: Any) -> InputMesh:
    """The vertices and faces of a pymeshlab mesh as they are now."""
    return InputMesh(np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32))


def mark_origins(mesh: Any) -> None:
    """Number the elements of a pymeshlab mesh."""
    n, m = mesh.vertex_number(), mesh.face_number()
    mesh.add_vertex_custom_scalar_attribute(np.arange(1.0, n + 1.0), ORIGIN)
    if m:
        mesh.add_face_custom_scalar_attribute(np.arange(1.0, m + 1.0), ORIGIN)


def find_origins(mesh: Any, before: InputMesh) -> Origins:
    """What became of a marked mesh."""
    vertices, faces = mesh_of(mesh)
    of_vertices = _numbers(mesh.vertex_custom_scalar_attribute_array, len(vertices), len(before.vertices))
    known = of_vertices is not None
    if of_vertices is None:
        of_vertices = np.full(len(vertices), -1)
    of_faces = _numbers(mesh.face_custom_scalar_attribute_array, len(faces), len(before.faces))
    if of_faces is None:
        of_faces = np.full(len(faces), -1)
    _drop_changed(of_faces, of_vertices, faces, before.faces)
    distances = np.zeros(len(vertices))
    old = of_vertices >= 0
    distances[old] = vector_lengths(vertices[old] - before.vertices[of_vertices[old]])
    if not old.all():
        none = np.empty((0, 3), dtype=np.int32)
        added = displacement(vertices[~old], none, before.vertices, before.faces, correspondence="surface")
        distances[~old] = added.distances
    return Origins(of_vertices, of_faces, distances, known)


def _numbers(read: Any, count: int, most: int) -> NDArray[np.int64] | None:
    """The numbers from 0 of `count` elements, -1 where there is none; None if the mesh does not know them."""
    try:
        marks = np.asarray(read(ORIGIN))
    except Exception:  # pymeshlab's, of a type of its own
        return None
    if marks.shape != (count,):
        return None
    valid = (marks >= 1.0) & (marks <= most) & (marks == np.rint(marks))
    return np.where(valid, marks, 0.0).astype(np.int64) - 1


def _drop_changed(of_faces: NDArray[np.int64], of_vertices: NDArray[np.int64], faces: Ints, before: Ints) -> None:
    """Take the number from faces that have other corners than the face of that number had."""
    old = np.flatnonzero(of_faces >= 0)
    now = np.sort(of_vertices[faces[old]], axis=1)
    then = np.sort(before[of_faces[old]], axis=1)
    of_faces[old[(now != then).any(axis=1)]] = -1
