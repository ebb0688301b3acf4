"""What a filter reads and what it returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]


class Layer(Protocol):
    """The current mesh as read-only arrays; each is read from MeshLab when it is first asked for.

    n vertices, m triangles, e edges. A mesh with vertices alone is a point cloud, one with edges and no triangles a polyline.
    """

    @property
    def label(self) -> str: ...
    @property
    def vertices(self) -> Floats: ...  # (n, 3)
    @property
    def faces(self) -> Ints: ...  # (m, 3) indices of vertices, counter-clockwise seen from outside
    @property
    def edges(self) -> Ints: ...  # (e, 2)
    @property
    def vertex_normals(self) -> Floats: ...  # (n, 3)
    @property
    def face_normals(self) -> Floats: ...  # (m, 3)
    @property
    def vertex_selection(self) -> Bools: ...  # (n,)
    @property
    def face_selection(self) -> Bools: ...  # (m,)
    @property
    def vertex_scalars(self) -> Floats: ...  # (n,)
    @property
    def face_scalars(self) -> Floats: ...  # (m,)
    @property
    def vertex_colors(self) -> Floats: ...  # (n, 4) from 0 to 1
    @property
    def face_colors(self) -> Floats: ...  # (m, 4) from 0 to 1
    @property
    def has_vertex_scalars(self) -> bool: ...
    @property
    def has_vertex_colors(self) -> bool: ...
    @property
    def diagonal(self) -> float: ...  # of the bounding box, in mesh units
    @property
    def mean_edge(self) -> float: ...  # mean edge length; of a cloud the mean distance to the nearest neighbour

    def selected_vertices(self) -> Bools:
        """The selected vertices or, when there are none, the vertices all of whose triangles are selected.

        Raises `MeshError` when nothing at all is selected.
        """
        ...

    def other(self, mesh_id: int) -> Layer:
        """Another layer of the mesh set; raises `MeshError` when there is none of that id."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class NewLayer:
    """A layer that a filter adds to the mesh set."""

    label: str
    vertices: Floats
    faces: Ints | None = None
    edges: Ints | None = None
    vertex_normals: Floats | None = None
    vertex_scalars: Floats | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Edit:
    """What a filter changed. None means untouched; everything that is not named stays as it is, bit by bit.

    Attributes:
        vertices: (n, 3) new coordinates.
        vertex_selection, face_selection: (n,), (m,) the new selection.
        vertex_scalars, face_scalars: (n,), (m,) the new scalar ("quality").
        vertex_colors, face_colors: (n, 4), (m, 4) red, green, blue, opacity from 0 to 1.
        vertex_normals: (n, 3) of a point cloud; a mesh's normals follow from its coordinates.
        face_normals: (m, 3) unit normals.
        delete_vertices, delete_faces: (n,), (m,) true where the element goes; a vertex takes its faces along.
        new_layers: layers to add; the first becomes the current one.
        values: what `apply_filter` returns: numbers, texts, arrays by name.
        notes: sentences that the user should read, such as what was left alone and why.
    """

    vertices: Floats | None = None
    vertex_selection: Bools | None = None
    face_selection: Bools | None = None
    vertex_scalars: Floats | None = None
    face_scalars: Floats | None = None
    vertex_colors: Floats | None = None
    face_colors: Floats | None = None
    vertex_normals: Floats | None = None
    face_normals: Floats | None = None
    delete_vertices: Bools | None = None
    delete_faces: Bools | None = None
    new_layers: tuple[NewLayer, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
