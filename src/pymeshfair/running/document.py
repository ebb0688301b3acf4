"""The layers of a run: meshes by the ids that MeshLab would give them, and the steps that change them.

A plugin's filter makes the next mesh of the current one. MeshLab's work behind the door, which keeps meshes from step to step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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


class State(NamedTuple):
    """The layers of a document at one time."""

    meshes: Mapping[int, MeshData]  # by id
    visible: Mapping[int, bool]  # whether each is, by id
    current_id: int | None  # of the current layer; None if there is none
    next_id: int  # that of the next layer
    losses: Sequence[str]  # contents that MeshLab did not take so far


class Document:
    """Meshes by id."""

    def __init__(
        self,
        folder: Path,
        *,
        on_progress: Callable[[float], None] | None = None,
        on_note: Callable[[str], None] = lambda text: None,
    ) -> None:
        """`folder` takes the files for MeshLab, and `on_progress` may raise to stop a filter."""
        self._folder, self._on_progress, self._on_note = folder, on_progress, on_note
        self._meshes: dict[int, MeshData | None] = {}  # None: the door has it
        self._visible: dict[int, bool] = {}
        self._next_id = 0
        self._door: Door  # since layers were handed over
        self._is_inside = False
        self.current_id: int | None = None  # of the current layer; None if there is none
        self.losses: list[str] = []  # contents that MeshLab did not take, in words

    def add(self, mesh: MeshData) -> int:
        """Add a layer, which becomes the current one; its id."""
        number, self._next_id = self._next_id, self._next_id + 1
        self._meshes[number], self._visible[number] = mesh, True
        self._is_inside = False
        self.current_id = number
        return number

    @property
    def ids(self) -> tuple[int, ...]:
        """The ids of the layers."""
        return tuple(self._meshes)

    @property
    def state(self) -> State | None:
        """The layers as they are; None while MeshLab has one of them."""
        meshes = {number: mesh for number, mesh in self._meshes.items() if mesh is not None}
        if len(meshes) < len(self._meshes):
            return None
        return State(meshes, self._visible.copy(), self.current_id, self._next_id, self.losses.copy())

    def restore(self, state: State) -> None:
        """Take the layers of another time."""
        meshes, visible, self.current_id, self._next_id, losses = state
        self._meshes, self._visible, self.losses, self._is_inside = {**meshes}, {**visible}, [*losses], False

    def mesh(self, number: int) -> MeshData:
        """The mesh of a layer."""
        self._check_layer(number)
        mesh = self._meshes[number]
        if mesh is None:
            mesh = self._meshes[number] = self._door.fetch(number)
        return mesh

    @property
    def current(self) -> MeshData:
        """The mesh of the current layer."""
        if self.current_id is None:
            raise MeshError("there is no mesh")
        return self.mesh(self.current_id)

    def apply(self, step: Step) -> tuple[dict[str, Any], dict[str, Any]]:
        """Apply a step of a script; all values that it ran with, by name, lengths in mesh units; what its filter reports."""
        if step.filter.arity is not Arity.NONE and self.current_id is None:
            raise MeshError("there is no mesh that it could be applied to")
        for name, number in step.filter.layers(step.values).items():
            self._check_layer(number, f"parameter {name!r}: ")
        return self._apply_builtin(step) if step.filter.is_builtin else self._apply_plugin(step)

    def _check_layer(self, number: int, before: str = "") -> None:
        if number not in self._meshes:
            there = ", ".join(map(str, self._meshes)) or "none"
            raise MeshError(f"{before}there is no layer {number} (there are {there})")

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
                self._is_inside = False
        before = self.current_id
        added = [self.add(as_layer(new)) for new in edit.new_layers]
        self.current_id = added[0] if added else before
        for note in edit.notes:
            self._on_note(note)
        return parameters, dict(edit.values)

    def _apply_builtin(self, step: Step) -> tuple[dict[str, Any], dict[str, Any]]:
        if not self._is_inside:
            load_pymeshlab()
            from ..door import Door

            meshes = {number: self.mesh(number) for number in self._meshes}
            self._door = Door(self._folder, meshes, self._visible, self.current_id)
            self.losses += self._door.lost
            self._is_inside = True
        try:
            return self._door.apply(step)
        finally:
            ids, self.current_id, self._visible = self._door.layers(self._next_id)
            self._meshes = dict.fromkeys(ids)
            self._next_id = max([self._next_id, *(number + 1 for number in ids)])
