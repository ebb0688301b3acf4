"""What `MeshSet` offers besides pymeshlab's methods: recipes by name, meshes of other packages, and how it is shown."""

from __future__ import annotations

import os
from typing import Any

from ..recipe import load_recipe
from ..scripts import Script, Step
from .exchange import to_meshio, to_open3d, to_trimesh
from .script_log import ScriptLog
from .showing import layers_table, layers_text


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
        found = load_recipe(name_or_path).override([f"{name}={value}" for name, value in settings.items()])
        return self.apply_script(found.script)

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
            ScriptLog(script).apply(apply)
        return results

    def to_trimesh(self) -> Any:
        """The current mesh as a `trimesh.Trimesh`, or a `trimesh.PointCloud` if it has no faces, with its vertex colours."""
        return to_trimesh(self._current())

    def to_open3d(self) -> Any:
        """The current mesh as an `open3d.geometry.TriangleMesh`, or a `PointCloud`, with vertex normals and colours."""
        return to_open3d(self._current())

    def to_meshio(self) -> Any:
        """The current mesh as a `meshio.Mesh` of triangles and lines, with the vertex normals as point data."""
        return to_meshio(self._current())

    def _current(self) -> Any:
        meshes: Any = self
        return meshes.current_mesh()

    def __str__(self) -> str:
        return layers_text(self)

    def _repr_html_(self) -> str:
        return layers_table(self)
