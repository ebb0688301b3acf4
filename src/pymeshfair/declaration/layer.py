"""The input and the result of a filter: `Layer` and `Edit`."""

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
    def has_face_scalars(self) -> bool: ...
    @property
    def has_face_colors(self) -> bool: ...
    @property
    def has_wedge_tex_coords(self) -> bool: ...
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
    """The changes by a filter. None means untouched; everything that is not named stays as it is, bit by bit.

    n and m count the vertices and faces of the layer; N = n + a and M = m + b count those that are added, too, which come last.

    Attributes of added elements that the edit does not set come from near by: a vertex takes scalar and texture
    coordinates of the nearest old vertex that added faces use, a face the scalar of an old face at such a vertex, nearest to its
    own centre. Colours are blended: those of a vertex from its neighbours in added faces, those of a face from the faces around.
    A face shows one place of the texture at its three corners: the middle of an old face near by whose colour there is such a
    blend, or of the one next to it where the image is not readable; of several textures, the most frequent one among its old
    vertices. Added elements are not selected, their custom attributes are 0, normals follow from the coordinates.

    A layer to which elements are added stays the same one, with its id. MeshLab leaves some things not as they were: a mesh
    with texture coordinates at the corners of its faces alone gets some at its vertices, a mesh of polygons alone becomes one of
    triangles, and scalars of faces that are written, or differ when faces are added, make the faces of a mesh without colours
    white. If an addition fails the layer becomes what it was, but for these.
    """

    vertices: Floats | None = None  # (n, 3) new coordinates
    added_vertices: Floats | None = None  # (a, 3) vertices to add, to a mesh that has faces
    added_faces: Ints | None = None  # (b, 3) three different indices of vertices; from n on they mean `added_vertices`
    vertex_selection: Bools | None = None  # (N,) the new selection
    face_selection: Bools | None = None  # (M,)
    vertex_scalars: Floats | None = None  # (N,) the new scalar ("quality")
    face_scalars: Floats | None = None  # (M,)
    vertex_colors: Floats | None = None  # (N, 4) red, green, blue, opacity from 0 to 1
    face_colors: Floats | None = None  # (M, 4)
    vertex_normals: Floats | None = None  # (N, 3) of a point cloud; a mesh's normals follow from its coordinates
    face_normals: Floats | None = None  # (M, 3) unit normals
    delete_vertices: Bools | None = None  # (N,) true where the vertex goes, which takes its faces along
    delete_faces: Bools | None = None  # (M,) true where the face goes
    new_layers: tuple[NewLayer, ...] = ()  # layers to add; the first becomes the current one
    values: Mapping[str, Any] = field(default_factory=dict)  # what `apply_filter` returns: numbers, texts, arrays by name
    notes: tuple[str, ...] = ()  # sentences for the user, such as parts that were left alone, with the reason
