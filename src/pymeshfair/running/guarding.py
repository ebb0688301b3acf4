"""The guards of a run that a result breaks: where, and by how much."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..filters.inspection import SHARP, share_kept, sharp_edges
from ..scripts.guards import Guards
from .origins import Origins
from .shape_change import Moved, ShapeChange


@dataclass(frozen=True)
class Breach:
    """One guard that was broken."""

    guard: str  # its name
    message: str  # the breach, its place, and the allowed amount
    vertex: int | None = None  # the vertex of the result that it happened at; None if it concerns the whole
    place: tuple[float, float, float] | None = None  # (x, y, z) of that vertex
    amount: float | None = None  # the measured amount; None if it could not be measured
    allowed: float | None = None  # the allowed amount, in the same unit


def breaches(
    guards: Guards,
    origins: Origins,
    change: ShapeChange | None,
    measures_before: Mapping[str, Any] | None,
    measures_after: Mapping[str, Any] | None,
    *,
    unit: str | None = None,
) -> list[Breach]:
    """The guards that a result breaks; none without measures, where there can be no limits."""
    if measures_before is None or measures_after is None or change is None:
        return []
    before, result = origins.before, origins.result
    broken: list[Breach] = []
    edge = measures_before["mean_edge"] or measures_before["mean_spacing"] or 0.0
    if guards.max_displacement is not None:
        allowed = guards.in_mesh_units(unit).max_displacement
        assert allowed is not None
        limit = allowed.resolve(diagonal=measures_before["diagonal"], mean_edge=lambda: edge)
        broken += _displacement(origins, change.moved, limit, str(guards.max_displacement), f" {unit}" if unit else "")
    if guards.max_volume_change is not None:
        broken += _volume(measures_before["volume"], measures_after["volume"], guards.max_volume_change)
    for word, number in guards.require:
        broken += _requirement(word, number, measures_after)
    if guards.keep_sharp is not None:
        kept = share_kept(sharp_edges(before.vertices, before.faces), sharp_edges(result.vertices, result.faces), within=edge)
        if kept is not None and 100.0 * kept < guards.keep_sharp:
            text = f"{100.0 * kept:.4g} % of the length of the edges sharper than {SHARP:g} degrees are kept"
            broken.append(
                Breach("keep_sharp", f"{text}, not {guards.keep_sharp:g} %", amount=100.0 * kept, allowed=guards.keep_sharp)
            )
    return broken


def _displacement(origins: Origins, moved: Moved | None, limit: float, said: str, unit: str) -> Iterator[Breach]:
    # Added vertices have not moved; where nothing could be followed, the distance from the surface is all there is.
    if moved is None or not moved.largest > limit:
        return
    others = int((origins.displaced[1] > limit).sum()) - 1
    x, y, z = moved.place
    number = origins.vertices[moved.vertex]
    named = f"vertex {moved.vertex}" + (f" (vertex {number} of the input)" if number not in (-1, moved.vertex) else "")
    verb = "has moved by" if moved.same else "lies away from the input by"
    alone = said in (repr(limit), f"{limit!r}{unit.strip()}")
    allowed = f"{limit!r}{unit}" if alone else f"{said} = {limit:.6g}{unit}"
    more = f"; so do {others:,} others" if others else ""
    message = f"{named} at ({x:.6g}, {y:.6g}, {z:.6g}) {verb} {moved.largest:.6g}{unit}, which is more than {allowed}{more}"
    yield Breach("max_displacement", message, moved.vertex, moved.place, moved.largest, limit)


def _volume(before: float | None, after: float | None, limit: float) -> Iterator[Breach]:
    if before is None or after is None:
        side = "the input" if before is None else "the result"
        yield Breach("max_volume_change", f"{side} is not closed and oriented, so it has no volume that could be compared")
        return
    change = 100.0 * (after - before) / abs(before) if before else float("inf") if after else 0.0
    if abs(change) > limit:
        text = f"the volume changed from {before:.6g} to {after:.6g}, by {change:+.4g} %, which is more than {limit:g} %"
        yield Breach("max_volume_change", text, amount=change, allowed=limit)


def _requirement(word: str, number: int | None, measures: Mapping[str, Any]) -> Iterator[Breach]:
    if word == "watertight" and not measures["closed"]:
        count = measures["border_edges"]
        yield Breach("require", f"the result is not watertight: it has {count:,} border edges", amount=count, allowed=0)
    elif word == "oriented" and not measures["oriented"]:
        yield Breach("require", "the result is not oriented: neighbouring faces look to different sides")
    elif word == "printable":
        return  # seen on the written file, see `pymeshfair.running.printable`
    elif word == "manifold":
        edges, vertices = measures["non_manifold_edges"], measures["non_manifold_vertices"]
        if edges or vertices:
            text = f"the result has {edges:,} non-manifold edges and {vertices:,} non-manifold vertices"
            yield Breach("require", text, amount=edges + vertices, allowed=0)
    elif number is not None and measures[word] != number:
        has = "no genus" if measures[word] is None else f"{word} {measures[word]}"
        yield Breach("require", f"the result has {has}, not {number}", amount=measures[word], allowed=number)
