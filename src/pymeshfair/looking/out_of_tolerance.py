"""The areas of a surface that lie out of a tolerance: where, how large, and by how much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..filters.inspection import SurfaceDistance
from ..filters.topology import connected_components
from ..mesh_data import MeshData


@dataclass(frozen=True)
class Area:
    """A part of a surface that lies out of the tolerance; its faces share vertices.

    Attributes:
        mesh: "after", or "before" of what the second mesh does not have.
        place: (x, y, z) where it lies furthest from the other surface.
        amount: how far that is, above 0 on the outer side of the other surface; in mesh units, as the next one.
        size: the diagonal of its box.
        area: of it, in square mesh units.
    """

    mesh: str
    place: tuple[float, float, float]
    amount: float
    size: float
    area: float


def areas_out_of_tolerance(name: str, mesh: MeshData, distance: SurfaceDistance, tolerance: float, area: float) -> list[Area]:
    """The parts of a surface whose samples lie further from another one than the tolerance, the furthest first.

    Args:
        name: of the mesh, for `Area.mesh`.
        mesh: the mesh. In a cloud every point is a part.
        distance: of it from the other surface.
        tolerance: in mesh units.
        area: of the mesh.
    """
    over = np.flatnonzero(np.abs(distance.distances) > tolerance)
    if not len(over):
        return []
    if len(mesh.faces):
        faces, row = np.unique(distance.faces[over], return_inverse=True)
        parts, _ = connected_components(mesh.faces[faces], len(mesh.vertices))
        part = parts[mesh.faces[faces, 0]][row]
    else:
        part = np.arange(len(over))
    order = np.lexsort((-np.abs(distance.distances[over]), part))
    starts = np.flatnonzero(np.diff(part[order], prepend=-1))
    found = []
    for rows in np.split(over[order], starts[1:]):
        places = distance.places[rows]
        x, y, z = places[0].tolist()
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        share = float(distance.weights[rows].sum())
        found.append(Area(name, (x, y, z), float(distance.distances[rows[0]]), size, share * area))
    return sorted(found, key=lambda a: -abs(a.amount))
