"""What `MeshSet` offers besides pymeshlab's methods: recipes by name, meshes of other packages, and how it is shown."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from ..filters.libraries import ImportedWhenUsed
from .exchange import Arrays, bytes_of

if TYPE_CHECKING:
    from .. import recipe
    from ..scripts import Script, Step
    from . import exchange, script_log
else:  # importing them takes longer than importing pymeshlab
    recipe = ImportedWhenUsed("pymeshfair.recipe")
    exchange, script_log = (ImportedWhenUsed(f"pymeshfair.meshset.{name}") for name in ("exchange", "script_log"))


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


def layer_rows(meshes: Any) -> list[tuple[str, str, str]]:
    """For every layer of a mesh set its number, starred if it is the current one, its name, and how large it is."""
    current = meshes.current_mesh_id() if meshes.mesh_number() else -1
    rows = []
    for mesh in meshes:
        counts = ((mesh.vertex_number(), "vertices"), (mesh.face_number(), "faces"), (mesh.edge_number(), "edges"))
        size = ", ".join(f"{count:,} {what}" for count, what in counts if count or what == "vertices")
        rows.append((f"{mesh.id()}{'*' if mesh.id() == current else ''}", mesh.label(), size))
    return rows


def layers_text(meshes: Any) -> str:
    """One line a layer."""
    rows = layer_rows(meshes)
    count = f"{len(rows)} {'layer' if len(rows) == 1 else 'layers'}"
    return "\n".join([f"MeshSet of {count}", *(f"  {number:<4} {name}: {size}" for number, name, size in rows)])


def layers_line(meshes: Any) -> str:
    """The number of layers and the current one, for ``repr``."""
    rows = layer_rows(meshes)
    count = f"{len(rows)} {'layer' if len(rows) == 1 else 'layers'}"
    current = [f", current {number.rstrip('*')} {name!r}: {size}" for number, name, size in rows if number.endswith("*")]
    return f"<{type(meshes).__name__} of {count}{''.join(current)}>"


def layers_table(meshes: Any) -> str:
    """The layers as a table of HTML; the current one is bold."""
    lines = ["<table>", "<tr><th>layer</th><th>name</th><th>size</th></tr>"]
    for row in layer_rows(meshes):
        cells = (f"<b>{escape(cell)}</b>" if row[0].endswith("*") else escape(cell) for cell in row)
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return "\n".join([*lines, "</table>"])


class Conveniences:
    """For `MeshSet` to inherit."""

    def apply_recipe(self, name_or_path: str | os.PathLike[str], **settings: object) -> list[dict[str, Any]]:
        """Apply a recipe to the current mesh, and add its steps to the filter script; what each of them reports.

        Limits of the recipe are not looked at: `pymeshfair.run` does that.

        Args:
            name_or_path: a shipped recipe, or the path of an .mlx script.
            **settings: values over the recipe's own, by the names of its settings.

        Raises:
            UnknownNameError: there is no such recipe or setting.
            ScriptError: something in the script is wrong; lists every problem.
            ScriptStepFailedError: a step failed; the mesh is as the last complete step left it.
        """
        loaded = recipe.load_recipe(name_or_path).override([f"{name}={value}" for name, value in settings.items()])
        return self.apply_script(loaded.script)

    def apply_script(self, script: Script) -> list[dict[str, Any]]:
        """Apply all steps of a script to the current mesh, and add them to the filter script; what each of them reports.

        Raises:
            ScriptStepFailedError: a step failed; the mesh and the filter script are as the last complete step left them.
        """
        meshes: Any = self
        results: list[dict[str, Any]] = []

        def apply(step: Step) -> None:
            result, done = meshes._filters.apply_step(step)
            results.append(result)
            meshes._script.steps.append(done)

        with meshes.deferred():
            script_log.ScriptLog(script).apply(apply)
        return results

    def to_trimesh(self) -> Any:
        """The current mesh as a `trimesh.Trimesh`, without faces as a `Path3D` or a `PointCloud`, with colours and values.

        What trimesh does not take is named by a warning of the logger ``pymeshfair``; so by the next three.
        """
        return self._given(to_trimesh)

    def to_open3d(self) -> Any:
        """The current mesh as an `open3d.geometry.TriangleMesh`, or a `PointCloud`, with vertex normals and colours."""
        return self._given(to_open3d)

    def to_meshio(self) -> Any:
        """The current mesh as a `meshio.Mesh` of triangles and lines, with normals, colours and values of points and cells."""
        return self._given(to_meshio)

    def to_pyvista(self) -> Any:
        """The current mesh as a `pyvista.PolyData` with normals, colours, texture coordinates and values of points and cells."""
        return self._given(to_pyvista)

    def _given(self, make: Callable[[exchange.Arrays], Any]) -> Any:
        meshes: Any = self
        arrays = exchange.of_meshlab(meshes.current_mesh(), meshes._layers.bench)
        made = make(arrays)
        meshes._filters.plugins.tell_losses(arrays.lost)
        return made

    def __str__(self) -> str:
        return layers_text(self)

    def __repr__(self) -> str:
        return layers_line(self)

    def _repr_html_(self) -> str:
        return layers_table(self)
