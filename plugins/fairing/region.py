"""Region fairing: the selected part as smooth as its surroundings allow."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Bools, Edit, Enum, FilterClass, Int, Layer, MeshElement, mesh_filter
from pymeshfair.errors import MeshError
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.fairing import ENERGIES, Energy, fair_region
from pymeshfair.filters.holes import remesh_region

from ..moving_vertices import MOVES_VERTICES, irregular_note

# A note is given if the area of a region falls below this share.
_SHRUNK = 1 / 3
FairingEnergy: TypeAlias = Annotated[
    Energy,
    Enum(
        label="Energy",
        choices=ENERGIES,
        help="'membrane' spans it like a soap film, and meets its surroundings with a crease; 'thin_plate' bends least and "
        "continues their tangent planes; 'minimum_variation' continues their curvatures too, so that what is round stays round.",
    ),
]


@mesh_filter(
    name="Region Fairing",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES
    | MeshElement.VERTNUMBER
    | MeshElement.FACENUMBER
    | MeshElement.VERTFLAGSELECT
    | MeshElement.FACEFLAGSELECT,
    references=("botsch2004",),
)
def apply_coord_region_fairing(
    layer: Layer,
    *,
    energy: FairingEnergy = "thin_plate",
    iterations: Annotated[
        int,
        Int(
            label="Iterations",
            minimum=1,
            maximum=100,
            advanced=True,
            help="How often, each time with the areas and angles that the one before has left. More forget the shape that was "
            "there more fully, and come nearer to the surface of least area or bending; one is mostly enough. With remeshing it "
            "is done three times at least.",
        ),
    ] = 1,
    remesh: Annotated[
        bool,
        Bool(
            label="Remesh",
            help="Replace the triangles of the part, too, by regular ones as dense as those around: for rough damage, whose "
            "needles and folds would remain. Colours go on from around; what the texture showed there is lost, and each new "
            "triangle shows one place of it. Without, triangles, texture and all attributes stay.",
        ),
    ] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Replaces the selected part of a surface by the smoothest one that continues its surroundings.

    What the part looked like is forgotten: for dents, scars, bad fillings and seams. The selected vertices move, or, when no
    vertex is selected, those all of whose triangles are; the others, and open borders, stay. One, two or three rings of vertices
    around the region decide, so select until the damage ends, and a ring more. Returns how many vertices moved, the backward
    error of the solution, and a bound of the error that solving leaves as a share of the region's diagonal. With `remesh` the
    selected vertices and their triangles go, new ones come last and are selected, and their numbers are returned.
    """
    try:
        chosen = layer.selected_vertices()
    except MeshError:
        raise FilterInputError(
            f"nothing is selected in {layer.label!r}: select the vertices of the part that is to be faired, or triangles on all "
            "sides of them"
        ) from None
    if chosen.all():
        raise FilterInputError(
            "all vertices are selected, so that no surroundings are left to continue: select the part that is to be "
            "faired and leave its surroundings (to smooth a whole mesh take Bi-Laplacian Smoothing)"
        )
    if remesh:
        return _remade(layer, chosen, energy, max(3, iterations), progress)
    vertices = layer.vertices
    area_share = 1.0
    for i in range(iterations):

        def part(done: float, before: int = i) -> None:
            progress((before + done) / iterations)

        faired = fair_region(vertices, layer.faces, chosen, energy=energy, progress=part)
        vertices = faired.vertices
        area_share *= faired.area_share
    moved = int(faired.free.sum())
    notes = []
    if stayed := int(chosen.sum()) - moved:
        notes.append(
            f"{stayed:,} of the {int(chosen.sum()):,} selected vertices lie on an open border or have no triangle, and stay."
        )
    if faired.irregular:
        notes.append(irregular_note(faired.irregular))
    if area_share < _SHRUNK:
        notes.append(
            f"The region's area shrank to {area_share:.2g} of what it was: the vertices that stay around it span less than it "
            "covered. Select less if it was to keep its size."
        )
    return Edit(
        vertices=faired.vertices,
        values={
            "moved": moved,
            "backward_error": faired.backward_error,
            "last_correction": faired.last_correction,
            "refinements": faired.refinements,
        },
        notes=tuple(notes),
    )


def _remade(layer: Layer, chosen: Bools, energy: Energy, rounds: int, progress: Progress) -> Edit:
    """The selected vertices and their triangles replaced by a filling."""
    region, filling = remesh_region(layer.vertices, layer.faces, chosen, energy=energy, rounds=rounds, progress=progress)
    n, m = len(layer.vertices), len(layer.faces)
    a, b = len(filling.new_vertices), len(filling.new_faces)
    lower = sum(used != energy for used in filling.energies)
    notes = []
    if stayed := int((chosen & ~region).sum()):
        notes.append(
            f"{stayed:,} of the {int(chosen.sum()):,} selected vertices are at an open border or have no triangle, and stay."
        )
    if lower:
        notes.append(f"{lower} of {len(filling.closed)} parts were placed with a lower energy than {energy!r}.")
    return Edit(
        added_vertices=filling.new_vertices,
        added_faces=filling.new_faces,
        delete_vertices=np.concatenate([region, np.zeros(a, dtype=np.bool_)]),
        vertex_selection=np.arange(n + a) >= n,
        face_selection=np.arange(m + b) >= m,
        values={
            "deleted_vertices": int(region.sum()),
            "deleted_faces": int(region[layer.faces].any(axis=1).sum()),
            "new_vertices": a,
            "new_faces": b,
            "parts": len(filling.closed),
        },
        notes=tuple(notes),
    )
