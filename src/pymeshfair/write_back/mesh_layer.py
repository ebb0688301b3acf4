"""A pymeshlab mesh as the `Layer` that a filter reads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..declaration import Bools, Floats, Ints, Layer
from ..errors import MeshError
from ..mesh_data.mesh_data import Has, Measures
from .workbench import ARRAYS, Workbench, empty_array, read_array


class MeshLayer(Measures):
    """A pymeshlab mesh as a `Layer`.

    Arrays are read when first asked for and then kept, so a layer serves until the mesh changes.
    """

    vertices: Floats
    faces: Ints
    edges: Ints
    vertex_normals: Floats
    face_normals: Floats
    vertex_selection: Bools
    face_selection: Bools
    vertex_scalars: Floats
    face_scalars: Floats
    vertex_colors: Floats
    face_colors: Floats
    has_vertex_scalars, has_vertex_colors, has_face_scalars, has_face_colors = Has(), Has(), Has(), Has()

    def __init__(self, mesh: Any, bench: Workbench, other: Callable[[int], Layer]) -> None:
        """See the class; None reads as an empty mesh, and `other` gives another layer by its id."""
        self._mesh, self._bench, self.other = mesh, bench, other

    def __getattr__(self, name: str) -> Any:
        """Read an array; it is an attribute of the layer from then on."""
        if name not in ARRAYS:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if self._mesh is None:
            array = empty_array(name)
        elif name in ("face_scalars", "face_colors") and not self.has(name):
            raise MeshError(f"the mesh {self.label!r} has no {name.replace('_', ' ')}")
        elif name == "face_normals":
            with self._bench.matrix_aside(self._mesh):
                array = read_array(self._mesh, name)
        else:
            array = read_array(self._mesh, name)
        array.flags.writeable = False
        setattr(self, name, array)
        return array

    @property
    def label(self) -> str:
        return "" if self._mesh is None else str(self._mesh.label())

    @property
    def has_wedge_tex_coords(self) -> bool:
        return self._mesh is not None and bool(self._mesh.has_wedge_tex_coord())

    def has(self, name: str) -> bool:
        """Whether the mesh has an array, such as ``"vertex_scalars"``."""
        return self._mesh is not None and bool(getattr(self._mesh, f"has_{name[:-1]}")())
