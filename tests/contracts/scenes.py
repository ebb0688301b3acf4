"""Small scenes on which every filter has something to do, filters applied to them, and what came out."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

import pymeshfair
from pymeshfair.declaration import Filter, MeshElement
from tests.meshes import Bools, Floats, Ints, Mesh, icosphere, noisy

#: coordinates are multiples of this, so that moving a scene by up to 2^20 diagonals rounds none of them
GRID = 2.0**-28
#: vertices with a scalar below it can be selected, see `apply`
CHOSEN_BELOW = 0.7


@dataclass(frozen=True)
class Scene:
    """A layer that filters are applied to.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3).
        edges: (e, 2), of polylines.
        scalars: (n,) of the vertices.
        colors: (n, 4) of the vertices, from 0 to 1.
    """

    vertices: Floats
    faces: Ints
    edges: Ints
    scalars: Floats
    colors: Floats

    @property
    def chosen(self) -> Bools:
        """(n,) the vertices that `apply` selects if it selects any."""
        chosen: Bools = self.scalars < CHOSEN_BELOW
        return chosen

    @property
    def chosen_faces(self) -> Bools:
        """(m,) the faces that `apply` selects: those of which all vertices are."""
        return np.asarray(self.chosen[self.faces].all(axis=1))

    def with_stray(self, at: int, position: Floats) -> Scene:
        """The scene with one vertex more, number `at`, that no face and no edge uses and that is never chosen."""
        shift = self.faces.dtype.type(1)
        return Scene(
            np.insert(self.vertices, at, position, axis=0),
            self.faces + shift * (self.faces >= at),
            self.edges + shift * (self.edges >= at),
            np.insert(self.scalars, at, 1.0),
            np.insert(self.colors, at, 1.0, axis=0),
        )

    def renumbered(self, order: NDArray[np.intp], face_order: NDArray[np.intp]) -> Scene:
        """The scene with vertex ``order[i]`` as vertex i, and its faces in that order."""
        place = np.argsort(order).astype(np.int32)
        return Scene(
            self.vertices[order], place[self.faces][face_order], place[self.edges], self.scalars[order], self.colors[order]
        )


@dataclass(frozen=True)
class Outcome:
    """What a filter made of a scene: arrays of the mesh by name, and what it reports."""

    arrays: Mapping[str, NDArray[Any]]
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def vertices(self) -> Floats:
        return self.arrays["vertices"]

    def without_vertex(self, at: int) -> Outcome:
        """The outcome without a vertex that no face and no edge uses."""
        arrays = {name: np.delete(array, at, axis=0) for name, array in self.arrays.items() if name.startswith("vert")}
        arrays |= {name: self.arrays[name] - (self.arrays[name] > at) for name in ("faces", "edges")}
        return replace(self, arrays={**self.arrays, **arrays})

    def differences(self, other: Outcome) -> list[str]:
        """The names of arrays and values that are not the same to the bit."""
        both = {**self.arrays, **self.values}, {**other.arrays, **other.values}
        return sorted(name for name in both[0].keys() | both[1].keys() if not _same(both[0].get(name), both[1].get(name)))


def scene_for(declared: Filter) -> Scene:
    """The scene with everything that the filter's declaration requires."""
    return curves() if declared.requires & MeshElement.EDGENUMBER else two_open_spheres()


@functools.cache
def two_open_spheres() -> Scene:
    """Two rough unit spheres, each with a hole towards the other; scalars rise with the distance from the plane between them."""
    left, right = _open_sphere(1), _open_sphere(2)
    vertices = np.concatenate([left[0] - [1.2, 0, 0], right[0] * [-1, -1, 1] + [1.2, 0, 0]])
    faces = np.concatenate([left[1], right[1] + np.int32(len(left[0]))])
    return _scene(vertices, faces, np.empty((0, 2), dtype=np.int32))


@functools.cache
def curves() -> Scene:
    """A rough closed curve and a rough open one, not in a plane."""
    n = 60
    angle = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.2 * np.cos(3 * angle)])
    line = np.column_stack([np.linspace(-1, 1, n // 2), np.linspace(2, 2.5, n // 2), np.zeros(n // 2)])
    vertices, _ = noisy((np.concatenate([ring, line]), np.empty((0, 3), dtype=np.int32)), 0.03, 3)
    ring_edges = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    line_edges = np.column_stack([np.arange(n, n + n // 2 - 1), np.arange(n + 1, n + n // 2)])
    return _scene(vertices, np.empty((0, 3), dtype=np.int32), np.concatenate([ring_edges, line_edges]).astype(np.int32))


def scene_of(mesh: Mesh) -> Scene:
    """A scene of any mesh."""
    return _scene(*mesh, np.empty((0, 2), dtype=np.int32), rounded=False)


def _open_sphere(seed: int) -> Mesh:
    vertices, faces = noisy(icosphere(2), 0.02, seed)
    kept = faces[vertices[faces].mean(axis=1)[:, 0] < 0.85]
    used, inverse = np.unique(kept, return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3).astype(np.int32)


def _scene(vertices: Floats, faces: Ints, edges: Ints, *, rounded: bool = True) -> Scene:
    rng = np.random.default_rng(7)
    if rounded:
        vertices = np.round(vertices / GRID) * GRID
    scalars = np.abs(vertices[:, 0]) + rng.normal(0, 0.01, len(vertices))
    colors = np.column_stack([rng.integers(0, 256, (len(vertices), 3)) / 255, np.ones(len(vertices))])
    return Scene(vertices, faces, edges, scalars, colors)


def mesh_set(scene: Scene, *, select: bool = False) -> pymeshfair.MeshSet:
    """A mesh set with the scene as its only layer; `select` selects the chosen vertices, and the faces between them."""
    meshes = pymeshfair.MeshSet()
    if len(scene.vertices) == 0:  # pymeshlab makes no empty mesh, but empties one
        meshes.add_mesh(pymeshlab.Mesh(np.zeros((1, 3))))
        meshes.set_selection_all()
        meshes.meshing_remove_selected_vertices()
        return meshes
    given: dict[str, NDArray[Any]] = {
        "vertex_matrix": scene.vertices,
        "face_matrix": scene.faces,
        "edge_matrix": scene.edges,
        "v_scalar_array": scene.scalars,
        "v_color_matrix": scene.colors,
    }
    meshes.add_mesh(pymeshlab.Mesh(**{name: array for name, array in given.items() if len(array)}))
    if select:
        meshes.compute_selection_by_condition_per_vertex(condselect=f"q < {CHOSEN_BELOW}")
        if len(scene.faces):
            meshes.compute_selection_by_condition_per_face(condselect=" && ".join(f"q{k} < {CHOSEN_BELOW}" for k in range(3)))
    return meshes


def apply(
    declared: Filter,
    scene: Scene,
    values: Mapping[str, Any],
    *,
    select: bool = True,
    on_progress: Callable[[float], None] | None = None,
) -> Outcome:
    """Apply the filter to the scene as users do, on a mesh set; notes are not kept."""
    meshes = mesh_set(scene, select=select)
    meshes.on_note = lambda note: None
    meshes.on_progress = on_progress
    told = meshes.apply_filter(declared.python_name, **values)
    return Outcome(arrays_of(meshes), told)


def arrays_of(meshes: pymeshfair.MeshSet) -> dict[str, NDArray[Any]]:
    """What the current mesh holds, by name."""
    mesh = meshes.current_mesh()
    return {
        "vertices": mesh.vertex_matrix(),
        "faces": mesh.face_matrix(),
        "edges": mesh.edge_matrix(),
        "vertex_scalars": mesh.vertex_scalar_array(),
        "vertex_colors": mesh.vertex_color_matrix(),
        "vertex_selection": mesh.vertex_selection_array(),
        "face_selection": mesh.face_selection_array(),
        "face_normals": mesh.face_normal_matrix(),
    }


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)
