"""Colorings: measures of a mesh that a picture shows as colours."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..declaration import Floats, nearest
from ..errors import MeshError, ParameterError
from ..filters.geometry import vector_lengths
from ..filters.inspection import (
    Limits,
    Surface,
    diverging_colors,
    gaussian_curvature,
    mean_curvature,
    robust_limits,
    sequential_colors,
    symmetric_limits,
    triangle_shapes,
)
from ..mesh_data import MeshData

#: the colour of distances within a tolerance, and where on the map, from the middle to an end, colours begin beyond it
_WITHIN, _BAND = (0.86, 0.90, 0.84), 0.3


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers on the vertices or faces of one mesh."""

    values: Floats  # (n,) or (m,)
    by_face: bool = False  # whether they belong to faces


@dataclass(frozen=True)
class Coloring:
    """A measure that becomes a colour."""

    label: str  # the text at the colour bar
    #: the numbers of a mesh, from the mesh and a reference; None where the mesh has none
    of: Callable[[MeshData, MeshData], Numbers | None]
    diverging: bool  # whether 0 is the middle, and has the middle colour
    limits: Limits | None = None  # the ends of the colour bar, where they do not follow from the numbers
    alone: str = "the meshes have none"  # why a mesh has no such numbers, in words

    def limits_for(self, numbers: Sequence[Numbers]) -> Limits:
        """The ends of one colour bar for several meshes."""
        if self.limits is not None:
            return self.limits
        values = np.concatenate([n.values for n in numbers])
        return symmetric_limits(values) if self.diverging else robust_limits(values)

    def colors(self, values: Floats, limits: Limits, tolerance: float = 0.0) -> Floats:
        """(k, 3) red, green, blue from 0 to 1 of (k,) numbers; diverging ones up to a tolerance have one colour."""
        if not self.diverging:
            return sequential_colors(values, limits)[:, :3]
        if not tolerance > 0.0:
            return diverging_colors(values, limits)[:, :3]
        high = max(limits.high, -limits.low)
        share = np.clip((np.abs(values) - tolerance) / max(high - tolerance, 1e-12 * tolerance), 0.0, 1.0)
        colors = diverging_colors(np.sign(values) * (_BAND + (1.0 - _BAND) * share), Limits(-1.0, 1.0))[:, :3]
        return np.where((np.abs(values) <= tolerance)[:, None], _WITHIN, colors)


def same_elements(first: MeshData, second: MeshData) -> bool:
    """Whether both have as many vertices and the same faces, so that vertices of the same number are the same."""
    return len(first.vertices) == len(second.vertices) and np.array_equal(first.faces, second.faces)


def in_unit(label: str, unit: str | None) -> str:
    """The label of a coloring with the unit of the scan in place of mesh units; unchanged without a unit."""
    return re.sub("mesh units?", unit, label) if unit else label


def _distance(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh is reference:
        return None
    return Numbers(Surface.of(reference.vertices, reference.faces).nearest(mesh.vertices).signed)


def _displacement(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh is reference or not same_elements(mesh, reference):
        return None
    return Numbers(vector_lengths(mesh.vertices - reference.vertices))


def _scalar(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh.has_vertex_scalars:
        return Numbers(mesh.vertex_scalars)
    return Numbers(mesh.face_scalars, by_face=True) if mesh.has_face_scalars else None


COLORINGS: Mapping[str, Coloring] = {
    "curvature": Coloring(
        "mean curvature (1 / mesh unit)", lambda mesh, _: Numbers(mean_curvature(mesh.vertices, mesh.faces)), diverging=True
    ),
    "gaussian": Coloring(
        "Gaussian curvature (1 / squared mesh unit)",
        lambda mesh, _: Numbers(gaussian_curvature(mesh.vertices, mesh.faces)),
        diverging=True,
    ),
    "distance": Coloring(
        "distance from the first surface (mesh units, outwards above 0)",
        _distance,
        diverging=True,
        alone="it takes a second mesh, whose distance from the surface of the first is shown",
    ),
    "displacement": Coloring(
        "displacement of the vertices (mesh units)",
        _displacement,
        diverging=False,
        alone="it takes a second mesh of the same vertices and faces as the first; 'distance' compares any two surfaces",
    ),
    "shape": Coloring(
        "triangle shape (1: equilateral)",
        lambda mesh, _: Numbers(triangle_shapes(mesh.vertices, mesh.faces), by_face=True),
        diverging=False,
        limits=Limits(0.0, 1.0),
    ),
    "scalar": Coloring("scalar", _scalar, diverging=False),
}


#: those that are no numbers: the colours of the mesh itself, and lines that follow from the direction of view
OTHERS = ("plain", "own", "reflection")


def check_coloring(name: str) -> None:
    """Raise `ParameterError` with the nearest name if there is no such coloring."""
    names = [*OTHERS, *COLORINGS]
    if name not in names:
        near = nearest(name, names)
        hint = f"did you mean {near!r}?" if near else f"it takes {', '.join(names)}"
        raise ParameterError(f"{name!r} is no coloring; {hint}")


def numbers_of(coloring: str, meshes: Sequence[MeshData]) -> list[Numbers | None]:
    """The numbers of each mesh; the first one is the reference."""
    numbers = [COLORINGS[coloring].of(mesh, meshes[0]) for mesh in meshes]
    if not any(numbers):
        raise MeshError(f"nothing to colour by {coloring}: {COLORINGS[coloring].alone}")
    return numbers
