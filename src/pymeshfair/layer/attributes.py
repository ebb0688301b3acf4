"""Brings arrays into a mesh as custom attributes, where MeshLab's "by function" filters can read them.

pymeshlab can add a custom attribute of given values, but neither change nor remove one, and it does not give back the memory
of one when its mesh goes (8 bytes a number). So at most `MOST` stay on a layer: when they are used up, `refill` overwrites them,
which takes longer. Point attributes are never used: MeshLab reads freed memory for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab

from ..declaration import Floats
from ..errors import MeshError
from .arrays import read_array
from .refill import refill_faces, refill_vertices
from .workbench import Workbench

Element: TypeAlias = Literal["vertex", "face"]

#: Every helper attribute's name begins with this.
PREFIX = "pymeshfair_helper_"
#: Most helper attributes for the vertices of a layer, and for its faces. A full edit needs nine, overwriting needs three more.
MOST = 12
#: As many of them are used up while others are overwritten.
SPARE = 3

_SAVED_AS: dict[Element, str] = {"vertex": "__ca_vs__", "face": "__ca_fs__"}
_POINTS_SAVED_AS: dict[Element, str] = {"vertex": "__ca_vp__", "face": "__ca_fp__"}


def bring_in(bench: Workbench, mesh: Any, element: Element, arrays: Sequence[Floats]) -> list[str]:
    """Helper attributes of the current layer that hold these arrays of one number a vertex (or face).

    Returns:
        The attributes' names; their values stay until the next call for the same kind of element.
    """
    if has_room(bench, element, len(arrays)):
        count = len(helper_names(bench, element))
        fresh = _names(count, count + len(arrays))
        add = mesh.add_vertex_custom_scalar_attribute if element == "vertex" else mesh.add_face_custom_scalar_attribute
        for name, values in zip(fresh, arrays, strict=True):
            add(np.ascontiguousarray(values, dtype=np.float64), name)
        return fresh
    filled = _names(SPARE, SPARE + len(arrays))
    if element == "face":
        refill_faces(bench, mesh, spare_names(), filled, arrays)
        return filled
    normals = read_array(mesh, "face_normals")
    refill_vertices(bench, mesh, spare_names(), filled, arrays)
    if not np.array_equal(read_array(mesh, "face_normals"), normals):
        x, y, z = bring_in(bench, mesh, "face", list(normals.T))
        bench.apply("compute_normal_by_function_per_face", x=x, y=y, z=z)
    return filled


def has_room(bench: Workbench, element: Element, count: int) -> bool:
    """Whether the current layer may get that many more helper attributes."""
    return len(helper_names(bench, element)) + count <= MOST


def spare_names() -> list[str]:
    """The helper attributes that hold normals while others are overwritten."""
    return _names(0, SPARE)


def _names(start: int, stop: int) -> list[str]:
    return [f"{PREFIX}{i}" for i in range(start, stop)]


def helper_names(bench: Workbench, element: Element) -> list[str]:
    """The helper attributes that the current layer has."""
    return [name for name in attribute_names(bench, element) if name.startswith(PREFIX)]


def attribute_names(bench: Workbench, element: Element) -> list[str]:
    """All custom scalar attributes of the current layer."""
    return _saved(bench, _SAVED_AS[element])


def _saved(bench: Workbench, prefix: str) -> list[str]:
    """The custom attributes of one kind; MeshLab tells them as parameters of saving a PLY file."""
    offered = pymeshlab.MeshSet.filter_parameter_values(bench.meshset, "ply")
    return [key.removeprefix(prefix) for key in offered if key.startswith(prefix)]


def clear_beyond(bench: Workbench, mesh: Any, element: Element, kept: int) -> None:
    """Make the custom attributes of the current layer 0 from element `kept` on, where MeshLab may leave anything."""
    index = {"vertex": "vi", "face": "fi"}[element]
    for name in attribute_names(bench, element):
        if name.startswith(PREFIX):
            continue
        if getattr(mesh, f"{element}_custom_scalar_attribute_array")(name)[kept:].any():
            new = f"{index}<{kept}?{name}:0"
            bench.apply(f"compute_new_custom_scalar_attribute_per_{element}", name=name, expr=new)
    for name in _saved(bench, _POINTS_SAVED_AS[element]):
        points = getattr(mesh, f"{element}_custom_point_attribute_matrix")(name)
        if points[kept:].any():
            points[kept:] = 0.0
            x, y, z = bring_in(bench, mesh, element, list(points.T))
            bench.apply(f"compute_new_custom_point_attribute_per_{element}", name=name, x_expr=x, y_expr=y, z_expr=z)


def without_helpers(parameters: dict[str, Any]) -> dict[str, Any]:
    """The parameters of saving a file without those that stand for helper attributes."""
    ours = tuple(prefix + PREFIX for prefix in _SAVED_AS.values())
    return {name: value for name, value in parameters.items() if not name.startswith(ours)}


def explain(bench: Workbench, error: Exception) -> MeshError:
    """What it means that one of MeshLab's "by function" filters failed during a write-back."""
    every = [name for element in _SAVED_AS for name in attribute_names(bench, element)]
    own = [name for name in every if not name.startswith(PREFIX)]
    if own and "unknown exception" in str(error):
        return MeshError(
            f"MeshLab cannot compute on this mesh, most likely because of its custom attributes ({', '.join(own)}): a name may "
            "have letters, digits and _, and no digit first; save the mesh without the one that has others"
        )
    return MeshError(f"MeshLab could not take the result: {error}")
