"""Surfaces as smooth as possible: by an energy over all of a mesh, along the surface alone, or in a selected region."""

from __future__ import annotations

from typing import Annotated

from pymeshfair.declaration import Edit, Enum, FilterClass, Int, Layer, MeshElement, mesh_filter
from pymeshfair.filters.errors import FilterInputError
from pymeshfair.filters.fairing.region import ENERGIES, Energy, fair_region
from pymeshfair.filters.progress import Progress, ignore_progress

from .moving_vertices import MOVES_VERTICES

ENERGY = Enum(
    label="Energy",
    choices=ENERGIES,
    help="'membrane' spans it like a soap film, and meets its surroundings with a crease; 'thin_plate' bends "
    "least and continues their tangent planes; 'minimum_variation' continues their curvatures too, so that what is round "
    "stays round.",
)


@mesh_filter(
    name="Region Fairing",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("botsch2004",),
)
def apply_coord_region_fairing(
    layer: Layer,
    *,
    energy: Annotated[Energy, ENERGY] = "thin_plate",
    iterations: Annotated[
        int,
        Int(
            label="Iterations",
            minimum=1,
            maximum=100,
            advanced=True,
            help="How often, each time with the areas and angles that the one before has left. More forget the shape that was "
            "there more fully, and come nearer to the surface of least area or bending; one is mostly enough.",
        ),
    ] = 1,
    progress: Progress = ignore_progress,
) -> Edit:
    """Replaces the selected part of a surface by the smoothest one that continues its surroundings.

    What the part looked like is forgotten: for dents, scars, bad fillings and seams. The selected vertices move, or, when no
    vertex is selected, those all of whose triangles are; the others, and open borders, stay. One, two or three rings of vertices
    around the region decide, so select until the damage ends, and a ring more. Returns how many vertices moved, the backward
    error of the solution, and a bound of the error that solving leaves as a share of the region's diagonal.
    """
    chosen = layer.selected_vertices()
    if chosen.all():
        raise FilterInputError(
            "all vertices are selected, so that nothing around them says how the surface goes on: select the part that is to be "
            "faired and leave its surroundings (to smooth a whole mesh take Bi-Laplacian Smoothing)"
        )
    vertices = layer.vertices
    for i in range(iterations):

        def part(done: float, before: int = i) -> None:
            progress((before + done) / iterations)

        found = fair_region(vertices, layer.faces, chosen, energy=energy, progress=part)
        vertices = found.vertices
    moved = int(found.free.sum())
    notes = []
    if stayed := int(chosen.sum()) - moved:
        notes.append(
            f"{stayed:,} of the {int(chosen.sum()):,} selected vertices lie on an open border or have no triangle, and stay."
        )
    return Edit(
        vertices=found.vertices,
        values={
            "moved": moved,
            "backward_error": found.backward_error,
            "last_correction": found.last_correction,
            "refinements": found.refinements,
        },
        notes=tuple(notes),
    )
