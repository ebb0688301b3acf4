"""Selecting points that do not belong to the surface."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from pymeshfair.declaration import Edit, FilterClass, Float, Int, Layer, MeshElement, mesh_filter
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.outliers import local_outlier_probability


@mesh_filter(
    name="Select Outliers by Probability (LoOP)",
    classes=FilterClass.SELECTION | FilterClass.CLEANING | FilterClass.POINT_SET,
    changes=MeshElement.VERTQUALITY | MeshElement.VERTFLAGSELECT,
    references=("kriegel2009",),
)
def compute_selection_by_outlier_probability_per_vertex(
    layer: Layer,
    *,
    neighbors: Annotated[
        int,
        Int(
            label="Neighbours",
            minimum=1,
            help="How many nearest points a point is compared with. It must exceed the size of the clumps of stray points that "
            "are to be found. More give steadier probabilities, blur borders between dense and sparse parts, and take longer.",
        ),
    ] = 20,
    extent: Annotated[
        float,
        Float(
            label="Extent",
            minimum=0.1,
            help="How far beyond the usual a point must be to count as an outlier for certain, in standard deviations: 2 takes "
            "95 % of the points for regular, 3 takes 99.7 %. Larger gives lower probabilities, so fewer points are selected.",
        ),
    ] = 3.0,
    threshold: Annotated[
        float,
        Float(
            label="Threshold",
            minimum=0,
            maximum=1,
            help="Vertices with a probability above it are selected. Larger selects fewer: 1 none, 0 every vertex that is at all "
            "farther from its neighbours than they are from theirs.",
        ),
    ] = 0.5,
    progress: Progress = ignore_progress,
) -> Edit:
    """Selects the vertices that are probably outliers, and gives every vertex that probability.

    LoOP (local outlier probability) compares how far each vertex is from its neighbours with how far they are from theirs: dense
    and sparse parts of a scan are judged alike, whatever its unit. The probability, from 0 to 1, becomes the vertex scalar, to be
    looked at in colours before anything is deleted. The selection of vertices is replaced, that of faces stays. Faces play no
    part: a point cloud and a mesh with the same vertices have the same outliers. Returns the number of selected vertices, the
    largest and the mean probability.
    """
    probabilities = local_outlier_probability(layer.vertices, neighbors=neighbors, extent=extent, progress=progress)
    selected = probabilities > threshold
    return Edit(
        vertex_scalars=probabilities,
        vertex_selection=selected,
        values={
            "selected_vertices": int(np.count_nonzero(selected)),
            "largest_probability": float(probabilities.max()),
            "mean_probability": float(probabilities.mean()),
        },
    )
