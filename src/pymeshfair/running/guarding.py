"""Checks a result against the limits of a run; each breach has its place and its amount, if known.

`print_faults` sees the written file as a slicer does: as triangles, with equal points merged.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..declaration import Floats, Ints
from ..files.polygons import numbered
from ..filters.geometry import cross_products, vector_lengths
from ..filters.inspection import SHARP, Surface, share_kept, sharp_edges, wall_thickness
from ..filters.inspection.surface_measures import SurfaceMeasures, inward_faces, surface_measures
from ..filters.libraries import sparse
from ..filters.topology import IRREGULAR, proper_faces, stars
from ..mesh_data import MeshData
from ..places import counted, point_text
from ..scripts.guards import Guards
from .measuring import MeasuredMesh, self_intersecting, self_intersecting_apart
from .shape_change import Moved, Origins, ShapeChange


@dataclass(frozen=True)
class Breach:
    """One broken limit."""

    guard: str  # the name of the limit
    message: str  # the breach, its place, and the allowed amount
    vertex: int | None = None  # the vertex of the result that breaks the limit; None if the breach has no single vertex
    place: tuple[float, ...] | None = None  # (x, y, z) of that vertex, or the middle of the largest connected group of faults
    amount: float | None = None  # the measured amount; None if there is none
    allowed: float | None = None  # the allowed amount, in the same unit


def breaches(
    guards: Guards, origins: Origins, change: ShapeChange | None, before: MeasuredMesh, after: MeasuredMesh, unit: str | None
) -> list[Breach]:
    """The breaches of a result; empty for a run without measures, which has no limits."""
    if before.measures is None or after.measures is None or change is None:
        return []
    broken: list[Breach] = []
    if (allowed := guards.in_mesh_units(unit).max_displacement) is not None:
        limit = allowed.resolve(diagonal=before.diagonal, mean_edge=before.resolution)
        broken += _displacement(origins, change.moved, limit, str(guards.max_displacement), f" {unit}" if unit else "")
    if guards.max_volume_change is not None:
        broken += _volume(before.measures.volume, after.measures.volume, guards.max_volume_change)
    for word, number in guards.require:
        broken += _requirement(word, number, after.measures)
        if word == "outward" and after.measures.volume is not None:
            broken += _inward(after.mesh.vertices, after.mesh.faces, "the result")
    if guards.keep_sharp is not None:
        old, new = sharp_edges(before.mesh.vertices, before.mesh.faces), sharp_edges(origins.in_place, after.mesh.faces)
        kept, least = share_kept(old, new, within=before.resolution()), guards.keep_sharp
        if kept is not None and 100.0 * kept < least:
            text = f"of the length of the edges sharper than {SHARP:g} degrees is kept, not {least:g} %"
            broken.append(Breach("keep_sharp", f"{100.0 * kept:.4g} % {text}", amount=100.0 * kept, allowed=least))
    return broken


def _displacement(origins: Origins, moved: Moved | None, limit: float, limit_text: str, unit: str) -> Iterator[Breach]:
    if moved is None or not moved.largest > limit:
        return
    others = int((origins.displaced[1] > limit).sum()) - 1
    number = origins.vertices[moved.vertex]
    vertex = f"vertex {moved.vertex}" + (f" (vertex {number} of the input)" if number not in (-1, moved.vertex) else "")
    verb = "has moved by" if moved.same else "lies away from the input by"
    is_in_mesh_units = limit_text in (repr(limit), f"{limit!r}{unit.strip()}")
    digits = next(d for d in (6, 9, 17) if f"{moved.largest:.{d}g}" != f"{limit:.{d}g}")  # the texts must differ
    allowed = f"{limit!r}{unit}" if is_in_mesh_units else f"{limit_text} = {limit:.{digits}g}{unit}"
    further = f"; {counted(others, 'more vertex exceeds it', 'more vertices exceed it')}" if others else ""
    message = (
        f"{vertex} at ({point_text(moved.place)}) {verb} {moved.largest:.{digits}g}{unit}, which is more than {allowed}{further}"
    )
    yield Breach("max_displacement", message, moved.vertex, moved.place, moved.largest, limit)


def _volume(before: float | None, after: float | None, limit: float) -> Iterator[Breach]:
    if before is None or after is None:
        side = "the input" if before is None else "the result"
        yield Breach("max_volume_change", f"{side} is not closed and oriented, so it has no volume to compare")
        return
    change = 100.0 * (after - before) / abs(before) if before else float("inf") if after else 0.0
    if abs(change) > limit:
        text = f"the volume changed from {before:.6g} to {after:.6g}, by {change:+.4g} %, which is more than {limit:g} %"
        yield Breach("max_volume_change", text, amount=change, allowed=limit)


def _requirement(word: str, number: int | None, measures: SurfaceMeasures) -> Iterator[Breach]:
    """The breach of one requirement; `print_faults` checks "printable" on the written file."""
    if word == "watertight" and not measures.closed:
        border, shared = measures.border_edges, measures.non_manifold_edges
        text = f"the result is not watertight: border edges {border:,}, edges of more than two faces {shared:,}"
        yield Breach("require", text, amount=border + shared, allowed=0)
    elif word == "oriented" and not measures.oriented:
        yield Breach("require", "the result is not oriented: neighbouring faces are oriented differently")
    elif word == "manifold":
        edges, vertices = measures.non_manifold_edges, measures.non_manifold_vertices
        if edges or vertices:
            text = f"the result is not manifold: non-manifold edges {edges:,}, non-manifold vertices {vertices:,}"
            yield Breach("require", text, amount=edges + vertices, allowed=0)
    elif number is not None and (measured := getattr(measures, word)) != number:
        text = "no genus" if measured is None else f"{word} {measured}"
        yield Breach("require", f"the result has {text}, not {number}", amount=measured, allowed=number)


PRINTABLE = "printable"  # the requirement that `print_faults` checks
_PLACES = 3  # the most places that a message names


def print_faults(mesh: MeshData, folder: Path | None = None, *, wrapped: bool = False) -> Iterator[Breach]:
    """Faults for printing: borders, non-manifold edges and vertices, flipped, inward or intersecting faces, and no volume.

    MeshLab finds the intersecting faces, with its files in `folder`. If `folder` is None, MeshLab runs in a process of its own,
    and a crash there raises `RunError`. If the mesh is `wrapped`, the message advises other settings of the wrap.
    """
    firsts, numbers = numbered(mesh.vertices)
    vertices, faces = mesh.vertices[firsts], numbers[mesh.faces].astype(np.int32)
    measures = surface_measures(vertices, faces)
    # Degenerate faces count, as a slicer sees them too.
    sides = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends, edge_of_side, counts = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    upwards = np.bincount(edge_of_side.ravel(), weights=sides[:, 0] < sides[:, 1], minlength=len(ends))
    same_way = (upwards == 0) | (upwards == counts)
    wrong_edges = {
        ("border edge", "border edges"): counts == 1,
        ("edge with more than two faces", "edges with more than two faces"): counts > 2,
        ("edge whose two faces look to different sides", "edges whose two faces look to different sides"): same_way
        & (counts == 2),
    }
    remedy = "wrap with another alpha or offset" if wrapped else "take wrap_for_print, which wraps all in one surface"
    advice = f"mend these places, or {remedy}"
    for nouns, wrong in wrong_edges.items():
        yield from _faults(nouns, vertices, ends[wrong], advice)
    if measures.closed and not measures.non_manifold_edges and measures.non_manifold_vertices:
        touching = np.flatnonzero(stars(faces[proper_faces(faces)], len(vertices)).kinds == IRREGULAR).astype(np.int32)
        nouns = ("vertex where the surface touches itself", "vertices where the surface touches itself")
        yield from _faults(nouns, vertices, touching[:, None])
    if measures.volume is not None:
        yield from _inward(vertices, faces)
    if measures.volume == 0.0 or not len(faces):
        yield Breach("require", "the written file has no volume", amount=0.0)
    merged = MeshData(vertices=vertices, faces=faces)
    cuts = self_intersecting_apart(merged) if folder is None else self_intersecting(merged, folder)
    yield from _faults(("face that cuts others", "faces that cut others"), vertices, faces[cuts], advice)


def _inward(vertices: Floats, faces: Ints, subject: str = "the written file") -> Iterator[Breach]:
    inward = faces[inward_faces(vertices, faces)]
    advice = "turn these parts over: select them, and run Invert Faces Orientation on the selection"
    nouns = ("face of parts that look inwards", "faces of parts that look inwards")
    yield from _faults(nouns, vertices, inward, advice, subject)


def wall_words(mesh: MeshData, unit: str | None) -> str:
    """A sentence on the wall thickness of a closed mesh and its thinnest place; empty if no walls face each other."""
    if not len(mesh.faces):
        return ""
    walls = wall_thickness(mesh.vertices, mesh.faces)
    thinnest = int(walls.values.argmin())
    if not np.isfinite(walls.values[thinnest]):
        return ""
    suffix = f" {unit}" if unit else ""
    return (
        f"walls: half of the area is thicker than {walls.below(0.5):.4g}{suffix}, "
        f"1 % is thinner than {walls.below(0.01):.4g}{suffix}, "
        f"the thinnest place is {walls.values[thinnest]:.4g}{suffix} at {point_text(walls.places[thinnest])}; "
        "thin walls are kept as they are"
    )


def wrap_words(scan: MeshData, wrap: MeshData) -> str:
    """A sentence on the share of a scan's area that is over 2 d from the wrap; d is the wrap's mean distance from the scan."""
    if not len(scan.faces):
        return ""
    areas = vector_lengths(cross_products(scan.vertices, scan.faces))
    mean_distance = np.abs(Surface.of(scan.vertices, scan.faces).nearest(wrap.vertices).signed).mean()
    depths = np.abs(Surface.of(wrap.vertices, wrap.faces).nearest(scan.vertices[scan.faces].mean(axis=1)).signed)
    share = areas[depths > 2.0 * mean_distance].sum() / max(areas.sum(), np.finfo(np.float64).tiny)
    return f"{share:.1%} of the scanned area is enclosed: inside, or in hollows narrower than alpha; less with a smaller alpha"


def _faults(
    nouns: tuple[str, str], vertices: Floats, cells: Ints, advice: str = "", subject: str = "the written file"
) -> Iterator[Breach]:
    """The breach by (k, 1) vertices, (k, 2) edges or (k, 3) faces, with the middles of their largest connected groups."""
    if not len(cells):
        return
    n = len(vertices)
    ends = np.concatenate([cells[:, [0, -1]], cells[:, [0, len(cells[0]) // 2]]])
    links = sparse.coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
    place_of = sparse.csgraph.connected_components(links, directed=False)[1][cells[:, 0]]
    places, sizes = np.unique(place_of, return_counts=True)
    largest = places[np.argsort(-sizes, kind="stable")][:_PLACES]
    middles = [vertices[np.unique(cells[place_of == place])].mean(axis=0).tolist() for place in largest]
    more = f", and {counted(len(places) - _PLACES, 'more place')}" if len(places) > _PLACES else ""
    around = "; ".join(map(point_text, middles))
    text = f"{subject} has {counted(len(cells), *nouns)}, around {around}{more}{advice and f'; {advice}'}"
    yield Breach("require", text, place=tuple(middles[0]), amount=len(cells), allowed=0)
