"""A pymeshlab mesh as the `Layer` that a filter reads, and MeshLab's filters applied silently, outside the filter script.

Arrays come into a mesh as custom attributes, where MeshLab's "by function" filters can read them. pymeshlab can add one, but
neither change nor remove it, so every array takes 8 bytes an element as long as the process lasts. Point attributes are never
used: MeshLab reads freed memory for them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import chain, combinations, islice, product
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Floats
from ..errors import MeshError
from ..mesh_data import MeshData, View, as_levels
from ..mesh_data.mesh_data import ReadWhenAsked
from ..meshlab.base import BASE, MESHLAB, UnknownLayerError, apply_filter

#: A morph is s + (t - s) in floating point; from what the first leaves over, the second reaches t exactly.
_MOST_MORPHS = 3
_KINDS = {"selection": "selection_array", "scalars": "scalar_array", "colors": "color_matrix", "normals": "normal_matrix"}
#: by the names of `Layer`, pymeshlab's method that gives an array
_ARRAYS = {
    **{"vertices": "vertex_matrix", "faces": "face_matrix", "edges": "edge_matrix"},
    **{f"{element}_{kind}": f"{element}_{method}" for kind, method in _KINDS.items() for element in ("vertex", "face")},
}
Element: TypeAlias = Literal["vertex", "face"]
ELEMENTS: tuple[Element, Element] = ("vertex", "face")
#: every helper attribute's name begins with this
PREFIX = "pymeshfair_helper_"
#: MeshLab's names of custom attributes as parameters of saving begin with these
SAVED_AS: dict[str, str] = {"vertex": "__ca_vs__", "face": "__ca_fs__"}
_POINTS_SAVED_AS: dict[str, str] = {"vertex": "__ca_vp__", "face": "__ca_fp__"}
#: Names that can stand in an expression, apart from constants of muParser and the variables of MeshLab that a write-back uses.
_WORD = re.compile("[A-Za-z_][A-Za-z0-9_]*")
_TAKEN: dict[Element, set[str]] = {
    "vertex": {"_pi", "_e", "vi", "x", "y", "z", "nx", "ny", "nz"},
    "face": {"_pi", "_e", "fi", "ti"},
}
#: How many spellings of each kind are tried, ten microseconds each; enough for every one of a name of twelve letters.
_MOST_SPELLINGS = 2**12


def read_array(mesh: Any, name: str) -> NDArray[Any]:
    """One of the arrays of `Layer`, copied, C-contiguous; normals of faces are right only without a matrix (`matrix_aside`)."""
    try:
        return np.ascontiguousarray(getattr(mesh, _ARRAYS[name])())
    except pymeshlab.MissingCompactnessException:
        # Deleted elements still have their places, as in a mesh edited through other bindings; MeshLab itself compacts
        # after each filter.
        mesh.compact()
        return np.ascontiguousarray(getattr(mesh, _ARRAYS[name])())


def check_taken(mesh: Any, now: NDArray[Any], wanted: NDArray[Any], what: str) -> None:
    """Raise `MeshError` if MeshLab has not made an array of a mesh exactly the wanted one."""
    if not np.array_equal(now, wanted, equal_nan=now.dtype.kind == "f"):
        raise MeshError(f"MeshLab did not take the {what} of {mesh.label()!r} exactly; please report this mesh")


def attributes_of(mesh: Any, element: str) -> dict[str, NDArray[Any]]:
    """The colours, scalars and selection of vertices or faces, as far as there are any, as `MeshData` has them."""
    return {name: read() for name, read in _readers(mesh, element).items()}


def _readers(mesh: Any, element: str) -> dict[str, Callable[[], NDArray[Any]]]:
    readers: dict[str, Callable[[], NDArray[Any]]] = {}
    if getattr(mesh, f"has_{element}_color")():
        readers["colors"] = lambda: as_levels(read_array(mesh, f"{element}_colors"))
    if getattr(mesh, f"has_{element}_scalar")():
        readers["scalars"] = partial(read_array, mesh, f"{element}_scalars")
    if getattr(mesh, f"selected_{element}_number")():
        readers["selection"] = partial(read_array, mesh, f"{element}_selection")
    return readers


def wedges_of(mesh: Any) -> Any:
    """(m, 3, 2) the texture coordinates of the corners of faces, None if there are none."""
    return mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2) if mesh.has_wedge_tex_coord() else None


class Workbench:
    """Reads the layers of a mesh set, and applies MeshLab's filters outside its script and without output on the screen.

    It calls the methods of `pymeshlab.MeshSet` itself, never those of a subclass.

    Attributes:
        meshset: the mesh set; any `pymeshlab.MeshSet` serves.
        helper_ids: ids that MeshLab has given to helper layers, ascending. MeshLab never gives an id twice, so every helper layer
            leaves a gap behind.
        verbose: whether the mesh set reports its own filters on the screen; those applied here are silent.
        prints_parameters: the same for their parameters alone.
    """

    def __init__(self, meshset: Any, *, verbose: bool = False) -> None:
        self.meshset = meshset
        self.helper_ids: list[int] = []
        self.verbose = verbose
        self.prints_parameters = False

    def has_current(self) -> bool:
        """Whether the mesh set has a current layer."""
        try:
            BASE.current_mesh_id(self.meshset)
        except pymeshlab.PyMeshLabException:
            return False
        return True

    def current(self) -> View:
        """The current layer as it is now; an empty one if there is none."""
        has_none = MeshData(vertices=np.empty((0, 3)))
        return View(self._read(BASE.current_mesh(self.meshset)) if self.has_current() else has_none, self._find)

    def _find(self, mesh_id: int) -> MeshData:
        self.check(mesh_id)
        return self._read(BASE.mesh(self.meshset, mesh_id))

    def _read(self, mesh: Any) -> MeshData:
        """A layer whose attributes are read when they are first asked for, so that it serves until the mesh changes."""
        vertex, face = _readers(mesh, "vertex"), _readers(mesh, "face")

        def face_normals() -> NDArray[Any]:
            with self.matrix_aside(mesh):
                return read_array(mesh, "face_normals")

        vertex["normals"], face["normals"] = partial(read_array, mesh, "vertex_normals"), face_normals
        if mesh.has_wedge_tex_coord():
            face["wedge_texture_coordinates"] = partial(wedges_of, mesh)
        return MeshData(
            vertices=read_array(mesh, "vertices"),
            faces=read_array(mesh, "faces"),
            edges=read_array(mesh, "edges"),
            vertex_attributes=ReadWhenAsked(vertex),
            face_attributes=ReadWhenAsked(face),
            label=mesh.label(),
        )

    def check(self, mesh_id: int, where: str = "") -> None:
        """Raise `UnknownLayerError`, its message beginning with `where`, if there is no layer of that id."""
        if mesh_id >= 0 and BASE.mesh_id_exists(self.meshset, mesh_id):
            return
        there = ", ".join(f"{m.id()} {m.label()!r}" for m in BASE.__iter__(self.meshset)) or "none"
        gaps = "; ids skip numbers, see current_mesh_id() after a layer is made" if self.helper_ids else ""
        raise UnknownLayerError(f"{where}there is no layer {mesh_id} in the mesh set (it has {there}{gaps})")

    def apply(self, filter_name: str, /, **parameters: Any) -> dict[str, Any]:
        """Apply a filter of MeshLab to the current layer; its report."""
        with MESHLAB:
            BASE.set_verbosity(self.meshset, False)
            BASE.set_parameter_verbosity(self.meshset, False)
            try:
                return apply_filter(self.meshset, filter_name, parameters, verbose=False)
            finally:
                BASE.set_verbosity(self.meshset, self.verbose)
                BASE.set_parameter_verbosity(self.meshset, self.prints_parameters)

    @contextmanager
    def helper_layer(self, mesh: Any) -> Iterator[int]:
        """Another layer for as long as the context lasts; gives its id. The current layer stays the current one."""
        current = BASE.current_mesh_id(self.meshset)
        BASE.add_mesh(self.meshset, mesh, "", False)
        helper: int = [m.id() for m in BASE.__iter__(self.meshset)][-1]
        self.helper_ids.append(helper)
        try:
            yield helper
        finally:
            BASE.set_current_mesh(self.meshset, helper)
            self.apply("delete_current_mesh")
            BASE.set_current_mesh(self.meshset, current)

    def move_to(self, mesh: Any, places: NDArray[np.float64]) -> None:
        """Move the vertices of the current layer, a mesh with faces, to (n, 3) places; raise `MeshError` unless exactly there."""
        with self.helper_layer(pymeshlab.Mesh(vertex_matrix=places)) as target:
            for _ in range(_MOST_MORPHS):
                self.apply("compute_coord_linear_morphing", targetmesh=target, percentmorph=100)
                if np.array_equal(read_array(mesh, "vertices"), places):
                    return
        check_taken(mesh, read_array(mesh, "vertices"), places, "new vertices")

    @contextmanager
    def matrix_aside(self, mesh: Any) -> Iterator[None]:
        """A layer without its matrix in the context: pymeshlab applies it to normals of faces, and to these alone."""
        matrix = mesh.transform_matrix()
        self.set_matrix(mesh, np.eye(4))
        try:
            yield
        finally:
            self.set_matrix(mesh, matrix)

    def set_matrix(self, mesh: Any, matrix: NDArray[np.float64]) -> None:
        """Give a layer a matrix, unless it has it."""
        if np.array_equal(mesh.transform_matrix(), matrix):
            return
        current = BASE.current_mesh_id(self.meshset)
        BASE.set_current_mesh(self.meshset, mesh.id())
        self.apply("set_matrix", transformmatrix=matrix, compose=False, freeze=False)
        BASE.set_current_mesh(self.meshset, current)

    def without_helpers(self, mesh_id: int) -> int:
        """The id that a layer would have without helper layers: the one for scripts."""
        return mesh_id - sum(helper < mesh_id for helper in self.helper_ids)

    def with_helpers(self, mesh_id: int) -> int:
        """The layer's id in this mesh set, from the one in a script; undoes `without_helpers`."""
        for helper in self.helper_ids:
            if helper <= mesh_id:
                mesh_id += 1
        return mesh_id


def bring_in(bench: Workbench, mesh: Any, element: Element, arrays: Sequence[Floats]) -> list[str]:
    """The names of new helper attributes of the current layer with these arrays of one number an element each."""
    start = sum(name.startswith(PREFIX) for name in saved_attributes(bench.meshset, SAVED_AS[element]))
    names = [f"{PREFIX}{i}" for i in range(start, start + len(arrays))]
    for name, values in zip(names, arrays, strict=True):
        getattr(mesh, f"add_{element}_custom_scalar_attribute")(np.ascontiguousarray(values, dtype=np.float64), name)
    return names


def without_helpers(parameters: dict[str, Any]) -> dict[str, Any]:
    """The parameters of saving a file without those that stand for helper attributes."""
    ours = tuple(prefix + PREFIX for prefix in SAVED_AS.values())
    return {name: value for name, value in parameters.items() if not name.startswith(ours)}


def saved_attributes(meshset: Any, prefix: str) -> list[str]:
    """The custom attributes of the current layer of one kind; MeshLab lists them as parameters of saving a PLY file."""
    offered = BASE.filter_parameter_values(meshset, "ply")
    return [key.removeprefix(prefix) for key in offered if key.startswith(prefix)]


def check_names(bench: Workbench, mesh: Any) -> None:
    """Raise `MeshError` if the name of a custom attribute keeps MeshLab from computing on the current layer."""
    for element, listed, points, name in _own(bench, mesh):
        if name is None or not _WORD.fullmatch(name) or (not points and name in _TAKEN[element]):
            raise MeshError(
                f"{mesh.label()!r} cannot be changed because of the name of its custom {element} attribute {name or listed!r}: "
                "MeshLab computes with names of the letters a to z, digits and _, no digit first, that are no words of its "
                "expressions; save the mesh without it, or give it another name"
            )


def clear_beyond(bench: Workbench, mesh: Any, element: Element, kept: int) -> None:
    """Set custom attributes, whose names were checked, to 0 from element `kept` on, where MeshLab leaves undefined values."""
    for of, name, values in list(custom_attributes(bench, mesh)):
        if of != element or not values[kept:].any():
            continue
        if values.ndim == 1:
            expression = f"{'vi' if element == 'vertex' else 'fi'}<{kept}?{name}:0"
            bench.apply(f"compute_new_custom_scalar_attribute_per_{element}", name=name, expr=expression)
        else:
            values[kept:] = 0.0
            x, y, z = bring_in(bench, mesh, element, list(values.T))
            bench.apply(f"compute_new_custom_point_attribute_per_{element}", name=name, x_expr=x, y_expr=y, z_expr=z)


def custom_attributes(bench: Workbench, mesh: Any) -> Iterator[tuple[Element, str, Floats]]:
    """The custom attributes of the current layer, `mesh`, with their names and values: (n,) or, of points, (n, 3)."""
    for element, _, points, name in _own(bench, mesh):
        if name is not None:
            yield element, name, _reader(mesh, element, points=points)(name)


def _own(bench: Workbench, mesh: Any) -> Iterator[tuple[Element, str, bool, str | None]]:
    """Custom attributes except helpers: element, name as MeshLab lists it, whether its values are points, exact name or None."""
    for element in ELEMENTS:
        for points, prefixes in ((False, SAVED_AS), (True, _POINTS_SAVED_AS)):
            for listed in saved_attributes(bench.meshset, prefixes[element]):
                if points or not listed.startswith(PREFIX):
                    yield element, listed, points, _spelled(_reader(mesh, element, points=points), listed)


def _reader(mesh: Any, element: Element, *, points: bool) -> Callable[[str], Floats]:
    kind = "point_attribute_matrix" if points else "scalar_attribute_array"
    read: Callable[[str], Floats] = getattr(mesh, f"{element}_custom_{kind}")
    return read


def _spelled(read: Callable[[str], Floats], listed: str) -> str | None:
    """The exact name of an attribute that MeshLab lists in lower case with _ for blanks and hyphens; None if no spelling fits."""
    words = [(word, word.capitalize(), word.upper()) for word in listed.split("_")]
    letters = [place for place, letter in enumerate(listed) if letter != letter.upper()]
    capitals = chain.from_iterable(combinations(letters, count) for count in range(1, len(letters) + 1))
    few = ("".join(c.upper() if k in chosen else c for k, c in enumerate(listed)) for chosen in capitals)
    of_words = (map(separator.join, product(*words)) for separator in "_ -")
    for name in chain.from_iterable(islice(spellings, _MOST_SPELLINGS) for spellings in (*of_words, few)):
        try:
            read(name)
        except pymeshlab.PyMeshLabException:
            continue
        return name
    return None
