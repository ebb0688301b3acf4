"""Everything that a pymeshlab mesh holds, to be compared property by property."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from pymeshfair.declaration import Edit, FilterClass, Layer, mesh_filter
from pymeshfair.meshset import MeshSet
from pymeshfair.scripts import Step

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"

#: arrays of a mesh by what they have a row for
PER_VERTEX = ("vertices", "vertex_normals", "vertex_selection", "vertex_scalars", "vertex_colors", "vertex_uv", "va_s", "va_p")
PER_FACE = ("faces", "face_normals", "face_selection", "face_scalars", "face_colors", "wedge_uv", "fa_s", "fa_p")
NORMALS = {"vertex_normals", "face_normals"}


def sample(name: str) -> str:
    """The path of one of the meshes that the pymeshlab wheel carries."""
    return str(SAMPLES / name)


def add_attributes(mesh: Any, seed: int = 0) -> None:
    """Give the mesh custom attributes of the four kinds, named as `everything` expects them."""
    random = np.random.default_rng(seed)
    n, m = mesh.vertex_number(), mesh.face_number()
    mesh.add_vertex_custom_scalar_attribute(random.normal(size=n), "va_s")
    mesh.add_vertex_custom_point_attribute(random.normal(size=(n, 3)), "va_p")
    if m:
        mesh.add_face_custom_scalar_attribute(random.normal(size=m), "fa_s")
        mesh.add_face_custom_point_attribute(random.normal(size=(m, 3)), "fa_p")


def everything(meshes: MeshSet) -> dict[str, Any]:
    """What the current mesh holds, by name; what it lacks is absent."""
    mesh = pymeshlab.MeshSet.current_mesh(meshes)
    m = mesh.face_number()
    found: dict[str, Any] = {
        "id": mesh.id(),
        "label": mesh.label(),
        "visible": mesh.is_visible(),
        "matrix": mesh.transform_matrix(),
        "textures": {name: (image.width(), image.height()) for name, image in mesh.textures().items()},
        "vertices": mesh.vertex_matrix(),
        "faces": mesh.face_matrix(),
        "edges": mesh.edge_matrix(),
        "vertex_normals": mesh.vertex_normal_matrix(),
        "face_normals": mesh.face_normal_matrix(),
        "vertex_selection": mesh.vertex_selection_array(),
        "face_selection": mesh.face_selection_array(),
        "vertex_scalars": mesh.vertex_scalar_array(),
        "vertex_colors": mesh.vertex_color_array(),
    }
    if mesh.has_face_scalar():
        found["face_scalars"] = mesh.face_scalar_array()
    if mesh.has_face_color():
        found["face_colors"] = mesh.face_color_array()
    if mesh.has_vertex_tex_coord():
        found["vertex_uv"] = mesh.vertex_tex_coord_matrix()
    if mesh.has_wedge_tex_coord():
        found["wedge_uv"] = mesh.wedge_tex_coord_matrix().reshape(m, 6)
    offered = pymeshlab.MeshSet.filter_parameter_values(meshes, "ply")
    readers = {
        "va_s": mesh.vertex_custom_scalar_attribute_array,
        "va_p": mesh.vertex_custom_point_attribute_matrix,
        "fa_s": mesh.face_custom_scalar_attribute_array,
        "fa_p": mesh.face_custom_point_attribute_matrix,
    }
    found |= {name: read(name) for name, read in readers.items() if any(key.endswith(f"__{name}") for key in offered)}
    return found


def differences(before: dict[str, Any], after: dict[str, Any], *, but: set[str] = frozenset()) -> list[str]:  # type: ignore[assignment]
    """The names under which two states differ, to the bit, other than those of `but`."""
    return sorted(name for name in (before.keys() | after.keys()) - but if not same(before.get(name), after.get(name)))


def same(one: Any, other: Any) -> bool:
    """Whether two properties are equal, NaN being equal to NaN."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        alike = one.shape == other.shape and one.dtype == other.dtype
        return alike and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return type(one) is type(other) and bool(one == other)


def wild(random: np.random.Generator, *shape: int) -> NDArray[np.float64]:
    """Numbers of both signs whose sizes go from 1e-9 to 1e9."""
    return random.normal(size=shape) * 10.0 ** random.integers(-9, 10, size=shape)


def give_back(edit: Edit) -> Step:
    """The step of a filter that gives this edit back, whatever mesh it meets."""

    @mesh_filter(name="Give Back", classes=FilterClass.OTHER)
    def give_back_edit(layer: Layer) -> Edit:
        """Gives an edit back."""
        return edit

    return Step(give_back_edit)
