"""Brings arrays into a mesh as custom attributes, where MeshLab's "by function" filters can read them.

pymeshlab can add a custom attribute, but neither change nor remove one, and it does not free the memory of one
with its mesh (8 bytes a number). So a layer gets at most `MOST` of them: after that `refill` overwrites them, which takes longer.
Point attributes are never used: MeshLab reads freed memory for them.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, combinations, islice, product
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab

from ..declaration import Floats
from ..errors import MeshError
from ..meshlab.base import BASE
from .refill import PREFIX, SPARE, refill_faces, refill_vertices
from .workbench import Workbench, read_array

Element: TypeAlias = Literal["vertex", "face"]
ELEMENTS: tuple[Element, Element] = ("vertex", "face")

#: Most helper attributes for the vertices of a layer, and for its faces. A full edit needs nine, overwriting needs three more.
MOST = 12

#: MeshLab's names of custom attributes as parameters of saving begin with these
SAVED_AS: dict[str, str] = {"vertex": "__ca_vs__", "face": "__ca_fs__"}
_POINTS_SAVED_AS: dict[str, str] = {"vertex": "__ca_vp__", "face": "__ca_fp__"}


#: Names that can stand in an expression, apart from constants of muParser and the variables of MeshLab that a write-back uses.
_WORD = re.compile("[A-Za-z_][A-Za-z0-9_]*")
_TAKEN: dict[Element, set[str]] = {
    "vertex": {"_pi", "_e", "vi", "x", "y", "z", "nx", "ny", "nz"},
    "face": {"_pi", "_e", "fi", "ti", *(f"n{axis}{corner}" for axis in "xyz" for corner in range(3))},
}
_ALLOWED = "MeshLab computes with names of the letters a to z, digits and _, no digit first, that are no words of its expressions"
#: How many spellings of each kind are tried, ten microseconds each; enough for every one of a name of twelve letters.
_MOST_SPELLINGS = 2**12


def bring_in(bench: Workbench, mesh: Any, element: Element, arrays: Sequence[Floats]) -> list[str]:
    """The names of helper attributes of the current layer with these arrays of one number each; kept until the next call."""
    if has_room(bench, element, len(arrays)):
        count = len(helper_names(bench, element))
        fresh = _names(count, count + len(arrays))
        add = mesh.add_vertex_custom_scalar_attribute if element == "vertex" else mesh.add_face_custom_scalar_attribute
        for name, values in zip(fresh, arrays, strict=True):
            add(np.ascontiguousarray(values, dtype=np.float64), name)
        return fresh
    filled = _names(len(SPARE), len(SPARE) + len(arrays))
    if element == "face":
        refill_faces(bench, mesh, filled, arrays)
        return filled
    normals = read_array(mesh, "face_normals")
    refill_vertices(bench, mesh, filled, arrays)
    if not np.array_equal(read_array(mesh, "face_normals"), normals):
        x, y, z = bring_in(bench, mesh, "face", list(normals.T))
        bench.apply("compute_normal_by_function_per_face", x=x, y=y, z=z)
    return filled


def has_room(bench: Workbench, element: Element, count: int) -> bool:
    """Whether the current layer may get that many more helper attributes."""
    return len(helper_names(bench, element)) + count <= MOST


def _names(start: int, stop: int) -> list[str]:
    return [f"{PREFIX}{i}" for i in range(start, stop)]


def helper_names(bench: Workbench, element: Element) -> list[str]:
    """The helper attributes that the current layer has."""
    return [name for name in saved_attributes(bench.meshset, SAVED_AS[element]) if name.startswith(PREFIX)]


def saved_attributes(meshset: Any, prefix: str) -> list[str]:
    """The custom attributes of the current layer of one kind; MeshLab lists them as parameters of saving a PLY file."""
    offered = BASE.filter_parameter_values(meshset, "ply")
    return [key.removeprefix(prefix) for key in offered if key.startswith(prefix)]


def check_names(bench: Workbench, mesh: Any) -> None:
    """Raise `MeshError` if the name of a custom attribute keeps MeshLab from computing on the current layer."""
    for element, listed, points, name in _own(bench, mesh):
        if name is None or not _WORD.fullmatch(name) or (not points and name in _TAKEN[element]):
            raise MeshError(
                f"nothing can be added to {mesh.label()!r} because of the name of its custom {element} attribute "
                f"{name or listed!r}: {_ALLOWED}; save the mesh without it, or give it another name"
            )


def clear_beyond(bench: Workbench, mesh: Any, element: Element, kept: int) -> None:
    """Set the custom attributes of the current layer to 0 from element `kept` on, where MeshLab leaves undefined values.

    The layer has passed `check_names`.
    """
    index = {"vertex": "vi", "face": "fi"}[element]
    for of, _, points, name in list(_own(bench, mesh)):
        if of != element or name is None:
            continue
        values = _reader(mesh, element, points=points)(name)
        if not values[kept:].any():
            continue
        if points:
            values[kept:] = 0.0
            x, y, z = bring_in(bench, mesh, element, list(values.T))
            bench.apply(f"compute_new_custom_point_attribute_per_{element}", name=name, x_expr=x, y_expr=y, z_expr=z)
        else:
            new = f"{index}<{kept}?{name}:0"
            bench.apply(f"compute_new_custom_scalar_attribute_per_{element}", name=name, expr=new)


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
    read: Callable[[str], Floats] = getattr(
        mesh, f"{element}_custom_point_attribute_matrix" if points else f"{element}_custom_scalar_attribute_array"
    )
    return read


def _spelled(read: Callable[[str], Floats], listed: str) -> str | None:
    """The exact name of an attribute that MeshLab lists in lower case with _ for blanks and hyphens; None if no spelling fits."""
    for name in _spellings(listed):
        try:
            read(name)
        except pymeshlab.PyMeshLabException:
            continue
        return name
    return None


def _spellings(listed: str) -> Iterator[str]:
    """Names that MeshLab would list so: words with capitals first, then few capitals anywhere, then other separators."""
    words = [(word, word.capitalize(), word.upper()) for word in listed.split("_")]
    letters = [place for place, letter in enumerate(listed) if letter != letter.upper()]
    capitals = chain.from_iterable(combinations(letters, count) for count in range(1, len(letters) + 1))
    yield from islice(map("_".join, product(*words)), _MOST_SPELLINGS)
    for chosen in islice(capitals, _MOST_SPELLINGS):
        yield "".join(letter.upper() if place in chosen else letter for place, letter in enumerate(listed))
    for other in " -":
        yield from islice(map(other.join, product(*words)), _MOST_SPELLINGS)


def without_helpers(parameters: dict[str, Any]) -> dict[str, Any]:
    """The parameters of saving a file without those that stand for helper attributes."""
    ours = tuple(prefix + PREFIX for prefix in SAVED_AS.values())
    return {name: value for name, value in parameters.items() if not name.startswith(ours)}


def explain(bench: Workbench, error: Exception) -> MeshError:
    """The error to raise when one of MeshLab's "by function" filters has failed during a write-back."""
    mesh = BASE.current_mesh(bench.meshset)
    own = [name or listed for _, listed, _, name in _own(bench, mesh)]
    if own and "unknown exception" in str(error):
        return MeshError(
            f"MeshLab cannot compute on this mesh, most likely because of its custom attributes ({', '.join(map(repr, own))}): "
            f"{_ALLOWED}; save the mesh without the attribute that has another name"
        )
    return MeshError(f"MeshLab could not take the result: {error}")
