"""Filtering by the wavelengths of a surface, with its modes or without them."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated

from pymeshfair.declaration import (
    Bools,
    Edit,
    Enum,
    FilterClass,
    Float,
    Floats,
    Int,
    Ints,
    Layer,
    MeshElement,
    mesh_filter,
)
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.spectral import (
    DEFAULT_ORDER,
    ORDERS,
    RESPONSE_NAMES,
    SPECTRAL_METHODS,
    SPECTRAL_OPERATORS,
    ResponseName,
    SpectralMethod,
    SpectralOperator,
    SpectralResult,
    spectral_filter,
)

from ..moving_vertices import (
    MOVES_VERTICES,
    Selected,
    detail_size_parameter,
    largest_size_parameter,
    no_amount,
    smoothed_by_size,
)

OPERATOR = Enum(
    label="Operator",
    choices=SPECTRAL_OPERATORS,
    advanced=True,
    help="'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same for slivers and non-manifold meshes; "
    "'auto' takes the robust one where it is needed.",
)


@mesh_filter(
    name="Spectral Filter",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("taubin1995", "vallet2008"),
)
def apply_coord_spectral_filter(
    layer: Layer,
    *,
    response: Annotated[
        ResponseName,
        Enum(
            label="Response",
            choices=RESPONSE_NAMES,
            help="'low_pass' removes waves shorter than the detail size; 'enhance' multiplies those from the detail size to the "
            "largest size by the gain and keeps all others; 'band_pass' keeps that band alone, about the centroid of each "
            "component, to look at.",
        ),
    ] = "low_pass",
    detail_size: Annotated[
        float,
        detail_size_parameter(
            "Not used when a number of modes is given.",
            of_band="With 'enhance' and 'band_pass' the shortest wave of the band: choose it above the size of the noise.",
        ),
    ],
    largest_size: Annotated[float, largest_size_parameter("of the band of 'enhance' and 'band_pass'.")],
    modes: Annotated[
        int,
        Int(
            label="Modes",
            minimum=0,
            maximum=1_000_000,
            help="In place of the detail size, how many modes (manifold harmonics) are kept, over all components; centroids stay "
            "and do not count. More keep finer features: 5 leave a blob, 500 most of them. 0: not used, the detail size decides.",
        ),
    ] = 0,
    gain: Annotated[
        float,
        Float(
            label="Gain",
            minimum=0,
            maximum=10,
            help="By what 'enhance' multiplies the waves of the band. Larger makes these details stronger, below 1 weaker.",
        ),
    ] = 2.0,
    order: Annotated[
        int,
        Int(
            label="Order",
            minimum=min(ORDERS),
            maximum=max(ORDERS),
            advanced=True,
            help="How sharply the response falls at the detail size. 1 is diffusion; larger is sharper, slower, and leaves "
            "ripples beside edges. Not used with a number of modes, where eigenvectors cut off at once.",
        ),
    ] = DEFAULT_ORDER,
    method: Annotated[
        SpectralMethod,
        Enum(
            label="Method",
            choices=SPECTRAL_METHODS,
            help="'eigenvectors' computes the modes; 'polynomial' filters without them, far faster on large meshes; 'auto' "
            "computes modes only where their number is given and memory allows. The result says which ran.",
        ),
    ] = "auto",
    operator: Annotated[SpectralOperator, OPERATOR] = "auto",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes, keeps or exaggerates details by their size, as an equaliser does with sound.

    A surface is a sum of waves, the modes of its Laplace-Beltrami operator, from its largest parts to the finest noise. The
    filter multiplies each by a factor that depends on its wavelength alone, whatever the sampling. Components are filtered one by
    one, and their centroids stay. Open borders are natural: their vertices are free, and they get as smooth as the surface.
    Returns the route that was taken, the number of modes or the degree of the polynomial, the wavelength at the cutoff, and a
    bound of the error in mesh units.
    """
    if modes == 0 and detail_size == 0.0:
        raise no_amount("modes")
    if detail_size < 0.0 and response != "low_pass" and not modes:
        raise FilterInputError(
            f"detail_size 'auto' is for the response 'low_pass', not {response!r}: give a size such as '6edge'"
        )
    filtered: SpectralResult | None = None

    def smooth(points: Floats, faces: Ints, size: float, movable: Bools | None, tell: Progress) -> Floats:
        nonlocal filtered
        filtered = spectral_filter(
            points,
            faces,
            response=response,
            detail_size=None if modes else size,
            largest_size=largest_size or None,
            modes=modes or None,
            gain=gain if response == "enhance" else None,
            order=order,
            method=method,
            operator=operator,
            movable=movable,
            progress=tell,
        )
        return filtered.vertices

    done = smoothed_by_size(layer, 0.0 if modes else detail_size, smooth, selected=selected, progress=progress)
    if filtered is None or not (modes or done.amount):
        return Edit(vertices=done.vertices, values=done.values, notes=done.notes)
    report = {f.name: getattr(filtered, f.name) for f in fields(filtered) if f.name not in ("vertices", "explanation")}
    return Edit(vertices=filtered.vertices, values={**report, **done.values}, notes=(_in_words(response, filtered),))


def _in_words(response: ResponseName, filtered: SpectralResult) -> str:
    """What was done to the shape; how it was computed is reported in numbers."""
    if filtered.route == "none":
        return filtered.explanation
    did = {"low_pass": "waves shorter than {} were removed", "band_pass": "waves from {} on were kept"}
    return did.get(response, "waves from {} on were made stronger or weaker").format(f"{filtered.detail_size:.4g}")
