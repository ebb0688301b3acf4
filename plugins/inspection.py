"""Inspection: measures, curvature, reflection lines, triangle shape, displacement."""

import math
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

import numpy as np

from pymeshfair.declaration import Arity, Bool, Direction, Edit, Enum, FilterClass, Float, Layer, Mesh, MeshElement, mesh_filter
from pymeshfair.filters import inspection
from pymeshfair.filters.mesh import Bools, Floats
from pymeshfair.filters.topology import referenced_vertices

Colored = Annotated[bool, Bool(label="Colour", help="Also colour the mesh by the scalar, which replaces its colours.")]

#: the angle of adjacent triangles, in radians, up to which the surface counts as flat; rounded coordinates alone bend it so much
_FLAT = 1e-6
_SCALARS_AND_COLORS = MeshElement.VERTQUALITY | MeshElement.VERTCOLOR
#: `mesh_filter` with the defaults for a filter that writes the vertex scalar and shows it in colours
vertex_measure = partial(
    mesh_filter,
    classes=FilterClass.QUALITY | FilterClass.VERTEX_COLORING,
    requires=MeshElement.FACENUMBER,
    changes=_SCALARS_AND_COLORS,
)


@mesh_filter(name="Surface Measures", classes=FilterClass.MEASURE)
def get_surface_measures(layer: Layer) -> Edit:
    """Measures the counts, topology, size, roughness and triangle quality of the mesh.

    Counts vertices, unreferenced vertices, faces, degenerate and folded faces, edges, border edges, non-manifold edges and
    vertices, and components; reports whether the surface is closed and oriented, its genus and Euler characteristic; measures
    diagonal, area, volume (if closed and oriented), mean edge (also of polylines), mean spacing of clouds (to the nearest point),
    roughness (mean angle in degrees between normals of adjacent faces) and mean triangle quality (1 for equilateral triangles).
    """
    return Edit(values=asdict(inspection.surface_measures(layer.without_matrix().vertices, layer.faces, edges=layer.edges)))


@vertex_measure(name="Mean Curvature by Laplacian", references=("meyer2003",))
def compute_scalar_by_mean_curvature_per_vertex(
    layer: Layer, *, operator: Annotated[inspection.CurvatureOperator, Enum()] = "cotangent", color: Colored = True
) -> Edit:
    """Gives every vertex its mean curvature: 1/r on a sphere of radius r, positive on bulges and negative in hollows.

    In 1 / mesh unit; 0 on borders. Colours: blue in hollows, nearly white on flat parts, orange on bulges, between limits that
    enclose 98 % of the vertices. Returns the limits of the colours, and the lowest, the highest and the mean value.

    Args:
        operator: 'cotangent' allows for triangle shapes; 'uniform' is robust to slivers, but wrong for unevenly spread vertices.
    """
    values = inspection.mean_curvature(layer.vertices, layer.faces, operator=operator)
    return _colored(layer, values, color, flat=_FLAT / (layer.mean_edge or math.inf))


@vertex_measure(name="Gaussian Curvature by Angle Deficit", references=("meyer2003",))
def compute_scalar_by_gaussian_curvature_per_vertex(
    layer: Layer, *, measure: Annotated[inspection.GaussianMeasure, Enum()] = "per_area", color: Colored = True
) -> Edit:
    """Gives every vertex its Gaussian curvature: 1/r^2 on a sphere of radius r, 0 on cylinders and planes, negative on saddles.

    Colours: blue on saddles, nearly white on developable parts, orange on domes and in bowls, between limits that enclose 98 %
    of the vertices. On borders the curvature is 0, and the deficit is the angle by which the border turns. Returns the
    limits of the colours; the lowest, the highest and the mean value; and the sum.

    Args:
        measure: 'per_area' is the curvature, in 1 / squared mesh unit; 'deficit' is the angle deficit of the vertex, in radians.
    """
    values = inspection.gaussian_curvature(layer.vertices, layer.faces, measure=measure)
    flat = _FLAT if measure == "deficit" else _FLAT / (layer.mean_edge or math.inf)
    return _colored(layer, values, color, flat=flat * flat, sum=float(values[_used(layer)].sum()))


@mesh_filter(
    name="Triangle Shape",
    classes=FilterClass.QUALITY | FilterClass.FACE_COLORING,
    requires=MeshElement.FACENUMBER,
    changes=MeshElement.FACEQUALITY | MeshElement.FACECOLOR,
)
def compute_scalar_by_triangle_shape_per_face(layer: Layer, *, color: Colored = True) -> Edit:
    """Gives every face its shape quality: 1 for an equilateral triangle, near 0 for slivers, 0 without area.

    The quality is the shortest edge divided by the circumradius, normalised. Colours go from dark violet at 0 to yellow at 1.
    Returns these two limits, and the lowest, the highest and the mean value.
    """
    shapes = inspection.triangle_shapes(layer.vertices, layer.faces)
    limits = inspection.Limits(0.0, 1.0)
    colors = inspection.sequential_colors(shapes, limits) if color else None
    return Edit(face_scalars=shapes, face_colors=colors, values=_statistics(shapes, limits))


@vertex_measure(name="Reflection Lines")
def compute_color_by_reflection_lines_per_vertex(
    layer: Layer,
    *,
    stripes: Annotated[float, Float(minimum=1, maximum=200)] = 8.0,
    direction: Annotated[tuple[float, float, float], Direction()] = (0.0, 1.0, 0.0),
    view: Annotated[tuple[float, float, float], Direction()] = (0.0, 0.0, 1.0),
) -> Edit:
    """Colours the vertices like a polished surface in a hall of parallel lamps.

    The lines jump at creases, and bend sharply where the curvature jumps. The brightness, from 0 to 1, becomes the vertex scalar.

    Args:
        stripes: The number of lamps all round. More lamps show smaller defects, down to the length of the edges.
        direction: The direction along the lamps, which are parallel and infinitely far.
        view: The direction from the mesh to the eye.
    """
    normals = inspection.mesh_normals(layer.vertices, layer.faces)
    bright = inspection.reflection_stripes(normals, view=view, direction=direction, stripes=stripes)
    grey = 0.08 + 0.84 * bright
    return Edit(vertex_scalars=bright, vertex_colors=np.column_stack([grey, grey, grey, np.ones(len(grey))]))


@mesh_filter(
    name="Displacement from Another Layer",
    classes=FilterClass.QUALITY | FilterClass.VERTEX_COLORING | FilterClass.MEASURE,
    changes=_SCALARS_AND_COLORS,
    arity=Arity.FIXED,
)
def compute_scalar_by_displacement_per_vertex(
    layer: Layer,
    *,
    reference: Annotated[int, Mesh()] = 0,
    correspondence: Annotated[inspection.Correspondence, Enum()] = "auto",
    signed: Annotated[bool, Bool()] = True,
    color: Colored = True,
) -> Edit:
    """Gives every vertex its distance from another layer, for example to see what a clean-up has moved.

    In mesh units. Colours: blue below 0, nearly white at 0, orange above, or dark violet to yellow for unsigned values, between
    limits that enclose 98 % of the vertices. Returns the limits of the colours; the lowest, the highest and the mean value; the
    mean, root mean square, 95th percentile and largest distance; and whether vertices were compared by number.

    Args:
        reference: The layer from which the displacement is measured, such as the mesh before cleaning.
        correspondence: 'vertex' measures from the vertex of the same number, 'surface' from the nearest place of the reference;
            'auto' takes 'vertex' if both layers have equally many vertices, and the same faces, at least one.
        signed: Values are negative on the inner side of the reference; for 'vertex' they are components along its normals.
    """
    other = layer.other(reference)
    points, faces = other.vertices, other.faces
    if not len(faces) and correspondence != "vertex":  # polylines become triangles without width
        faces = np.column_stack([other.edges, np.arange(len(points), len(points) + len(other.edges))])
        points = np.concatenate([points, points[other.edges[:, 1]]])
    result = inspection.displacement(layer.vertices, layer.faces, points, faces, correspondence=correspondence)
    d = result.distances[_used(layer)]
    values: dict[str, Any] = {"by_vertex": result.by_vertex}
    if len(d):
        values |= {
            "mean_distance": float(d.mean()),
            "rms_distance": float(np.sqrt((d**2).mean())),
            "distance_95": float(np.quantile(d, 0.95)),
            "largest_distance": float(d.max()),
        }
    return _colored(layer, result.signed if signed else result.distances, color, signed=signed, **values)


def _used(layer: Layer) -> Bools:
    return referenced_vertices(layer.faces, len(layer.vertices)) if len(layer.faces) else np.ones(len(layer.vertices), dtype=bool)


def _colored(layer: Layer, values: Floats, color: bool, *, signed: bool = True, flat: float = 0.0, **report: Any) -> Edit:
    counted = values[_used(layer)]
    limits = inspection.symmetric_limits(counted, flat) if signed else inspection.robust_limits(counted)
    colors = (inspection.diverging_colors if signed else inspection.sequential_colors)(values, limits) if color else None
    return Edit(vertex_scalars=values, vertex_colors=colors, values=_statistics(counted, limits) | report)


def _statistics(values: Floats, limits: inspection.Limits) -> dict[str, Any]:
    statistics: dict[str, Any] = {"lower_limit": limits.low, "upper_limit": limits.high}
    if len(values):
        statistics |= {"lowest": float(values.min()), "highest": float(values.max()), "mean": float(values.mean())}
    return statistics
