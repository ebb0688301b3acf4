"""Anisotropic diffusion of scalars and colours of vertices."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np

from pymeshfair.declaration import Edit, Enum, FilterClass, Float, Floats, Layer, MeshElement, mesh_filter
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion import EDGE_STOPS, EdgeStop, longest_step, perona_malik
from pymeshfair.filters.execution import Progress, ignore_progress

from ..moving_vertices import Iterations, Selected, movable_vertices

EdgeStopping: TypeAlias = Annotated[
    EdgeStop,
    Enum(
        label="Range kernel",
        choices=EDGE_STOPS,
        help="How the flow between neighbours falls with their difference. 'lorentzian' and 'gaussian' are the paper's, "
        "1 / (1 + x^2) and exp(-x^2); 'tukey', 'hampel' and 'truncated_l2' stop it at edges; 'huber' slows it, 'l2' does not.",
    ),
]
ShareOfStep: TypeAlias = Annotated[
    float,
    Float(
        label="Step",
        minimum=0,
        maximum=1,
        help="The share of the largest stable step, which is one over the largest number of neighbours of a vertex. Larger is "
        "smoother per iteration.",
    ),
]


def _contrast(meaning: str) -> Float:
    """The difference of neighbours that counts as an edge."""
    sentences = f"{meaning} Larger smooths stronger noise and blurs more edges. 'auto' takes it from the median difference."
    return Float(label="Range sigma (contrast)", minimum=0, automatic=0, help=sentences)


@mesh_filter(
    name="Anisotropic Diffusion of Vertex Scalars",
    classes=FilterClass.SMOOTHING | FilterClass.QUALITY,
    requires=MeshElement.FACENUMBER | MeshElement.VERTQUALITY,
    changes=MeshElement.VERTQUALITY,
    references=("perona1990", "black1998"),
)
def apply_scalar_anisotropic_diffusion_per_vertex(
    layer: Layer,
    *,
    range_kernel: EdgeStopping = "lorentzian",
    range_sigma: Annotated[float, _contrast("Differences between neighbours above it are edges, and stay.")] = 0.0,
    step: ShareOfStep = 1.0,
    iterations: Iterations = 10,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths the vertex scalar over the mesh and keeps its edges, as Perona and Malik did for images. Vertices do not move."""
    values = _diffused(layer, layer.vertex_scalars, range_kernel, range_sigma, step, iterations, selected, progress)
    return Edit(vertex_scalars=values)


@mesh_filter(
    name="Anisotropic Diffusion of Vertex Colors",
    classes=FilterClass.SMOOTHING | FilterClass.VERTEX_COLORING,
    requires=MeshElement.FACENUMBER | MeshElement.VERTCOLOR,
    changes=MeshElement.VERTCOLOR,
    references=("perona1990", "black1998"),
)
def apply_color_anisotropic_diffusion_per_vertex(
    layer: Layer,
    *,
    range_kernel: EdgeStopping = "lorentzian",
    range_sigma: Annotated[
        float,
        _contrast("Differences between neighbouring colours above it are edges, and stay; 1.73 is from black to white."),
    ] = 0.0,
    step: ShareOfStep = 1.0,
    iterations: Iterations = 10,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths the vertex colours over the mesh and keeps their edges, the same for red, green and blue. Opacity stays."""
    colors = np.array(layer.vertex_colors)
    colors[:, :3] = _diffused(layer, colors[:, :3], range_kernel, range_sigma, step, iterations, selected, progress)
    return Edit(vertex_colors=colors)


def _diffused(
    layer: Layer,
    values: Floats,
    range_kernel: EdgeStop,
    range_sigma: float,
    step: float,
    iterations: int,
    selected: bool,
    progress: Progress,
) -> Floats:
    if step == 0.0:
        raise FilterInputError("step=0 changes nothing: take a share of the largest stable step above 0 and at most 1")

    return perona_malik(
        values,
        layer.faces,
        edge_stop=range_kernel,
        contrast=range_sigma or None,
        step=step * longest_step(layer.faces),
        iterations=iterations,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
