"""Arrays as meshes of trimesh, Open3D, meshio and PyVista; none of these packages is needed unless its mesh is asked for."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from .exchange import Arrays, bytes_of


def to_trimesh(arrays: Arrays) -> Any:
    """A `trimesh.Trimesh`; without faces a `trimesh.path.Path3D` if there are edges, else a `trimesh.PointCloud`."""
    trimesh = importlib.import_module("trimesh")
    colors = None if arrays.colors is None else bytes_of(arrays.colors)
    if len(arrays.faces):
        looks: dict[str, Any] = {"vertex_colors": colors}
        if colors is None and arrays.uv is not None:
            looks = {"visual": trimesh.visual.TextureVisuals(uv=arrays.uv)}
        elif colors is None and arrays.face_colors is not None:
            looks = {"face_colors": bytes_of(arrays.face_colors)}
        unused = {"texture_coordinates": arrays.uv, "colours_of_faces": arrays.face_colors}
        if colors is not None:
            arrays.lose("trimesh with colours of vertices", **unused)
        arrays.lose("trimesh", edges=arrays.edges)
        made = trimesh.Trimesh(arrays.vertices, arrays.faces, process=False, **looks)
        made.vertex_attributes.update(arrays.of_vertices)
        made.face_attributes.update(arrays.of_faces)
        return made
    arrays.lose("trimesh without faces", values_of_vertices=arrays.of_vertices)
    if not len(arrays.edges):
        return trimesh.PointCloud(arrays.vertices, colors=colors)
    arrays.lose("trimesh with edges alone", colours=colors)
    path = importlib.import_module("trimesh.path")
    lines = [path.entities.Line(edge) for edge in arrays.edges]
    return path.Path3D(entities=lines, vertices=arrays.vertices, process=False)


def to_open3d(arrays: Arrays) -> Any:
    """An `open3d.geometry.TriangleMesh`, or a `PointCloud` of a mesh without faces, with vertex normals and colours."""
    o3d = importlib.import_module("open3d")
    vectors = o3d.utility.Vector3dVector
    cloud = not len(arrays.faces)
    made = o3d.geometry.PointCloud() if cloud else o3d.geometry.TriangleMesh()
    setattr(made, "points" if cloud else "vertices", vectors(arrays.vertices))
    setattr(made, "normals" if cloud else "vertex_normals", vectors(arrays.normals))
    if arrays.colors is not None:
        setattr(made, "colors" if cloud else "vertex_colors", vectors(arrays.colors[:, :3]))
    if not cloud:
        made.triangles = o3d.utility.Vector3iVector(arrays.faces)
    arrays.lose(
        "Open3D",
        edges=arrays.edges,
        texture_coordinates=arrays.uv,
        colours_of_faces=arrays.face_colors,
        values_of_vertices=arrays.of_vertices,
        values_of_faces=arrays.of_faces,
    )
    return made


def to_meshio(arrays: Arrays) -> Any:
    """A `meshio.Mesh` with triangles and lines, or vertices where there are neither, and values of points and cells."""
    meshio = importlib.import_module("meshio")
    cells: list[tuple[str, Any]] = [
        (kind, found) for kind, found in (("triangle", arrays.faces), ("line", arrays.edges)) if len(found)
    ]
    cells = cells or [("vertex", np.arange(len(arrays.vertices)).reshape(-1, 1))]
    of_points: dict[str, Any] = {"normals": arrays.normals, **arrays.of_vertices}
    if arrays.colors is not None:
        of_points["rgba"] = bytes_of(arrays.colors)
    of_faces = dict(arrays.of_faces)
    if arrays.face_colors is not None:
        of_faces["rgba"] = bytes_of(arrays.face_colors)
    arrays.lose("meshio", texture_coordinates=arrays.uv)
    of_cells = {
        name: [v, *(np.zeros((len(arrays.edges), *v.shape[1:]), v.dtype) for _ in cells[1:])] for name, v in of_faces.items()
    }
    return meshio.Mesh(arrays.vertices, cells, point_data=of_points, cell_data=of_cells)


def to_pyvista(arrays: Arrays) -> Any:
    """A `pyvista.PolyData` with triangles and lines, colours as ``RGBA``, texture coordinates and all values."""
    pyvista = importlib.import_module("pyvista")
    parts = {"lines": (2, arrays.edges), "faces": (3, arrays.faces)}
    rows = {name: np.insert(found, 0, size, axis=1).ravel() for name, (size, found) in parts.items() if len(found)}
    made = pyvista.PolyData(arrays.vertices, **rows)
    made.point_data["Normals"] = arrays.normals
    for name, values in arrays.of_vertices.items():
        made.point_data[name] = values
    if arrays.colors is not None:
        made.point_data["RGBA"] = bytes_of(arrays.colors)
    if arrays.uv is not None:
        made.active_texture_coordinates = arrays.uv
    if arrays.face_colors is not None:
        arrays.of_faces["RGBA"] = bytes_of(arrays.face_colors)
    for name, values in arrays.of_faces.items():  # the cells of lines come first
        made.cell_data[name] = np.concatenate([np.zeros((len(arrays.edges), *values.shape[1:]), values.dtype), values])
    return made
