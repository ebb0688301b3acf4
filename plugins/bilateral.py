"""Bilateral filters of positions, and anisotropic diffusion of what a mesh carries."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from pymeshfair.declaration import (
    Bool,
    Edit,
    Enum,
    FilterClass,
    Float,
    Floats,
    Int,
    Layer,
    MeshElement,
    Percentage,
    mesh_filter,
)
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.bilateral import JONES_BORDERS, JonesBorder, bilateral_fleishman, bilateral_jones
from pymeshfair.filters.denoising.clouds import bilateral_projection
from pymeshfair.filters.diffusion.anisotropic import EDGE_STOPS, EdgeStop, longest_step, perona_malik
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.robust import KERNEL_NAMES, KernelName
from pymeshfair.filters.topology import BORDER_POLICIES, BorderPolicy

from .moving_vertices import MOVES_VERTICES, SELECTED, movable_vertices

RANGE_KERNEL = Enum(
    label="Range kernel",
    choices=KERNEL_NAMES,
    help="How a neighbour counts that disagrees. With 'gaussian', 'tukey', 'hampel', 'lorentzian' and the truncated kernels it "
    "counts little or nothing far beyond the range sigma: features stay. 'huber' and 'l1' respect them less, 'l2' not at all.",
)
SPACE_KERNEL = Enum(
    label="Space kernel",
    choices=KERNEL_NAMES,
    help="How neighbours count by their distance; beyond 1.4 times the space sigma none does. 'gaussian' is the paper's, 'l2' "
    "counts all alike, 'l1' favours the nearest.",
)
RANGE_SIGMA = Percentage(
    label="Range sigma",
    default="0",
    help="Differences in height below it are taken for noise, larger ones for features. Larger removes stronger noise, and "
    "flattens larger features. 0: estimated from the mesh.",
)
ITERATIONS = Int(
    label="Iterations", minimum=0, maximum=10_000, help="How many steps are taken. More are smoother, slower, and shrink more."
)
EDGE_STOP = Enum(
    label="Range kernel",
    choices=EDGE_STOPS,
    help="How the flow between neighbours falls with their difference. 'lorentzian' and 'gaussian' are the paper's, "
    "1 / (1 + x^2) and exp(-x^2); 'tukey', 'hampel' and 'truncated_l2' stop it at edges; 'huber' slows it, 'l2' does not.",
)
STEP = Float(
    label="Step",
    minimum=0,
    maximum=1,
    help="The share of the largest stable step, which is one over the largest number of neighbours of a vertex. Larger is "
    "smoother per iteration.",
)
DIFFUSION_ITERATIONS = Int(
    label="Iterations", minimum=0, maximum=100_000, help="How many steps are taken. More are smoother and slower."
)


@mesh_filter(
    name="Bilateral Denoising along Normals (Fleishman)",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("fleishman2003",),
)
def apply_coord_bilateral_fleishman(
    layer: Layer,
    *,
    range_kernel: Annotated[KernelName, RANGE_KERNEL] = "gaussian",
    space_kernel: Annotated[KernelName, SPACE_KERNEL] = "gaussian",
    range_sigma: Annotated[float, RANGE_SIGMA],
    space_sigma: Annotated[
        float,
        Percentage(
            label="Space sigma",
            default="0",
            help="How far away neighbours count. Larger averages over more, is smoother and slower. 0: 1.4 mean edges.",
        ),
    ],
    iterations: Annotated[int, ITERATIONS] = 2,
    border: Annotated[
        BorderPolicy,
        Enum(
            label="Border",
            choices=BORDER_POLICIES,
            help="What the vertices of open borders do: 'fixed' stay; 'along' see their neighbours on the border alone; 'free' "
            "see all of their neighbours.",
        ),
    ] = "along",
    selected: Annotated[bool, SELECTED] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps features: every vertex moves along its normal to the mean height of neighbours that roughly agree.

    Fast, and enough for light noise; triangles keep their shape. The surface shrinks a little with each iteration.
    """
    vertices = bilateral_fleishman(
        layer.vertices,
        layer.faces,
        range_kernel=range_kernel,
        space_kernel=space_kernel,
        range_sigma=range_sigma or None,
        space_sigma=space_sigma or None,
        iterations=iterations,
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices)


@mesh_filter(
    name="Bilateral Denoising by Triangle Predictors (Jones)",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
    references=("jones2003",),
)
def apply_coord_bilateral_jones(
    layer: Layer,
    *,
    range_kernel: Annotated[KernelName, RANGE_KERNEL] = "gaussian",
    space_kernel: Annotated[KernelName, SPACE_KERNEL] = "gaussian",
    range_sigma: Annotated[float, RANGE_SIGMA],
    space_sigma: Annotated[
        float,
        Percentage(
            label="Space sigma",
            default="0",
            help="How far away triangles count. Larger averages over more, is smoother and slower. 0: 2 mean edges.",
        ),
    ],
    border: Annotated[
        JonesBorder,
        Enum(
            label="Border",
            choices=JONES_BORDERS,
            help="What the vertices of open borders do: 'fixed' stay; 'free' move like any other vertex.",
        ),
    ] = "free",
    selected: Annotated[bool, SELECTED] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps features in one step: every vertex goes to the mean of its projections to the planes of triangles.

    Near triangles that roughly agree count most. Triangles are found by place, so that non-manifold meshes and loose triangles
    are filtered too; curved surfaces shrink less than along normals.
    """
    vertices = bilateral_jones(
        layer.vertices,
        layer.faces,
        range_kernel=range_kernel,
        space_kernel=space_kernel,
        range_sigma=range_sigma or None,
        space_sigma=space_sigma or None,
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices)


@mesh_filter(
    name="Bilateral Projection of Points",
    classes=FilterClass.SMOOTHING | FilterClass.POINT_SET,
    changes=MOVES_VERTICES,
    references=("fleishman2003",),
)
def apply_coord_bilateral_projection_of_points(
    layer: Layer,
    *,
    neighbors: Annotated[
        int,
        Int(label="Neighbours", minimum=3, help="How many nearest points count. More are smoother, slower, and round off edges."),
    ] = 18,
    range_kernel: Annotated[KernelName, RANGE_KERNEL] = "gaussian",
    space_kernel: Annotated[KernelName, SPACE_KERNEL] = "gaussian",
    range_sigma: Annotated[float, RANGE_SIGMA],
    space_sigma: Annotated[
        float,
        Percentage(
            label="Space sigma",
            default="0",
            help="How neighbours count by their distance. Larger weighs distant ones more like near ones. 0: from the mean "
            "distance of the farthest neighbour.",
        ),
    ],
    iterations: Annotated[int, ITERATIONS] = 2,
    use_normals: Annotated[
        bool,
        Bool(
            label="Use the points' normals",
            help="Move along the normals that the points have, in all iterations. Otherwise normals are estimated from the same "
            "neighbours, anew in each iteration.",
        ),
    ] = False,
    selected: Annotated[bool, SELECTED] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise from a point cloud: every point moves along its normal to the mean height of neighbours that roughly agree.

    Triangles, if there are any, play no part. The normals themselves are not changed: compute them anew afterwards.
    """
    points = bilateral_projection(
        layer.vertices,
        normals=layer.vertex_normals if use_normals else None,
        neighbors=neighbors,
        range_kernel=range_kernel,
        space_kernel=space_kernel,
        range_sigma=range_sigma or None,
        space_sigma=space_sigma or None,
        iterations=iterations,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=points)


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
    range_kernel: Annotated[EdgeStop, EDGE_STOP] = "lorentzian",
    range_sigma: Annotated[
        float,
        Float(
            label="Range sigma (contrast)",
            minimum=0,
            help="Differences between neighbours above it are edges, and stay. Larger smooths stronger noise and blurs more "
            "edges. 0: from the median difference.",
        ),
    ] = 0.0,
    step: Annotated[float, STEP] = 1.0,
    iterations: Annotated[int, DIFFUSION_ITERATIONS] = 10,
    selected: Annotated[bool, SELECTED] = False,
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
    range_kernel: Annotated[EdgeStop, EDGE_STOP] = "lorentzian",
    range_sigma: Annotated[
        float,
        Float(
            label="Range sigma (contrast)",
            minimum=0,
            help="Differences between neighbouring colours above it are edges, and stay; 1.73 is from black to white. Larger "
            "smooths stronger noise and blurs more edges. 0: from the median difference.",
        ),
    ] = 0.0,
    step: Annotated[float, STEP] = 1.0,
    iterations: Annotated[int, DIFFUSION_ITERATIONS] = 10,
    selected: Annotated[bool, SELECTED] = False,
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
