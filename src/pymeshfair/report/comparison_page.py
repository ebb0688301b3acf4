"""The report on two meshes: verdict, pictures, 3D view, numbers, charts, and the run that made the second from the first."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ..declaration import Floats
from ..filters.geometry import edge_lengths, vector_lengths
from ..filters.inspection import Limits, mean_curvature, robust_limits, symmetric_limits, triangle_shapes
from ..filters.topology import border_vertices, referenced_vertices
from ..looking.comparison import Compared, Comparison, compare, same_elements, state_of
from ..looking.picture import BAR_STRIP, COLORINGS, VIEWS, Appearance, Numbers, draw_color_bar, draw_meshes, in_unit
from ..looking.words import (
    MOST_AREAS,
    area_table,
    became_text,
    change_lines,
    comparison_lines,
    distance_table,
    measure_rows,
    verdict_text,
)
from ..places import counted, without_folders
from ..running.job import plain, steps_of
from ..running.read import ReadMesh
from .page import Chart, Figure, SectionChart, figure_of, histogram, render
from .scene import Marker, Scene, Shown, pack_scene, shown_mesh

#: the side in pixels of a picture of a mesh, and of a view of the distances
_PICTURE, _VIEW = 400, 300
_PATH = re.compile(r'"(?:path|file)": ("(?:[^"\\]|\\.)*")')  # of a file in a record


@dataclass(frozen=True)
class Verdict:
    """The verdict of a report."""

    kind: str  # "good", "info", "warn" or "bad", which the style sheet shows by a colour
    text: str  # the main sentence
    lines: tuple[str, ...] = ()  # further sentences


def comparison_page(
    compared: Compared,
    *,
    title: str,
    subtitle: str,
    numbers: Mapping[str, Any],
    verdict: Verdict | None = None,
    markers: Sequence[Marker] = (),
    warnings: Sequence[str] = (),
    run: Mapping[str, Any] | None = None,
    provenance: str = "",
    up: str = "y",
    limits: Limits | None = None,
    sections: Sequence[SectionChart] = (),
    unit: str | None = None,
) -> bytes:
    """Returns the report as the bytes of an HTML file.

    The page shows `numbers` as JSON, and the `sections` of both meshes. After a run, `run` is its record and `provenance`
    the record's text. By default the comparison gives the verdict, the markers show the areas out of tolerance or the largest
    distance, and the colours end at the `symmetric_limits` of the distances, but at 1.5 times the tolerance at least.
    """
    comparison = compared.comparison
    least = 1.5 * compared.tolerance  # the colour bar must reach beyond the tolerance
    low, high = symmetric_limits(compared.after_distance.distances, comparison.rounding)
    ends = limits or Limits(min(low, -least), max(high, least))
    curvatures = {name: mean_curvature(m.vertices, m.faces) for name, m in compared.meshes.items() if len(m.faces)}
    scene, shown = _scene(compared, up, markers or _markers(comparison, unit), ends, curvatures, unit)
    text = render(
        "report.html",
        title=title,
        subtitle=subtitle,
        verdict=verdict or verdict_of(comparison, unit=unit),
        pictures=_pictures(compared, up, ends, unit),
        scene=scene,
        notes=[_decimation(mesh) for mesh in shown if mesh.decimated],
        change=change_lines(run["measures"]["change"], unit) if run and run["measures"]["change"] else (),
        distances=distance_table(comparison, unit),
        areas=area_table(comparison, unit),
        lines=comparison_lines(comparison, unit),
        measure_rows=measure_rows({"before": comparison.before, "after": comparison.after}, unit),
        sections=sections,
        charts=_charts(compared, ends, curvatures, unit or "mesh units"),
        unsought=not any(measures["self_intersecting_faces"] is not None for measures in (comparison.before, comparison.after)),
        warnings=warnings,
        run=run,
        steps=steps_of(run) if run else (),
        provenance=provenance,
        numbers=numbers,
        numbers_text=json.dumps(numbers, indent=1, ensure_ascii=False),
        made=f"Made by pymeshfair on {datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC. This page needs no network.",
    )
    return text.encode("utf-8", "replace")  # names of files may contain bytes that are no text


def verdict_of(comparison: Comparison, change: Mapping[str, Any] | None = None, unit: str | None = None) -> Verdict:
    """Returns the verdict on the distance of the surfaces; after a run, the main sentence is about the run's `change`."""
    text = verdict_text(comparison, unit)
    flipped = comparison.flipped_faces or 0
    lines = (f"{counted(flipped, 'face looks', 'faces look')} to the other side now.",) if flipped else ()
    if change:
        text, lines = f"{became_text(change, unit)}.", (text, *lines)
    if comparison.passed is not None:
        return Verdict("good" if comparison.passed else "bad", text, lines)
    return Verdict("good" if comparison.same_surface else "warn" if flipped else "info", text, lines)


def run_page(record: Mapping[str, Any], input: ReadMesh, output: ReadMesh, *, up: str = "y") -> bytes:
    """Returns the report of a run as the bytes of an HTML file; `record` is the provenance document."""
    paths = map(Path, (*map(json.loads, _PATH.findall(json.dumps(record))), *record["run"]["command"]))
    folders = {Path.cwd(), *(path.parent for path in paths if path.is_absolute())}
    record = without_folders(record, folders)
    compared = compare(state_of(input), state_of(output))
    comparison = replace(compared.comparison, displacement=None)  # the record has the exact one; the file has rounded coordinates
    change, unit = record["measures"]["change"] or {}, record["measures"]["unit"]
    names = {"before": Path(record["input"]["path"]).name, "after": Path(record["output"]["path"]).name}
    return comparison_page(
        replace(compared, comparison=comparison),
        title=f"{names['before']}: {record['recipe']['name']}",
        subtitle=f"The recipe {record['recipe']['name']} on {names['before']}, written to {names['after']}.",
        numbers={"files": names, "change": change, "comparison": plain(asdict(comparison))},
        up=up,
        unit=unit,
        warnings=record["warnings"],
        verdict=_verdict_of_run(record, verdict_of(comparison, change, unit)),
        markers=[Marker(b["place"], _title(b)) for b in record.get("guards", {}).get("breaches", ()) if b["place"]],
        run=record,
        provenance=json.dumps(record, indent=2, ensure_ascii=False),
    )


def _title(breach: Mapping[str, Any]) -> str:
    if breach["vertex"] is None:
        return str(breach["message"].partition(", around ")[0])
    return f"{breach['guard']}, vertex {breach['vertex']}"


def _verdict_of_run(record: Mapping[str, Any], of_change: Verdict) -> Verdict:
    guards = record.get("guards", {})
    steps = f"{counted(len(record['steps']), 'step')} in {record['run']['seconds']:.1f} s."
    lines = (of_change.text, *of_change.lines, steps)
    if breaches := guards.get("breaches"):
        count = "a limit" if len(breaches) == 1 else f"{len(breaches)} limits"
        text = f"The run went beyond {count}; the output was written all the same."
        return Verdict("bad", text, (*(f"{breach['guard']}: {breach['message']}." for breach in breaches), *lines))
    if limits := guards.get("limits"):
        unit = f" {record['measures']['unit'] or ''}".rstrip()
        texts = {n: f"{t}{unit if n == 'max_displacement' and t[-1].isdigit() else ''}" for n, t in limits.items()}
        kept = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in texts.items())
        return Verdict("good", f"Done, and every limit was kept: {kept}.", lines)
    return Verdict(of_change.kind, of_change.text, (*of_change.lines, f"{steps} No limits were set."))


def _markers(comparison: Comparison, unit: str | None) -> list[Marker]:
    suffix = f" {unit}" if unit else ""
    if comparison.out_of_tolerance:
        return [
            Marker(a.place, f"out of tolerance, distance {abs(a.amount):.4g}{suffix}", 0 if a.mesh == "before" else 1)
            for a in comparison.out_of_tolerance[:MOST_AREAS]
        ]
    after, before = comparison.after_from_before, comparison.before_from_after
    mesh, farther = (1, after) if after.largest.mesh_units >= before.largest.mesh_units else (0, before)
    if farther.largest.mesh_units == 0.0:
        return []
    return [Marker(farther.place, f"largest distance, {farther.largest.mesh_units:.4g}{suffix}", mesh)]


def _scene(
    compared: Compared, up: str, markers: Sequence[Marker], ends: Limits, curvatures: Mapping[str, Floats], unit: str | None
) -> tuple[Scene, list[Shown]]:
    before, after = compared.meshes.values()
    limits = {"distance": ends}
    scalars = {name: {"curvature": curvatures[name]} if name in curvatures else {} for name in compared.meshes}
    scalars["after"]["distance"] = compared.after_distance.at_vertices
    if compared.comparison.displacement is not None:
        scalars["after"]["displacement"] = vector_lengths(after.vertices - before.vertices)
        limits["displacement"] = robust_limits(scalars["after"]["displacement"])
    if curvatures:
        limits["curvature"] = symmetric_limits(np.concatenate(list(curvatures.values())))
    shown = [shown_mesh("before", before, scalars=scalars["before"])]
    like = shown[0] if same_elements(before, after) else None
    shown.append(shown_mesh("after", after, scalars=scalars["after"], like=like))
    return pack_scene(shown, limits, up=up, markers=markers, tolerance=compared.tolerance, unit=unit), shown


def _decimation(mesh: Shown) -> str:
    kind = "faces" if mesh.of_faces else "points"
    shown, whole = (len(mesh.elements), mesh.of_faces) if mesh.of_faces else (len(mesh.vertices), mesh.of_vertices)
    return (
        f"In three dimensions the mesh {mesh.name} is shown with {shown:,} of its {whole:,} {kind}, so that the page stays "
        "small. Pictures, numbers, charts and the colours are those of the whole mesh."
    )


def _pictures(compared: Compared, up: str, ends: Limits, unit: str | None) -> list[Figure]:
    unit_name, tolerance, has_sides = unit or "mesh units", compared.tolerance, len(compared.before.mesh.faces) > 0
    plain = Appearance(up=up, width=_PICTURE, height=_PICTURE, titles=False, unit=unit or "")
    whole = draw_meshes([*compared.meshes.values()], ["", ""], plain)
    panels = [whole.crop((k * _PICTURE, 0, (k + 1) * _PICTURE, _PICTURE)) for k in range(2)]
    figures = [
        figure_of(panels[0], "The mesh before, from the front.", f"Before, with a scale bar in {unit_name}"),
        figure_of(panels[1], "The mesh after, from the same place.", "After"),
    ]
    numbers = [Numbers(compared.after_distance.at_vertices)]
    look = replace(plain, color="distance", width=_VIEW, height=_VIEW, limits=ends, tolerance=tolerance)
    for side in ("front", "back", "left", "right", "top", "bottom"):
        azimuth, elevation = VIEWS[side]
        view = replace(look, azimuth=azimuth, elevation=elevation)
        drawn = draw_meshes([compared.after.mesh], [""], view, numbers=numbers)
        words = "orange outside of the mesh before, blue inside" if has_sides else "orange far from the cloud before"
        figures.append(figure_of(drawn.crop((0, 0, _VIEW, _VIEW)), f"The mesh after, {side}: {words}.", f"Distance, {side}"))
    within = f", within {tolerance:.4g} {unit_name} pale green" if tolerance else ""
    bar = Image.new("RGB", (3 * _PICTURE, BAR_STRIP), "white")
    coloring = COLORINGS["distance"]
    label = coloring.label if has_sides else "distance from the cloud before (mesh units)"
    draw_color_bar(bar, 4, ends, partial(coloring.colors, tolerance=tolerance), in_unit(label, unit))
    scale = figure_of(
        bar.crop((_PICTURE // 2, 0, bar.width - _PICTURE // 2, BAR_STRIP)),
        f"The colours of distances from {ends.low:.4g} to {ends.high:.4g} {unit_name}{within}.",
        f"The colours of distances: {'orange outwards, blue inwards' if has_sides else 'orange far away'}{within}",
    )
    return [*figures, scale]


def _charts(compared: Compared, ends: Limits, curvatures: Mapping[str, Floats], unit: str) -> list[Chart]:
    meshes, distance = compared.meshes, compared.after_distance
    used = {name: referenced_vertices(mesh.faces, len(mesh.vertices)) for name, mesh in meshes.items() if len(mesh.faces)}
    sides = ", outwards above 0" if "before" in used else ""
    distances = np.where(np.abs(distance.distances) > compared.comparison.rounding, distance.distances, 0.0)
    order = np.argsort(distances)
    by_area = np.searchsorted(np.cumsum(distance.weights[order]), (np.arange(len(order)) + 0.5) / len(order))
    charts = [histogram("Distance from the mesh before", f"{unit}{sides}", {"after": distances[order[by_area]]}, *ends)]
    if len(curvatures) == 2:
        inner = {name: used[name] & ~border_vertices(mesh.faces, len(mesh.vertices)) for name, mesh in meshes.items()}
        defined = {name: values[inner[name]] for name, values in curvatures.items()}  # a curvature is 0 where it is not defined
        ends = symmetric_limits(np.concatenate(list(defined.values())))
        charts.append(histogram("Mean curvature", f"1 / {unit.removesuffix('s')}", defined, *ends))
        edges = {  # the sides of all faces, so that an inner edge counts twice
            name: np.concatenate([edge_lengths(mesh.vertices, mesh.faces[:, [k, k - 1]]) for k in range(3)])
            for name, mesh in meshes.items()
        }
        charts.append(histogram("Edge lengths", unit, edges, 0.0, max(robust_limits(e).high for e in edges.values())))
        del edges  # frees about six numbers for each vertex
        shapes = {name: triangle_shapes(mesh.vertices, mesh.faces) for name, mesh in meshes.items()}
        charts.append(histogram("Shape of triangles", "1: equilateral, 0: degenerate", shapes, *Limits(0.0, 1.0)))
    return [chart for chart in charts if chart is not None]
