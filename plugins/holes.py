"""The filter that closes holes by fillings that continue the surrounding surface."""

from collections import Counter
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Bools, Edit, Enum, FilterClass, Int, Layer, MeshElement, mesh_filter, point_text
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.holes import HoleEnergy, HoleFilling, close_holes
from pymeshfair.filters.topology import non_manifold_edges

from .moving_vertices import ADDS_ELEMENTS, MOVES_VERTICES, additions

Mark: TypeAlias = Literal["none", "scalar", "color"]

ORANGE = (1.0, 128 / 255, 0.0, 1.0)  # the colour of marked faces
MOST_NAMED = 10  # the largest number of notes of each kind


@mesh_filter(
    name="Close Holes by Fairing",
    classes=FilterClass.REMESHING | FilterClass.CLEANING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES | ADDS_ELEMENTS | MeshElement.FACEQUALITY | MeshElement.FACECOLOR,
    references=("liepa2003",),
)
def meshing_close_holes_by_fairing(
    layer: Layer,
    *,
    max_edges: Annotated[int, Int(label="Largest hole", minimum=3, maximum=10_000)] = 300,
    energy: Annotated[HoleEnergy, Enum()] = "thin_plate",
    refine: Annotated[bool, Bool()] = True,
    rounds: Annotated[int, Int(minimum=1, maximum=100, advanced=True)] = 3,
    islands: Annotated[Literal["join", "leave"], Enum()] = "join",
    selected: Annotated[bool, Bool(label="Holes at the selection only")] = False,
    mark: Annotated[Mark, Enum(label="Mark new faces")] = "none",
    progress: Progress = ignore_progress,
) -> Edit:
    """Closes holes with triangles that are as dense as those around, and continue the surface smoothly across the rim.

    Old elements stay as they are, textures too. New vertices and faces come last and become the selection. They continue colours
    and scalars from the rim, and a new face shows a nearby place of the texture with a similar colour. Returns the numbers of
    closed holes, new vertices, new faces, holes with joined islands and holes filled with a lower energy than asked for, the
    number of open rims by reason, and the number of edges of each closed and each open rim; notes name the largest rims.

    Args:
        max_edges: The largest number of edges in the rim of a hole. Larger closes larger holes; a hole of 10,000 edges takes half
            a gigabyte of memory. Outer borders of open sheets stay open: most rims with a total geodesic curvature above 1.5 pi
            (a flat disc has 2 pi); and, unless selected, most that span more than a third of the area of their sheet.
        energy: How the new vertices are placed: 'membrane' spans a hole like a soap film, with a crease at its rim;
            'thin_plate' continues the tangent planes at the rim; 'minimum_variation' continues the curvatures too, and
            follows noise there; 'none' leaves them on the flat triangles that first close the hole. Degenerate triangles and
            spikes may need a lower energy (earlier in this list, or 'none'); notes say so.
        refine: Split the new faces until they are as dense as those around the hole. Otherwise there are no new vertices, and
            nothing is faired.
        rounds: How often the new faces are refined and faired. More rounds let a filling bulge further if the mesh bulges there.
        islands: What to do with loose pieces of surface in a hole: 'join' connects them to the filling, and leaves the hole open
            if that fails; 'leave' fills the hole as if they were not there.
        selected: Close only holes whose rim has a selected vertex, or a vertex of a selected face.
        mark: How new faces are marked in a saved file: 'scalar' replaces the face scalars by the number of the hole, from 1, and
            by 0 on old faces; 'color' paints new faces orange, and old faces white if they have no colours; 'none' does neither.
    """
    options: dict[str, Any] = {"max_edges": max_edges, "energy": energy, "refine": refine, "rounds": rounds, "islands": islands}
    touched = None
    if selected:
        touched = layer.vertex_selection.copy()
        touched[layer.faces[layer.face_selection]] = True
        touched = touched if touched.any() else layer.selected_vertices()  # raises an error
    filling = close_holes(layer.vertices, layer.faces, **options, selected=touched, progress=progress)
    added = additions(layer, filling.new_vertices, filling.new_faces)
    refined = set(filling.hole_of_vertex.tolist())
    lower = [k for k, used in enumerate(filling.energies) if used != energy and k in refined]
    values = {
        "closed_holes": len(filling.closed),
        "new_vertices": len(filling.new_vertices),
        "new_faces": len(filling.new_faces),
        "joined_islands": sum(len(island) > 0 for island in filling.islands),
        "closed_rim_edges": [len(rim) for rim in filling.closed],
        "lower_energy_holes": len(lower),
        "left_open": dict(sorted(Counter(rim.reason for rim in filling.left_open).items())),
        "left_open_rim_edges": [len(rim.vertices) for rim in filling.left_open],
    }
    marks = _marks(layer, filling, added["face_selection"], mark if filling.closed else "none")
    return Edit(**added, **marks, values=values, notes=tuple(_notes(layer, filling, energy, lower)))


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


def _notes(layer: Layer, filling: HoleFilling, energy: HoleEnergy, lower: list[int]) -> list[str]:
    if not (filling.closed or filling.left_open):
        non_manifold = len(non_manifold_edges(layer.faces))
        if non_manifold == 0:
            return ["there is no hole: every edge has two faces"]
        return [
            f"no hole was found: no edge has one face alone, but {non_manifold} have more than two; duplicate faces hide "
            "holes, so remove duplicate faces first"
        ]
    closed = sorted(filling.closed, key=len, reverse=True)
    left = [rim for rim in filling.left_open if rim.reason not in ("selection", "outer")]
    left.sort(key=lambda rim: -len(rim.vertices))
    reasons = (
        f"the equations of {energy!r} are too ill-conditioned there, as at triangles without area",
        f"with {energy!r} it would reach further out of its rim than the rim is wide, as beside a spike",
    )
    points = layer.vertices
    notes = [f"closed a hole of {len(rim)} edges around {point_text(points[rim].mean(axis=0))}" for rim in closed[:MOST_NAMED]]
    if len(closed) > MOST_NAMED:
        notes.append(f"further closed holes, of at most {len(closed[MOST_NAMED])} edges each: {len(closed) - MOST_NAMED}")
    notes += [
        f"the filling of the rim of {len(filling.closed[k])} edges through vertex {filling.closed[k][0]} was placed with energy "
        f"{filling.energies[k]!r}: {reasons[bool(filling.thrown_out[k])]}"
        for k in lower[:MOST_NAMED]
    ]
    notes += [f"{rim.message}; it is around {point_text(points[rim.vertices].mean(axis=0))}" for rim in left[:MOST_NAMED]]
    if outer := sum(rim.reason == "outer" for rim in filling.left_open):
        notes.append(f"outer borders of open sheets that were left open: {outer}")
    return notes or [f"no hole has a selected vertex: {len(filling.left_open)} stay open"]
