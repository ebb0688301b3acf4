"""Vertex normals and curvatures of triangle meshes, from the angles and areas of the faces; reflection stripes."""

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice, check_finite
from ..compilation import compiled
from ..geometry import angle_at, corner_angles, cross_product, unit_vectors
from ..mesh import Floats, Ints, NormalisedMesh, check_mesh, normalised_mesh
from ..operators import laplace_beltrami, mixed_voronoi_areas
from ..topology import border_vertices, edges, proper_faces

#: The brightness of stripes is 1 where cos(stripes x angle) > `_SOFTNESS`, and 0 where cos(stripes x angle) < -`_SOFTNESS`.
_SOFTNESS = 0.25


def mesh_normals(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(n, 3) unit vertex normals: the sum of the face normals weighted by the corner angles; 0 at vertices without a face."""
    mesh = _normalised(vertices, faces)
    return at_vertices(mesh, normals_by_completed_angle(mesh.points, mesh.cells))


def normals_by_completed_angle(points: Floats, faces: Ints) -> Floats:
    """(n, 3) unit vectors along sums of face normals weighted by corner angles; 0 stays 0. Splitting a face changes no normal.

    The corner angles of each face are corrected to sum to pi. For normalised points; others: `geometry.vertex_normals_by_angle`.
    """
    sums = np.zeros((len(points), 3))
    _add_normals(points, faces, sums)
    return unit_vectors(sums)


@compiled(nogil=True)
def _add_normals(points: Floats, faces: Ints, sums: Floats) -> None:
    for f in range(faces.shape[0]):
        a, b, c = faces[f]
        x, y, z = cross_product(points, a, b, c)
        length = math.sqrt(x * x + y * y + z * z)
        if not length > 0.0:
            continue
        at_a, at_b, at_c = angle_at(points, a, b, c), angle_at(points, b, c, a), angle_at(points, c, a, b)
        missing = (math.pi - at_a - at_b - at_c) / 3.0
        for corner, angle in ((a, at_a + missing), (b, at_b + missing), (c, at_c + missing)):
            sums[corner, 0] += angle * x / length
            sums[corner, 1] += angle * y / length
            sums[corner, 2] += angle * z / length


CurvatureOperator: TypeAlias = Literal["cotangent", "uniform"]
GaussianMeasure: TypeAlias = Literal["per_area", "deficit"]


def mean_curvature(vertices: ArrayLike, faces: ArrayLike, *, operator: CurvatureOperator = "cotangent") -> Floats:
    """(n,) the mean curvature H of every vertex, in 1 / mesh unit: 1 / r on a sphere of radius r whose normals point outwards.

    H is positive where the surface bulges towards its normals, negative in hollows. n_i is the angle-weighted vertex normal.
    "cotangent": H_i = -n_i . (L p)_i / 2 with L = M^-1 C, the cotangent stiffness C and the mixed Voronoi areas M [meyer2003];
    its error falls with the square of the edge length on regular meshes, and is 0 on cylinders with edges along the axis.
    "uniform": H_i = -2 n_i . (mean of the one-ring - p_i) / (mean squared length of its edges), the mean of the normal curvatures
    along the edges, weighted by the squared lengths of the edges; it equals H if the edges are spread evenly, and is robust to
    slivers. H is 0 on borders, where it is not defined, and at vertices without a face.
    """
    check_choice("operator", operator, CurvatureOperator)
    mesh = _normalised(vertices, faces)
    if not len(mesh.cells):
        return np.zeros(len(mesh.vertices))
    points = mesh.points
    if operator == "cotangent":
        moves = laplace_beltrami(points, mesh.cells).apply(points)
        local = -0.5 * np.einsum("ij,ij->i", normals_by_completed_angle(points, mesh.cells), moves)
    else:
        local = _uniform(points, mesh.cells)
    local[border_vertices(mesh.cells, len(mesh))] = 0.0
    return at_vertices(mesh, local * mesh.scale)


def gaussian_curvature(vertices: ArrayLike, faces: ArrayLike, *, measure: GaussianMeasure = "per_area") -> Floats:
    """(n,) the Gaussian curvature of every vertex [meyer2003]; 0 at vertices without a face.

    "deficit", in radians: 2 pi minus the sum of the corner angles at an inner vertex, which is the integral of the curvature over
    its neighbourhood; pi minus the sum at a border vertex, the angle by which the border turns. On every mesh without
    non-manifold vertices, closed or not, the deficits sum to 2 pi times the Euler characteristic (Gauss-Bonnet).

    "per_area": the deficit over the mixed Voronoi area, in 1 / squared mesh unit: 1 / r^2 on a sphere of radius r, 0 on
    developable surfaces, negative on saddles; 0 on borders. It converges on meshes that are regular near the vertex; noise and
    irregular triangles disturb it more than they disturb the mean curvature.
    """
    check_choice("measure", measure, GaussianMeasure)
    mesh = _normalised(vertices, faces)
    if not len(mesh.cells):
        return np.zeros(len(mesh.vertices))
    on_border = border_vertices(mesh.cells, len(mesh))
    angles = corner_angles(mesh.points, mesh.cells)
    # The angles of a face must sum to pi: a face with coinciding corners lacks an angle, other faces have rounding errors.
    angles = angles + (math.pi - angles.sum(axis=1, keepdims=True)) / 3.0
    full = np.where(on_border, math.pi, 2.0 * math.pi)
    deficits: Floats = full - np.bincount(mesh.cells.ravel(), angles.ravel(), minlength=len(mesh))
    if measure == "deficit":
        return at_vertices(mesh, deficits)
    areas = mixed_voronoi_areas(mesh.points, mesh.cells)
    local = np.divide(deficits, areas, out=np.zeros_like(deficits), where=(areas > 0.0) & ~on_border)
    return at_vertices(mesh, local * mesh.scale * mesh.scale)


def _normalised(vertices: ArrayLike, faces: ArrayLike) -> NormalisedMesh:
    points, triangles = check_mesh(vertices, faces)
    return normalised_mesh(points, triangles[proper_faces(triangles)])


def _uniform(points: Floats, faces: Ints) -> Floats:
    pairs = edges(faces)
    towards = points[pairs[:, 1]] - points[pairs[:, 0]]
    squares = np.einsum("ij,ij->i", towards, towards)
    sums, lengths = np.zeros_like(points), np.zeros(len(points))
    for k, sign in ((0, 1.0), (1, -1.0)):
        np.add.at(sums, pairs[:, k], sign * towards)
        lengths += np.bincount(pairs[:, k], squares, minlength=len(points))
    # Sums over the ring instead of means: the valence cancels in the quotient.
    bulges = -2.0 * np.einsum("ij,ij->i", normals_by_completed_angle(points, faces), sums)
    return np.asarray(np.divide(bulges, lengths, out=np.zeros_like(bulges), where=lengths > 0.0))


def at_vertices(mesh: NormalisedMesh, local: Floats) -> Floats:
    """(n, ...) the values of the points of a normalised mesh at the original vertices, 0 at unused vertices."""
    values = np.zeros((len(mesh.vertices), *local.shape[1:]))
    values[mesh.used] = local
    return values


def reflection_stripes(normals: Floats, *, view: ArrayLike, direction: ArrayLike, stripes: float = 8.0) -> Floats:
    """(n,) the brightness, from 0 to 1, that a polished surface under line lamps has at each normal.

    The lamps are infinitely far, parallel to `direction`, and evenly spread round it. The eye is infinitely far in the direction
    v = `view`. At a normal n it sees light from r = 2 (n . v) n - v; the angle of r about `direction` decides whether r hits a
    lamp or the dark between two lamps. A break in a stripe shows a jump of the normals, a sharp bend a jump of the curvature;
    smooth stripes with uneven gaps show a gradual change of the curvature.

    Args:
        normals: (n, 3) unit normals; 0 gives 0.5.
        view: (3,) from the surface to the eye.
        direction: (3,) along the lamps.
        stripes: the number of lamps, rounded; more lamps show smaller defects.

    Raises:
        FilterInputError: a direction without length, or stripes below 1.
    """
    stripes = check_finite("stripes", stripes, least=1.0)
    eye, axis = _unit("view", view), _unit("direction", direction)
    reflected = 2.0 * (normals @ eye)[:, None] * normals - eye
    # Two directions perpendicular to the lamps; angles are measured from the first.
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    angles = np.arctan2(reflected @ np.cross(axis, first), reflected @ first)
    brightness = 0.5 + 0.5 * np.clip(np.cos(round(stripes) * angles) / _SOFTNESS, -1.0, 1.0)
    brightness[~normals.any(axis=1)] = 0.5
    return np.asarray(brightness)


def _unit(name: str, direction: ArrayLike) -> Floats:
    vector = np.asarray(direction, dtype=np.float64)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else np.nan
    if not 0.0 < length < np.inf:
        raise FilterInputError(f"{name} {vector.tolist()} is no direction: it takes three finite numbers, not all of them 0")
    return vector / length
