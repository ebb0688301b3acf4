"""A mesh as a value: arrays, named attributes of its elements, textures, and the file that it comes from."""

from __future__ import annotations

import io
import math
from collections import UserDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats, Ints
from ..errors import MeshError
from ..filters.geometry import face_normals, mean_edge_length, unit_vectors, vertex_normals_by_angle
from ..filters.mesh import mask_of

#: the attributes of vertices and of faces that MeshLab has too; all others are custom attributes
VERTEX_ATTRIBUTES = frozenset(("normals", "colors", "scalars", "radii", "texture_coordinates", "selection"))
FACE_ATTRIBUTES = frozenset(("normals", "colors", "scalars", "selection", "wedge_texture_coordinates", "texture", "polygon"))
Array: TypeAlias = NDArray[Any]
_T = TypeVar("_T")


@dataclass(frozen=True)
class Texture:
    """An image on the surface."""

    name: str  # as the mesh file writes it
    image: Path | bytes | None  # the path of an image file, the bytes of an image within the mesh file, or None if it is missing


@dataclass(frozen=True, eq=False)
class Source:
    """The file that a mesh was read from."""

    path: Path
    format: str  # an extension in lower case
    document: Any = None  # what the reader keeps for the writer of this format, to write unchanged parts as they were
    #: names of contents that `MeshData` cannot hold; only a file of the same format can keep them
    extras: tuple[str, ...] = ()
    side_files: tuple[Path, ...] = ()  # the files that belong to it: materials, textures, buffers
    #: images that its materials name besides textures; only a file of the same format can keep them
    images: tuple[Texture, ...] = ()
    vertices: int = 0  # the number of its vertices
    faces: int = 0  # the number of triangles that its faces make
    edges: int = 0  # the number of edges of its polylines


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshData:
    """A mesh: n vertices, m triangles, e edges of polylines. Coordinates, faces, edges and attributes are read-only.

    Attributes:
        vertices: (n, 3) coordinates.
        faces: (m, 3) indices of vertices, counter-clockwise seen from outside.
        edges: (e, 2) indices of vertices.
        vertex_attributes: by name: ``normals`` (n, 3), ``colors`` (n, 4) uint8, ``scalars`` (n,), ``radii`` (n,),
            ``texture_coordinates`` (n, 2), ``selection`` (n,) bool; any other name is a custom attribute, (n,) or (n, 3).
        face_attributes: by name: ``normals`` (m, 3), ``colors`` (m, 4) uint8, ``scalars`` (m,), ``selection`` (m,) bool,
            ``wedge_texture_coordinates`` (m, 3, 2), ``texture`` (m,) the number of the texture or -1, ``polygon`` (m,) one number
            for all triangles of a polygon, -1 for a single triangle; any other name is a custom attribute.
        keeps_normals: whether files of a mesh with faces get vertex normals. After vertices move these are computed anew.
        textures: the images; ``texture`` is an index into them.
        matrix: (4, 4) transformation of the coordinates, None for the identity. A run applies it before it writes a file.
        label: the name of the layer.
        unit: of the coordinates: ``"um"``, ``"mm"``, ``"cm"``, ``"m"``, ``"in"`` or ``"ft"``; None if it is not known.
        source: the file that the mesh comes from.
        vertex_ids: (n,) the index of each vertex in the source, -1 for a new vertex; None: all vertices in the source's order.
        face_ids: (m,) the same for the triangles.
        edge_ids: (e,) the same for the edges.
    """

    vertices: Floats
    faces: Ints = field(default_factory=lambda: np.empty((0, 3), np.int32))
    edges: Ints = field(default_factory=lambda: np.empty((0, 2), np.int32))
    vertex_attributes: Mapping[str, Array] = field(default_factory=dict)
    face_attributes: Mapping[str, Array] = field(default_factory=dict)
    keeps_normals: bool = False
    textures: tuple[Texture, ...] = ()
    matrix: Floats | None = None
    label: str = ""
    unit: str | None = None
    source: Source | None = None
    vertex_ids: NDArray[np.int64] | None = None
    face_ids: NDArray[np.int64] | None = None
    edge_ids: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        for name, dtype, shape in (("vertices", np.float64, (-1, 3)), ("faces", np.int32, (-1, 3)), ("edges", np.int32, (-1, 2))):
            object.__setattr__(self, name, _frozen(np.asarray(getattr(self, name), dtype).reshape(shape)))
        for name in ("vertex_attributes", "face_attributes"):
            if not isinstance(getattr(self, name), LazyAttributes):
                object.__setattr__(self, name, {key: _frozen(value) for key, value in getattr(self, name).items()})
        if np.array_equal(self.matrix, np.eye(4)):  # type: ignore[arg-type]
            object.__setattr__(self, "matrix", None)

    def with_attributes(
        self, vertex: Mapping[str, Array | None] | None = None, face: Mapping[str, Array | None] | None = None
    ) -> MeshData:
        """Returns the mesh with these attributes added or replaced; None removes an attribute."""
        return replace(
            self,
            vertex_attributes=_changed(self.vertex_attributes, vertex or {}),
            face_attributes=_changed(self.face_attributes, face or {}),
        )

    def part(self, vertices: Bools, faces: Bools | None = None) -> MeshData:
        """Returns the vertices in an (n,) mask, and edges and faces between them; of the faces only those in an (m,) mask."""
        number = np.cumsum(vertices, dtype=np.int32) - np.int32(1)
        kept_faces = vertices[self.faces].all(axis=1)
        if faces is not None:
            kept_faces &= faces
        kept_edges = vertices[self.edges].all(axis=1)
        return replace(
            self,
            vertices=self.vertices[vertices],
            faces=number[self.faces[kept_faces]],
            edges=number[self.edges[kept_edges]],
            vertex_attributes={name: values[vertices] for name, values in self.vertex_attributes.items()},
            face_attributes={name: values[kept_faces] for name, values in self.face_attributes.items()},
            vertex_ids=source_ids(self.vertex_ids, len(self.vertices))[vertices],
            face_ids=source_ids(self.face_ids, len(self.faces))[kept_faces],
            edge_ids=source_ids(self.edge_ids, len(self.edges))[kept_edges],
        )

    def document(self, kind: type[_T]) -> _T | None:
        """Returns what the reader keeps for the writer in `Source.document`; None if it is not of type `kind`."""
        document = None if self.source is None else self.source.document
        return document if isinstance(document, kind) else None

    def without_matrix(self) -> MeshData:
        """If there is a matrix, applies it to coordinates and vertex normals, and removes stored face normals."""
        if self.matrix is None:
            return self
        turn, normals = self.matrix[:3, :3], self.vertex_attributes.get("normals")
        inverse = np.cross(turn[[1, 2, 0]], turn[[2, 0, 1]]).T / (np.linalg.det(turn) or 1.0)  # or the adjugate, if singular
        if normals is not None:
            normals = unit_vectors(normals @ inverse) * np.linalg.norm(normals, axis=1, keepdims=True)  # each keeps its length
        turned = self.with_attributes({"normals": normals}, {"normals": None})
        return replace(turned, vertices=self.vertices @ turn.T + self.matrix[:3, 3], matrix=None)

    @property
    def writes_normals(self) -> bool:
        """Whether files get vertex normals. Without faces they cannot be computed, so they are written only if they are there."""
        return self.keeps_normals if len(self.faces) else "normals" in self.vertex_attributes

    @cached_property
    def vertex_normals(self) -> Floats:
        """(n, 3) the attribute ``normals``, else angle-weighted means of the face normals; 0 without faces."""
        if (normals := self.vertex_attributes.get("normals")) is not None:
            return normals
        return _frozen(vertex_normals_by_angle(self.vertices, self.faces))

    @cached_property
    def face_normals(self) -> Floats:
        """(m, 3) the attribute ``normals``, else unit normals computed from the faces; 0 for a face without area."""
        if (normals := self.face_attributes.get("normals")) is not None:
            return normals
        return _frozen(face_normals(self.vertices, self.faces))

    @property
    def vertex_selection(self) -> Bools:
        """(n,) the selected vertices."""
        return self.vertex_attributes.get("selection", _frozen(np.zeros(len(self.vertices), np.bool_)))

    @property
    def face_selection(self) -> Bools:
        """(m,) the selected faces."""
        return self.face_attributes.get("selection", _frozen(np.zeros(len(self.faces), np.bool_)))

    @property
    def vertex_scalars(self) -> Floats:
        """(n,) the scalars; 0 if the mesh has none, as in MeshLab."""
        return self.vertex_attributes.get("scalars", _frozen(np.zeros(len(self.vertices))))

    @property
    def face_scalars(self) -> Floats:
        """(m,) the scalars of the faces; raises `MeshError` if there are none."""
        return self._face_attribute("scalars")

    @property
    def vertex_colors(self) -> Floats:
        """(n, 4) from 0 to 1; white if the mesh has none, as in MeshLab."""
        colors = self.vertex_attributes.get("colors")
        return _frozen(np.ones((len(self.vertices), 4)) if colors is None else colors / 255.0)

    @property
    def face_colors(self) -> Floats:
        """(m, 4) from 0 to 1; raises `MeshError` if there are none."""
        return _frozen(self._face_attribute("colors") / 255.0)

    has_vertex_scalars = property(lambda self: "scalars" in self.vertex_attributes)
    has_vertex_colors = property(lambda self: "colors" in self.vertex_attributes)
    has_face_scalars = property(lambda self: "scalars" in self.face_attributes)
    has_face_colors = property(lambda self: "colors" in self.face_attributes)
    has_wedge_tex_coords = property(lambda self: "wedge_texture_coordinates" in self.face_attributes)

    def _face_attribute(self, name: str) -> Array:
        if name not in self.face_attributes:
            raise MeshError(f"the mesh {self.label!r} has no face {name}")
        return self.face_attributes[name]

    @cached_property
    def diagonal(self) -> float:
        """The diagonal of the bounding box."""
        if not len(self.vertices):
            return 0.0
        extent = self.vertices.max(axis=0) - self.vertices.min(axis=0)
        with np.errstate(over="ignore", under="ignore"):
            diagonal = float(np.linalg.norm(extent))
        return diagonal if 1e-140 < diagonal < 1e140 else math.hypot(*extent)  # other squares may overflow or underflow

    @cached_property
    def mean_edge(self) -> float:
        """The mean edge length of the faces, else of the polylines, else the mean distance of a point to its nearest point."""
        from ..filters.neighbours import nearest_neighbours

        if len(self.faces) or len(self.edges):
            return float(mean_edge_length(self.vertices, self.faces if len(self.faces) else self.edges))
        return float(nearest_neighbours(self.vertices, 1)[0].mean()) if len(self.vertices) > 1 else 0.0

    def selected_vertices(self) -> Bools:
        """Returns (n,) the selected vertices, else those whose faces are all selected; raises `MeshError` if there are none."""
        vertices, faces, chosen, n = self.vertex_selection, self.faces, self.face_selection, len(self.vertices)
        if vertices.any() or (vertices := mask_of(faces[chosen], n) & ~mask_of(faces[~chosen], n)).any():
            return vertices
        raise MeshError(
            f"nothing is selected in {self.label!r}: select vertices, or triangles on all sides of them, or use selected=False"
        )


class LazyAttributes(UserDict[str, Any]):
    """Attributes by name; a value that is a function is called once, at the first access."""

    def __getitem__(self, name: str) -> Array:
        if callable(read := self.data[name]):
            self.data[name] = _frozen(read())
        array: Array = self.data[name]
        return array


class View:
    """A mesh as the `Layer` that a filter reads; `find` returns the mesh of another layer by its id."""

    def __init__(self, mesh: MeshData, find: Callable[[int], MeshData]) -> None:
        self._mesh, self._find = mesh, find

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mesh, name)

    def other(self, mesh_id: int) -> Any:
        """Returns another layer in the coordinates of this one."""
        mesh, own = self._find(mesh_id), self._mesh.matrix
        if not np.array_equal(own, mesh.matrix):  # type: ignore[arg-type]
            place, here = (np.eye(4) if matrix is None else matrix for matrix in (mesh.matrix, own))
            try:
                to_here = np.linalg.solve(here, place).astype(np.float64)
            except np.linalg.LinAlgError as error:
                advice = "apply the matrix (apply_matrix_freeze) or replace it (set_matrix)"
                raise MeshError(f"the matrix of the layer {self._mesh.label!r} has no inverse: {advice}") from error
            mesh = replace(replace(mesh, matrix=to_here).without_matrix(), matrix=own)
        return View(mesh, self._find)


def read_pixels(texture: Texture) -> NDArray[np.uint8] | None:
    """Returns (height, width, 3) pixels of a texture, the top row first; None if no image can be read."""
    from PIL import Image, UnidentifiedImageError

    if texture.image is None:
        return None
    try:
        with Image.open(io.BytesIO(texture.image) if isinstance(texture.image, bytes) else texture.image) as image:
            return np.asarray(image.convert("RGB"))
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError):
        return None


def sampled(pixels: NDArray[np.uint8], uv: Floats) -> Floats:
    """Returns (k, 3) colours from 0 to 1 of the pixels nearest to (k, 2) texture coordinates; images repeat, NaN counts as 0."""
    height, width = pixels.shape[:2]
    u, v = np.nan_to_num(uv).T
    column = np.minimum((u % 1.0 * width).astype(np.intp), width - 1)
    row = np.minimum(((1.0 - v) % 1.0 * height).astype(np.intp), height - 1)
    return np.asarray(pixels[row, column] / 255.0)


def source_ids(ids: NDArray[np.int64] | None, count: int) -> NDArray[np.int64]:
    """Returns the indices of `count` elements in the source: `ids`, or 0 to `count` - 1 if it is None."""
    return np.arange(count) if ids is None else ids


def _changed(attributes: Mapping[str, Array], changes: Mapping[str, Array | None]) -> dict[str, Array]:
    return {name: value for name, value in {**attributes, **changes}.items() if value is not None}


def _frozen(array: Array) -> Array:
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view
