"""What `MeshSet` offers besides pymeshlab's methods: recipes by name, meshes of other packages, and how it is shown."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from ..filters.libraries import ImportedWhenUsed

if TYPE_CHECKING:
    from .. import recipe
    from ..scripts import Script, Step
    from . import exchange, script_log
else:  # importing them takes longer than importing pymeshlab
    recipe = ImportedWhenUsed("pymeshfair.recipe")
    exchange, script_log = (ImportedWhenUsed(f"pymeshfair.meshset.{name}") for name in ("exchange", "script_log"))


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
        return self._given(exchange.to_trimesh)

    def to_open3d(self) -> Any:
        """The current mesh as an `open3d.geometry.TriangleMesh`, or a `PointCloud`, with vertex normals and colours."""
        return self._given(exchange.to_open3d)

    def to_meshio(self) -> Any:
        """The current mesh as a `meshio.Mesh` of triangles and lines, with normals, colours and values of points and cells."""
        return self._given(exchange.to_meshio)

    def to_pyvista(self) -> Any:
        """The current mesh as a `pyvista.PolyData` with normals, colours, texture coordinates and values of points and cells."""
        return self._given(exchange.to_pyvista)

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


def layer_rows(meshes: Any) -> list[tuple[str, str, str]]:
    """(number, name, size) of every layer of a mesh set; the number of the current layer ends with ``*``."""
    current = meshes.current_mesh_id() if meshes.mesh_number() else -1
    rows = []
    for mesh in meshes:
        counts = ((mesh.vertex_number(), "vertices"), (mesh.face_number(), "faces"), (mesh.edge_number(), "edges"))
        size = ", ".join(f"{count:,} {what}" for count, what in counts if count or what == "vertices")
        rows.append((f"{mesh.id()}{'*' if mesh.id() == current else ''}", mesh.label(), size))
    return rows


def layers_text(meshes: Any) -> str:
    """One line per layer."""
    rows = layer_rows(meshes)
    return "\n".join([f"MeshSet of {_layer_count(rows)}", *(f"  {number:<4} {name}: {size}" for number, name, size in rows)])


def layers_line(meshes: Any) -> str:
    """The number of layers and the current one, for ``repr``."""
    rows = layer_rows(meshes)
    current = [f", current {number.rstrip('*')} {name!r}: {size}" for number, name, size in rows if number.endswith("*")]
    return f"<{type(meshes).__name__} of {_layer_count(rows)}{''.join(current)}>"


def _layer_count(rows: Sequence[Any]) -> str:
    return f"{len(rows)} {'layer' if len(rows) == 1 else 'layers'}"


def layers_table(meshes: Any) -> str:
    """The layers as a table of HTML; the current one is bold."""
    lines = ["<table>", "<tr><th>layer</th><th>name</th><th>size</th></tr>"]
    for row in layer_rows(meshes):
        cells = (f"<b>{escape(cell)}</b>" if row[0].endswith("*") else escape(cell) for cell in row)
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return "\n".join([*lines, "</table>"])
