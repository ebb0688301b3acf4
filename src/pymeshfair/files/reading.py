"""Loads the input into a mesh set, and reports what MeshLab removed or split silently."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .announced import Announced
from .errors import InputError
from .formats import extension

#: how many losses are named one by one, and how many letters of each: a file may say a million
_MOST_LOSSES, _LONGEST_LOSS = 50, 200


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Refuse a file that another program writes to while the context lasts.

    Raises:
        InputError: it changed.
    """
    before = path.stat()
    yield
    after = path.stat()
    if (before.st_size, before.st_mtime_ns, before.st_ino) != (after.st_size, after.st_mtime_ns, after.st_ino):
        raise InputError(path, "it changed while it was read")


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
    layers = meshes.mesh_number()
    # Only the current layer is written, so the layers of one file have to become one.
    options = {"load_in_a_single_layer": True} if extension(path) in ("3ds", "glb", "gltf") else {}
    try:
        meshes.load_new_mesh(str(announced.reading or path), **options)
    except MemoryError:
        raise
    except Exception as error:  # pymeshlab raises several unrelated types
        reason = " ".join(str(error).split("Error details:")[-1].split())
        raise InputError(path, f"MeshLab says: {reason}") from error
    warnings = []
    if (loaded := meshes.mesh_number() - layers) > 1:
        warnings.append(f"{path.name} holds {loaded} meshes; one is cleaned and written, the others are not")
    apply_matrix(meshes)
    mesh = meshes.current_mesh()
    if mesh.vertex_number() == 0:
        raise InputError(path, "no vertex could be read from it")
    _compare_places(path, announced, mesh.vertex_matrix())
    warnings += _differences(path.name, announced, mesh.vertex_number(), mesh.face_number())
    warnings += _attach(mesh, path.name, announced)
    if mesh.vertex_number() > 1 and not np.ptp(mesh.vertex_matrix(), axis=0).any():
        warnings.append(f"all {mesh.vertex_number():,} vertices of {path.name} are at one place")
    if announced.not_kept:
        more = len(announced.not_kept) - _MOST_LOSSES
        told = [
            text if len(text) <= _LONGEST_LOSS else f"{text[:_LONGEST_LOSS]}..." for text in announced.not_kept[:_MOST_LOSSES]
        ]
        told += [f"and {more:,} more"] if more > 0 else []
        warnings.append(f"MeshLab does not keep of {path.name}: {'; '.join(told)}")
    return warnings


def _compare_places(path: Path, announced: Announced, vertices: NDArray[np.float64]) -> None:
    """Refuse vertices that are not where the file says."""
    points = announced.points
    if points is None:
        return
    if len(points) != len(vertices):  # those that are not finite are left out
        points = points[np.isfinite(points).all(axis=1)]
    if len(points) != len(vertices):
        raise InputError(
            path, f"it says where {len(points):,} vertices are, but MeshLab read {len(vertices):,}; this is a defect"
        )
    same = np.isclose(vertices, points, rtol=announced.precision, atol=1e-300, equal_nan=True).all(axis=1)
    if not same.all():
        k = int(np.argmin(same))
        raise InputError(path, f"its vertex {k + 1:,} is at {points[k].tolist()}, but MeshLab read {vertices[k].tolist()}")


def _attach(mesh: Any, name: str, announced: Announced) -> list[str]:
    """Give the mesh what MeshLab's reader passes over; what cannot be given, in words."""
    lost = []
    for kind, attributes, n in (
        ("vertex", announced.vertex_attributes, mesh.vertex_number()),
        ("face", announced.face_attributes, mesh.face_number()),
    ):
        for attribute, values in attributes.items():
            if len(values) == n:
                getattr(mesh, f"add_{kind}_custom_scalar_attribute")(values, attribute)
            else:
                lost.append(f"{kind} property {attribute!r}")
    return [f"of {name} were not kept, as MeshLab left some vertices or faces out: {'; '.join(lost)}"] if lost else []


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
        expected = announced.triangles if announced.triangles is not None else max(faces, expected)
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
