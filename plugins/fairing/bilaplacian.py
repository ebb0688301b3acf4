"""Bi-Laplacian smoothing: an energy over all of a mesh, features spared."""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeAlias, get_args

from pymeshfair.declaration import Bools, Edit, Enum, FilterClass, Float, Floats, Ints, Layer, MeshElement, mesh_filter
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.fairing import (
    bilaplacian_smoothing,
    feature_weights,
    scalar_feature_weights,
    weight_of_detail_size,
)

from ..moving_vertices import (
    MOVES_VERTICES,
    Border,
    Selected,
    detail_size_parameter,
    displacement,
    irregular_note,
    no_amount,
    smoothed_by_size,
)

Features: TypeAlias = Literal["none", "curvature", "scalar"]
FEATURES: tuple[Features, ...] = get_args(Features)


@mesh_filter(
    name="Bi-Laplacian Smoothing",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("nealen2006", "zheng2011"),
)
def apply_coord_bilaplacian_smoothing(
    layer: Layer,
    *,
    detail_size: Annotated[float, detail_size_parameter("Not used when a weight is given.")],
    weight: Annotated[
        float,
        Float(
            label="Weight",
            minimum=0,
            advanced=True,
            help="How strongly vertices are held to their places, w, in one over the fourth power of mean edges. Larger stays "
            "closer to the input: 0.02 smooths strongly, 0.2 mildly. 0: not used, the detail size decides.",
        ),
    ] = 0.0,
    features: Annotated[
        Features,
        Enum(
            label="Features",
            choices=FEATURES,
            help="What is spared. 'none': every place is smoothed alike; 'curvature': ridges, found where the surface bends by "
            "more than an angle, may stay sharp; 'scalar': places of a high vertex scalar are spared.",
        ),
    ] = "none",
    feature_angle: Annotated[
        float,
        Float(
            label="Feature angle",
            minimum=1,
            maximum=179,
            help="For 'curvature', the angle between neighbouring triangles, in degrees, at which a ridge counts half; noise is "
            "filtered out before. Larger spares sharper ridges alone.",
        ),
    ] = 30.0,
    feature_scalar: Annotated[
        float,
        Float(
            label="Feature scalar",
            minimum=1e-30,
            maximum=1e30,
            help="For 'scalar', the size of the vertex scalar at which smoothing counts half, as 1 / (1 + (q / this)^2). Larger "
            "spares higher values alone.",
        ),
    ] = 1.0,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths by trading the bending of the surface for the distance that its vertices move: (C M^-1 W C + w M) p' = w M p.

    W is 1, or nearly 0 at features, where the surface may bend. Against implicit fairing at the same detail size, shorter waves
    are damped more and longer ones kept better, so that shapes shrink far less. Returns w in one over the fourth power of mesh
    units (0 or infinite where no number is so small or large), how many vertices moved and how far the furthest went.
    """
    if weight == 0.0 and detail_size == 0.0:
        raise no_amount("weight")
    before = 0.3 if features == "curvature" else 0.0
    weights = _feature_weights(layer, features, feature_angle, feature_scalar, lambda done: progress(before * done))
    if weight:  # as a length, whose fourth power may leave the range of numbers
        detail_size = 2.0 * math.pi * layer.mean_edge / weight**0.25
    if detail_size == 0.0:
        raise FilterInputError("the mean edge has no length, so that a weight in mean edges has no meaning; give a detail size")
    if detail_size < 0.0 and weights is not None:
        raise FilterInputError("detail_size 'auto' knows no features: give a size such as '6edge', or features='none'")
    notes: set[str] = set()

    def smooth(points: Floats, faces: Ints, size: float, movable: Bools | None, tell: Progress) -> Floats:
        notes.clear()
        return bilaplacian_smoothing(
            points,
            faces,
            detail_size=size,
            feature_weights=weights,
            border=border,
            movable=movable,
            on_irregular=lambda count: notes.add(irregular_note(count)),
            progress=tell,
        )

    done = smoothed_by_size(layer, detail_size, smooth, selected=selected, progress=part_of(progress, before, 1.0))
    held = weight_of_detail_size(done.amount) if done.amount else math.inf
    moved = displacement(layer.vertices, done.vertices)
    return Edit(
        vertices=done.vertices,
        values={"weight": held, **moved, **done.values},
        notes=(*notes, *done.notes) if done.amount else done.notes,
    )


def _feature_weights(layer: Layer, features: Features, angle: float, scalar: float, progress: Progress) -> Floats | None:
    if features == "none":
        return None
    if features == "curvature":
        return feature_weights(layer.vertices, layer.faces, feature_angle=angle, progress=progress)
    if not (layer.has_vertex_scalars and layer.vertex_scalars.any()):
        raise FilterInputError(
            "features='scalar' needs a vertex scalar, and that of the mesh is 0 everywhere: first compute one, such as a "
            "curvature"
        )
    return scalar_feature_weights(layer.vertex_scalars, half=scalar)
