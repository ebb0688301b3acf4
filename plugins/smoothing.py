"""Smoothing by diffusion: implicit, explicit and Taubin's; spikes; curves; edge-preserving diffusion of scalars and colours."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np

from pymeshfair.declaration import Bool, Edit, Enum, Equivalent, FilterClass, Float, Int, Layer, MeshElement, mesh_filter
from pymeshfair.filters import diffusion
from pymeshfair.filters.checks import FilterInputError, UnstableStepError
from pymeshfair.filters.choosing import PASSES
from pymeshfair.filters.curves import CurveBorder, CurveMethod, CurveWeights, curve_smoothing
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.mesh import Floats, Ints
from pymeshfair.filters.operators import OperatorName

from . import moving_vertices as moving
from .moving_vertices import Border, Iterations, Selected, movable_vertices, vertex_smoother


@vertex_smoother(
    name="Implicit Fairing", requires=MeshElement.NONE, references=("desbrun1999", "kazhdan2012", "sharp2020", "tukey1977")
)
def apply_coord_implicit_fairing(
    layer: Layer,
    *,
    operator: Annotated[diffusion.ImplicitOperator, Enum()] = "cotangent",
    detail_size: Annotated[float, moving.DETAIL_SIZE],
    time_step: Annotated[float, Float(minimum=0, advanced=True)] = 0.0,
    iterations: Annotated[int, Int(minimum=1, maximum=10_000)] = 1,
    flow: Annotated[diffusion.Flow, Enum()] = "linear",
    preserve_volume: Annotated[bool, Bool()] = False,
    keep_dimensions: Annotated[bool, Bool()] = False,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths strongly in one stable step: solves (M - t C) p' = M p, the surface after a diffusion time t.

    M: vertex areas; C: stiffness. Any step is stable. With 'cotangent' and 'robust' the sampling hardly matters.

    Args:
        operator: 'cotangent' is the Laplace-Beltrami operator for any triangulation; 'robust' is the same operator for slivers,
            non-manifold meshes and point clouds; 'uniform', 'inverse_length' and 'scale_dependent' need a time step.
        time_step: The diffusion time of one iteration, in squared mean edges (a pure number for 'uniform' and 'inverse_length').
            Larger is smoother; any value is stable. 0: not used, the detail size decides.
        iterations: With a detail size, more iterations make a sharper cutoff; with a time step, each iteration smooths further.
        flow: For several iterations: 'linear' keeps the operator of the input; 'mean_curvature' rebuilds it at each step;
            'conformalized' updates only the areas, so that thin parts do not pinch off.
        preserve_volume: Rescale every closed component about its centroid so that it keeps its volume, if all of its vertices may
            move. Not for point clouds.
        keep_dimensions: Undo the motion along the normals as far as neighbours move alike: limbs keep their thickness and the
            shape keeps its size, on open surfaces too. Not for point clouds.
    """
    options: dict[str, Any] = {"operator": operator, "iterations": iterations, "flow": flow, "border": border}
    options |= {"preserve_volume": preserve_volume, "keep_dimensions": keep_dimensions}
    note = "preserve_volume rescales only closed components whose vertices are all selected."
    notes = (note,) if preserve_volume and selected else ()
    if time_step:
        time = time_step if operator in ("uniform", "inverse_length") else time_step * moving.squared_mean_edge(layer)
        options |= {"movable": movable_vertices(layer, selected), "progress": progress}
        vertices = diffusion.implicit_fairing(layer.vertices, layer.faces, time_step=time, **options)
        return Edit(vertices=vertices, values={"time_step": time}, notes=notes)
    if operator not in ("cotangent", "robust"):  # the other operators do not approximate the Laplace-Beltrami operator
        raise FilterInputError(f"operator {operator!r} does not work with a detail size: give a time_step, for example 1.0")
    if detail_size == 0.0:
        raise moving.no_amount(layer, "time_step")

    def time_of(size: float) -> float:
        return diffusion.time_step_of_detail_size(size, iterations=iterations, keep_dimensions=keep_dimensions)

    def smooth(points: Floats, faces: Ints, size: float, **keywords: Any) -> Floats:
        return diffusion.implicit_fairing(points, faces, time_step=time_of(size), **options, **keywords)

    smoothed = moving.smoothed_by_size(layer, detail_size, smooth, selected=selected, progress=progress)
    smoothed = smoothed._replace(notes=(*notes, *smoothed.notes))
    return smoothed.edit(time_step=time_of(smoothed.amount) if smoothed.amount else 0.0)


def laplacian_smooth_of_meshlab(values: Mapping[str, Any]) -> Equivalent | None:
    """MeshLab's Laplacian Smooth if it gives the same result; never with cotangents, which MeshLab computes with 32 bits."""
    if (values["update"], values["operator"]) != ("meshlab", "uniform") or values["border"] == "fixed" or values["selected"]:
        return None
    parameters = {"stepsmoothnum": values["iterations"], "boundary": values["border"] == "along", "cotangentweight": False}
    return Equivalent("apply_coord_laplacian_smoothing", parameters | {"selected": False})


@vertex_smoother(
    name="Explicit Smoothing",
    requires=MeshElement.NONE,
    references=("taubin1995", "fujiwara1995", "desbrun1999", "sharp2020"),
    equivalent=laplacian_smooth_of_meshlab,
)
def apply_coord_explicit_smoothing(
    layer: Layer,
    *,
    operator: Annotated[OperatorName, Enum()] = "uniform",
    step: Annotated[float, Float(minimum=0)] = 0.5,
    iterations: Iterations = 10,
    update: Annotated[diffusion.UpdateRule, Enum(label="Update rule")] = "euler",
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Moves all vertices towards the weighted mean of their neighbours, in repeated steps.

    Simple and fast, but closed surfaces shrink; Taubin Fairing avoids this.

    Args:
        operator: How neighbours are weighted. 'uniform' evens out triangle sizes, as vertices drift along the surface;
            'inverse_length' and 'scale_dependent' keep uneven sampling; 'cotangent' and 'laplace_beltrami' move vertices along
            the normal; 'robust' also works on point clouds, slivers and non-manifold meshes.
        step: How far a vertex moves towards the mean of its neighbours, as a share, above 0 and at most 1; for 'scale_dependent',
            'laplace_beltrami' and 'robust' a diffusion time in squared mean edges, bounded by stability. Larger is smoother.
        update: 'euler' uses the step. 'meshlab' is the rule of MeshLab's Laplacian Smooth: the mean includes the vertex
            itself, and the step is not used; only with the operators 'uniform' and 'cotangent'.
    """
    has_unit = operator in ("scale_dependent", "laplace_beltrami", "robust")  # L in 1 / length^2, the step in length^2
    unit = moving.squared_mean_edge(layer) if has_unit else 1.0
    options: dict[str, Any] = {"operator": operator, "iterations": iterations, "update": update, "border": border}
    options |= {"movable": movable_vertices(layer, selected), "progress": progress}
    try:
        return Edit(vertices=diffusion.explicit_smoothing(layer.vertices, layer.faces, step=step * unit, **options))
    except UnstableStepError as error:
        raise UnstableStepError(
            f"step={step} is unstable with operator {operator!r} on this mesh: take at most {{}} "
            "(squared mean edges), or use Implicit Fairing, which has no limit",
            largest_stable=error.largest_stable / unit,
        ) from error


TAUBIN_STEP = Float(label="Step (lambda)", minimum=0, maximum=1)
TAUBIN_MU = Float(
    label="Step back (mu)",
    minimum=-1.5,
    maximum=0,
    help="The step back, which undoes the shrinking; it must be below -step. Nearer to -step smooths more; not used when a "
    "pass band is given. Only for Taubin's method.",
)
TAUBIN_PASS_BAND = Float(label="Pass band", minimum=0, maximum=2)


def taubin_smooth_of_meshlab(values: Mapping[str, Any]) -> Equivalent | None:
    """MeshLab's Taubin Smooth, equivalent on closed meshes only: on a border its step is two thirds of ours."""
    if values["operator"] != "uniform" or values["pass_band"] or values["selected"] or values["iterations"] == "auto":
        return None
    parameters = {"lambda_": values["step"], "mu": values["mu"], "stepsmoothnum": values["iterations"], "selected": False}
    return Equivalent("apply_coord_taubin_smoothing", parameters, closed_only=True)


@vertex_smoother(name="Taubin Fairing", references=("taubin1995",), equivalent=taubin_smooth_of_meshlab)
def apply_coord_taubin_fairing(
    layer: Layer,
    *,
    operator: Annotated[diffusion.TaubinOperator, Enum()] = "uniform",
    step: Annotated[float, TAUBIN_STEP] = 0.5,
    mu: Annotated[float, TAUBIN_MU] = -0.53,
    pass_band: Annotated[float, TAUBIN_PASS_BAND] = 0.0,
    iterations: Annotated[int, Int(minimum=0, maximum=100_000, automatic=-1)] = 10,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths without shrinking: each iteration is a smoothing step followed by a slightly longer step back.

    With 'uniform' it is MeshLab's Taubin Smooth, except at non-manifold edges, and on borders, where its step is 2/3 of ours.

    Args:
        operator: How neighbours are weighted. 'uniform' is Taubin's choice; 'inverse_length' keeps uneven sampling; 'cotangent'
            moves vertices only along the normal.
        step: The smoothing step, above 0. Larger is smoother per iteration.
        pass_band: Frequencies below it are kept, above it damped; on the operator's scale from 0 to 2, typically 0.01 to 0.1.
            Smaller is smoother. 0: not used, mu decides. A pass band sets mu = 1 / (pass band - 1 / step).
        iterations: The number of step pairs. More pairs smooth more. 'auto' chooses the number for the noise of the mesh.
    """
    faired = partial(diffusion.taubin_fairing, operator=operator, step=step, mu=mu, pass_band=pass_band or None, border=border)

    def smooth(points: Floats, faces: Ints, passes: float, **keywords: Any) -> Floats:
        return faired(points, faces, iterations=int(passes), **keywords)

    return moving.smoothed_by_amount(layer, iterations, smooth, PASSES, selected=selected, progress=progress).edit()


@vertex_smoother(name="Remove Spikes", classes=FilterClass.SMOOTHING | FilterClass.CLEANING)
def apply_coord_spike_removal(
    layer: Layer,
    *,
    steepness: Annotated[float, Float(minimum=0)] = 1.5,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Moves single vertices that stand up like needles back among their neighbours; all other vertices keep every bit.

    Vertices on open borders and the apexes of cones stay. Returns the number of spikes.

    Args:
        steepness: A vertex is a spike if its distance from the mean of its neighbours exceeds this many times their spread.
            Larger removes only thinner spikes; below 1 corners of boxes may count as spikes.
    """
    options: dict[str, Any] = {"steepness": steepness, "movable": movable_vertices(layer, selected), "progress": progress}
    vertices, spikes = diffusion.remove_spikes(layer.vertices, layer.faces, **options)
    return Edit(vertices=vertices, values={"spikes": int(np.count_nonzero(spikes))})


@vertex_smoother(name="Curve Smoothing", requires=MeshElement.EDGENUMBER, references=("taubin1995", "desbrun1999"))
def apply_coord_curve_smoothing(
    layer: Layer,
    *,
    method: Annotated[CurveMethod, Enum()] = "implicit",
    weights: Annotated[CurveWeights, Enum()] = "inverse_length",
    detail_size: Annotated[float, moving.SIZE_ON_CURVES],
    time_step: Annotated[float, Float(minimum=0, advanced=True)] = 0.0,
    step: Annotated[float, TAUBIN_STEP] = 0.5,
    mu: Annotated[float, TAUBIN_MU] = -0.53,
    pass_band: Annotated[float, TAUBIN_PASS_BAND] = 0.0,
    iterations: Annotated[int, Int(minimum=1, maximum=100_000)] = 10,
    border: Annotated[CurveBorder, Enum(label="Ends")] = "fixed",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths polylines: sections, contours, borders; open or closed, several in one layer, in the plane or in space.

    Planar curves stay in their plane. A vertex at a branch moves towards the mean of all its neighbours. Faces of the layer are
    ignored.

    Args:
        method: 'explicit': every vertex moves a step towards its neighbours; closed curves shrink. 'implicit': waves below the
            detail size vanish, any step length is stable, and closed curves shrink a little. 'taubin': a step and a longer step
            back, so that curves keep their size.
        weights: 'inverse_length': near neighbours pull more, so that uneven sampling is kept and straight parts do not move.
            'uniform': all neighbours pull equally, which evens out the distances along the curve.
        time_step: For 'implicit': the strength of one iteration, a pure number; uniform weights need it. Larger is smoother; any
            value is stable. 0: not used, the detail size decides.
        step: For 'explicit' and 'taubin': how far a vertex moves towards the mean of its neighbours, as a share above 0. Larger
            is smoother.
        pass_band: For 'taubin': frequencies below it are kept, above it damped; m waves round a closed curve of n vertices have
            the frequency 1 - cos(2 pi m / n). Smaller is smoother. 0: not used, mu decides.
        iterations: The number of steps ('taubin': of pairs). More smooth more; with a detail size they only sharpen the cutoff.
        border: How the ends of open curves move: 'fixed' ends stay; 'free' ends move towards their neighbours.
    """
    by_size = method == "implicit" and time_step == 0.0
    if by_size and weights == "uniform":
        raise FilterInputError("uniform weights ignore lengths: give a time_step, for example 10, or take 'inverse_length'")
    if by_size and detail_size == 0.0:
        raise moving.no_amount(layer, "time_step")
    options: dict[str, Any] = {"method": method, "weights": weights, "step": step, "mu": mu, "pass_band": pass_band or None}
    options |= {"time_step": time_step if method == "implicit" and not by_size else None}
    options |= {"detail_size": detail_size if by_size else None, "iterations": iterations, "border": border}
    movable = movable_vertices(layer, selected)
    return Edit(vertices=curve_smoothing(layer.vertices, layer.edges, **options, movable=movable, progress=progress))


@dataclass(frozen=True, kw_only=True)
class Diffusion:
    """The common parameters of diffusion that stops at edges, where values jump.

    Attributes:
        range_kernel: How the flow between neighbours falls with x, their difference divided by range sigma. 'lorentzian',
            1 / (1 + x^2), and 'gaussian', exp(-x^2), are the kernels of Perona and Malik; 'tukey' and 'truncated_l2' stop the
            flow at x = 1, 'hampel' at 4; 'huber' slows it; 'l2' smooths across edges.
        step: The step as a share of the largest stable step, which is one over the largest number of neighbours of a vertex.
            Larger is smoother per iteration.
    """

    range_kernel: Annotated[diffusion.EdgeStop, Enum(label="Range kernel")] = "lorentzian"
    range_sigma: Annotated[float, Float(label="Range sigma (contrast)", minimum=0, automatic=0)] = 0.0
    step: Annotated[float, Float(label="Step", minimum=0, maximum=1)] = 1.0
    iterations: Iterations = 10
    selected: Selected = False


def _diffused(values: Floats, layer: Layer, parameters: Diffusion, progress: Progress) -> Floats:
    if parameters.step == 0.0:
        raise FilterInputError("step=0 changes nothing: take a share of the largest stable step above 0 and at most 1")
    options: dict[str, Any] = {"edge_stop": parameters.range_kernel, "contrast": parameters.range_sigma or None}
    options |= {"step": parameters.step * diffusion.longest_step(layer.faces), "iterations": parameters.iterations}
    options |= {"movable": layer.selected_vertices() if parameters.selected else None, "progress": progress}
    return diffusion.perona_malik(values, layer.faces, **options)


attribute_smoother = partial(mesh_filter, references=("perona1990", "black1998"))


@attribute_smoother(
    name="Anisotropic Diffusion of Vertex Scalars",
    classes=FilterClass.SMOOTHING | FilterClass.QUALITY,
    requires=MeshElement.FACENUMBER | MeshElement.VERTQUALITY,
    changes=MeshElement.VERTQUALITY,
)
def apply_scalar_anisotropic_diffusion_per_vertex(
    layer: Layer, *, parameters: Diffusion, progress: Progress = ignore_progress
) -> Edit:
    """Smooths the vertex scalar, not the mesh, and keeps its edges (jumps), as Perona and Malik did for images.

    Args:
        range_sigma: Differences between neighbours above this value are edges, and are kept. Larger smooths stronger noise and
            blurs more edges. 'auto' estimates it from the median difference.
    """
    return Edit(vertex_scalars=_diffused(layer.vertex_scalars, layer, parameters, progress))


@attribute_smoother(
    name="Anisotropic Diffusion of Vertex Colors",
    classes=FilterClass.SMOOTHING | FilterClass.VERTEX_COLORING,
    requires=MeshElement.FACENUMBER | MeshElement.VERTCOLOR,
    changes=MeshElement.VERTCOLOR,
)
def apply_color_anisotropic_diffusion_per_vertex(
    layer: Layer, *, parameters: Diffusion, progress: Progress = ignore_progress
) -> Edit:
    """Smooths the vertex colours over the mesh and keeps their edges (jumps): red, green and blue alike. Opacity stays.

    Args:
        range_sigma: Differences between neighbouring colours above this value are edges, and are kept; black and white differ
            by 1.73. Larger smooths stronger noise and blurs more edges. 'auto' estimates it from the median difference.
    """
    colors = np.array(layer.vertex_colors)
    colors[:, :3] = _diffused(colors[:, :3], layer, parameters, progress)
    return Edit(vertex_colors=colors)
