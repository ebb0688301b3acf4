"""The report of two meshes: verdict, pictures, 3D, numbers, charts, and what a run did between them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any

import numpy as np

from ..declaration import Floats
from ..filters.inspection import Displacement, Limits, mean_curvature, robust_limits, symmetric_limits, triangle_shapes
from ..looking.annotation import BAR_STRIP
from ..looking.comparison import Comparison
from ..looking.mesh_state import MeshState
from ..looking.picture import Appearance, draw_meshes
from ..looking.words import DISPLACEMENT_HEADERS, comparison_lines, displacement_rows, measure_rows
from ..running.job import StepReport
from .charts import Chart, histogram, spectrum_chart
from .display import Shown, shown_mesh
from .page import Figure, figure_of, render
from .scene import Marker, Scene, pack_scene

#: pixels of one picture
_PICTURE = 400


@dataclass(frozen=True)
class Verdict:
    """What came of it, in one sentence and some more.

    Attributes:
        kind: "good", "info", "warn" or "bad", which the style sheet shows by a colour.
        text: the sentence.
        lines: what else is to be said first.
    """

    kind: str
    text: str
    lines: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunPart:
    """What the report tells of a run.

    Attributes:
        steps: what they did.
        recipe: the script as text.
        provenance: the record as text.
    """

    steps: Sequence[StepReport]
    recipe: str
    provenance: str


@dataclass(frozen=True, eq=False)
class Compared:
    """Two meshes and what lies between them.

    Attributes:
        before: the first.
        after: the second.
        found: what `pymeshfair.looking.comparison.compare` found.
        moved: the displacement of every vertex of the second.
        spectra: by "before" and "after", what the filter ``get_surface_spectrum`` found; empty if it was not asked.
    """

    before: MeshState
    after: MeshState
    found: Comparison
    moved: Displacement
    spectra: Mapping[str, Mapping[str, Any]]


def comparison_page(
    compared: Compared,
    *,
    title: str,
    subtitle: str,
    numbers: Mapping[str, Any],
    verdict: Verdict | None = None,
    markers: Sequence[Marker] = (),
    warnings: Sequence[str] = (),
    left_out: Sequence[str] = (),
    run: RunPart | None = None,
    up: str = "y",
) -> str:
    """The report as the text of an HTML file.

    Args:
        compared: the meshes.
        title: of the page.
        subtitle: a sentence below it.
        numbers: the same document that the command prints with ``--json``, in terms of JSON.
        verdict: what came of it; made of the comparison if it is None.
        markers: places to show; the largest displacement if there are none.
        warnings: what is to be known.
        left_out: what the page does not show, and why.
        run: what lay between the meshes, if that is known.
        up: the upright axis, "y" or "z".
    """
    scene, shown = _scene(compared, up, markers or _largest(compared.found))
    return render(
        "report.html",
        title=title,
        subtitle=subtitle,
        verdict=verdict or verdict_of(compared.found),
        pictures=_pictures(compared, up),
        scene=scene,
        notes=[_decimation(mesh) for mesh in shown if mesh.decimated],
        displacement_headers=DISPLACEMENT_HEADERS,
        displacement_rows=displacement_rows(compared.found),
        lines=comparison_lines(compared.found),
        measure_rows=measure_rows({"before": compared.found.before, "after": compared.found.after}),
        charts=_charts(compared),
        left_out=left_out,
        warnings=warnings,
        run=run,
        numbers=numbers,
        numbers_text=json.dumps(numbers, indent=1, ensure_ascii=False),
        made=f"Made by pymeshfair on {datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC. This page needs no network.",
    )


def verdict_of(found: Comparison) -> Verdict:
    """How far what moved, in a sentence."""
    moved = found.displacement
    if found.hausdorff.mesh_units == 0.0 and moved.largest.mesh_units == 0.0:
        return Verdict("good", "Both meshes are the same surface: nothing moved.")
    of, most = moved.mean, moved.largest
    if of.mean_edges is not None and most.mean_edges is not None:
        text = f"Vertices moved by {of.mean_edges:.3g} mean edges on average, and by {most.mean_edges:.3g} at most."
    else:
        text = f"Points moved by {of.mesh_units:.4g} on average, and by {most.mesh_units:.4g} at most."
    flipped = found.flipped_faces or 0
    return Verdict("warn" if flipped else "info", text, (f"{flipped:,} faces look to the other side now.",) if flipped else ())


def _largest(found: Comparison) -> list[Marker]:
    moved = found.displacement
    if moved.largest.mesh_units == 0.0:
        return []
    return [Marker(moved.place, f"largest displacement, vertex {moved.vertex}")]


def _curvatures(compared: Compared) -> dict[str, Floats]:
    """The mean curvature of each mesh that has faces."""
    meshes = {"before": compared.before.mesh, "after": compared.after.mesh}
    return {name: mean_curvature(mesh.vertices, mesh.faces) for name, mesh in meshes.items() if len(mesh.faces)}


def _scene(compared: Compared, up: str, markers: Sequence[Marker]) -> tuple[Scene, list[Shown]]:
    curvatures = _curvatures(compared)
    limits = {"displacement": symmetric_limits(compared.moved.signed)}
    if curvatures:
        limits["curvature"] = symmetric_limits(np.concatenate(list(curvatures.values())))
    shown = []
    for name, state in (("before", compared.before), ("after", compared.after)):
        scalars = {"curvature": curvatures[name]} if name in curvatures else {}
        if name == "after":
            scalars["displacement"] = compared.moved.signed
        mesh = state.mesh
        shown.append(
            shown_mesh(
                name, mesh.vertices, mesh.faces, mesh.edges, normals=mesh.vertex_attributes.get("normals"), scalars=scalars
            )
        )
    return pack_scene(shown, limits, up=up, markers=markers), shown


def _decimation(mesh: Shown) -> str:
    what = "faces" if mesh.of_faces else "points"
    now, of = (len(mesh.elements), mesh.of_faces) if mesh.of_faces else (len(mesh.vertices), mesh.of_vertices)
    return (
        f"In three dimensions the mesh {mesh.name} is shown with {now:,} of its {of:,} {what}, so that the page stays small. "
        "Pictures, numbers, charts and the colours are those of the whole mesh."
    )


def _pictures(compared: Compared, up: str) -> list[Figure]:
    meshes = [compared.before.mesh, compared.after.mesh, compared.after.mesh]
    size = _PICTURE
    appearance = Appearance("displacement", azimuth=0.0, elevation=0.0, up=up, width=size, height=size, titles=False)
    whole = draw_meshes(meshes, ["", "", ""], appearance, plain=(0, 1))
    panels = [whole.crop((k * size, 0, (k + 1) * size, size)) for k in range(3)]
    # The bar is in the middle half of the strip, its ends are written beside it.
    bar = whole.crop((size // 2, size, whole.width - size // 2, size + BAR_STRIP))
    moved = compared.found.displacement
    words = (
        ("The mesh before, from the front.", "Before, with a scale bar in mesh units"),
        ("The mesh after, from the same place.", "After"),
        (
            "The mesh after, orange where it lies outside of the mesh before, blue where inside; "
            f"mean {moved.mean.mesh_units:.4g}, largest {moved.largest.mesh_units:.4g} mesh units.",
            "What moved: orange outwards, blue inwards",
        ),
    )
    low, high = symmetric_limits(compared.moved.signed)
    scale = figure_of(bar, f"The colours of displacements from {low:.4g} to {high:.4g} mesh units.", "The colours of what moved")
    return [*(figure_of(panel, *text) for panel, text in zip(panels, words, strict=True)), scale]


def _charts(compared: Compared) -> list[Chart]:
    before, after = compared.before.mesh, compared.after.mesh
    limits = symmetric_limits(compared.moved.signed)
    charts = [histogram("Displacement", "mesh units, outwards above 0", {"after": compared.moved.signed}, *limits)]
    if len(before.faces) and len(after.faces):
        edges = {name: _edge_lengths(mesh.vertices, mesh.faces) for name, mesh in (("before", before), ("after", after))}
        shapes = {"before": triangle_shapes(before.vertices, before.faces), "after": triangle_shapes(after.vertices, after.faces)}
        curvatures = _curvatures(compared)
        every = np.concatenate(list(curvatures.values()))
        charts += [
            histogram("Mean curvature", "1 / mesh unit", curvatures, *symmetric_limits(every)),
            histogram("Edge lengths", "mesh units", edges, 0.0, robust_limits(np.concatenate(list(edges.values()))).high),
            histogram("Shape of triangles", "1: equilateral, 0: degenerate", shapes, *Limits(0.0, 1.0)),
        ]
    charts.append(spectrum_chart(compared.spectra))
    return [chart for chart in charts if chart is not None]


def _edge_lengths(vertices: Floats, faces: Any) -> Floats:
    """The length of every side of every face; an inner edge counts twice."""
    corners = vertices[faces]
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).ravel())
