"""Origins of elements: the number in the input of every vertex and face of a result."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats
from ..filters.geometry import vector_lengths
from ..filters.inspection import Surface
from ..mesh_data import MeshData


@dataclass(frozen=True, eq=False)
class Origins:
    """The origins of the elements of a result."""

    before: MeshData  # the mesh that was read
    result: MeshData  # the mesh after the steps
    vertices: NDArray[np.int64]  # (n,) of every vertex of the result its number in the input, -1 for one that was added
    #: (m,) of every face the number of the face of the input with the same corners, -1 for one that was added
    faces: NDArray[np.int64]
    known: bool  # whether elements could be followed; else all count as added

    @cached_property
    def distances(self) -> Floats:
        """(n,) the displacement of each vertex; for an added one its distance from the surface of the input."""
        distances = np.zeros(len(self.vertices))
        old = self.vertices >= 0
        distances[old] = self._moves
        if not old.all():
            surface = Surface.of(self.before.vertices, self.before.faces)
            distances[~old] = surface.nearest(self.result.vertices[~old]).distances
        return distances

    @cached_property
    def displaced(self) -> tuple[NDArray[np.int64], Floats]:
        """The vertices whose displacement counts, and how far each lies from where it was.

        Those that are the same in both meshes; where nothing could be followed all, with their distances from the input.
        """
        if self.known:
            return np.flatnonzero(self.vertices >= 0), self._moves
        return np.arange(len(self.vertices)), self.distances

    @cached_property
    def _moves(self) -> Floats:
        old = np.flatnonzero(self.vertices >= 0)
        return vector_lengths(self.result.vertices[old] - self.before.vertices[self.vertices[old]])


def find_origins(result: MeshData, before: MeshData) -> Origins:
    """The origins of the elements of a result in the mesh that was read."""
    same_source = result.source is not None and result.source is before.source
    of_vertices = _numbers(result.vertex_ids, before.vertex_ids, len(result.vertices), same_source)
    of_faces = _numbers(result.face_ids, before.face_ids, len(result.faces), same_source)
    same_source &= bool((of_vertices >= 0).any()) or not len(of_vertices)
    return Origins(before, result, of_vertices, of_faces, same_source)


def removed_elements(origins: Origins) -> tuple[Bools, Bools]:
    """(n,) and (m,) which vertices and which faces of the input the result does not have."""
    gone = np.ones(len(origins.before.vertices), dtype=np.bool_)
    gone[origins.vertices[origins.vertices >= 0]] = False
    faces_gone = np.ones(len(origins.before.faces), dtype=np.bool_)
    faces_gone[origins.faces[origins.faces >= 0]] = False
    return gone, faces_gone


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
