"""Copies arrays into a mesh as custom attributes, which MeshLab's "by function" filters can read.

pymeshlab can add a custom attribute, but cannot change, remove or free it. So the vertices of a layer get at most `MOST` helper
attributes, and its faces as many. Later calls overwrite helpers by way of vertex normals, which is slower: vertex i moves to
(i, 0, 0). A helper cloud has the same points, and the arrays as normals. "Transfer attributes" copies each normal to the vertex
at its point, and expressions copy normals to attributes. At the end coordinates and normals are restored. All steps are exact to
the bit. Helpers hold scalars only: from attributes of 3D points, MeshLab's expressions would read freed memory.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, combinations, islice, product
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Floats, Ints
from ..errors import MeshError
from ..meshlab.base import BASE
from .workbench import Workbench, read_array

Element: TypeAlias = Literal["vertex", "face"]
ELEMENTS: tuple[Element, Element] = ("vertex", "face")
PREFIX = "pymeshfair_helper_"
#: The largest number of helper attributes of a layer's vertices, and of its faces: nine for a full edit, three for overwriting.
MOST = 12
#: the helper attributes that hold normals while others are overwritten
_SPARE = tuple(f"{PREFIX}{i}" for i in range(3))
_AXES = ("nx", "ny", "nz")
#: prefixes of custom attributes among MeshLab's parameters for saving a file
SAVED_AS: dict[str, str] = {"vertex": "__ca_vs__", "face": "__ca_fs__"}
_POINTS_SAVED_AS: dict[str, str] = {"vertex": "__ca_vp__", "face": "__ca_fp__"}
#: Valid names in expressions of muParser, MeshLab's parser; and the names of its constants and of variables used in a write-back.
WORD = re.compile("[A-Za-z_][A-Za-z0-9_]*")
_TAKEN: dict[Element, set[str]] = {
    "vertex": {"_pi", "_e", "vi", "x", "y", "z", "nx", "ny", "nz"},
    "face": {"_pi", "_e", "fi", "ti", *(f"n{axis}{corner}" for axis in "xyz" for corner in range(3))},
}
#: The largest number of spellings of each kind that are tried: enough for every choice of capitals in a name of twelve letters.
_MOST_SPELLINGS = 2**12


def bring_in(bench: Workbench, mesh: Any, element: Element, arrays: Sequence[Floats]) -> list[str]:
    """Stores (n,) arrays in helper attributes of the current layer, and returns their names; the next call may overwrite them."""
    if has_room(bench, element, len(arrays)):
        fresh = _names(_count_helpers(bench, element), len(arrays))
        for name, values in zip(fresh, arrays, strict=True):
            getattr(mesh, f"add_{element}_custom_scalar_attribute")(np.ascontiguousarray(values, dtype=np.float64), name)
        return fresh
    filled = _names(len(_SPARE), len(arrays))
    if element == "face":
        _refill_faces(bench, mesh, filled, arrays)
        return filled
    normals = read_array(mesh, "face_normals")
    _refill_vertices(bench, mesh, filled, arrays)
    if not np.array_equal(read_array(mesh, "face_normals"), normals):
        x, y, z = bring_in(bench, mesh, "face", list(normals.T))
        bench.apply("compute_normal_by_function_per_face", x=x, y=y, z=z)
    return filled


def has_room(bench: Workbench, element: Element, count: int) -> bool:
    """Whether the current layer may get `count` more helper attributes."""
    return _count_helpers(bench, element) + count <= MOST


def _count_helpers(bench: Workbench, element: Element) -> int:
    return sum(name.startswith(PREFIX) for name in saved_attributes(bench.meshset, SAVED_AS[element]))


def _names(start: int, count: int) -> list[str]:
    return [f"{PREFIX}{i}" for i in range(start, start + count)]


def without_helpers(parameters: dict[str, Any]) -> dict[str, Any]:
    """Returns the parameters for saving a file without those of helper attributes."""
    ours = tuple(prefix + PREFIX for prefix in SAVED_AS.values())
    return {name: value for name, value in parameters.items() if not name.startswith(ours)}


def _refill_vertices(bench: Workbench, mesh: Any, names: Sequence[str], arrays: Sequence[Floats]) -> None:
    """Sets the vertex attributes `names` of the current layer to the arrays. Face normals become those of the geometry."""
    with _on_a_line(bench, mesh) as line:
        for first in range(0, len(arrays), 3):
            line.send(arrays[first : first + 3])
            _compute(bench, "vertex", dict(zip(names[first : first + 3], _AXES, strict=False)))


def _refill_faces(bench: Workbench, mesh: Any, names: Sequence[str], arrays: Sequence[Floats]) -> None:
    """Sets the face attributes `names` of the current layer to the arrays.

    A face reads its numbers from a corner: in each round every vertex carries the index and two numbers of one adjacent face.
    """
    faces = read_array(mesh, "faces")
    targets = [*zip(names, arrays, strict=False)]
    with _on_a_line(bench, mesh) as line:
        if line.face_normals is not None:
            targets += zip(_SPARE, line.face_normals.T, strict=True)
        for first in range(0, len(targets), 2):
            pair = targets[first : first + 2]
            _compute(bench, "face", {name: "0" for name, _ in pair})
            for carried in _rounds(faces, line.length):
                line.send([carried, *(values[carried] for _, values in pair)])
                expressions = {
                    n: f"nx0==fi?{a}0:(nx1==fi?{a}1:(nx2==fi?{a}2:{n}))" for (n, _), a in zip(pair, ("ny", "nz"), strict=False)
                }
                _compute(bench, "face", expressions)
    if line.face_normals is not None:
        bench.apply("compute_normal_by_function_per_face", **dict(zip("xyz", _SPARE, strict=True)))


def _rounds(faces: Ints, vertices: int) -> Iterator[NDArray[np.intp]]:
    """Yields for each round the face that each vertex carries, -1 for none, until each face was carried by one of its corners."""
    waiting: NDArray[np.intp] = np.arange(len(faces))
    while len(waiting):
        carried = np.full(vertices, -1, dtype=np.intp)
        for corner in range(3):
            at = faces[waiting, corner]
            free = carried[at] < 0
            carried[at[free]] = waiting[free]  # the last of several faces at a vertex wins
            waiting = waiting[carried[at] != waiting]
        yield carried


def _compute(bench: Workbench, element: Element, expressions: dict[str, str]) -> None:
    for name, expression in expressions.items():
        bench.apply(f"compute_new_custom_scalar_attribute_per_{element}", name=name, expr=expression)


def move_points(bench: Workbench, mesh: Any, points: Floats) -> None:
    """Moves the vertices of the current layer, which has no faces, and keeps their normals."""
    with _on_a_line(bench, mesh) as line:
        line.points = points


@contextmanager
def _on_a_line(bench: Workbench, mesh: Any) -> Iterator[_Line]:
    """Keeps the vertices of the current layer on a line while the context is open, then restores them; overwrites `_SPARE`."""
    line = _Line(bench, mesh)
    try:
        bench.apply("compute_coord_by_function", x="vi", y="0", z="0")
        yield line
    finally:
        if np.array_equal(read_array(mesh, "vertices"), line.places[:-1]):
            line.put_back()


class _Line:
    def __init__(self, bench: Workbench, mesh: Any) -> None:
        self._bench, self._id = bench, int(mesh.id())
        #: where the vertices were, and where `put_back` moves them
        self.points, self._normals = read_array(mesh, "vertices"), read_array(mesh, "vertex_normals")
        self.length = len(self.points)
        #: the face normals if they differ from those of the geometry, so that moving vertices loses them; else None
        self.face_normals: Floats | None = None
        if mesh.face_number():
            before = read_array(mesh, "face_normals")
            bench.apply("compute_coord_by_function", x="x", y="y", z="z")
            self.face_normals = None if np.array_equal(read_array(mesh, "face_normals"), before) else before
        # One point more than vertices: MeshLab's search never ends if the bounding box is a single point.
        self.places = np.eye(1, 3) * np.arange(self.length + 1.0)[:, None]

    def send(self, columns: Sequence[NDArray[Any]]) -> None:
        """Writes at most three columns of numbers into the normals of the vertices."""
        normals = np.zeros((self.length + 1, 3))
        for axis, values in enumerate(columns):
            normals[:-1, axis] = values
        cloud = pymeshlab.Mesh(vertex_matrix=self.places, v_normals_matrix=normals)
        parameters: dict[str, Any] = {
            f"{kind}transfer": kind == "normal" for kind in ("geom", "normal", "color", "quality", "selection")
        }
        with self._bench.helper_layer(cloud) as helper:
            parameters |= {"sourcemesh": helper, "targetmesh": self._id, "upperbound": pymeshlab.PureValue(0.5)}
            self._bench.apply("transfer_attributes_per_vertex", **parameters)

    def put_back(self) -> None:
        self.send(list(self._normals.T))
        _compute(self._bench, "vertex", dict(zip(_SPARE, _AXES, strict=True)))
        self.send(list(self.points.T))
        for filter_name, columns in (("compute_coord_by_function", _AXES), ("compute_normal_by_function_per_vertex", _SPARE)):
            self._bench.apply(filter_name, **dict(zip("xyz", columns, strict=True)))


def saved_attributes(meshset: Any, prefix: str) -> list[str]:
    """Lists the custom attributes of one kind in the current layer; MeshLab lists them as options for saving a PLY file."""
    return [key.removeprefix(prefix) for key in BASE.filter_parameter_values(meshset, "ply") if key.startswith(prefix)]


def check_names(bench: Workbench, mesh: Any) -> None:
    """Raises `MeshError` if the name of a custom attribute keeps MeshLab from computing on the current layer."""
    for element, listed, points, name in _user_attributes(bench.meshset, mesh):
        if name is None or not WORD.fullmatch(name) or (not points and name in _TAKEN[element]):
            reason = "MeshLab needs a name of the letters a to z, digits and _ that does not begin with a digit"
            reason += " and is no variable or constant of its expressions"
            if name is None:
                reason = "MeshLab does not tell which of its letters are capitals"
            raise MeshError(
                f"{mesh.label()!r} cannot be changed because of the name of its custom {element} attribute {name or listed!r}: "
                f"{reason}; save the mesh without the attribute, or rename the attribute"
            )


def clear_beyond(bench: Workbench, mesh: Any, element: Element, kept: int) -> None:
    """Sets custom attributes to 0 from element `kept` on, where MeshLab leaves undefined values; call `check_names` before."""
    for kind, name, values in list(custom_attributes(bench.meshset, mesh)):
        if kind != element or not values[kept:].any():
            continue
        if values.ndim == 1:
            _compute(bench, element, {name: f"{'vi' if element == 'vertex' else 'fi'}<{kept}?{name}:0"})
        else:
            values[kept:] = 0.0
            x, y, z = bring_in(bench, mesh, element, list(values.T))
            bench.apply(f"compute_new_custom_point_attribute_per_{element}", name=name, x_expr=x, y_expr=y, z_expr=z)


def custom_attributes(meshset: Any, mesh: Any, likely: Iterable[str] = ()) -> Iterator[tuple[Element, str, Floats]]:
    """Yields the user's custom attributes of the current layer, `mesh`: element, name and values, (n,), or (n, 3) for points.

    MeshLab does not tell the exact names: `likely` ones are tried first. Attributes whose name is not found are left out.
    """
    for element, _, points, name in _user_attributes(meshset, mesh, likely):
        if name is not None:
            yield element, name, _reader(mesh, element, points=points)(name)


def _user_attributes(meshset: Any, mesh: Any, likely: Iterable[str] = ()) -> Iterator[tuple[Element, str, bool, str | None]]:
    """Yields the user's custom attributes: element, name in MeshLab's list, whether values are points, exact name or None."""
    for element in ELEMENTS:
        for points, prefixes in ((False, SAVED_AS), (True, _POINTS_SAVED_AS)):
            for listed in saved_attributes(meshset, prefixes[element]):
                if points or not listed.startswith("pymeshfair_"):
                    yield element, listed, points, _spelled(_reader(mesh, element, points=points), listed, likely)


def _reader(mesh: Any, element: Element, *, points: bool) -> Callable[[str], Floats]:
    kind = "point_attribute_matrix" if points else "scalar_attribute_array"
    read: Callable[[str], Floats] = getattr(mesh, f"{element}_custom_{kind}")
    return read


def _spelled(read: Callable[[str], Floats], listed: str, likely: Iterable[str]) -> str | None:
    """Finds the exact name of an attribute, which MeshLab lists in lower case with _ for blanks and hyphens; None if unknown."""
    for name in chain((name for name in likely if re.sub("[ -]", "_", name.lower()) == listed), _spellings(listed)):
        try:
            read(name)
        except pymeshlab.PyMeshLabException:
            continue
        return name
    return None


def _spellings(listed: str) -> Iterator[str]:
    """Yields names that MeshLab lists as `listed`: words with capitals, then a few capitals anywhere, then other separators."""
    words = [(word, word.capitalize(), word.upper()) for word in listed.split("_")]
    letters = [place for place, letter in enumerate(listed) if letter != letter.upper()]
    capitals = chain.from_iterable(combinations(letters, count) for count in range(1, len(letters) + 1))
    yield from islice(map("_".join, product(*words)), _MOST_SPELLINGS)
    for chosen in islice(capitals, _MOST_SPELLINGS):
        yield "".join(letter.upper() if place in chosen else letter for place, letter in enumerate(listed))
    for other in " -":
        yield from islice(map(other.join, product(*words)), _MOST_SPELLINGS)
