"""The change by a run: the origin of every element of a result, moves, additions, removals and dimensions, and their map."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, FilterClass, Floats, Ints
from ..files.ply_write import write_ply
from ..files.writing import StagedFile
from ..filters.geometry import cross_products, turned_faces, vector_lengths
from ..filters.inspection import Surface, folded_faces, share_kept, sharp_edges, side_changes
from ..filters.inspection.surface_measures import SurfaceMeasures
from ..filters.mesh import bounding_box, scaled_to_unit
from ..filters.topology import border_vertices, connected_components
from ..mesh_data import MeshData
from ..scripts.script import Step
from .suitability import ERASED

if TYPE_CHECKING:
    from ..filters.diffusion import ReliefLoss

LARGEST_SIDE_CHANGE = 0.01  # a run warns where a side of the box has changed by more than this share
#: and where a vertex has moved by more than this many mean edges, or more than this share of the area was added
LARGEST_MOVE, LARGEST_ADDED = 5.0, 1.0 / 3.0
_AMOUNTS = ("gain", "detail_size", "outer_iterations", "iterations", "stepsmoothnum")  # parameters whose smaller values do less
_LISTED = 20  # pieces that are listed one by one

Sides: TypeAlias = tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class Origins:
    """The origins of the elements of a result."""

    before: MeshData  # the mesh that was read
    result: MeshData  # the mesh after the steps
    vertices: NDArray[np.int64]  # (n,) of every vertex of the result its number in the input, -1 for one that was added
    #: (m,) of every face the number of the face of the input with the same corners, -1 for one that was added
    faces: NDArray[np.int64]
    followed: bool  # whether elements could be followed; else all count as added

    @cached_property
    def distances(self) -> Floats:
        """(n,) the displacement of each vertex; for an added one its distance from the surface of the input."""
        distances = np.zeros(len(self.vertices))
        old = self.vertices >= 0
        distances[old] = self._moves
        if not old.all():
            surface = Surface.of(self.before.vertices, self.before.faces)
            distances[~old] = surface.nearest(self.result.vertices[~old]).distances
        return distances

    @cached_property
    def displaced(self) -> tuple[NDArray[np.int64], Floats]:
        """The vertices that are the same in both meshes, or all, and how far each lies from where it was, or from the input."""
        if self.followed:
            return np.flatnonzero(self.vertices >= 0), self._moves
        return np.arange(len(self.vertices)), self.distances

    @cached_property
    def _moves(self) -> Floats:
        old = np.flatnonzero(self.vertices >= 0)
        return vector_lengths(self.result.vertices[old] - self.before.vertices[self.vertices[old]])

    @cached_property
    def removed(self) -> tuple[Bools, Bools]:
        """(n,) and (m,) which vertices and which faces of the input the result does not have."""
        gone, faces_gone = np.ones(len(self.before.vertices), dtype=np.bool_), np.ones(len(self.before.faces), dtype=np.bool_)
        gone[self.vertices[self.vertices >= 0]] = False
        faces_gone[self.faces[self.faces >= 0]] = False
        return gone, faces_gone


def find_origins(result: MeshData, before: MeshData) -> Origins:
    """The origins of the elements of a result in the mesh that was read."""
    same_source = result.source is not None and result.source is before.source
    of_vertices = _numbers(result.vertex_ids, before.vertex_ids, len(result.vertices), same_source)
    of_faces = _numbers(result.face_ids, before.face_ids, len(result.faces), same_source)
    same_source &= bool((of_vertices >= 0).any()) or not len(of_vertices)
    return Origins(before, result, of_vertices, of_faces, same_source)


def _numbers(after: NDArray[np.int64] | None, before: NDArray[np.int64] | None, count: int, same: bool) -> NDArray[np.int64]:
    """(count,) the numbers in the mesh that was read, which may have lost elements; `same` if both meshes are of one file."""
    if not same:
        return np.full(count, -1)
    if before is None:
        return np.arange(count) if after is None else after
    assert after is not None
    place = np.full(int(max(before.max(initial=-1), after.max(initial=-1))) + 1, -1)
    place[before] = np.arange(len(before))
    return np.where(after >= 0, place[np.maximum(after, 0)], -1) if len(place) else after


@dataclass(frozen=True)
class Moved:
    """Displacement of the vertices that are the same before and after; of a new mesh distances of all vertices from the input."""

    same: bool  # whether the vertices are the same
    count: int  # of the vertices that count
    moved: int  # how many of them lie elsewhere now
    mean: float  # of the distances
    rms: float  # the root of the mean of their squares
    most: float  # the bound below which 99 % of them stay
    largest: float  # of them
    vertex: int  # the number in the result of the vertex that moved furthest
    place: tuple[float, ...]  # its place now, (x, y, z)
    edges: float | None  # the largest distance in mean edges of the input; None if it has no edges
    mean_edges: float | None  # the mean in the same way


@dataclass(frozen=True)
class Piece:
    """A connected piece of what was added or removed."""

    faces: int  # how many
    share: float | None  # of the area of the input; None if it has none
    size: float  # the diagonal of its box, in mesh units
    place: tuple[float, ...]  # the middle of the box, (x, y, z)


@dataclass(frozen=True)
class Part:
    """Elements that were added or removed."""

    vertices: int  # how many
    faces: int  # how many
    area: float  # of the faces
    share: float | None  # of the area of the input; None if it has none
    pieces: int  # connected pieces of the faces
    loose: int  # how many of the pieces share no vertex with what stays
    rims: int  # how many of the others reach the border of their mesh
    largest: tuple[Piece, ...] = ()  # up to twenty of the pieces, the largest area first


@dataclass(frozen=True)
class Folded:
    """Faces that are folded over in the result and were not before."""

    count: int  # of them
    face: int  # the number of the largest
    place: tuple[float, ...]  # its centre in the result, (x, y, z)


@dataclass(frozen=True)
class ShapeChange:
    """The change of shape by a run."""

    #: of the bounding box of what faces use, or of all vertices where there are none: the change along x, y and z as a share of
    #: the side, None where that was 0
    sides: Sides
    sides_without_noise: Sides | None  # the same without noise at the ends; found where one is large and vertices correspond
    area: float | None  # its change as a share; None where there was none
    volume: float | None  # the same, of closed meshes
    moved: Moved | None  # how far vertices moved; None if no vertex counts
    added: Part  # elements of the result that the input did not have
    removed: Part  # elements of the input that the result does not have
    turned: int | None  # faces that look more than a right angle away from where they did; None if elements came or went
    folded: Folded | None  # which faces were folded over, if there are more of them than before; else None
    #: `pymeshfair.filters.diffusion.relief_lost` of the faces whose vertices are the same, beside the noise that is estimated, on
    #: a sample of a large mesh; None where no vertex moved or relief does not stand out
    relief_lost: float | None = None
    relief_from: float = 0.0  # the shortest waves that count there, in mean edges; 0 for all, else noise hides shorter relief
    sharp_kept: float | None = None  # the share of the length of their sharp edges that is sharp still; None without any


def shape_change(origins: Origins, measured: tuple[SurfaceMeasures, SurfaceMeasures]) -> ShapeChange:
    """The change of shape between two meshes: the one place from which tables, documents, limits, maps and reports take it."""
    first, second = measured
    before, result = ((mesh.vertices, mesh.faces) for mesh in (origins.before, origins.result))
    old, new = (_box(*mesh, m) for mesh, m in zip((before, result), measured, strict=True))
    sides: Sides = tuple(_share(a, b) for a, b in zip(old.tolist(), new.tolist(), strict=True))
    turned, without_noise, folded = None, None, None
    if len(before[0]) == len(result[0]) and len(before[0]) and np.array_equal(before[1], result[1]):
        turned = turned_faces(scaled_to_unit(before[0])[0], scaled_to_unit(result[0])[0], before[1])
        if second.folded_faces > first.folded_faces:
            folded = _folded(before[0], result[0], before[1])
        if _is_large(sides) and len(before[1]):
            without_noise = tuple(None if np.isnan(s) else float(s) for s in side_changes(before[0], result[0], before[1]))
    moved = _moved(origins, first.mean_edge or first.mean_spacing)
    relief, sharp = None, None
    if moved and moved.same and moved.moved and first.mean_edge:
        relief, sharp = _details(origins, first.mean_edge)
    return ShapeChange(
        sides=sides,
        sides_without_noise=without_noise,
        area=_share(first.area, second.area),
        volume=_share(first.volume, second.volume) if first.closed and second.closed else None,
        moved=moved,
        added=_part(*result, origins.vertices < 0, origins.faces < 0, first.area),
        removed=_part(*before, *origins.removed, first.area),
        turned=turned,
        folded=folded,
        relief_lost=None if relief is None else relief.share,
        relief_from=0.0 if relief is None else relief.shortest,
        sharp_kept=sharp,
    )


def _details(origins: Origins, edge: float) -> tuple[ReliefLoss | None, float | None]:
    """Which share of the relief is lost, and which of the sharp edges is kept, of the faces whose vertices are the same."""
    # Half of all filters come with these, and most runs of a batch without measures need none of them.
    from ..filters.denoising import Scan
    from ..filters.diffusion import relief_lost

    faces = origins.result.faces[(origins.vertices[origins.result.faces] >= 0).all(axis=1)]
    if not len(faces):
        return None, None
    old, new = origins.before.vertices[np.maximum(origins.vertices, 0)], origins.result.vertices
    sharp = share_kept(sharp_edges(old, faces), sharp_edges(new, faces), within=edge)
    points, scale = scaled_to_unit(old)
    scan, origin = Scan.sampled(points, faces)
    if scan.has_impulses:
        return None, sharp
    noise = scan.noise.deviation  # energies are compared: outliers count in full
    return relief_lost(points[origin], (scale * new)[origin], scan.faces, noise=noise), sharp


def warnings_of(
    change: ShapeChange, steps: Sequence[Step], other_recipe: Callable[[], str], *, keeps_relief: bool = False
) -> Iterator[str]:
    """Warnings about a change of shape, with advice; those of dimensions and moves only where no elements came or went."""
    more = (change.added.share or 0.0) - (change.removed.share or 0.0)
    if change.moved is not None and more > LARGEST_ADDED:
        yield (
            f"new surface of {more:.0%} of the area that was scanned was added without measurements: look at it"
            if change.moved.same
            else f"the new surface has {more:.0%} more area than the scan, and no measurements there: look at it; where it went "
            "through an opening to the inside, walls are thin: fill_holes_smoothly and prepare_for_print close openings"
        )
    moved = None if change.turned is None else change.moved
    dimensions = moved and change.sides_without_noise is not None and _is_large(change.sides_without_noise)
    far = moved and moved.edges is not None and moved.edges > LARGEST_MOVE
    erased = keeps_relief and (change.relief_lost or 0.0) > ERASED
    name = other_recipe() if dimensions or far or change.folded or erased else ""
    ways = [way for way in (milder(steps), name and f"take {name}") if way]
    if dimensions:
        shown = ", ".join(f"{a} {s:+.1%}" for a, s in zip("xyz", change.sides_without_noise or (), strict=True) if s is not None)
        yield f"the shape has other dimensions, noise at its ends aside: {shown}{_told('. To keep them: ', ways)}"
    if moved and far:
        where = ", ".join(f"{c:.6g}" for c in moved.place)
        stay = ["border fixed"] if any(step.values.get("border", "fixed") != "fixed" for step in steps) else []
        yield (
            f"vertex {moved.vertex} at {where} moved by {moved.largest:.6g}, {moved.edges:.1f} mean edges: "
            f"look at the place{_told('; if it should have stayed: ', [*stay, *ways])}; --max-displacement "
            "makes that an error"
        )
    if change.folded:
        where = ", ".join(f"{c:.6g}" for c in change.folded.place)
        faces = "1 face was" if change.folded.count == 1 else f"{change.folded.count:,} faces were"
        yield (
            f"{faces} folded over, the largest is face {change.folded.face} at {where}: look at the place; long thin triangles "
            f"fold first, improve_triangles before this recipe makes them regular{_told('; or ', ways)}"
        )
    if erased:
        yield (
            f"{change.relief_lost:.0%} of the relief beside the noise is gone: compare the result with the scan; if that "
            f"was detail: {', or '.join([*ways, 'leave it as it is'])}; `pymeshfair suggest` ranks recipes by what they "
            "would take"
        )


def milder(steps: Sequence[Step]) -> str:
    """Advice to smooth less: a smaller setting of the recipe, or else a parameter; empty if there is none."""
    smoothing = [step for step in steps if step.filter.classes & FilterClass.SMOOTHING]
    amounts = [(step, name) for step in smoothing for name in _AMOUNTS if step.values.get(name, 1) != 1]
    settings = [step.settings[name] for step, name in amounts if name in step.settings and step.values[name] != "auto"]
    named = settings or [name for _, name in amounts]
    return f"a smaller {named[0]}" if named else ""


def _told(before: str, ways: Sequence[str]) -> str:
    return before + ", or ".join(ways) if ways else ""


def _box(vertices: Floats, faces: Ints, measures: SurfaceMeasures) -> Floats:
    """(3,) the sides of the box."""
    if len(faces) and measures.unreferenced_vertices:
        vertices = vertices[np.bincount(faces.ravel(), minlength=len(vertices)) > 0]
    return np.asarray(np.subtract(*bounding_box(vertices)[::-1]) if len(vertices) else np.zeros(3))


def _folded(before: Floats, after: Floats, faces: Ints) -> Folded:
    new = np.flatnonzero(folded_faces(after, faces) & ~folded_faces(before, faces))
    sizes = vector_lengths(cross_products(scaled_to_unit(after)[0], faces[new]))
    face = int(new[sizes.argmax()])
    return Folded(len(new), face, tuple(after[faces[face]].mean(axis=0).tolist()))


def _is_large(sides: Sides) -> bool:
    return any(side is not None and abs(side) > LARGEST_SIDE_CHANGE for side in sides)


def _share(before: float | None, after: float | None) -> float | None:
    return after / before - 1.0 if before and after is not None else None


def _moved(origins: Origins, edge: float | None) -> Moved | None:
    vertices, distances = origins.displaced
    if not len(distances):
        return None
    furthest = int(distances.argmax())
    largest = float(distances[furthest])
    shares = distances / (largest or 1.0)  # no sum of distances or of squares leaves the range of numbers
    mean, rms = largest * float(shares.mean()), largest * float(np.sqrt(np.mean(shares**2)))
    return Moved(
        same=origins.followed,
        count=len(distances),
        moved=int(np.count_nonzero(distances)),
        mean=mean,
        rms=rms,
        most=float(np.quantile(distances, 0.99)),
        largest=largest,
        vertex=int(vertices[furthest]),
        place=tuple(origins.result.vertices[vertices[furthest]].tolist()),
        edges=largest / edge if edge else None,
        mean_edges=mean / edge if edge else None,
    )


def _part(vertices: Floats, faces: Ints, of_vertices: Bools, of_faces: Bools, whole: float | None) -> Part:
    """The measures of some vertices and faces of a mesh."""
    inside = faces[of_faces]
    if not len(inside):
        return Part(int(of_vertices.sum()), 0, 0.0, 0.0 if whole else None, 0, 0, 0)
    points, scale = scaled_to_unit(vertices)
    areas = vector_lengths(cross_products(points, inside))
    area = 0.5 * float(areas.sum()) / scale / scale
    pieces, count = connected_components(inside, len(vertices))
    share = area / whole if whole else None
    numbers = pieces[inside[:, 0]]  # -1 where a corner stands twice
    sums = np.bincount(numbers[numbers >= 0], weights=areas[numbers >= 0], minlength=count)

    def piece(number: int) -> Piece:
        corners = inside[numbers == number]
        low, high = bounding_box(points[corners.ravel()])
        middle = np.mean(bounding_box(vertices[corners.ravel()]), axis=0).tolist()
        of_all = None if share is None else share * float(sums[number]) / (float(areas.sum()) or 1.0)
        return Piece(len(corners), of_all, float(np.linalg.norm(high - low)) / scale, tuple(middle))

    beside = np.zeros(len(vertices), dtype=np.bool_)
    beside[faces[~of_faces]] = True
    holds = np.zeros((2, count), dtype=np.bool_)
    for row, marked in enumerate((beside, border_vertices(faces, len(vertices)) if beside.any() else beside)):
        holds[row, pieces[marked & (pieces >= 0)]] = True
    return Part(
        int(of_vertices.sum()),
        len(inside),
        area,
        share,
        count,
        int((~holds[0]).sum()),
        int((holds[0] & holds[1]).sum()),
        tuple(piece(number) for number in np.argsort(-sums, kind="stable")[:_LISTED].tolist()),
    )


KEPT, MOVED, ADDED, REMOVED = 0, 1, 2, 3  # the fate of an element; the face scalar of the map
#: red, green, blue, opacity: grey, orange, blue, purple; distinct for colour-blind readers and in grey
COLORS: NDArray[np.uint8] = np.array(
    [[200, 200, 200, 255], [222, 143, 5, 255], [1, 90, 178, 255], [120, 40, 110, 255]], dtype=np.uint8
)


def stage_map(folder: Path, targets: Sequence[Path], origins: Origins, tolerance: float) -> tuple[StagedFile, ...]:
    """Write both files of a map into a staging folder, the second, of what was removed, only if something was.

    A vertex is kept that moved by no more than the tolerance, in mesh units; a face whose corners are its own, and all kept.
    """
    staged = []
    for number, (mesh, target) in enumerate(zip((_map(origins, tolerance), _removed(origins)), targets, strict=True)):
        if mesh is not None:
            staged.append(StagedFile(folder / f"map-{number}.ply", target))
            with staged[-1].staged.open("xb") as file:
                write_ply(mesh, file)
    return tuple(staged)


def _map(origins: Origins, tolerance: float) -> MeshData:
    """The result with how far each vertex moved as its scalar, and what became of it as colour and scalar of faces."""
    result = origins.result
    vertices = np.where(origins.vertices < 0, ADDED, np.where(origins.distances > tolerance, MOVED, KEPT))
    touched = (vertices[result.faces] == MOVED).any(axis=1)
    faces = np.where(origins.faces < 0, ADDED, np.where(touched, MOVED, KEPT))
    return MeshData(
        vertices=result.vertices,
        faces=result.faces,
        vertex_attributes={"scalars": origins.distances, "colors": COLORS[vertices]},
        face_attributes={"scalars": faces.astype(np.float64), "colors": COLORS[faces]},
    )


def _removed(origins: Origins) -> MeshData | None:
    """What the result does not have of the input, with numbers of vertices there as scalars; None if it has all."""
    before, (gone, faces_gone) = origins.before, origins.removed
    needed = gone.copy()
    needed[before.faces[faces_gone]] = True
    if not needed.any():
        return None
    part = MeshData(vertices=before.vertices, faces=before.faces[faces_gone]).part(needed)
    colors, of_faces = (np.tile(COLORS[REMOVED], (len(elements), 1)) for elements in (part.vertices, part.faces))
    return part.with_attributes(
        {"scalars": np.flatnonzero(needed).astype(np.float64), "colors": colors},
        {"scalars": np.full(len(part.faces), float(REMOVED)), "colors": of_faces},
    )
