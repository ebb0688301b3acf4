"""Edge flips towards better triangles on the same surface."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import check_finite
from ..execution import Progress, ignore_progress
from ..geometry import WalkableSurface, mean_edge_length
from ..mesh import Bools, Floats, Ints, check_mesh, normalised_mesh
from ..topology import faces_across, proper_faces
from .flip_pass import flip_pass

# Every pass raises the mean quality; after this many passes it rises by next to nothing.
_PASSES = 50


def flip_edges(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    max_deviation: float | None = None,
    movable: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Ints:
    """Flips edges while that makes the two triangles at them better, and neither worse than the worse one was [lawson1977].

    The quality of a triangle is l / (sqrt(3) R), l its shortest edge and R its circumradius: 1 for equilateral ones, towards 0
    for slivers. An edge is flipped where the sum of the two qualities rises and the lower of them does not fall, so the mean
    quality of the mesh rises with every flip and the lowest does not fall. A flip is not made if the normal of a new triangle
    would be more than 75 degrees from that of an old one, if the new edge exists already, or if the middle or a quarter point of
    the edge or the centroid of a new triangle would be further from the input surface than allowed. Edges with other than two
    faces stay, as do those whose faces are oriented against each other. Vertices do not move.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        max_deviation: how far new edges and triangles may be from the input, in mesh units: larger allows better triangles on
            curved parts and across edges. None: 5 % of the mean edge. 0: only flips within a plane.
        movable: (n,) bool: an edge is flipped only if the four vertices of its two triangles are in this. None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (m, 3) int32. A triangle that no flip has changed keeps its row.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    if max_deviation is not None:
        check_finite("max_deviation", max_deviation, least=0.0)
    mesh = normalised_mesh(points, triangles, movable)
    may = np.ones(len(mesh), dtype=np.bool_) if mesh.movable is None else mesh.movable
    kept = mesh.cells[proper_faces(mesh.cells)]
    found = triangles.copy()
    if not len(kept):
        return found
    allowed = 0.05 * mean_edge_length(mesh.points, kept) if max_deviation is None else max_deviation * mesh.scale
    surface = WalkableSurface.of(mesh.points, kept)
    flipped, _ = flip_towards_quality(mesh.points, kept, may, surface, surface.first_faces(), allowed, progress)
    found[proper_faces(triangles)] = mesh.used[flipped]
    return found


def flip_towards_quality(
    points: Floats,
    faces: Ints,
    may: Bools,
    surface: WalkableSurface,
    at: Ints,
    allowed: float,
    progress: Progress = ignore_progress,
) -> tuple[Ints, int]:
    """`flip_edges` on triangles that keep to a given surface; the triangles, and the number of flips.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles, none of which names a vertex twice.
        may: (n,) the vertices whose triangles may change.
        surface: the surface that the triangles keep to.
        at: (n,) the face of the surface where a walk from each vertex starts.
        allowed: the largest distance from the surface.
        progress: called with the share that is done; may raise to stop.
    """
    flipped, across = faces.copy(), faces_across(faces)
    valences = np.bincount(faces.ravel(), minlength=len(points))
    # Points of a plane are off it by rounding.
    near = (allowed + 1e-14 * float(np.abs(points[faces]).max(initial=0.0))) ** 2
    total = 0
    for done in range(_PASSES):
        count = int(flip_pass(points, flipped, across, valences, may, *surface, at, near))
        total += count
        progress((done + 1) / _PASSES)
        if count == 0:
            break
    return flipped, total
