"""Smoothing of curves: polylines such as sections, contours and borders, open or closed."""

from typing import Annotated

from pymeshfair.declaration import Edit, Enum, Int, Layer, MeshElement, Percentage
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.curves import CurveBorder, CurveMethod, CurveWeights, curve_smoothing
from pymeshfair.filters.execution import Progress, ignore_progress

from .moving_vertices import TIME_STEP, Selected, movable_vertices, no_amount, vertex_smoother
from .smoothing import TAUBIN_MU, TAUBIN_PASS_BAND, TAUBIN_STEP


@vertex_smoother(name="Curve Smoothing", requires=MeshElement.EDGENUMBER, references=("taubin1995", "desbrun1999"))
def apply_coord_curve_smoothing(
    layer: Layer,
    *,
    method: Annotated[CurveMethod, Enum()] = "implicit",
    weights: Annotated[CurveWeights, Enum()] = "inverse_length",
    detail_size: Annotated[float, Percentage(default="12edge", of_edges=True)],
    time_step: Annotated[float, TIME_STEP] = 0.0,
    step: Annotated[float, TAUBIN_STEP] = 0.5,
    mu: Annotated[float, TAUBIN_MU] = -0.53,
    pass_band: Annotated[float, TAUBIN_PASS_BAND] = 0.0,
    iterations: Annotated[int, Int(minimum=1, maximum=100_000)] = 10,
    border: Annotated[CurveBorder, Enum(label="Ends")] = "fixed",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths polylines: sections, contours, borders; open or closed, several in one layer, in the plane or in space.

    Planar curves stay in their plane. Where a curve branches, a vertex goes towards the mean of all its neighbours. Faces of the
    same layer are not looked at.

    Args:
        method: 'explicit': every vertex goes a step towards its neighbours; closed curves shrink. 'implicit': waves below the
            detail size vanish, in steps that are stable however long; closed curves shrink a little. 'taubin': a step and a
            longer one back, so that curves keep their size.
        weights: 'inverse_length': near neighbours pull more, so that uneven sampling stays as it is and straight parts do not
            move. 'uniform': all neighbours pull alike, which evens out the distances along the curve.
        detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay. Larger is
            smoother. Mean edges are those of the curves. For 'implicit' with 'inverse_length'; not used when a time step is
            given.
        time_step: For 'implicit': how strong one iteration is, a pure number; with uniform weights it must be given. Larger is
            smoother; any value is stable. 0: not used, the detail size decides.
        step: For 'explicit' and 'taubin': the share of the way towards the neighbours' mean that a vertex goes, above 0. Larger
            is smoother.
        mu: For 'taubin': the step back, below minus the first one. Nearer to -lambda is smoother; not used when a pass band is
            given.
        pass_band: For 'taubin': frequencies below it are kept, above it damped; on a closed curve of n vertices a wave that runs
            m times round it has 1 - cos(2 pi m / n). Smaller is smoother. 0: not used, mu decides.
        iterations: How many steps. More are smoother; with a detail size they cut off more sharply instead.
        border: What the ends of open curves do: 'fixed' stay; 'free' draw in towards their neighbours.
    """
    by_size = method == "implicit" and time_step == 0.0
    if by_size and weights == "uniform":
        raise FilterInputError("uniform weights know no lengths: give a time_step, for example 10, or take 'inverse_length'")
    if by_size and detail_size == 0.0:
        raise no_amount("time_step")
    vertices = curve_smoothing(
        layer.vertices,
        layer.edges,
        method=method,
        weights=weights,
        step=step,
        mu=mu,
        pass_band=pass_band or None,
        time_step=time_step if method == "implicit" and not by_size else None,
        detail_size=detail_size if by_size else None,
        iterations=iterations,
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices)
