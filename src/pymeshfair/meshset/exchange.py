"""Meshes of trimesh, Open3D and meshio, taken and given back; none of these packages is needed unless its mesh is asked for."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pymeshlab

from ..declaration import Floats, Ints
from ..meshlab.errors import ForeignMeshError

#: cells of meshio: each row of corners becomes these triangles
_TRIANGLES = {"triangle": ((0, 1, 2),), "quad": ((0, 1, 2), (0, 2, 3))}


def as_meshlab(mesh: Any) -> Any:
    """A mesh of another package as a `pymeshlab.Mesh`; one of pymeshlab's as it is.

    Taken are vertices, triangles, edges of meshio, colours, the normals of Open3D's clouds and the texture coordinates of
    trimesh's vertices. The packages are known by what their meshes look like: none is imported.

    Raises:
        ForeignMeshError: it is no mesh of these packages, or has cells that are no triangles, quads, lines or vertices.
    """
    if isinstance(mesh, pymeshlab.Mesh):
        return mesh
    if hasattr(mesh, "to_legacy"):  # Open3D's tensors
        mesh = mesh.to_legacy()
    if hasattr(mesh, "points") and hasattr(mesh, "cells"):
        return _from_meshio(mesh)
    if hasattr(mesh, "vertices") and (hasattr(mesh, "faces") or hasattr(mesh, "colors")):
        return _from_trimesh(mesh)
    if hasattr(mesh, "triangles") or (hasattr(mesh, "points") and hasattr(mesh, "normals")):
        return _from_open3d(mesh)
    kind = f"{type(mesh).__module__}.{type(mesh).__qualname__}"
    raise ForeignMeshError(f"add_mesh takes a pymeshlab.Mesh, or a mesh or cloud of trimesh, Open3D or meshio, got a {kind}")


def _from_trimesh(mesh: Any) -> Any:
    vertices = _coordinates(mesh.vertices)
    if not hasattr(mesh, "faces"):  # a PointCloud
        return pymeshlab.Mesh(vertices, **_colored("v_color_matrix", getattr(mesh, "colors", ()), len(vertices)))
    visual: Any = getattr(mesh, "visual", None)
    faces, kind = _indices(mesh.faces), getattr(visual, "kind", None)
    more: dict[str, Any] = {}
    if kind == "vertex":
        more = _colored("v_color_matrix", visual.vertex_colors, len(vertices))
    elif kind == "face":
        more = _colored("f_color_matrix", visual.face_colors, len(faces))
    elif kind == "texture" and getattr(visual, "uv", None) is not None:
        more = {"v_tex_coords_matrix": _coordinates(visual.uv)}
    return pymeshlab.Mesh(vertices, faces, **more)


def _from_open3d(mesh: Any) -> Any:
    cloud = not hasattr(mesh, "triangles")
    vertices = _coordinates(mesh.points if cloud else mesh.vertices)
    more = _colored("v_color_matrix", mesh.colors if cloud else mesh.vertex_colors, len(vertices))
    if cloud and len(mesh.normals) == len(vertices) > 0:  # those of meshes follow from their faces
        more["v_normals_matrix"] = _coordinates(mesh.normals)
    return pymeshlab.Mesh(vertices, **more) if cloud else pymeshlab.Mesh(vertices, _indices(mesh.triangles), **more)


def _from_meshio(mesh: Any) -> Any:
    points = _coordinates(mesh.points)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    faces, edges = [np.zeros((0, 3), dtype=np.int32)], [np.zeros((0, 2), dtype=np.int32)]
    for block in mesh.cells:
        kind, cells = (block.type, block.data) if hasattr(block, "type") else block
        if kind in _TRIANGLES:
            faces += [_indices(np.asarray(cells)[:, corners]) for corners in _TRIANGLES[kind]]
        elif kind == "line":
            edges.append(_indices(cells))
        elif kind != "vertex":
            raise ForeignMeshError(
                f"the meshio mesh has cells of type {kind!r}; taken are triangles, quads (as two of them) and lines"
            )
    return pymeshlab.Mesh(points, np.concatenate(faces), edge_matrix=np.concatenate(edges))


def to_trimesh(mesh: Any) -> Any:
    """A `trimesh.Trimesh`, or a `trimesh.PointCloud` of a mesh without faces, with the colours of the vertices if it has any."""
    trimesh = importlib.import_module("trimesh")
    colors = (255.0 * mesh.vertex_color_matrix()).round().astype(np.uint8) if mesh.has_vertex_color() else None
    if mesh.face_number() == 0:
        return trimesh.PointCloud(mesh.vertex_matrix(), colors=colors)
    return trimesh.Trimesh(mesh.vertex_matrix(), mesh.face_matrix(), vertex_colors=colors, process=False)


def to_open3d(mesh: Any) -> Any:
    """An `open3d.geometry.TriangleMesh`, or a `PointCloud` of a mesh without faces, with vertex normals and colours."""
    o3d = importlib.import_module("open3d")
    vectors = o3d.utility.Vector3dVector
    cloud = mesh.face_number() == 0
    made = o3d.geometry.PointCloud() if cloud else o3d.geometry.TriangleMesh()
    setattr(made, "points" if cloud else "vertices", vectors(mesh.vertex_matrix()))
    setattr(made, "normals" if cloud else "vertex_normals", vectors(_unit_normals(mesh)))
    if mesh.has_vertex_color():
        setattr(made, "colors" if cloud else "vertex_colors", vectors(mesh.vertex_color_matrix()[:, :3]))
    if not cloud:
        made.triangles = o3d.utility.Vector3iVector(mesh.face_matrix())
    return made


def to_meshio(mesh: Any) -> Any:
    """A `meshio.Mesh` with triangles and lines, or vertices where there are neither, and the vertex normals as point data."""
    meshio = importlib.import_module("meshio")
    points = mesh.vertex_matrix()
    cells = [(kind, found) for kind, found in (("triangle", mesh.face_matrix()), ("line", mesh.edge_matrix())) if len(found)]
    cells = cells or [("vertex", np.arange(len(points)).reshape(-1, 1))]
    return meshio.Mesh(points, cells, point_data={"normals": _unit_normals(mesh)})


def _unit_normals(mesh: Any) -> Floats:
    """(n, 3) the vertex normals, of length 1 or 0; MeshLab's are as long as their faces are large."""
    normals = _coordinates(mesh.vertex_normal_matrix())
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0.0, lengths, 1.0))


def _coordinates(values: Any) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)


def _indices(values: Any) -> Ints:
    return np.ascontiguousarray(values, dtype=np.int32)


def _colored(name: str, colors: Any, count: int) -> dict[str, Any]:
    """The argument of `pymeshlab.Mesh` for these colours, with opacity and from 0 to 1; none if there are not so many."""
    found = np.asarray(colors)
    if found.ndim != 2 or len(found) != count or count == 0:
        return {}
    scaled = found / 255.0 if found.dtype.kind in "ui" else found.astype(np.float64)
    opaque = scaled if scaled.shape[1] == 4 else np.column_stack([scaled[:, :3], np.ones(count)])
    return {name: np.ascontiguousarray(opaque)}
