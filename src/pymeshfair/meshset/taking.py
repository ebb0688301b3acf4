"""Converts meshes of trimesh, Open3D, meshio and PyVista to arrays; recognises them by attributes, without an import."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..declaration import Floats, Ints
from ..meshlab.errors import ForeignMeshError
from .exchange import Arrays, arrays_of, coordinates, indices, rgba

#: for each kind of cell in meshio, its triangles as corners of the cell
_TRIANGLES = {"triangle": ((0, 1, 2),), "quad": ((0, 1, 2), (0, 2, 3))}


def taken(mesh: Any) -> Arrays:
    """The arrays of a mesh of another package.

    Raises:
        ForeignMeshError: it is no mesh of these packages, or has cells that are no triangles, quads, lines or vertices.
    """
    if hasattr(mesh, "to_legacy"):  # Open3D's tensors
        mesh = mesh.to_legacy()
    if hasattr(mesh, "GetPointData"):
        return _of_pyvista(mesh)
    if hasattr(mesh, "points") and hasattr(mesh, "cells"):
        return _of_meshio(mesh)
    if hasattr(mesh, "geometry") and hasattr(mesh, "graph"):
        return _of_scene(mesh)
    if hasattr(mesh, "vertices") and (hasattr(mesh, "faces") or hasattr(mesh, "colors")):
        return _of_trimesh(mesh)
    if hasattr(mesh, "triangles") or (hasattr(mesh, "points") and hasattr(mesh, "normals")):
        return _of_open3d(mesh)
    kind = f"{type(mesh).__module__}.{type(mesh).__qualname__}"
    raise ForeignMeshError(
        f"add_mesh takes a pymeshlab.Mesh, or a mesh or cloud of trimesh, Open3D, meshio or PyVista, got a {kind}"
    )


def _of_scene(scene: Any) -> Arrays:
    """All parts of a trimesh scene, transformed to their places, as one mesh."""
    parts = scene.dump()
    kinds = sorted({type(part).__name__ for part in parts})
    if not parts:
        raise ForeignMeshError("the scene has no geometry")
    if len(kinds) > 1:
        raise ForeignMeshError(f"the scene has parts of several kinds ({', '.join(kinds)}): add each of scene.dump() by itself")
    arrays = _of_trimesh(parts[0] if len(parts) == 1 else scene.to_geometry())
    if len(parts) > 1:
        arrays.lost.append(f"the {len(parts)} parts of the scene are one mesh without their names")
    return arrays


def _of_trimesh(mesh: Any) -> Arrays:
    vertices = _in_space(coordinates(mesh.vertices))
    arrays = Arrays(vertices)
    if hasattr(mesh, "vertex_nodes"):  # a Path
        arrays.edges = indices(mesh.vertex_nodes)
        return arrays
    if not hasattr(mesh, "faces"):  # a PointCloud
        arrays.colors = rgba(getattr(mesh, "colors", ()), len(vertices))
        return arrays
    arrays.faces = indices(mesh.faces)
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "vertex":
        arrays.colors = rgba(visual.vertex_colors, len(vertices))
    elif kind == "face":
        arrays.face_colors = rgba(visual.face_colors, len(arrays.faces))
    elif kind == "texture" and getattr(visual, "uv", None) is not None:
        arrays.uv = coordinates(visual.uv)
        material = getattr(visual, "material", None)
        if getattr(material, "image", None) is not None or getattr(material, "baseColorTexture", None) is not None:
            arrays.lost.append("the texture is left out, as MeshLab takes no picture from memory; its coordinates are kept")
    arrays.of_vertices = arrays_of(getattr(mesh, "vertex_attributes", None))
    arrays.of_faces = arrays_of(getattr(mesh, "face_attributes", None))
    return arrays


def _in_space(points: Floats) -> Floats:
    """(n, 3) the points; z is 0 if they are (n, 2)."""
    return np.column_stack([points, np.zeros(len(points))]) if points.shape[1:] == (2,) else points


def _of_open3d(mesh: Any) -> Arrays:
    cloud = not hasattr(mesh, "triangles")
    vertices = coordinates(mesh.points if cloud else mesh.vertices)
    arrays = Arrays(vertices, colors=rgba(mesh.colors if cloud else mesh.vertex_colors, len(vertices)))
    if cloud and len(mesh.normals) == len(vertices) > 0:
        arrays.normals = coordinates(mesh.normals)
    if not cloud:
        arrays.faces = indices(mesh.triangles)
        arrays.lost += ["the texture of the Open3D mesh is not taken"] if len(getattr(mesh, "textures", ())) else []
    return arrays


def _of_meshio(mesh: Any) -> Arrays:
    points = _in_space(coordinates(mesh.points))
    faces, edges = [np.zeros((0, 3), dtype=np.int32)], [np.zeros((0, 2), dtype=np.int32)]
    from_cell: list[Ints] = [np.zeros(0, dtype=np.int32)]  # for each triangle, the number of its cell
    start = 0
    for block in mesh.cells:
        kind, cells = (block.type, block.data) if hasattr(block, "type") else block
        numbers = indices(np.arange(start, start + len(cells)))
        start += len(cells)
        if kind in _TRIANGLES:
            faces += [indices(np.asarray(cells)[:, corners]) for corners in _TRIANGLES[kind]]
            from_cell += [numbers for _ in _TRIANGLES[kind]]
        elif kind == "line":
            edges.append(indices(cells))
        elif kind != "vertex":
            raise ForeignMeshError(
                f"the meshio mesh has cells of type {kind!r}; supported are triangles, quads (as two triangles) and lines"
            )
    arrays = Arrays(
        points, np.concatenate(faces), np.concatenate(edges), of_vertices=arrays_of(getattr(mesh, "point_data", None))
    )
    of_cells = getattr(mesh, "cell_data", None) or {}
    joined = {name: np.concatenate([np.asarray(part) for part in parts]) for name, parts in of_cells.items()}
    arrays.of_faces = {name: values[np.concatenate(from_cell)] for name, values in joined.items()}
    _take_by_name(arrays)
    return arrays


def _of_pyvista(mesh: Any) -> Arrays:
    if not hasattr(mesh, "regular_faces"):
        mesh = mesh.extract_surface()
    lines, edges = np.asarray(mesh.lines), []
    while len(lines):
        count = int(lines[0])
        edges.append(np.column_stack([lines[1:count], lines[2 : count + 1]]))
        lines = lines[count + 1 :]
    surface = mesh.triangulate()
    arrays = Arrays(
        coordinates(mesh.points), indices(surface.regular_faces).reshape(-1, 3), of_vertices=arrays_of(mesh.point_data)
    )
    of_cells = arrays_of(surface.cell_data)
    arrays.of_faces = {name: array for name, array in of_cells.items() if len(array) == len(arrays.faces)}
    if others := sorted(of_cells.keys() - arrays.of_faces.keys()):
        arrays.lost.append(f"of lines, points and faces together, data of cells are not taken: {', '.join(others)}")
    if edges:
        arrays.edges = indices(np.concatenate(edges))
    uv = mesh.active_texture_coordinates
    if uv is not None:
        arrays.uv = coordinates(uv)
        arrays.of_vertices = {n: a for n, a in arrays.of_vertices.items() if a.shape != uv.shape or (a != uv).any()}
    _take_by_name(arrays)
    return arrays


def _take_by_name(arrays: Arrays) -> None:
    """Move values named as normals or colours to the fields for them."""
    for name, values in list(arrays.of_vertices.items()):
        if name.lower() in ("normals", "normal") and values.shape == arrays.vertices.shape:
            arrays.normals = coordinates(arrays.of_vertices.pop(name))
        elif name.lower() in ("rgb", "rgba", "colors") and values.shape[1:] in ((3,), (4,)):
            arrays.colors = rgba(arrays.of_vertices.pop(name), len(arrays.vertices))
    for name, values in list(arrays.of_faces.items()):
        if name.lower() in ("rgb", "rgba", "colors") and values.shape[1:] in ((3,), (4,)):
            arrays.face_colors = rgba(arrays.of_faces.pop(name), len(arrays.faces))
