"""The relief of a surface made higher."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated

from pymeshfair.declaration import Edit, FilterClass, Float, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.spectral import SpectralOperator, enhance_details

from ..moving_vertices import MOVES_VERTICES, Selected, largest_size_parameter, movable_vertices
from .filtering import OPERATOR


@mesh_filter(
    name="Detail Enhancement",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("vallet2008", "ma2012"),
)
def apply_coord_detail_enhancement(
    layer: Layer,
    *,
    gain: Annotated[
        float,
        Float(
            label="Gain",
            minimum=0,
            maximum=10,
            help="How many times as high the relief becomes. Larger makes it stronger, below 1 flatter; 1 changes nothing.",
        ),
    ] = 2.0,
    detail_size: Annotated[
        float,
        Percentage(
            label="Detail size",
            automatic=0,
            default="auto",
            help="The shortest wave of the relief: choose it above the size of the noise. Larger takes in larger details alone. "
            "'auto': where the spectrum of the surface rises above its noise, at least five mean edges.",
        ),
    ],
    largest_size: Annotated[float, largest_size_parameter("of the relief; what is larger is shape and stays.")],
    most: Annotated[
        float,
        Float(
            label="Most",
            minimum=0.001,
            maximum=0.5,
            help="How far a vertex may move, as a share of the thickness of the body there, or of the gap in front of it if that "
            "is less. Larger lets thin parts change more.",
        ),
    ] = 0.05,
    operator: Annotated[SpectralOperator, OPERATOR] = "auto",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Makes the relief of a surface higher, such as worn letters, and leaves its shape, its size and its borders.

    Vertices move along the normals of the shape, by the waves of the relief: shorter ones, noise among them, and longer ones stay
    as they are. Open borders stay, and what is near them changes less. Thin parts change less, too. Returns the two wavelengths,
    the height of the relief as it was (root mean square), the largest displacement, and the share of the vertices that the
    thickness has held back by half or more.
    """
    enhanced = enhance_details(
        layer.vertices,
        layer.faces,
        gain=gain,
        detail_size=detail_size or None,
        largest_size=largest_size or None,
        most=most,
        operator=operator,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    notes: tuple[str, ...] = ("nothing was enhanced: no triangle has an area",)
    if enhanced.detail_size > 0.0:
        edge = layer.mean_edge
        notes = (
            f"the relief is taken to be waves of {enhanced.detail_size / edge:.3g} to {enhanced.largest_size / edge:.3g} mean "
            f"edges, {enhanced.height / edge:.2g} mean edges high; no vertex moved by more than "
            f"{enhanced.largest_displacement / edge:.2g}",
        )
    report = {f.name: getattr(enhanced, f.name) for f in fields(enhanced) if f.name != "vertices"}
    return Edit(vertices=enhanced.vertices, values=report, notes=notes)
