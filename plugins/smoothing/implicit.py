"""Implicit fairing: backward Euler steps of any length."""

from __future__ import annotations

from typing import Annotated

from pymeshfair.declaration import Bool, Bools, Edit, Enum, FilterClass, Floats, Int, Ints, Layer, mesh_filter
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion import (
    FLOWS,
    IMPLICIT_OPERATORS,
    Flow,
    ImplicitOperator,
    implicit_fairing,
    time_step_of_detail_size,
)
from pymeshfair.filters.execution import Progress, ignore_progress

from ..moving_vertices import (
    MOVES_VERTICES,
    Border,
    Selected,
    detail_size_parameter,
    movable_vertices,
    no_amount,
    smoothed_by_size,
    squared_mean_edge,
    time_step_parameter,
)

#: operators that approximate the Laplace-Beltrami operator, for which a wavelength has a meaning
GEOMETRIC_OPERATORS = ("cotangent", "robust")


@mesh_filter(
    name="Implicit Fairing",
    classes=FilterClass.SMOOTHING,
    changes=MOVES_VERTICES,
    references=("desbrun1999", "kazhdan2012", "sharp2020", "tukey1977"),
)
def apply_coord_implicit_fairing(
    layer: Layer,
    *,
    operator: Annotated[
        ImplicitOperator,
        Enum(
            label="Operator",
            choices=IMPLICIT_OPERATORS,
            help="'cotangent' is the Laplace-Beltrami operator: it does not depend on how the surface is triangulated; 'robust' "
            "is the same for slivers, non-manifold meshes and point clouds; 'uniform', 'inverse_length' and "
            "'scale_dependent' see the triangulation and need a time step.",
        ),
    ] = "cotangent",
    detail_size: Annotated[
        float, detail_size_parameter("For the operators 'cotangent' and 'robust'; not used when a time step is given.")
    ],
    time_step: Annotated[
        float,
        time_step_parameter(
            "The diffusion time of one iteration, in squared mean edges (a pure number for 'uniform' and 'inverse_length')."
        ),
    ] = 0.0,
    iterations: Annotated[
        int,
        Int(
            label="Iterations",
            minimum=1,
            maximum=10_000,
            help="How many steps. At the same detail size more steps cut off more sharply; with a time step each one smooths "
            "further.",
        ),
    ] = 1,
    flow: Annotated[
        Flow,
        Enum(
            label="Flow",
            choices=FLOWS,
            help="For several iterations: 'linear' keeps the operator of the input; 'mean_curvature' rebuilds it at each step; "
            "'conformalized' updates the areas alone, so that thin parts do not pinch off under strong smoothing.",
        ),
    ] = "linear",
    preserve_volume: Annotated[
        bool,
        Bool(
            label="Preserve volume",
            help="Rescale every closed component about its centroid so that it keeps its volume. Open ones are left as they come "
            "out.",
        ),
    ] = False,
    keep_dimensions: Annotated[
        bool,
        Bool(
            label="Keep dimensions",
            help="Give back along the normals what whole parts of the shape have lost: limbs keep their thickness and the shape "
            "its size, open or closed. Not for point clouds.",
        ),
    ] = False,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths strongly in one stable step, by solving (M - t C) p' = M p: the surface after a diffusion time t.

    The amount is given as the size of the details that are to vanish. Unlike explicit smoothing it does not depend on the
    sampling, and no step is too long.
    """

    def smooth(points: Floats, faces: Ints, time: float, movable: Bools | None, tell: Progress) -> Floats:
        return implicit_fairing(
            points,
            faces,
            operator=operator,
            time_step=time,
            iterations=iterations,
            flow=flow,
            preserve_volume=preserve_volume,
            keep_dimensions=keep_dimensions,
            border=border,
            movable=movable,
            progress=tell,
        )

    def time_of(size: float) -> float:
        return time_step_of_detail_size(size, iterations, keep_dimensions=keep_dimensions)

    if time_step:
        time = time_step if operator in ("uniform", "inverse_length") else time_step * squared_mean_edge(layer)
        vertices = smooth(layer.vertices, layer.faces, time, movable_vertices(layer, selected), progress)
        return Edit(vertices=vertices, values={"time_step": time})
    if operator not in GEOMETRIC_OPERATORS:
        raise FilterInputError(f"operator {operator!r} sees the triangulation, not lengths: give a time_step, for example 1.0")
    if detail_size == 0.0:
        raise no_amount("time_step")
    done = smoothed_by_size(
        layer,
        detail_size,
        lambda points, faces, size, movable, tell: smooth(points, faces, time_of(size), movable, tell),
        selected=selected,
        progress=progress,
    )
    time = time_of(done.amount) if done.amount else 0.0
    return Edit(vertices=done.vertices, values={"time_step": time, **done.values}, notes=done.notes)
