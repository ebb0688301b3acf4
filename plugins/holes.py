"""Closing holes by surfaces that continue the one around them."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Bools, Edit, Enum, FilterClass, Int, Layer, MeshElement, mesh_filter
from pymeshfair.filters.holes.close_holes import HOLE_ENERGIES, HoleEnergy, close_holes
from pymeshfair.filters.holes.filling import HoleFilling, OpenRim
from pymeshfair.filters.progress import Progress, ignore_progress

Mark: TypeAlias = Literal["none", "scalar", "color"]
MARKS: tuple[Mark, ...] = ("none", "scalar", "color")
Islands: TypeAlias = Literal["join", "leave"]
ISLANDS: tuple[Islands, ...] = ("join", "leave")

#: red, green, blue, opacity of marked faces
ORANGE = (1.0, 128 / 255, 0.0, 1.0)
#: as many rims that were left open are told one by one
MOST_TOLD = 5

_CHANGES = (
    MeshElement.VERTCOORD
    | MeshElement.VERTNUMBER
    | MeshElement.FACENUMBER
    | MeshElement.VERTNORMAL
    | MeshElement.FACENORMAL
    | MeshElement.VERTFLAGSELECT
    | MeshElement.FACEFLAGSELECT
    | MeshElement.FACEQUALITY
    | MeshElement.FACECOLOR
)


@mesh_filter(
    name="Close Holes by Fairing",
    classes=FilterClass.REMESHING | FilterClass.CLEANING,
    requires=MeshElement.FACENUMBER,
    changes=_CHANGES,
    references=("liepa2003",),
)
def meshing_close_holes_by_fairing(
    layer: Layer,
    *,
    max_edges: Annotated[
        int,
        Int(
            label="Largest hole",
            minimum=3,
            maximum=100_000,
            help="The most edges that the rim of a hole may have. Larger closes larger holes. Outer borders of open sheets are "
            "told from holes by their shape and stay open.",
        ),
    ] = 300,
    energy: Annotated[
        HoleEnergy,
        Enum(
            label="Energy",
            choices=HOLE_ENERGIES,
            help="How the new vertices are placed: 'membrane' spans a hole like a soap film, with a crease at its rim; "
            "'thin_plate' continues the tangent planes around; 'minimum_variation' continues the curvatures too, so that what is "
            "round stays round, and follows noise at the rim; 'none' leaves them flat as they were made.",
        ),
    ] = "thin_plate",
    refine: Annotated[
        bool,
        Bool(
            label="Refine",
            help="Split the new faces until they are as dense as those around. Without, a hole is closed by faces between the "
            "vertices of its rim alone, and nothing is faired.",
        ),
    ] = True,
    rounds: Annotated[
        int,
        Int(
            label="Rounds",
            minimum=1,
            maximum=100,
            advanced=True,
            help="How often the new faces are refined and faired. More let a filling bulge further where its rim suggests that.",
        ),
    ] = 3,
    islands: Annotated[
        Islands,
        Enum(
            label="Islands",
            choices=ISLANDS,
            help="Pieces of surface that lie loose in a hole: 'join' makes them part of the filling, 'leave' fills the hole "
            "without regard to them.",
        ),
    ] = "join",
    selected: Annotated[
        bool,
        Bool(
            label="Holes at the selection only",
            help="Close only holes whose rim has a selected vertex, or a vertex of a selected face.",
        ),
    ] = False,
    mark: Annotated[
        Mark,
        Enum(
            label="Mark new faces",
            choices=MARKS,
            help="How new faces are told from the others in a saved file: 'scalar' gives each the number of the hole that it "
            "closes, from 1, and all others 0; 'color' paints them orange; 'none' leaves both as they are.",
        ),
    ] = "scalar",
    progress: Progress = ignore_progress,
) -> Edit:
    """Closes holes with triangles as dense as those around, which continue the surface smoothly across the rim.

    What is there stays as it is, textures too. New vertices and faces come last and are the ones that are selected afterwards, so
    that a next step can delete, smooth or measure them. They take colours, scalars and texture from the rim. Returns how many
    holes were closed and the edges of each rim, how many vertices and faces are new, and how many rims were left open, why and
    with how many edges; the largest are told one by one.
    """
    filling = close_holes(
        layer.vertices,
        layer.faces,
        max_edges=max_edges,
        energy=energy,
        refine=refine,
        rounds=rounds,
        islands=islands,
        selected=_touched(layer) if selected else None,
        progress=progress,
    )
    n, m = len(layer.vertices), len(layer.faces)
    new_faces = np.arange(m + len(filling.new_faces)) >= m
    return Edit(
        added_vertices=filling.new_vertices,
        added_faces=filling.new_faces,
        vertex_selection=np.arange(n + len(filling.new_vertices)) >= n,
        face_selection=new_faces,
        **_marks(layer, filling, new_faces, mark),
        values=_values(filling),
        notes=_notes(filling),
    )


def _touched(layer: Layer) -> Bools:
    """(n,) the vertices that are selected or have a selected face; raises `MeshError` if there are none."""
    touched = layer.vertex_selection.copy()
    touched[layer.faces[layer.face_selection]] = True
    return touched if touched.any() else layer.selected_vertices()


def _marks(layer: Layer, filling: HoleFilling, new_faces: Bools, mark: Mark) -> dict[str, Any]:
    if mark == "scalar":
        numbers = np.zeros(len(new_faces))
        numbers[new_faces] = filling.hole_of_face + 1.0
        return {"face_scalars": numbers}
    if mark == "color":
        colors = np.ones((len(new_faces), 4))
        if layer.has_face_colors:
            colors[~new_faces] = layer.face_colors
        colors[new_faces] = ORANGE
        return {"face_colors": colors}
    return {}


def _values(filling: HoleFilling) -> dict[str, Any]:
    return {
        "closed_holes": len(filling.closed),
        "new_vertices": len(filling.new_vertices),
        "new_faces": len(filling.new_faces),
        "joined_islands": sum(len(island) > 0 for island in filling.islands),
        "closed_rim_edges": [len(rim) for rim in filling.closed],
        "left_open": dict(sorted(Counter(rim.reason for rim in filling.left_open).items())),
        "left_open_rim_edges": [len(rim.vertices) for rim in filling.left_open],
    }


def _notes(filling: HoleFilling) -> tuple[str, ...]:
    """One sentence a rim for those that somebody may want closed, the largest first."""
    if not filling.closed and not filling.left_open:
        return ("there is no hole: every edge has two faces",)
    told: list[OpenRim] = [rim for rim in filling.left_open if rim.reason not in ("selection", "outer")]
    told.sort(key=lambda rim: -len(rim.vertices))
    notes = [rim.message for rim in told[:MOST_TOLD]]
    if len(told) > MOST_TOLD:
        notes.append(f"{len(told) - MOST_TOLD} more rims were left open, of at most {len(told[MOST_TOLD].vertices)} edges")
    if not filling.closed and not told:
        notes.append("no hole was closed: there are only outer borders" + _or_unselected(filling.left_open))
    return tuple(notes)


def _or_unselected(rims: tuple[OpenRim, ...]) -> str:
    return " and rims without a selected vertex" if any(rim.reason == "selection" for rim in rims) else ""
