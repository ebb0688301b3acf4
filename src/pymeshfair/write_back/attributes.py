"""Brings arrays into a mesh as custom attributes, where MeshLab's "by function" filters can read them, and reads those of others.

pymeshlab can add a custom attribute, but neither change nor remove one, so every array takes 8 bytes an element as long as the
process lasts. Point attributes are never used: MeshLab reads freed memory for them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, combinations, islice, product
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab

from ..declaration import Floats
from ..errors import MeshError
from ..meshlab.base import BASE
from .workbench import Workbench

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
    """Set the custom attributes of the current layer to 0 from element `kept` on, where MeshLab leaves undefined values.

    The layer has passed `check_names`.
    """
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
