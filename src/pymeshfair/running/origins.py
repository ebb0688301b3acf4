"""Origins of elements: the number in the input of every vertex and face of a result, and the intervention map that shows them."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats
from ..files.ply_write import write_ply
from ..files.writing import StagedFile
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
    followed: bool  # whether elements could be followed; else all count as added

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
        if self.followed:
            return np.flatnonzero(self.vertices >= 0), self._moves
        return np.arange(len(self.vertices)), self.distances

    @cached_property
    def _moves(self) -> Floats:
        old = np.flatnonzero(self.vertices >= 0)
        return vector_lengths(self.result.vertices[old] - self.before.vertices[self.vertices[old]])

    @cached_property
    def removed(self) -> tuple[Bools, Bools]:
        """(n,) and (m,) which vertices and which faces of the input the result does not have."""
        gone, faces_gone = np.ones(len(self.before.vertices), dtype=np.bool_), np.ones(len(self.before.faces), dtype=np.bool_)
        gone[self.vertices[self.vertices >= 0]] = False
        faces_gone[self.faces[self.faces >= 0]] = False
        return gone, faces_gone


def find_origins(result: MeshData, before: MeshData) -> Origins:
    """The origins of the elements of a result in the mesh that was read."""
    same_source = result.source is not None and result.source is before.source
    of_vertices = _numbers(result.vertex_ids, before.vertex_ids, len(result.vertices), same_source)
    of_faces = _numbers(result.face_ids, before.face_ids, len(result.faces), same_source)
    same_source &= bool((of_vertices >= 0).any()) or not len(of_vertices)
    return Origins(before, result, of_vertices, of_faces, same_source)


def _numbers(after: NDArray[np.int64] | None, before: NDArray[np.int64] | None, count: int, same: bool) -> NDArray[np.int64]:
    """(count,) the numbers in the mesh that was read, which may have lost elements; `same` if both meshes are of one file."""
    if not same:
        return np.full(count, -1)
    if before is None:
        return np.arange(count) if after is None else after
    assert after is not None
    place = np.full(int(max(before.max(initial=-1), after.max(initial=-1))) + 1, -1)
    place[before] = np.arange(len(before))
    return np.where(after >= 0, place[np.maximum(after, 0)], -1) if len(place) else after


KEPT, MOVED, ADDED, REMOVED = 0, 1, 2, 3  # the fate of an element; the face scalar of the map
#: red, green, blue, opacity: grey, orange, blue, purple; distinct for colour-blind readers and in grey
COLORS: NDArray[np.uint8] = np.array(
    [[200, 200, 200, 255], [222, 143, 5, 255], [1, 90, 178, 255], [120, 40, 110, 255]], dtype=np.uint8
)


def removed_path(path: Path) -> Path:
    """The second file of a map: ``map.removed.ply`` beside ``map.ply``."""
    return path.with_name(f"{path.stem}.removed{path.suffix}")


def stage_map(folder: Path, target: Path, origins: Origins, tolerance: float) -> tuple[StagedFile, ...]:
    """Write both files into a staging folder, the second only if something was removed.

    A vertex is kept if it moved by no more than the tolerance, in mesh units. A face is kept if it has the corners that it had
    and all are kept, moved if one has moved, else added.
    """
    files = [(folder / "map.ply", target, _map(origins, tolerance))]
    if (removed := _removed(origins)) is not None:
        files.append((folder / "map.removed.ply", removed_path(target), removed))
    for path, _, mesh in files:
        with path.open("xb") as file:
            write_ply(mesh, file)
    return tuple(StagedFile(path, place) for path, place, _ in files)


def _map(origins: Origins, tolerance: float) -> MeshData:
    """The result with how far each vertex moved as its scalar, and what became of it as colour and scalar of faces."""
    result = origins.result
    vertices = np.where(origins.vertices < 0, ADDED, np.where(origins.distances > tolerance, MOVED, KEPT))
    touched = (vertices[result.faces] == MOVED).any(axis=1)
    faces = np.where(origins.faces < 0, ADDED, np.where(touched, MOVED, KEPT))
    return MeshData(
        vertices=result.vertices,
        faces=result.faces,
        vertex_attributes={"scalars": origins.distances, "colors": COLORS[vertices]},
        face_attributes={"scalars": faces.astype(np.float64), "colors": COLORS[faces]},
    )


def _removed(origins: Origins) -> MeshData | None:
    """The faces and lone vertices of the input that the result does not have; None if there are none.

    Their vertex scalar is the number of the vertex in the input.
    """
    before, (gone, faces_gone) = origins.before, origins.removed
    needed = gone.copy()
    needed[before.faces[faces_gone]] = True
    if not needed.any():
        return None
    part = MeshData(vertices=before.vertices, faces=before.faces[faces_gone]).part(needed)
    colors, of_faces = (np.tile(COLORS[REMOVED], (len(elements), 1)) for elements in (part.vertices, part.faces))
    return part.with_attributes(
        {"scalars": np.flatnonzero(needed).astype(np.float64), "colors": colors},
        {"scalars": np.full(len(part.faces), float(REMOVED)), "colors": of_faces},
    )
