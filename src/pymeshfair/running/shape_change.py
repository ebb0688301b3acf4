"""What a run did to the shape: how far vertices moved, and how its dimensions changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ..declaration import Floats, Ints
from ..filters.geometry import cross_products, turned_faces, vector_lengths
from ..filters.inspection.folded_faces import folded_faces
from ..filters.inspection.side_changes import side_changes
from ..filters.inspection.surface_measures import SurfaceMeasures
from ..filters.mesh import bounding_box, scaled_to_unit

#: A run warns where a side of the box has changed by more than this share,
LARGEST_SIDE_CHANGE = 0.01
#: or a vertex has moved by more than this many mean edges.
LARGEST_MOVE = 5.0

Sides: TypeAlias = tuple[float | None, float | None, float | None]


@dataclass(frozen=True)
class Moved:
    """How far the vertices have moved, in mesh units.

    Attributes:
        mean: of the distances.
        most: what 99 % of them stay below.
        largest: of them.
        vertex: the number of the vertex that moved furthest.
        place: where it was, (x, y, z).
        edges: the largest distance in mean edges of the input; None if it has no edges.
    """

    mean: float
    most: float
    largest: float
    vertex: int
    place: tuple[float, float, float]
    edges: float | None


@dataclass(frozen=True)
class Folded:
    """Faces that are folded over in the result and were not before.

    Attributes:
        count: of them.
        face: the number of the largest.
        place: its centre in the result, (x, y, z).
    """

    count: int
    face: int
    place: tuple[float, float, float]


@dataclass(frozen=True)
class ShapeChange:
    """What a run did to the shape.

    Attributes:
        sides: of the bounding box of what faces use, or of all vertices where there are none, along x, y and z: the change as a
            share of the side, None where that was 0.
        sides_without_noise: the same where not by noise at the ends, `pymeshfair.filters.inspection.side_changes`; found where
            vertices correspond and a side has changed by more than `LARGEST_SIDE_CHANGE`, else None.
        area: its change as a share; None where there was none.
        volume: the same, of closed meshes.
        moved: how far vertices moved; None if the result has other vertices or faces, so that they do not correspond.
        turned: how many faces look more than a right angle away from where they did; None with `moved`.
        folded: which faces were folded over, `pymeshfair.filters.inspection.folded_faces`, if there are more of them than before;
            else None.
    """

    sides: Sides
    sides_without_noise: Sides | None
    area: float | None
    volume: float | None
    moved: Moved | None
    turned: int | None
    folded: Folded | None


def shape_change(
    before: tuple[Floats, Ints], after: tuple[Floats, Ints], measured: tuple[SurfaceMeasures, SurfaceMeasures]
) -> ShapeChange:
    """What lies between two meshes.

    Args:
        before: (n, 3) vertices and (m, 3) faces of the input.
        after: those of the result.
        measured: the measures of both.
    """
    first, second = measured
    old, new = (_sides(*mesh, m) for mesh, m in zip((before, after), measured, strict=True))
    x, y, z = (_share(float(a), float(b)) for a, b in zip(old, new, strict=True))
    moved, turned, without_noise, folded = None, None, None, None
    if len(before[0]) == len(after[0]) and len(before[0]) and np.array_equal(before[1], after[1]):
        moved = _moved(before[0], after[0], first.mean_edge)
        turned = turned_faces(scaled_to_unit(before[0])[0], scaled_to_unit(after[0])[0], before[1])
        if second.folded_faces > first.folded_faces:
            folded = _folded(before[0], after[0], before[1])
        if _is_large((x, y, z)) and len(before[1]):
            u, v, w = (None if np.isnan(s) else float(s) for s in side_changes(before[0], after[0], before[1]))
            without_noise = (u, v, w)
    volumes = (first.volume, second.volume) if first.closed and second.closed else (None, None)
    return ShapeChange((x, y, z), without_noise, _share(first.area, second.area), _share(*volumes), moved, turned, folded)


def warnings_of(change: ShapeChange, other_recipe: Callable[[], str]) -> Iterator[str]:
    """What the user should know of a change of shape, and what to do about it.

    Nothing where elements were added or removed: there the box changes on purpose.

    Args:
        change: of `shape_change`.
        other_recipe: finds the recipe to take in place of this one, empty if none is better.
    """
    if change.moved is None:
        return
    dimensions = change.sides_without_noise is not None and _is_large(change.sides_without_noise)
    far = change.moved.edges is not None and change.moved.edges > LARGEST_MOVE
    name = other_recipe() if dimensions or far or change.folded else ""
    other = f", or take {name}" if name else ""
    if dimensions:
        shown = ", ".join(f"{a} {s:+.1%}" for a, s in zip("xyz", change.sides_without_noise or (), strict=True) if s is not None)
        yield (
            f"the shape has other dimensions, noise at its ends aside: {shown}. To keep them: a smaller detail_size or "
            f"gain, fewer iterations{other}"
        )
    if far:
        where = ", ".join(f"{c:.6g}" for c in change.moved.place)
        yield (
            f"vertex {change.moved.vertex} at {where} moved by {change.moved.largest:.6g}, {change.moved.edges:.1f} mean edges: "
            f"look at the place; if it should have stayed, hold borders (border fixed), smooth less{other}; --max-displacement "
            "makes that an error"
        )
    if change.folded:
        where = ", ".join(f"{c:.6g}" for c in change.folded.place)
        faces = "1 face was" if change.folded.count == 1 else f"{change.folded.count:,} faces were"
        yield (
            f"{faces} folded over, the largest is face {change.folded.face} at {where}: look at the place; long thin triangles "
            f"fold first, improve_triangles before this recipe makes them regular; or smooth less{other}"
        )


def _sides(vertices: Floats, faces: Ints, measures: SurfaceMeasures) -> Floats:
    if len(faces) and measures.unreferenced_vertices:
        used = np.zeros(len(vertices), dtype=np.bool_)
        used[faces] = True
        vertices = vertices[used]
    if not len(vertices):
        return np.zeros(3)
    low, high = bounding_box(vertices)
    return np.asarray(high - low)


def _folded(before: Floats, after: Floats, faces: Ints) -> Folded:
    new = np.flatnonzero(folded_faces(after, faces) & ~folded_faces(before, faces))
    sizes = vector_lengths(cross_products(scaled_to_unit(after)[0], faces[new]))
    face = int(new[sizes.argmax()])
    x, y, z = after[faces[face]].mean(axis=0).tolist()
    return Folded(len(new), face, (x, y, z))


def _is_large(sides: Sides) -> bool:
    return any(side is not None and abs(side) > LARGEST_SIDE_CHANGE for side in sides)


def _share(before: float | None, after: float | None) -> float | None:
    return after / before - 1.0 if before and after is not None else None


def _moved(before: Floats, after: Floats, edge: float | None) -> Moved:
    distances = vector_lengths(after - before)
    vertex = int(distances.argmax())
    largest = float(distances[vertex])
    x, y, z = before[vertex].tolist()
    mean = largest and largest * float((distances / largest).mean())  # no sum of distances leaves the range of numbers
    return Moved(mean, float(np.quantile(distances, 0.99)), largest, vertex, (x, y, z), largest / edge if edge else None)
