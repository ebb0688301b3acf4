"""What lies between two meshes: how far each is from the other, and what was kept, lost, added and removed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..declaration import Floats, Ints
from ..filters.geometry import AREA, CENTRE, NORMAL, measure_faces
from ..filters.inspection import SHARP, Displacement, closest_points, displacement, share_kept
from .mesh_state import MeshState

#: mean edges of the first mesh: a place further than that from the other surface was added or removed
_APART = 1.0


@dataclass(frozen=True)
class LengthIn:
    """A length in three units.

    Attributes:
        mesh_units: as the coordinates have it.
        mean_edges: over the mean edge of the first mesh; None if it has none.
        percent_of_diagonal: over the diagonal of its bounding box; None if that is 0.
    """

    mesh_units: float
    mean_edges: float | None
    percent_of_diagonal: float | None


@dataclass(frozen=True)
class Moved:
    """How far the vertices of the second mesh lie from their counterparts on the first.

    Attributes:
        by_vertex: whether counterparts are the vertices of the same number, because both meshes have the same faces; otherwise
            they are the nearest places of the surface or, in a cloud, the nearest points.
        mean: of the distances.
        rms: the root of the mean of their squares.
        most: the distance that 95 % of them keep below.
        largest: of the distances.
        vertex: the vertex of the second mesh that has it.
        place: (x, y, z) of that vertex.
    """

    by_vertex: bool
    mean: LengthIn
    rms: LengthIn
    most: LengthIn
    largest: LengthIn
    vertex: int
    place: tuple[float, float, float]


@dataclass(frozen=True)
class Comparison:
    """Two meshes compared.

    Attributes:
        before: `MeshState.measures` of the first.
        after: those of the second.
        displacement: what has moved.
        after_from_before: the largest distance of a vertex of the second from the nearest place of the first.
        before_from_after: the other way round.
        hausdorff: the larger of the two.
        area_change: in percent, None without area before.
        volume_change: in percent, None unless both have a volume that is not 0.
        normal_deviation: the mean angle in degrees between the normals of the faces of the second mesh and of the first there,
            weighted with the area; None of clouds.
        largest_normal_deviation: in degrees.
        flipped_faces: faces of the second mesh that look away from where the first does there, by more than 90 degrees.
        sharp_edges_kept: the share of the length of the sharp edges of the first mesh within a mean edge of which the second has
            one; None if there were none.
        added_area: of faces of the second mesh whose middle is further than a mean edge from the first.
        removed_area: of faces of the first whose middle is further than a mean edge from the second.
        attributes_kept, attributes_lost, attributes_gained: what the meshes have.
        sharp_angle: degrees from which on an edge counts as sharp.
    """

    before: dict[str, Any]
    after: dict[str, Any]
    displacement: Moved
    after_from_before: LengthIn
    before_from_after: LengthIn
    hausdorff: LengthIn
    area_change: float | None
    volume_change: float | None
    normal_deviation: float | None
    largest_normal_deviation: float | None
    flipped_faces: int | None
    sharp_edges_kept: float | None
    added_area: float | None
    removed_area: float | None
    attributes_kept: tuple[str, ...]
    attributes_lost: tuple[str, ...]
    attributes_gained: tuple[str, ...]
    sharp_angle: float = SHARP


def compare(before: MeshState, after: MeshState) -> tuple[Comparison, Displacement]:
    """Compare two meshes or clouds; also the displacement of every vertex of the second.

    Exact far from the origin, too: everything is measured about the first mesh.
    """
    first, second = before.mesh, after.mesh
    moved = displacement(second.vertices, second.faces, first.vertices, first.faces)
    middle = 0.5 * (first.vertices.min(axis=0) + first.vertices.max(axis=0))
    old, new = first.vertices - middle, second.vertices - middle
    forth = moved.distances
    if moved.by_vertex:
        forth = closest_points(new, old, first.faces).distances
    back = closest_points(old, new, second.faces).distances
    to_first, to_second = float(forth.max()), float(back.max())

    def length(value: float) -> LengthIn:
        edge, diagonal = before.mean_edge, before.diagonal
        return LengthIn(float(value), float(value / edge) if edge else None, float(100 * value / diagonal) if diagonal else None)

    faces = _faces(old, first.faces, new, second.faces, before.mean_edge, by_vertex=moved.by_vertex)
    had, has = before.attributes, after.attributes
    return Comparison(
        before=before.measures,
        after=after.measures,
        displacement=_moved(moved, second.vertices, length),
        after_from_before=length(to_first),
        before_from_after=length(to_second),
        hausdorff=length(max(to_first, to_second)),
        area_change=_change(before.measures["area"], after.measures["area"]),
        volume_change=_change(before.measures["volume"], after.measures["volume"]),
        sharp_edges_kept=share_kept(before.sharp, after.sharp, within=before.mean_edge),
        attributes_kept=tuple(a for a in had if a in has),
        attributes_lost=tuple(a for a in had if a not in has),
        attributes_gained=tuple(a for a in has if a not in had),
        **faces,
    ), moved


def _moved(found: Displacement, vertices: Floats, length: Any) -> Moved:
    d = found.distances
    worst = int(d.argmax())
    x, y, z = vertices[worst].tolist()
    return Moved(
        found.by_vertex,
        length(d.mean()),
        length(np.sqrt((d**2).mean())),
        length(np.quantile(d, 0.95)),
        length(d[worst]),
        worst,
        (x, y, z),
    )


def _change(before: float | None, after: float | None) -> float | None:
    """In percent."""
    return 100.0 * (after - before) / abs(before) if before and after is not None else None


def _faces(old: Floats, old_faces: Ints, new: Floats, new_faces: Ints, edge: float, *, by_vertex: bool) -> dict[str, Any]:
    """What the faces of two meshes tell; everything None if one of them has none."""
    names = ("normal_deviation", "largest_normal_deviation", "flipped_faces", "added_area", "removed_area")
    if not (len(old_faces) and len(new_faces)):
        return dict.fromkeys(names)
    before, after = measure_faces(old, old_faces), measure_faces(new, new_faces)
    there = closest_points(np.ascontiguousarray(after[:, CENTRE]), old, old_faces)
    here = closest_points(np.ascontiguousarray(before[:, CENTRE]), new, new_faces)
    ground = before[:, NORMAL] if by_vertex else before[there.elements, NORMAL]
    normals, areas = after[:, NORMAL], after[:, AREA]
    cross = np.linalg.norm(np.cross(ground, normals), axis=1)
    angles = np.degrees(np.arctan2(cross, np.einsum("ij,ij->i", ground, normals)))
    counted = (areas > 0.0) & ground.any(axis=1)
    angles, weights = angles[counted], areas[counted]
    values = (
        float((angles * weights).sum() / weights.sum()) if len(angles) else None,
        float(angles.max()) if len(angles) else None,
        int((angles > 90.0).sum()),
        float(areas[there.distances > _APART * edge].sum()),
        float(before[here.distances > _APART * edge, AREA].sum()),
    )
    return dict(zip(names, values, strict=True))
