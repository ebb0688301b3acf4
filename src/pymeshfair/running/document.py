"""The layers of a run, numbered as in MeshLab, and the steps that change them.

A plugin's filter returns an edit of the current mesh. MeshLab's filters run in a `Door`, a MeshLab mesh set with the same layers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..calling import call, check_needs, resolved
from ..declaration import Arity
from ..errors import MeshError
from ..mesh_data import MeshData, View, apply_edit, as_layer
from ..meshlab.loading import load_pymeshlab
from ..scripts.script import Step

if TYPE_CHECKING:
    from ..door import Door

#: MeshLab's filters after which elements have lost their numbers: each runs in a new `Door`, which finds numbers by coordinates
_COPIES = frozenset({"meshing_repair_non_manifold_edges"})
#: MeshLab's filters that make quads, and what becomes of them
_MAKE_QUADS = {
    "meshing_surface_subdivision_catmull_clark",
    "meshing_tri_to_quad_by_4_8_subdivision",
    "meshing_tri_to_quad_by_smart_triangle_pairing",
    "meshing_tri_to_quad_dominant",
}
_QUADS = "the quads that MeshLab has made are written as triangles"


class State(NamedTuple):
    """A snapshot of the layers of a document."""

    meshes: Mapping[int, MeshData]  # by id
    visible: Mapping[int, bool]  # whether each layer is visible, by id
    current_id: int | None  # id of the current layer; None without layers
    next_id: int  # id of the next layer that is added
    losses: Sequence[str]  # what MeshLab could not take, or the output cannot hold, one text each


class Document:
    """The layers of a run."""

    def __init__(
        self,
        folder: Path,
        *,
        on_progress: Callable[[float], None] | None = None,
        on_note: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Files for MeshLab are written to `folder`; `on_progress` may raise to stop a filter."""
        self._folder, self._on_progress, self._on_note = folder, on_progress, on_note
        self._meshes: dict[int, MeshData | None] = {}  # None: only the `Door` has the mesh
        self._visible: dict[int, bool] = {}
        self._next_id = 0
        self._door: Door  # set by the first step with a filter of MeshLab
        self._door_is_current = False  # whether the `Door` has the layers as they are now
        self.current_id: int | None = None
        self.losses: list[str] = []

    def add(self, mesh: MeshData) -> int:
        number, self._next_id = self._next_id, self._next_id + 1
        self._meshes[number], self._visible[number] = mesh, True
        self._door_is_current = False
        self.current_id = number
        return number

    @property
    def ids(self) -> tuple[int, ...]:
        return tuple(self._meshes)

    @property
    def state(self) -> State | None:
        """A snapshot of the layers; None if the mesh of a layer is only in the `Door`."""
        meshes = {number: mesh for number, mesh in self._meshes.items() if mesh is not None}
        if len(meshes) < len(self._meshes):
            return None
        return State(meshes, self._visible.copy(), self.current_id, self._next_id, self.losses.copy())

    def restore(self, state: State) -> None:
        meshes, visible, self.current_id, self._next_id, losses = state
        self._meshes, self._visible, self.losses, self._door_is_current = {**meshes}, {**visible}, [*losses], False

    def mesh(self, number: int) -> MeshData:
        self._check_layer(number)
        mesh = self._meshes[number]
        if mesh is None:
            mesh = self._meshes[number] = self._door.fetch(number)
        return mesh

    @property
    def current(self) -> MeshData:
        if self.current_id is None:
            raise MeshError("there is no mesh")
        return self.mesh(self.current_id)

    @property
    def fullness(self) -> int:
        """Returns 2 if the current layer has faces, 1 if it has vertices but no faces, 0 if it is empty or there is none."""
        if self.current_id is None:
            return 0
        mesh = self._meshes[self.current_id]
        vertices, faces = self._door.counts() if mesh is None else (len(mesh.vertices), len(mesh.faces))
        return 2 if faces else min(vertices, 1)

    def apply(self, step: Step) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply a step; return its parameters, with lengths in mesh units, and the values that its filter reports, by name."""
        if step.filter.arity is not Arity.NONE and self.current_id is None:
            raise MeshError("there is no mesh to apply it to")
        for name, number in step.filter.layers(step.values).items():
            self._check_layer(number, f"parameter {name!r}: ")
        return self._apply_builtin(step) if step.filter.is_builtin else self._apply_plugin(step)

    def _check_layer(self, number: int, before: str = "") -> None:
        if number not in self._meshes:
            ids = ", ".join(map(str, self._meshes)) or "none"
            raise MeshError(f"{before}there is no layer {number} (there are {ids})")

    def _apply_plugin(self, step: Step) -> tuple[dict[str, Any], dict[str, Any]]:
        mesh = MeshData(vertices=np.empty((0, 3))) if self.current_id is None else self.current
        layer = View(mesh, self.mesh)
        check_needs(step.filter, layer)
        parameters = resolved(step.filter, {**step.filter.defaults, **step.values}, layer)
        edit = call(step.filter, parameters, layer, self._on_progress)
        if self.current_id is not None:
            changed = apply_edit(mesh, edit)
            if changed is not mesh:
                self._meshes[self.current_id] = changed
                self._door_is_current = False
        before = self.current_id
        matrix = None if step.filter.arity is Arity.NONE else mesh.matrix
        added = [self.add(replace(as_layer(new), matrix=matrix)) for new in edit.new_layers]
        self.current_id = added[0] if added else before
        for note in edit.notes:
            self._on_note(note)
        return parameters, dict(edit.values)

    def _apply_builtin(self, step: Step) -> tuple[dict[str, Any], dict[str, Any]]:
        copies = step.filter.python_name in _COPIES
        if copies or not self._door_is_current:
            load_pymeshlab()
            from ..door import Door

            meshes = {number: self.mesh(number) for number in self._meshes}
            self._door = Door(self._folder, meshes, self._visible, self.current_id)
            self.losses += self._door.lost
            self._door_is_current = True
        if (makes_quads := step.filter.python_name in _MAKE_QUADS) or step.filter.python_name == "meshing_poly_to_tri":
            self.losses = [*(text for text in self.losses if text != _QUADS), *([_QUADS] if makes_quads else ())]
        try:
            return self._door.apply(step)
        finally:
            ids, self.current_id, self._visible = self._door.layers(self._next_id)
            self._meshes = dict.fromkeys(ids)
            self._door_is_current = not copies
            self._next_id = max([self._next_id, *(number + 1 for number in ids)])
