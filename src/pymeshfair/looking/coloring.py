"""What the colours of a picture can say about a mesh."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..declaration import Floats
from ..errors import MeshError
from ..filters.inspection import (
    Limits,
    displacement,
    diverging_colors,
    gaussian_curvature,
    mean_curvature,
    robust_limits,
    sequential_colors,
    symmetric_limits,
    triangle_shapes,
)
from ..mesh_data import MeshData


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers on the vertices or faces of one mesh.

    Attributes:
        values: (n,) or (m,).
        by_face: whether they belong to faces.
    """

    values: Floats
    by_face: bool = False


@dataclass(frozen=True)
class Coloring:
    """A measure that becomes a colour.

    Attributes:
        label: what stands at the colour bar.
        of: the numbers of a mesh, given a reference as well; None where the mesh has none.
        diverging: whether 0 is the middle, and has the middle colour.
        limits: the ends of the colour bar, where they do not follow from the numbers.
    """

    label: str
    of: Callable[[MeshData, MeshData], Numbers | None]
    diverging: bool
    limits: Limits | None = None

    def limits_for(self, numbers: Sequence[Numbers]) -> Limits:
        """The ends of one colour bar for several meshes."""
        if self.limits is not None:
            return self.limits
        values = np.concatenate([n.values for n in numbers])
        return symmetric_limits(values) if self.diverging else robust_limits(values)

    def colors(self, values: Floats, limits: Limits) -> Floats:
        """(k, 3) red, green, blue from 0 to 1."""
        return (diverging_colors if self.diverging else sequential_colors)(values, limits)[:, :3]


def _moved(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh is reference:
        return None
    return Numbers(displacement(mesh.vertices, mesh.faces, reference.vertices, reference.faces).signed)


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
    "displacement": Coloring("displacement from the first mesh (mesh units)", _moved, diverging=True),
    "shape": Coloring(
        "triangle shape (1: equilateral)",
        lambda mesh, _: Numbers(triangle_shapes(mesh.vertices, mesh.faces), by_face=True),
        diverging=False,
        limits=Limits(0.0, 1.0),
    ),
    "scalar": Coloring("scalar", _scalar, diverging=False),
}


def numbers_of(coloring: str, meshes: Sequence[MeshData], *, left_out: Container[int] = ()) -> list[Numbers | None]:
    """The numbers of each mesh; the first one is the reference. Those that are left out have none.

    Raises:
        MeshError: no mesh has such numbers.
    """
    found = [None if k in left_out else COLORINGS[coloring].of(mesh, meshes[0]) for k, mesh in enumerate(meshes)]
    if not any(found):
        why = "it takes a second mesh, which is compared with the first" if coloring == "displacement" else "the meshes have none"
        raise MeshError(f"nothing to colour by {coloring}: {why}")
    return found
