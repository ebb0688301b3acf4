"""Loads the input into a mesh set, and reports what MeshLab removed or split silently."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from .errors import InputError
from .formats import extension
from .inputs import Announced
from .obj_polylines import write_single_edges


def load_mesh(meshes: Any, path: Path, announced: Announced) -> list[str]:
    """Load a file as the current mesh.

    Args:
        meshes: the mesh set.
        path: the file.
        announced: what it declares.

    Returns:
        What was left out, split or will not be kept, in words.

    Raises:
        InputError: MeshLab refuses it, or finds no vertex in it.
    """
    before, layers = path.stat(), meshes.mesh_number()
    # Only the current layer is written, so the layers of one file have to become one.
    options = {"load_in_a_single_layer": True} if extension(path) in ("3ds", "glb", "gltf") else {}
    try:
        if announced.polylines.misread and not announced.side_files:
            _load_polylines(meshes, path, announced)
        else:
            meshes.load_new_mesh(str(path), **options)
    except MemoryError:
        raise
    except Exception as error:  # pymeshlab raises several unrelated types
        reason = " ".join(str(error).split("Error details:")[-1].split())
        raise InputError(path, f"MeshLab says: {reason}") from error
    after = path.stat()
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
        raise InputError(path, "it changed while it was read")
    warnings = []
    if (loaded := meshes.mesh_number() - layers) > 1:
        warnings.append(f"{path.name} holds {loaded} meshes; one is cleaned and written, the others are not")
    apply_matrix(meshes)
    mesh = meshes.current_mesh()
    if mesh.vertex_number() == 0:
        raise InputError(path, "no vertex could be read from it")
    warnings += _differences(path.name, announced, mesh.vertex_number(), mesh.face_number())
    if announced.not_kept:
        warnings.append(f"MeshLab does not keep of {path.name}: {'; '.join(announced.not_kept)}")
    return warnings


def _load_polylines(meshes: Any, path: Path, announced: Announced) -> None:
    """Load an OBJ file without materials whose polylines MeshLab would misread, with every edge in a line of its own."""
    with tempfile.TemporaryDirectory(prefix="pymeshfair-") as folder:
        copy = Path(folder) / path.name
        write_single_edges(path, copy, announced.vertices or 0)
        meshes.load_new_mesh(str(copy))


def apply_matrix(meshes: Any) -> bool:
    """Apply the layer's matrix to its coordinates, as no file that a run writes holds one; whether there was one."""
    if np.array_equal(meshes.current_mesh().transform_matrix(), np.eye(4)):
        return False
    meshes.apply_filter("apply_matrix_freeze")
    return True


def _differences(name: str, announced: Announced, vertices: int, faces: int) -> list[str]:
    """What MeshLab left out or split: vertices that are not finite, degenerate faces, polygons."""
    expected = announced.faces if announced.faces is not None else faces
    if faces != expected:
        counted = announced.count_triangles()
        expected = counted if counted is not None else max(faces, expected)
    lost_vertices = max((announced.vertices or 0) - vertices, 0)
    lost_faces = max(expected - faces, 0)
    found = []
    if lost_vertices or lost_faces:
        found.append(
            f"of {name} were left out: {_counted(lost_vertices, 'vertex', 'vertices')} with a coordinate that is not finite, and "
            f"{_counted(lost_faces, 'face', 'faces')} with such a vertex or with one twice"
        )
    if announced.faces is not None and expected > announced.faces:
        found.append(f"polygons of {name} were split into triangles: {announced.faces:,} faces became {faces:,}")
    return found


def _counted(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"
