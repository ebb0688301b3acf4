"""Closing holes by surfaces that continue the one around them."""

from collections import Counter
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Bools, Edit, Enum, FilterClass, Int, Ints, Layer, MeshElement, mesh_filter
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.holes import HoleEnergy, HoleFilling, OpenRim, close_holes
from pymeshfair.filters.topology import non_manifold_edges

from .moving_vertices import ADDS_ELEMENTS, MOVES_VERTICES, additions

Mark: TypeAlias = Literal["none", "scalar", "color"]
Islands: TypeAlias = Literal["join", "leave"]

#: red, green, blue, opacity of marked faces
ORANGE = (1.0, 128 / 255, 0.0, 1.0)
#: at most so many rims that were left open get a note of their own
MOST_NAMED = 5
#: and so many that were closed
MOST_CLOSED_NAMED = 20


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
    islands: Annotated[Islands, Enum()] = "join",
    selected: Annotated[bool, Bool(label="Holes at the selection only")] = False,
    mark: Annotated[Mark, Enum(label="Mark new faces")] = "none",
    progress: Progress = ignore_progress,
) -> Edit:
    """Closes holes with triangles as dense as those around, which continue the surface smoothly across the rim.

    What is there stays as it is, textures too. New vertices and faces come last and are the ones that are selected afterwards, so
    that a next step can delete, smooth or measure them. Colours go on smoothly from the rim, and a new face
    shows a place of the texture near by whose colour does. Scalars are those of the rim. A mark is written if
    a hole was closed: "scalar" overwrites the scalars of all faces, "color" the colours of the new ones. Returns how many holes
    were closed and the edges of each rim, how many vertices and faces are new, how many holes were filled by a lower energy, and
    how many rims were left open, why and with how many edges; the largest are named one by one.

    Args:
        max_edges: The most edges that the rim of a hole may have. Larger closes larger holes; one of 10,000 edges takes half a
            gigabyte of memory. Outer borders of open sheets stay open, whatever their size: rims that turn like that of a flat
            disc, and those that span more than a third of the area of their sheet, unless they are selected.
        energy: How the new vertices are placed: 'membrane' spans a hole like a soap film, with a crease at its rim; 'thin_plate'
            continues the tangent planes around; 'minimum_variation' continues the curvatures too, so that what is round stays
            round, and follows noise at the rim; 'none' leaves them flat as they were made. A hole at whose rim there are
            degenerate triangles may get a lower energy than the others, which is said.
        refine: Split the new faces until they are as dense as those around. Without, a hole is closed by faces between the
            vertices of its rim alone, and nothing is faired.
        rounds: How often the new faces are refined and faired. More let a filling bulge further where its rim suggests that.
        islands: Pieces of surface that lie loose in a hole: 'join' makes them part of the filling, or leaves the hole open if
            that cannot be done; 'leave' fills the hole without regard to them.
        selected: Close only holes whose rim has a selected vertex, or a vertex of a selected face, those too that otherwise count
            as outer borders by their area.
        mark: How new faces are marked in a saved file: 'scalar' gives each the number of the hole that it closes, from 1, and all
            others 0, in place of the scalars that faces had; 'color' paints them orange, and the others white if faces had no
            colours; 'none' leaves both as they are.
    """
    how: dict[str, Any] = {"max_edges": max_edges, "energy": energy, "refine": refine, "rounds": rounds, "islands": islands}
    touched = _touched(layer) if selected else None
    filling = close_holes(layer.vertices, layer.faces, **how, selected=touched, progress=progress)
    added = additions(layer, filling.new_vertices, filling.new_faces)
    notes = [*_closed(layer, filling), *_lowered(filling, energy), *_left_open(layer, filling)]
    if not (filling.closed or filling.left_open):
        notes.append(_no_hole(layer))
    marks = _marks(layer, filling, added["face_selection"], mark)
    return Edit(**added, **marks, values=_values(filling, energy), notes=tuple(notes))


def _touched(layer: Layer) -> Bools:
    """(n,) the vertices that are selected or have a selected face; raises `MeshError` if there are none."""
    touched = layer.vertex_selection.copy()
    touched[layer.faces[layer.face_selection]] = True
    return touched if touched.any() else layer.selected_vertices()


def _marks(layer: Layer, filling: HoleFilling, new_faces: Bools, mark: Mark) -> dict[str, Any]:
    if not filling.closed:
        return {}
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


def _values(filling: HoleFilling, energy: HoleEnergy) -> dict[str, Any]:
    return {
        "closed_holes": len(filling.closed),
        "new_vertices": len(filling.new_vertices),
        "new_faces": len(filling.new_faces),
        "joined_islands": sum(len(island) > 0 for island in filling.islands),
        "closed_rim_edges": [len(rim) for rim in filling.closed],
        "lower_energy_holes": len(_lower(filling, energy)),
        "left_open": dict(sorted(Counter(rim.reason for rim in filling.left_open).items())),
        "left_open_rim_edges": [len(rim.vertices) for rim in filling.left_open],
    }


def _lower(filling: HoleFilling, energy: HoleEnergy) -> list[int]:
    """The holes that have new vertices which another energy than this one placed."""
    refined = set(filling.hole_of_vertex.tolist())
    return [k for k, used in enumerate(filling.energies) if used != energy and k in refined]


def _lowered(filling: HoleFilling, energy: HoleEnergy) -> list[str]:
    """One sentence for each hole that was placed by a lower energy than that of the parameter."""
    reasons = (
        f"the equations of {energy!r} are too ill-conditioned there, as at triangles without area",
        f"that of {energy!r} would reach further out of its rim than the rim is wide, as beside a spike",
    )
    notes = [
        f"the filling of the rim of {len(filling.closed[k])} edges through vertex {filling.closed[k][0]} was placed with energy "
        f"{filling.energies[k]!r}: {reasons[bool(filling.thrown_out[k])]}"
        for k in _lower(filling, energy)
    ]
    return _cut(notes, MOST_NAMED, "{} more fillings were placed with a lower energy")


def _cut(notes: list[str], most: int, more: str) -> list[str]:
    """The first notes, and a sentence on how many `more` there are."""
    return notes if len(notes) <= most else [*notes[:most], more.format(len(notes) - most)]


def _closed(layer: Layer, filling: HoleFilling) -> list[str]:
    """One sentence a closed hole, the largest first."""
    largest = sorted(filling.closed, key=lambda rim: -len(rim))
    notes = [f"closed a hole of {len(rim)} edges around {_place(layer, rim)}" for rim in largest]
    size = len(largest[MOST_CLOSED_NAMED]) if len(largest) > MOST_CLOSED_NAMED else 0
    return _cut(notes, MOST_CLOSED_NAMED, f"closed {{}} more, of at most {size} edges")


def _no_hole(layer: Layer) -> str:
    """A sentence on a mesh without any border, which may be hidden by faces that are there twice."""
    crowded = len(non_manifold_edges(layer.faces))
    if crowded == 0:
        return "there is no hole: every edge has two faces"
    return (
        f"no hole was found: no edge has one face alone, but {crowded} have more than two; faces that are there twice hide "
        "holes, so remove duplicate faces first"
    )


def _left_open(layer: Layer, filling: HoleFilling) -> list[str]:
    """One sentence a rim for those that a user may want closed, the largest first, and one on outer borders."""
    named: list[OpenRim] = [rim for rim in filling.left_open if rim.reason not in ("selection", "outer")]
    named.sort(key=lambda rim: -len(rim.vertices))
    size = len(named[MOST_NAMED].vertices) if len(named) > MOST_NAMED else 0
    notes = [f"{rim.message}; it is around {_place(layer, rim.vertices)}" for rim in named]
    notes = _cut(notes, MOST_NAMED, f"{{}} more rims were left open, of at most {size} edges")
    if not filling.closed and filling.left_open and not named:
        unselected = any(rim.reason == "selection" for rim in filling.left_open)
        notes.append(
            f"no hole was closed: there are only outer borders{' and rims without a selected vertex' if unselected else ''}"
        )
    outer = sorted((len(rim.vertices) for rim in filling.left_open if rim.reason == "outer"), reverse=True)
    if len(outer) == 1:
        notes.append(f"left the outer border of an open sheet, of {outer[0]} edges")
    elif outer:
        notes.append(f"left {len(outer)} outer borders of open sheets, of {outer[0]} edges and fewer")
    return notes


def _place(layer: Layer, vertices: Ints) -> str:
    x, y, z = layer.vertices[vertices].mean(axis=0).tolist()
    return f"{x:.6g}, {y:.6g}, {z:.6g}"
