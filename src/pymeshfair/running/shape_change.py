"""The change of a mesh by a run: origins of the elements, displacement, additions, removals, dimensions, and a coloured map."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, FilterClass, Floats, Ints
from ..files.ply_write import write_ply
from ..files.writing import StagedFile, to_disk
from ..filters.geometry import cross_products, turned_faces, vector_lengths
from ..filters.inspection import Surface, carried, folded_faces, share_kept, sharp_edges, side_changes
from ..filters.inspection.surface_measures import SurfaceMeasures
from ..filters.mesh import bounding_box, mask_of, scaled_to_unit
from ..filters.topology import border_vertices, connected_components
from ..mesh_data import MeshData
from ..places import distance_unit, point_text
from ..scripts.script import Step
from .suitability import ERASED

LARGEST_SIDE_CHANGE = 0.01  # a run warns if a side of the box changes by more than this share, both as measured and without noise
#: a run warns if a vertex moves by more than this many mean edges, or if the net added area exceeds this share of the old one
LARGEST_MOVE, LARGEST_ADDED = 5.0, 1.0 / 3.0
_AMOUNTS = ("gain", "detail_size", "outer_iterations", "iterations", "stepsmoothnum")  # smooth less if smaller; gain: if nearer 1
_WHOLE = 0.25  # a mesh was moved as a whole if, carried back, it has less than this share of its median displacement
_LISTED = 20  # the largest number of pieces that are listed one by one

Sides: TypeAlias = tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class Origins:
    """The origins of a result's elements in the input."""

    before: MeshData  # the mesh that was read
    result: MeshData  # the mesh after the steps
    vertices: NDArray[np.int64]  # (n,) the number that each vertex of the result has in the input; -1 if it was added
    faces: NDArray[np.int64]  # (m,) the number of the input's face with the same corners; -1 if the face was added
    followed: bool  # whether the elements could be followed through the steps; if not, all count as added

    @cached_property
    def distances(self) -> Floats:
        """(n,) the displacement of each vertex; for an added vertex the distance from the input's surface."""
        distances = np.zeros(len(self.vertices))
        old = self.vertices >= 0
        distances[old] = self._moves
        if not old.all():
            distances[~old] = Surface.of(self.before.vertices, self.before.faces).nearest(self.result.vertices[~old]).distances
        return distances

    @cached_property
    def displaced(self) -> tuple[NDArray[np.int64], Floats]:
        """The followed vertices and their displacements; if not `followed`, all vertices and their distances from the input."""
        if self.followed:
            return np.flatnonzero(self.vertices >= 0), self._moves
        return np.arange(len(self.vertices)), self.distances

    @cached_property
    def _moves(self) -> Floats:
        old = np.flatnonzero(self.vertices >= 0)
        return vector_lengths(self.result.vertices[old] - self.before.vertices[self.vertices[old]])

    @cached_property
    def in_place(self) -> Floats:
        """(n, 3) the result's vertices; carried back onto the input if the whole mesh was moved, turned, mirrored or scaled."""
        result, old = self.result.vertices, self.vertices >= 0
        if not (self.followed and old.sum() > 7 and self._moves.any()):  # a similarity has seven degrees of freedom
            return result
        target = self.before.vertices[self.vertices[old]]
        back = carried(result, result[old], target)
        return back if np.median(vector_lengths(back[old] - target)) < _WHOLE * np.median(self._moves) else result

    @cached_property
    def removed(self) -> tuple[Bools, Bools]:
        """(n,) and (m,) which vertices and faces of the input are not in the result."""
        kept_vertices = mask_of(self.vertices[self.vertices >= 0], len(self.before.vertices))
        return ~kept_vertices, ~mask_of(self.faces[self.faces >= 0], len(self.before.faces))


def find_origins(result: MeshData, before: MeshData) -> Origins:
    """Finds the origins of a result's elements in the mesh that was read."""
    same_source = result.source is not None and result.source is before.source
    vertices = _numbers(result.vertex_ids, before.vertex_ids, len(result.vertices), same_source)
    faces = _numbers(result.face_ids, before.face_ids, len(result.faces), same_source)
    same_source &= bool((vertices >= 0).any()) or not len(vertices)
    return Origins(before, result, vertices, faces, same_source)


def _numbers(after: NDArray[np.int64] | None, before: NDArray[np.int64] | None, count: int, same: bool) -> NDArray[np.int64]:
    """(count,) each element's number in the mesh that was read, found by its id; -1 without an id, or if the sources differ."""
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
    """Displacements of the followed vertices; if the mesh is new, the distances of all its vertices from the input."""

    same: bool  # whether the vertices were followed; if not, the mesh is new
    count: int  # the number of vertices that were compared
    moved: int  # the number of vertices that moved
    mean: float
    rms: float
    most: float  # the 99th percentile
    largest: float
    vertex: int  # the number of the vertex with the largest displacement, in the result
    place: tuple[float, ...]  # the place of that vertex in the result, (x, y, z)
    edges: float | None  # the largest displacement in mean edges of the input or mean spacings of a cloud; None if it has neither
    mean_edges: float | None  # the mean displacement in the same unit


@dataclass(frozen=True)
class Piece:
    """A connected piece of the added or removed faces."""

    faces: int
    share: float | None  # its share of the input's area; None if the input has no area
    size: float  # the diagonal of its bounding box, in mesh units
    place: tuple[float, ...]  # the middle of the box, (x, y, z)


@dataclass(frozen=True)
class Part:
    """The elements that were added, or those that were removed."""

    vertices: int
    faces: int
    area: float
    share: float | None  # as in `Piece`
    pieces: int  # the number of connected pieces of the faces
    loose: int  # the number of pieces that share no vertex with the remaining faces
    rims: int  # the number of pieces that share a vertex with the remaining faces and reach the border of the mesh
    largest: tuple[Piece, ...] = ()  # up to twenty pieces, the largest area first


@dataclass(frozen=True)
class Folded:
    """Faces that are folded over in the result and were not before."""

    count: int
    face: int  # the index of the largest face
    place: tuple[float, ...]  # its centre in the result, (x, y, z)


@dataclass(frozen=True)
class ShapeChange:
    """The change of shape by a run."""

    sides: Sides  # the relative change of each side of the bounding box; None where the side was 0
    #: the same changes without noise, see `side_changes`; None unless a side changed much and both meshes have the same faces
    sides_without_noise: Sides | None
    area: float | None  # the relative change of the area; None if the input has no area
    volume: float | None  # the relative change of the volume; None unless both meshes are closed
    moved: Moved | None  # None if there are no vertices to compare
    added: Part
    removed: Part
    #: how many faces turned by more than 90 degrees, apart from a motion of the whole; None if the vertex count or faces differ
    turned: int | None
    folded: Folded | None  # the newly folded faces; None if no more are folded than before, or if `turned` is None
    #: `pymeshfair.filters.diffusion.relief_lost` of the followed faces, given an estimate of the noise; of a large mesh, only a
    #: sample is measured. None if no followed vertex moved, or if the noise hides all relief or has impulses
    relief_lost: float | None = None
    relief_from: float = 0.0  # the shortest wavelength that the noise does not hide, in mean edges; 0 if it hides none or all
    sharp_kept: float | None = None  # the kept share of sharp edges' length; None if there were none or no followed vertex moved


def shape_change(origins: Origins, measured: tuple[SurfaceMeasures, SurfaceMeasures]) -> ShapeChange:
    """Measures the change of shape between two meshes."""
    first, second = measured
    before, result = ((mesh.vertices, mesh.faces) for mesh in (origins.before, origins.result))
    old, new = (_box(*mesh, m) for mesh, m in zip((before, result), measured, strict=True))
    sides: Sides = tuple(_share(a, b) for a, b in zip(old.tolist(), new.tolist(), strict=True))
    turned, without_noise, folded = None, None, None
    if len(before[0]) == len(result[0]) and len(before[0]) and np.array_equal(before[1], result[1]):
        turned = turned_faces(scaled_to_unit(before[0])[0], scaled_to_unit(origins.in_place)[0], before[1])
        if second.folded_faces > first.folded_faces:
            folded = _folded(before[0], result[0], before[1])
        if _is_large(sides) and len(before[1]):
            in_place = _box(origins.in_place, result[1], second)
            growth = np.divide(new, in_place, out=np.ones(3), where=in_place > 0.0)
            shares = side_changes(before[0], origins.in_place, before[1]) * growth + (growth - 1.0)
            without_noise = tuple(None if np.isnan(s) else float(s) for s in shares)
    moved = _moved(origins, first.mean_edge or first.mean_spacing)
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
        **(_details(origins, first.mean_edge) if moved and moved.same and moved.moved and first.mean_edge else {}),
    )


def _details(origins: Origins, edge: float) -> dict[str, Any]:
    """Returns the last three fields of `ShapeChange`, measured on the faces whose vertices were followed."""
    # Imported here, as they load half of all filters, and a batch without measures does not need them.
    from ..filters.denoising import Scan
    from ..filters.diffusion import relief_lost

    faces = origins.result.faces[(origins.vertices[origins.result.faces] >= 0).all(axis=1)]
    if not len(faces):
        return {}
    old, new = origins.before.vertices[np.maximum(origins.vertices, 0)], origins.in_place
    sharp = share_kept(sharp_edges(old, faces), sharp_edges(new, faces), within=edge)
    points, scale = scaled_to_unit(old)
    scan, origin = Scan.sampled(points, faces)
    if scan.has_impulses:
        return {"sharp_kept": sharp}
    noise = scan.noise.deviation  # not `level`: outliers must count in full, as they do in the energies of `relief_lost`
    relief = relief_lost(points[origin], (scale * new)[origin], scan.faces, noise=noise)
    return {"sharp_kept": sharp, **({"relief_lost": relief.share, "relief_from": relief.shortest} if relief else {})}


def warnings_of(
    change: ShapeChange, steps: Sequence[Step], other_recipe: Callable[[], str], *, keeps_relief: bool = False
) -> Iterator[str]:
    """Yields warnings about a change of shape, with advice; on dimensions and moves only if `turned` is known."""
    growth = (change.added.share or 0.0) - (change.removed.share or 0.0)
    if change.moved is not None and growth > LARGEST_ADDED:
        yield (
            f"new surface was added without measurements, {growth:.0%} of the scanned area: look at it"
            if change.moved.same
            else f"the new surface has {growth:.0%} more area than the scan, and this part is unmeasured: look at it; if it "
            "also covers the inner side, it is a thin shell: take fill_holes_smoothly or prepare_for_print instead"
        )
    moved = None if change.turned is None else change.moved
    dimensions = moved and change.sides_without_noise is not None and _is_large(change.sides_without_noise)
    far = moved and moved.edges is not None and moved.edges > LARGEST_MOVE
    erased = keeps_relief and (change.relief_lost or 0.0) > ERASED
    other = other_recipe() if dimensions or far or change.folded or erased else ""
    remedies = [text for text in (milder(steps), other and f"take {other}") if text]
    if dimensions:
        sides = ", ".join(f"{a} {s:+.1%}" for a, s in zip("xyz", change.sides_without_noise or (), strict=True) if s is not None)
        yield f"the shape's dimensions changed, not only because noise is gone: {sides}{_advice('. To keep them: ', remedies)}"
    if moved and far:
        fixed = ["border fixed"] if any(step.values.get("border", "fixed") != "fixed" for step in steps) else []
        yield (
            f"vertex {moved.vertex} at ({point_text(moved.place)}) moved by {moved.largest:.6g} ({moved.edges:.1f} mean "
            f"{distance_unit(change.area)}): "
            f"look at the place{_advice('; if it should have stayed: ', [*fixed, *remedies])}; --max-displacement "
            "makes such a move an error"
        )
    if change.folded:
        where = point_text(change.folded.place)
        faces = "1 face was" if change.folded.count == 1 else f"{change.folded.count:,} faces were"
        yield (
            f"{faces} folded over, the largest is face {change.folded.face} at ({where}): look at the place; long thin triangles "
            f"fold first: improve_triangles, run before this recipe, makes them regular{_advice('; or ', remedies)}"
        )
    if erased:
        yield (
            f"{change.relief_lost:.0%} of the relief apart from noise is gone: compare the result with the scan; if that "
            f"was detail: {', or '.join([*remedies, 'leave the scan as it is'])}; `pymeshfair suggest` tries recipes and shows "
            "the relief that each would remove"
        )


def milder(steps: Sequence[Step]) -> str:
    """Returns advice to smooth less: another value of a setting, or else of a parameter; empty if neither can be milder."""
    smoothing = [step for step in steps if step.filter.classes & FilterClass.SMOOTHING]
    amounts = [(step, name) for step in smoothing for name in _AMOUNTS if step.values.get(name, 1) != 1]
    amounts = [(s, n) for s, n in amounts if n != "gain" or s.values.get("response", "enhance") == "enhance"]  # else no effect
    chosen = [(s, n) for s, n in amounts if n in s.settings and s.values[n] != "auto"] or amounts
    if not chosen:
        return ""
    step, name = chosen[0]
    way = "larger" if name == "gain" and step.values[name] < 1 else "smaller"
    return f"a {way} value of {step.settings.get(name, name)}" + (" than 'auto' takes" if step.values[name] == "auto" else "")


def _advice(before: str, remedies: Sequence[str]) -> str:
    return before + ", or ".join(remedies) if remedies else ""


def _box(vertices: Floats, faces: Ints, measures: SurfaceMeasures) -> Floats:
    """(3,) the sides of the bounding box of the vertices that faces use, or of all vertices if there are no faces."""
    if len(faces) and measures.unreferenced_vertices:
        vertices = vertices[mask_of(faces, len(vertices))]
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
    shares = distances / (largest or 1.0)  # scaled, so that no sum overflows
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


def _part(vertices: Floats, faces: Ints, vertex_mask: Bools, face_mask: Bools, input_area: float | None) -> Part:
    inside = faces[face_mask]
    if not len(inside):
        return Part(int(vertex_mask.sum()), 0, 0.0, 0.0 if input_area else None, 0, 0, 0)
    points, scale = scaled_to_unit(vertices)
    areas = vector_lengths(cross_products(points, inside))
    area = 0.5 * float(areas.sum()) / scale / scale
    pieces, count = connected_components(inside, len(vertices))
    share = area / input_area if input_area else None
    numbers = pieces[inside[:, 0]]  # -1 if the first corner is in no proper face
    sums = np.bincount(numbers[numbers >= 0], weights=areas[numbers >= 0], minlength=count)

    def piece(number: int) -> Piece:
        corners = inside[numbers == number]
        low, high = bounding_box(points[corners.ravel()])
        middle = np.mean(bounding_box(vertices[corners.ravel()]), axis=0).tolist()
        piece_share = None if share is None else share * float(sums[number]) / (float(areas.sum()) or 1.0)
        return Piece(len(corners), piece_share, float(np.linalg.norm(high - low)) / scale, tuple(middle))

    remaining = mask_of(faces[~face_mask], len(vertices))
    touches = np.zeros((2, count), dtype=np.bool_)  # whether each piece touches the remaining faces, and the border
    for row, marked in enumerate((remaining, border_vertices(faces, len(vertices)) if remaining.any() else remaining)):
        touches[row, pieces[marked & (pieces >= 0)]] = True
    loose, rims = int((~touches[0]).sum()), int((touches[0] & touches[1]).sum())
    largest = tuple(piece(number) for number in np.argsort(-sums, kind="stable")[:_LISTED].tolist())
    return Part(int(vertex_mask.sum()), len(inside), area, share, count, loose, rims, largest)


KEPT, MOVED, ADDED, REMOVED = 0, 1, 2, 3  # the state of an element; the face scalar of the map
#: red, green, blue, opacity of each state: grey, orange, blue, purple; distinct for colour-blind readers and in greyscale
COLORS: NDArray[np.uint8] = np.array(
    [[200, 200, 200, 255], [222, 143, 5, 255], [1, 90, 178, 255], [120, 40, 110, 255]], dtype=np.uint8
)


def stage_map(folder: Path, targets: Sequence[Path], origins: Origins, tolerance: float) -> tuple[StagedFile, ...]:
    """Writes the two files of a map into a staging folder; the second holds the removed elements, if there are any.

    A vertex is kept if it moved by at most the tolerance (in mesh units), a face if the input has it and its vertices are kept.
    """
    staged = []
    for number, (mesh, target) in enumerate(zip((_map(origins, tolerance), _removed(origins)), targets, strict=True)):
        if mesh is not None:
            staged.append(StagedFile(folder / f"map-{number}.ply", target))
            with staged[-1].staged.open("xb") as file:
                write_ply(mesh, file)
                to_disk(file)
    return tuple(staged)


def _map(origins: Origins, tolerance: float) -> MeshData:
    """The result with displacements as vertex scalars, states as face scalars, and the states of both as colours."""
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
    """The removed elements, with the input's vertex numbers as scalars; None if there are none."""
    before, (vertices, faces) = origins.before, origins.removed
    needed = vertices | mask_of(before.faces[faces], len(vertices))
    if not needed.any():
        return None
    part = MeshData(vertices=before.vertices, faces=before.faces[faces]).part(needed)
    colors, face_colors = (np.tile(COLORS[REMOVED], (len(elements), 1)) for elements in (part.vertices, part.faces))
    return part.with_attributes(
        {"scalars": np.flatnonzero(needed).astype(np.float64), "colors": colors},
        {"scalars": np.full(len(part.faces), float(REMOVED)), "colors": face_colors},
    )
