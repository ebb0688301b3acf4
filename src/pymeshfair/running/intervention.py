"""The intervention map: the result of a run in which every element says whether it was kept, moved or added."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..declaration import Floats, Ints
from ..files.ply_write import write_ply
from .origins import InputMesh, Origins

#: what became of an element; the face scalar of the map
KEPT, MOVED, ADDED, REMOVED = 0, 1, 2, 3
#: red, green, blue, opacity: grey, orange, blue, purple; apart from each other for everybody, and in grey
COLORS: NDArray[np.uint8] = np.array(
    [[200, 200, 200, 255], [222, 143, 5, 255], [1, 90, 178, 255], [120, 40, 110, 255]], dtype=np.uint8
)


def removed_path(path: Path) -> Path:
    """The second file of a map: ``map.removed.ply`` beside ``map.ply``."""
    return path.with_name(f"{path.stem}.removed{path.suffix}")


def states_of(origins: Origins, faces: Ints) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """(n,) and (m,) what became of the vertices and of the faces.

    A face is kept if it has the corners that it had and none has moved, moved if one has, else added.
    """
    vertices = np.where(origins.vertices < 0, ADDED, np.where(origins.moved, MOVED, KEPT)).astype(np.uint8)
    touched = (vertices[faces] == MOVED).any(axis=1)
    return vertices, np.where(origins.faces < 0, ADDED, np.where(touched, MOVED, KEPT)).astype(np.uint8)


def stage_map(
    folder: Path, target: Path, vertices: Floats, faces: Ints, before: InputMesh, origins: Origins
) -> list[dict[str, str]]:
    """Write both files into a staging folder; where each is and where it belongs, the second only if something was removed."""
    staged, gone = folder / "map.ply", folder / "map.removed.ply"
    write_map(staged, vertices, faces, origins)
    files = [(staged, target)]
    if write_removed(gone, before, origins):
        files.append((gone, removed_path(target)))
    return [{"staged": str(file), "target": str(place)} for file, place in files]


def write_map(path: Path, vertices: Floats, faces: Ints, origins: Origins) -> None:
    """Write the result with how far each vertex moved as its scalar, and what became of it as colour and scalar of faces."""
    of_vertices, of_faces = states_of(origins, faces)
    write_ply(
        path,
        vertices,
        faces,
        vertex_scalars=origins.distances,
        vertex_colors=COLORS[of_vertices],
        face_scalars=of_faces.astype(np.float64),
        face_colors=COLORS[of_faces],
    )


def write_removed(path: Path, before: InputMesh, origins: Origins) -> bool:
    """Write the faces and lone vertices of the input that the result does not have; whether there are any.

    Their vertex scalar is the number of the vertex in the input.
    """
    faces_gone = np.ones(len(before.faces), dtype=np.bool_)
    faces_gone[origins.faces[origins.faces >= 0]] = False
    gone = np.ones(len(before.vertices), dtype=np.bool_)
    gone[origins.vertices[origins.vertices >= 0]] = False
    needed = gone.copy()
    needed[before.faces[faces_gone]] = True
    if not needed.any():
        return False
    number = np.cumsum(needed) - 1
    faces = number[before.faces[faces_gone]].astype(np.int32)
    write_ply(
        path,
        before.vertices[needed],
        faces,
        vertex_scalars=np.flatnonzero(needed).astype(np.float64),
        vertex_colors=np.repeat(COLORS[[REMOVED]], int(needed.sum()), axis=0),
        face_scalars=np.full(len(faces), float(REMOVED)),
        face_colors=np.repeat(COLORS[[REMOVED]], len(faces), axis=0),
    )
    return True
