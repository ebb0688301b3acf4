"""Filters that select points: outliers, stray points, surplus points, vertices far from a cloud."""

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any

import numpy as np

from pymeshfair.declaration import Arity, Bool, Edit, FilterClass, Float, Int, Layer, Mesh, MeshElement, Percentage, mesh_filter
from pymeshfair.filters import outliers
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.geometry import face_areas
from pymeshfair.filters.inspection import Surface
from pymeshfair.filters.mesh import Bools, Floats, Ints, scaled_to_unit

#: `mesh_filter` with the defaults for a filter that selects points of a cloud
point_selection = partial(
    mesh_filter, classes=FilterClass.SELECTION | FilterClass.CLEANING | FilterClass.POINT_SET, changes=MeshElement.VERTFLAGSELECT
)


def _selection(
    selected: Bools, parameters: Mapping[str, Any], *more: str, copies: int = 0, scalars: Floats | None = None, **report: float
) -> Edit:
    count = int(np.count_nonzero(selected))
    notes = (*outliers.found_words(count, len(selected), parameters, copies), *more)
    return Edit(vertex_selection=selected, vertex_scalars=scalars, values={"selected_vertices": count, **report}, notes=notes)


@point_selection(
    name="Select Outliers by Probability (LoOP)",
    changes=MeshElement.VERTQUALITY | MeshElement.VERTFLAGSELECT,
    references=("kriegel2009",),
)
def compute_selection_by_outlier_probability_per_vertex(
    layer: Layer,
    *,
    neighbors: Annotated[int, Int(label="Neighbours", minimum=1)] = 20,
    extent: Annotated[float, Float(minimum=0.1)] = 3.0,
    threshold: Annotated[float, Float(minimum=0, maximum=1)] = 0.5,
    progress: Progress = ignore_progress,
) -> Edit:
    """Selects the vertices that are probably outliers, and gives every vertex its outlier probability.

    LoOP (local outlier probability) compares the distances of a vertex to its neighbours with the distances of these neighbours
    to their own neighbours. So dense and sparse parts of a scan are judged equally. The probability, from 0 to 1, becomes the
    vertex scalar. The selection of vertices is replaced, the selection of faces stays. Faces are ignored. Returns the number of
    selected vertices, the largest and the mean probability.

    Args:
        neighbors: The number of neighbours to compare with: more than a stray clump has vertices. More give steadier
            probabilities, blur borders between dense and sparse parts, and take longer.
        extent: The probability is 0.68 at this many standard deviations beyond the usual distance. Larger gives lower
            probabilities, so fewer vertices are selected.
        threshold: Vertices with a larger probability are selected. Larger selects fewer, 1 none.
    """
    probabilities = outliers.local_outlier_probability(layer.vertices, neighbors=neighbors, extent=extent, progress=progress)
    more = (outliers.REPLACED_SCALARS,) if layer.has_vertex_scalars and layer.vertex_scalars.any() else ()
    largest, mean = float(probabilities.max()), float(probabilities.mean())
    report: dict[str, Any] = {"largest_probability": largest, "mean_probability": mean}
    return _selection(probabilities > threshold, {"threshold": threshold}, *more, scalars=probabilities, **report)


@point_selection(name="Select Stray Points")
def compute_selection_by_stray_points_per_vertex(
    layer: Layer,
    *,
    neighbors: Annotated[int, Int(label="Neighbours", minimum=1)] = 12,
    sparseness: Annotated[float, Float(minimum=1)] = 8.0,
    smallest_part: Annotated[int, Int(minimum=1)] = 100,
    clouds_only: Annotated[bool, Bool(label="Point clouds only")] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Selects the points of a cloud that belong to no surface: single distant points, hazes, and isolated clumps.

    The selection of vertices is replaced. Faces are ignored. Returns the number of selected points.

    Args:
        neighbors: The number of nearest points that measure the local density. More points bridge wider gaps and take longer.
        sparseness: Points whose neighbours are farther than this many times the median distance are usually selected. Larger
            keeps sparser parts of a scan, but also more of the hazes.
        smallest_part: Isolated clumps of fewer points than this are selected. For clumps that fill space the limit is three times
            this number. Larger selects larger clumps.
        clouds_only: Refuse a mesh: deleting the selected vertices would cut holes in it.
    """
    if clouds_only and len(layer.faces):
        raise FilterInputError(
            f"this is a mesh, not a point cloud (faces: {len(layer.faces):,}), and would get holes: the recipe 'clean_range_map' "
            "removes floating pieces of a mesh, 'denoise' its noise"
        )
    options: dict[str, Any] = {"neighbors": neighbors, "sparseness": sparseness, "smallest_part": smallest_part}
    stray = outliers.stray_points(layer.vertices, **options, progress=progress)
    copies = int(stray.sum()) - len(np.unique(layer.vertices[stray], axis=0))
    return _selection(stray, options, copies=copies)


@point_selection(name="Select Surplus Points")
def compute_selection_by_grid_per_vertex(layer: Layer, *, side: Annotated[float, Percentage(default="1%")]) -> Edit:
    """Selects all points but the first in each cell of a grid: without them the cloud is thinner, with an even density.

    The remaining points are measured points with all their attributes. The grid has a corner at the origin. The selection of
    vertices is replaced; faces are ignored. Returns the number of selected points.

    Args:
        side: The side of the cells. Larger leaves fewer points.
    """
    return _selection(outliers.surplus_points(layer.vertices, side), {"side": side})


@point_selection(
    name="Select Vertices Far from a Cloud",
    classes=FilterClass.SELECTION | FilterClass.CLEANING | FilterClass.REMESHING,
    arity=Arity.FIXED,
)
def compute_selection_by_distance_from_cloud_per_vertex(
    layer: Layer, *, reference: Annotated[int, Mesh(label="Cloud")] = 0, spacings: Annotated[float, Float(minimum=0)] = 4.0
) -> Edit:
    """Selects the parts of a reconstruction without measured points nearby, such as gaps that Screened Poisson closed.

    The spacing at a point is the mean distance to its six nearest neighbours. The unit of distances is the median spacing of the
    cloud or, if larger, two thirds of the median spacing nearby. The selection of vertices is replaced. Let d be the given number
    of spacings. Notes report the share of the area that is selected, the share that stays although it is farther than d / 2 from
    the points, and the share of the points farther than d from the remaining surface. Returns the number of selected vertices.

    Args:
        reference: The layer whose vertices are the measured points.
        spacings: Vertices farther from the nearest point than this many spacings of the cloud are selected. Larger keeps bridges
            over wider gaps.
    """
    cloud = layer.other(reference).vertices
    spacing_at = outliers.cloud_spacings(cloud)
    away = outliers.gaps(layer.vertices, cloud, spacing_at)
    selected = away > spacings
    notes: tuple[str, ...] = ()
    if len(layer.faces):
        areas, furthest = face_areas(scaled_to_unit(layer.vertices)[0], layer.faces), away[layer.faces].max(axis=1)
        far, half = (float(areas[furthest > limit].sum() / (areas.sum() or 1.0)) for limit in (spacings, 0.5 * spacings))
        notes = (
            f"{far:.2%} of the area is farther than {spacings:g} spacings from every point, and selected; another "
            f"{half - far:.2%} is farther than {0.5 * spacings:g}, and stays: it may bridge gaps",
            *_left_out(cloud, spacing_at, layer.vertices, layer.faces[furthest <= spacings], spacings),
        )
    return Edit(vertex_selection=selected, values={"selected_vertices": int(np.count_nonzero(selected))}, notes=notes)


def _left_out(cloud: Floats, spacing_at: Floats, vertices: Floats, faces: Ints, spacings: float) -> tuple[str, ...]:
    if not len(faces):
        return ()
    sample = slice(None, None, max(1, len(cloud) // 10_000))
    away = Surface.of(vertices, faces).nearest(cloud[sample]).distances / spacing_at[sample]
    share = float((away > spacings).mean())
    note = f"{share:.2%} of the points have no surface within {spacings:g} spacings: a larger reconstruction depth keeps details"
    return (note,) if share > 0.0 else ()
