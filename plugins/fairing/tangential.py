"""Tangential smoothing: better triangles on the same surface."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from pymeshfair.declaration import Bool, Bools, Edit, FilterClass, Float, Int, Ints, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.fairing import improve_triangles, tangential_smoothing
from pymeshfair.filters.inspection import surface_measures

from ..moving_vertices import MOVES_VERTICES, Selected, displacement, movable_vertices


@mesh_filter(
    name="Tangential Smoothing",
    classes=FilterClass.SMOOTHING | FilterClass.REMESHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES | MeshElement.FACENUMBER,
    references=("nealen2006", "lawson1977", "botsch2004remeshing"),
)
def apply_coord_tangential_smoothing(
    layer: Layer,
    *,
    weight: Annotated[
        float,
        Float(
            label="Weight",
            minimum=1e-9,
            maximum=1e9,
            help="How strongly vertices are held to their places. Larger moves them less in each iteration.",
        ),
    ] = 0.1,
    iterations: Annotated[
        int,
        Int(
            label="Iterations",
            minimum=0,
            maximum=1000,
            help="How many steps are taken. More give better triangles, up to a point, and take longer.",
        ),
    ] = 5,
    max_deviation: Annotated[
        float,
        Percentage(
            label="Largest deviation",
            default="0.05edge",
            help="How far the middles of triangles and edges may get from the surface as it was, at sharp edges a fifth of it; "
            "vertices stay on it. Larger allows better triangles where the surface is curved or has edges.",
        ),
    ],
    flip_edges: Annotated[
        bool,
        Bool(
            label="Flip edges",
            help="Before each step, take the other diagonal of two neighbouring triangles where that makes them better: for "
            "range maps and other grids, where moving vertices alone does next to nothing. Not on textured meshes.",
        ),
    ] = False,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Makes triangles better shaped on the same surface: vertices move along it towards the middle of their neighbours.

    Open borders stay. No triangle folds over. Colours and texture coordinates move along with their vertices. Triangles whose
    edges are flipped come last; they take colour and scalar from the old ones near them, and their custom attributes are 0.
    Returns the mean quality of the triangles before and after, as Surface Measures has it (1 for equilateral ones, 0 for those
    without area), how many triangles flips have changed, how many vertices moved and how far the furthest went.
    """
    textured = flip_edges and layer.has_wedge_tex_coords
    movable, faces = movable_vertices(layer, selected), layer.faces
    how: dict[str, Any] = {"weight": weight, "iterations": iterations, "max_deviation": max_deviation, "movable": movable}
    if flip_edges and not textured:
        vertices, faces = improve_triangles(layer.vertices, layer.faces, **how, progress=progress)
    else:
        vertices = tangential_smoothing(layer.vertices, layer.faces, **how, progress=progress)
    replaced = (np.sort(faces, axis=1) != np.sort(layer.faces, axis=1)).any(axis=1)
    return Edit(
        vertices=vertices,
        **_replacement(layer, faces, replaced),
        values={
            "triangle_quality_before": surface_measures(layer.vertices, layer.faces).triangle_quality,
            "triangle_quality_after": surface_measures(vertices, faces).triangle_quality,
            "changed_triangles": int(replaced.sum()),
            **displacement(layer.vertices, vertices),
        },
        notes=("No edge was flipped: the triangles are textured, and flipped ones would lose their texture.",)
        if textured
        else (),
    )


def _replacement(layer: Layer, faces: Ints, replaced: Bools) -> dict[str, Any]:
    """The fields of an `Edit` that replace triangles; new ones are selected if those in their rows were."""
    new = int(replaced.sum())
    if new == 0:
        return {}
    return {
        "added_faces": faces[replaced],
        "delete_faces": np.concatenate([replaced, np.zeros(new, dtype=np.bool_)]),
        "face_selection": np.concatenate([layer.face_selection, layer.face_selection[replaced]]),
    }
