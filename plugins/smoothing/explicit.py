"""Explicit smoothing: steps towards the neighbours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pymeshfair.declaration import Edit, Enum, Equivalent, FilterClass, Float, Layer, mesh_filter
from pymeshfair.filters.checks import UnstableStepError
from pymeshfair.filters.diffusion import UPDATE_RULES, UpdateRule, explicit_smoothing
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.operators import OPERATOR_NAMES, OperatorName

from ..moving_vertices import MOVES_VERTICES, Border, Iterations, Selected, movable_vertices, squared_mean_edge

#: operators whose L has the unit 1 / length^2, so that their step is a squared length
DIMENSIONAL_OPERATORS = ("scale_dependent", "laplace_beltrami", "robust")


def laplacian_smooth_of_meshlab(values: Mapping[str, Any]) -> Equivalent | None:
    """MeshLab's Laplacian Smooth where it does the same: not with cotangents, which MeshLab computes with 32 bits."""
    if (values["update"], values["operator"]) != ("meshlab", "uniform") or values["border"] == "fixed" or values["selected"]:
        return None
    own = {"stepsmoothnum": values["iterations"], "boundary": values["border"] == "along", "cotangentweight": False}
    return Equivalent("apply_coord_laplacian_smoothing", own | {"selected": False})


@mesh_filter(
    name="Explicit Smoothing",
    classes=FilterClass.SMOOTHING,
    changes=MOVES_VERTICES,
    references=("taubin1995", "fujiwara1995", "desbrun1999", "sharp2020"),
    equivalent=laplacian_smooth_of_meshlab,
)
def apply_coord_explicit_smoothing(
    layer: Layer,
    *,
    operator: Annotated[
        OperatorName,
        Enum(
            label="Operator",
            choices=OPERATOR_NAMES,
            help="How neighbours are weighted. 'uniform' evens out triangle sizes and drifts along the surface; 'inverse_length' "
            "keeps uneven sampling; 'scale_dependent' does so in true lengths; 'cotangent' moves vertices along the normal "
            "and leaves flat parts alone; 'laplace_beltrami' is the same in true units, the mean curvature flow; 'robust' "
            "works on slivers, non-manifold meshes and point clouds too.",
        ),
    ] = "uniform",
    step: Annotated[
        float,
        Float(
            label="Step",
            minimum=0,
            help="The share of the way towards the neighbours' mean that a vertex goes in one iteration, from 0 to 1; for "
            "'scale_dependent', 'laplace_beltrami' and 'robust' a diffusion time in squared mean edges, bounded by "
            "stability. Larger is smoother.",
        ),
    ] = 0.5,
    iterations: Iterations = 10,
    update: Annotated[
        UpdateRule,
        Enum(
            label="Update rule",
            choices=UPDATE_RULES,
            help="'euler' takes the step above. 'meshlab' repeats the rule of MeshLab's own Laplacian Smooth, where the vertex "
            "itself is averaged in and the step is not used; it knows the operators 'uniform' and 'cotangent'.",
        ),
    ] = "euler",
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Moves every vertex towards the weighted mean of its neighbours, all at once, again and again.

    Simple and fast, but closed surfaces shrink: use Taubin Fairing to keep the volume, or Implicit Fairing for strong smoothing
    in one step.
    """
    unit = squared_mean_edge(layer) if operator in DIMENSIONAL_OPERATORS else 1.0
    try:
        vertices = explicit_smoothing(
            layer.vertices,
            layer.faces,
            operator=operator,
            step=step * unit,
            iterations=iterations,
            update=update,
            border=border,
            movable=movable_vertices(layer, selected),
            progress=progress,
        )
    except UnstableStepError as error:
        largest = error.largest_stable / unit
        raise UnstableStepError(
            f"step={step} is unstable with operator {operator!r} on this mesh: take at most {largest:.4g} "
            "(squared mean edges), or use Implicit Fairing, which has no limit",
            largest_stable=largest,
        ) from error
    return Edit(vertices=vertices)
