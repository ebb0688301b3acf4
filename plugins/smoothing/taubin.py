"""Taubin's fairing: a step that smooths and a longer one back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pymeshfair.declaration import (
    Bools,
    Edit,
    Enum,
    Equivalent,
    FilterClass,
    Float,
    Floats,
    Int,
    Ints,
    Layer,
    MeshElement,
    mesh_filter,
)
from pymeshfair.filters.choosing import PASSES
from pymeshfair.filters.diffusion import TAUBIN_OPERATORS, TaubinOperator, taubin_fairing
from pymeshfair.filters.execution import Progress, ignore_progress

from ..moving_vertices import MOVES_VERTICES, Border, Selected, smoothed_by_amount


def taubin_step(help: str) -> Float:
    """The step lambda, which smooths."""
    return Float(label="Step (lambda)", minimum=0, maximum=1, help=help)


def taubin_mu(help: str) -> Float:
    """The step mu, which goes back."""
    return Float(label="Step back (mu)", minimum=-1.5, maximum=0, help=help)


def taubin_pass_band(help: str) -> Float:
    """The pass band, which gives mu for a lambda."""
    return Float(label="Pass band", minimum=0, maximum=2, help=help)


def taubin_smooth_of_meshlab(values: Mapping[str, Any]) -> Equivalent | None:
    """MeshLab's own filter, which is Taubin's on closed meshes: on a border its step goes two thirds of ours."""
    if values["operator"] != "uniform" or values["pass_band"] or values["selected"] or values["iterations"] == "auto":
        return None
    own = {"lambda_": values["step"], "mu": values["mu"], "stepsmoothnum": values["iterations"], "selected": False}
    return Equivalent("apply_coord_taubin_smoothing", own, closed_only=True)


@mesh_filter(
    name="Taubin Fairing",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("taubin1995",),
    equivalent=taubin_smooth_of_meshlab,
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
    step: Annotated[float, taubin_step("The step that smooths, above 0. Larger is smoother per iteration.")] = 0.5,
    mu: Annotated[
        float,
        taubin_mu(
            "The step that inflates again, below minus the first one. Nearer to -lambda narrows the pass band and is smoother; "
            "not used when a pass band is given."
        ),
    ] = -0.53,
    pass_band: Annotated[
        float,
        taubin_pass_band(
            "Frequencies below it are kept, above it damped; on the operator's scale from 0 to 2, typically 0.01 to 0.1. "
            "Smaller is smoother. 0: not used, mu decides. With it, mu = 1 / (pass band - 1 / lambda)."
        ),
    ] = 0.0,
    iterations: Annotated[
        int,
        Int(
            label="Iterations",
            minimum=0,
            maximum=100_000,
            automatic=-1,
            help="How many pairs of steps are taken. More are smoother and slower. 'auto' takes the number whose slopes are "
            "expected to be nearest to the true ones.",
        ),
    ] = 10,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths without shrinking: each iteration is a smoothing step followed by a slightly longer step back.

    With the uniform operator it is MeshLab's own Taubin Smooth, except on open borders, where a step of MeshLab's goes two thirds
    of the way of ours.
    """

    def smooth(points: Floats, faces: Ints, passes: float, movable: Bools | None, tell: Progress) -> Floats:
        return taubin_fairing(
            points,
            faces,
            operator=operator,
            step=step,
            mu=mu,
            pass_band=pass_band or None,
            iterations=int(passes),
            border=border,
            movable=movable,
            progress=tell,
        )

    done = smoothed_by_amount(layer, iterations, smooth, PASSES, selected=selected, progress=progress)
    return Edit(vertices=done.vertices, values=done.values, notes=done.notes)
