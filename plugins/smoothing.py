"""Smoothing by diffusion: explicit steps, Taubin's shrink-free pair of steps, implicit fairing."""

from __future__ import annotations

from typing import Annotated

from pymeshfair.declaration import (
    Bool,
    Edit,
    Enum,
    FilterClass,
    Float,
    Int,
    Layer,
    MeshElement,
    Percentage,
    mesh_filter,
)
from pymeshfair.filters.checks import FilterInputError, UnstableStepError
from pymeshfair.filters.diffusion.explicit import explicit_smoothing
from pymeshfair.filters.diffusion.flows import FLOWS, Flow
from pymeshfair.filters.diffusion.implicit import IMPLICIT_OPERATORS, ImplicitOperator, implicit_fairing, time_step_of_detail_size
from pymeshfair.filters.diffusion.stencil import UPDATE_RULES, UpdateRule
from pymeshfair.filters.diffusion.taubin import TAUBIN_OPERATORS, TaubinOperator, taubin_fairing
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.operators import OPERATOR_NAMES, OperatorName
from pymeshfair.filters.topology import BORDER_POLICIES, BorderPolicy

from .moving_vertices import MOVES_VERTICES, SELECTED, movable_vertices

#: operators whose L has the unit 1 / length^2, so that a step of theirs is a squared length
DIMENSIONAL_OPERATORS = ("scale_dependent", "laplace_beltrami", "robust")
#: operators of implicit fairing that approximate the Laplace-Beltrami operator, for which a wavelength has a meaning
GEOMETRIC_OPERATORS = ("cotangent", "robust")

BORDER = Enum(
    label="Border",
    choices=BORDER_POLICIES,
    help="What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours on the "
    "border alone; 'free' move like any other vertex, so that borders recede.",
)
ITERATIONS = Int(label="Iterations", minimum=0, maximum=100_000, help="How many steps are taken. More are smoother and slower.")


@mesh_filter(
    name="Explicit Smoothing",
    classes=FilterClass.SMOOTHING,
    changes=MOVES_VERTICES,
    references=("taubin1995", "fujiwara1995", "desbrun1999", "sharp2020"),
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
    iterations: Annotated[int, ITERATIONS] = 10,
    update: Annotated[
        UpdateRule,
        Enum(
            label="Update rule",
            choices=UPDATE_RULES,
            help="'euler' takes the step above. 'meshlab' repeats the rule of MeshLab's own Laplacian Smooth, where the vertex "
            "itself is averaged in and the step is not used; it knows the operators 'uniform' and 'cotangent'.",
        ),
    ] = "euler",
    border: Annotated[BorderPolicy, BORDER] = "along",
    selected: Annotated[bool, SELECTED] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Moves every vertex towards the weighted mean of its neighbours, all at once, again and again.

    Simple and fast, but closed surfaces shrink: use Taubin Fairing to keep the volume, or Implicit Fairing for strong smoothing
    in one step.
    """
    unit = layer.mean_edge**2 if operator in DIMENSIONAL_OPERATORS else 1.0
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


@mesh_filter(
    name="Taubin Fairing",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("taubin1995",),
)
def apply_coord_taubin_fairing(
    layer: Layer,
    *,
    operator: Annotated[
        TaubinOperator,
        Enum(
            label="Operator",
            choices=TAUBIN_OPERATORS,
            help="How neighbours are weighted. 'uniform' is Taubin's choice; 'inverse_length' keeps uneven sampling; 'cotangent' "
            "moves vertices along the normal alone.",
        ),
    ] = "uniform",
    step: Annotated[
        float,
        Float(
            label="Step (lambda)", minimum=0, maximum=1, help="The step that smooths, above 0. Larger is smoother per iteration."
        ),
    ] = 0.5,
    mu: Annotated[
        float,
        Float(
            label="Step back (mu)",
            minimum=-1.5,
            maximum=0,
            help="The step that inflates again, below minus the first one. Nearer to -lambda narrows the pass band and is "
            "smoother; not used when a pass band is given.",
        ),
    ] = -0.53,
    pass_band: Annotated[
        float,
        Float(
            label="Pass band",
            minimum=0,
            maximum=2,
            help="Frequencies below it are kept, above it damped; on the operator's scale from 0 to 2, typically 0.01 to 0.1. "
            "Smaller is smoother. 0: not used, mu decides. With it, mu = 1 / (pass band - 1 / lambda).",
        ),
    ] = 0.0,
    iterations: Annotated[int, ITERATIONS] = 10,
    border: Annotated[BorderPolicy, BORDER] = "along",
    selected: Annotated[bool, SELECTED] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths without shrinking: each iteration is a smoothing step followed by a slightly longer step back.

    With the uniform operator it is MeshLab's own Taubin Smooth, except on open borders, where a step of MeshLab's goes two thirds
    of the way of ours.
    """
    vertices = taubin_fairing(
        layer.vertices,
        layer.faces,
        operator=operator,
        step=step,
        mu=mu,
        pass_band=pass_band or None,
        iterations=iterations,
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices)


@mesh_filter(
    name="Implicit Fairing",
    classes=FilterClass.SMOOTHING,
    changes=MOVES_VERTICES,
    references=("desbrun1999", "kazhdan2012", "sharp2020"),
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
        float,
        Percentage(
            label="Detail size",
            default="6edge",
            help="Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay. Larger is "
            "smoother. For the operators 'cotangent' and 'robust'; not used when a time step is given.",
        ),
    ],
    time_step: Annotated[
        float,
        Float(
            label="Time step",
            minimum=0,
            advanced=True,
            help="The diffusion time of one iteration, in squared mean edges (a pure number for 'uniform' and 'inverse_length'). "
            "Larger is smoother; any value is stable. 0: not used, the detail size decides.",
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
    border: Annotated[BorderPolicy, BORDER] = "along",
    selected: Annotated[bool, SELECTED] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths strongly in one stable step, by solving (M - t C) p' = M p: the surface after a diffusion time t.

    The amount is given as the size of the details that are to vanish. Unlike explicit smoothing it does not depend on the
    sampling, and no step is too long.
    """
    if time_step == 0.0:
        if operator not in GEOMETRIC_OPERATORS:
            raise FilterInputError(
                f"operator {operator!r} sees the triangulation, not lengths: give a time_step, for example 1.0"
            )
        if detail_size == 0.0:
            raise FilterInputError("detail_size is 0 and so is time_step: nothing to do; give one of them")
        time = time_step_of_detail_size(detail_size, iterations=iterations)
    else:
        time = time_step if operator in ("uniform", "inverse_length") else time_step * layer.mean_edge**2
    vertices = implicit_fairing(
        layer.vertices,
        layer.faces,
        operator=operator,
        time_step=time,
        iterations=iterations,
        flow=flow,
        preserve_volume=preserve_volume,
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices, values={"time_step": time})
