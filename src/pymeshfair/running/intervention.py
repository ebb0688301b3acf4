"""The intervention map: the result of a run in which every element says whether it was kept, moved or added."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..files.ply_write import write_ply
from ..files.writing import StagedFile
from ..mesh_data import MeshData
from .origins import Origins, removed_elements

#: the fate of an element; the face scalar of the map
KEPT, MOVED, ADDED, REMOVED = 0, 1, 2, 3
#: red, green, blue, opacity: grey, orange, blue, purple; distinct for colour-blind readers and in grey
COLORS: NDArray[np.uint8] = np.array(
    [[200, 200, 200, 255], [222, 143, 5, 255], [1, 90, 178, 255], [120, 40, 110, 255]], dtype=np.uint8
)


def removed_path(path: Path) -> Path:
    """The second file of a map: ``map.removed.ply`` beside ``map.ply``."""
    return path.with_name(f"{path.stem}.removed{path.suffix}")


def states_of(origins: Origins, tolerance: float = 0.0) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """(n,) and (m,) the state of each vertex and of each face: kept, moved or added.

    A vertex is kept if it moved by no more than the tolerance, in mesh units. A face is kept if it has the corners that it had
    and all are kept, moved if one has moved, else added.
    """
    vertices = np.where(origins.vertices < 0, ADDED, np.where(origins.distances > tolerance, MOVED, KEPT)).astype(np.uint8)
    touched = (vertices[origins.result.faces] == MOVED).any(axis=1)
    return vertices, np.where(origins.faces < 0, ADDED, np.where(touched, MOVED, KEPT)).astype(np.uint8)


def stage_map(folder: Path, target: Path, origins: Origins, tolerance: float) -> tuple[StagedFile, ...]:
    """Write both files into a staging folder, the second only if something was removed; `tolerance` is that of `states_of`."""
    staged, gone = folder / "map.ply", folder / "map.removed.ply"
    files = [(staged, target, map_of(origins, tolerance))]
    if (removed := removed_of(origins)) is not None:
        files.append((gone, removed_path(target), removed))
    for path, _, mesh in files:
        with path.open("xb") as file:
            write_ply(mesh, file)
    return tuple(StagedFile(path, place) for path, place, _ in files)


def map_of(origins: Origins, tolerance: float = 0.0) -> MeshData:
    """The result with how far each vertex moved as its scalar, and what became of it as colour and scalar of faces."""
    result = origins.result
    of_vertices, of_faces = states_of(origins, tolerance)
    return MeshData(
        vertices=result.vertices,
        faces=result.faces,
        vertex_attributes={"scalars": origins.distances, "colors": COLORS[of_vertices]},
        face_attributes={"scalars": of_faces.astype(np.float64), "colors": COLORS[of_faces]},
    )


def removed_of(origins: Origins) -> MeshData | None:
    """The faces and lone vertices of the input that the result does not have; None if there are none.

    Their vertex scalar is the number of the vertex in the input.
    """
    before = origins.before
    gone, faces_gone = removed_elements(origins)
    needed = gone.copy()
    needed[before.faces[faces_gone]] = True
    if not needed.any():
        return None
    part = MeshData(vertices=before.vertices, faces=before.faces[faces_gone]).part(needed)
    return part.with_attributes(
        {"scalars": np.flatnonzero(needed).astype(np.float64), "colors": np.tile(COLORS[REMOVED], (len(part.vertices), 1))},
        {"scalars": np.full(len(part.faces), float(REMOVED)), "colors": np.tile(COLORS[REMOVED], (len(part.faces), 1))},
    )
