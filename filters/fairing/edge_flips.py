"""Edge flips towards better triangles: the other diagonal of two neighbours where it shapes them better on the same surface."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..geometry import WalkableSurface, mean_edge_length, some_face
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable, enter, ordered_frame
from ..topology import face_adjacency, referenced_vertices
from .flip_pass import flip_pass

# Every pass gains; after so many what is left to gain is next to nothing.
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
    quality of the mesh rises with every flip and the lowest does not fall. A flip is not made where a triangle would look more
    than 75 degrees away from one that it replaces, where the new edge is there already, or where its middle or quarters or the
    middles of the new triangles would be further from the input surface than allowed. Edges with other than two faces stay, as
    do those whose faces are oriented against each other. Vertices do not move.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        max_deviation: how far new edges and triangles may be from the input, in mesh units: larger allows better triangles on
            curved parts and across edges. None: 5 % of the mean edge. 0: only flips within a plane.
        movable: (n,) bool: an edge is flipped only if the four vertices of its two triangles are in this. None for all.
        progress: called with the share that is done; may raise to stop.

    Returns:
        (m, 3) int32. A triangle that no flip has changed is in its row as it was.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    if max_deviation is not None and not max_deviation >= 0.0:
        raise FilterInputError(f"max_deviation {max_deviation} is not at least 0")
    may = check_movable(movable, len(points))
    found, proper = triangles.copy(), proper_faces(triangles)
    if not proper.any():
        return found
    frame = ordered_frame(points[referenced_vertices(triangles, len(points))], None)
    start, kept = enter(points, frame), triangles[proper]
    allowed = 0.05 * mean_edge_length(start, kept) if max_deviation is None else max_deviation * frame.scale
    at = some_face(kept, len(points))
    found[proper], _ = flip_towards_quality(start, kept, may, WalkableSurface.of(start, kept), at, allowed, progress)
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
    """`flip_edges` of proper triangles near a surface that need not be their own; the triangles, and the number of flips.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles, none of which names a vertex twice.
        may: (n,) the vertices whose triangles may change.
        surface: what the triangles keep to.
        at: (n,) the face of the surface where a walk from each vertex starts.
        allowed: the largest distance from the surface.
        progress: called with the share that is done; may raise to stop.
    """
    flipped, across = faces.copy(), _faces_across(faces)
    valences = np.bincount(faces.ravel(), minlength=len(points))
    # Rounding takes a point of a plane off it.
    near = (allowed + 1e-14 * float(np.abs(points[faces]).max(initial=0.0))) ** 2
    total = 0
    for done in range(_PASSES):
        count = int(flip_pass(points, flipped, across, valences, may, *surface, at, near))
        total += count
        progress((done + 1) / _PASSES)
        if count == 0:
            break
    return flipped, total


def proper_faces(faces: Ints) -> Bools:
    """(m,) which faces name three different vertices."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))


def _faces_across(faces: Ints) -> Ints:
    """(m, 3) the face across the edge from corner k to the next; -1 where there is not one, oriented alike."""
    across = np.full(faces.shape, -1, dtype=np.int32)
    pairs, ends = face_adjacency(faces)
    sides, along = [], []
    for side in range(2):
        corners, following = faces[pairs[:, side]], np.roll(faces[pairs[:, side]], -1, axis=1)
        forward = (corners == ends[:, :1]) & (following == ends[:, 1:])
        backward = (corners == ends[:, 1:]) & (following == ends[:, :1])
        sides.append((forward | backward).argmax(axis=1))
        along.append(forward.any(axis=1))
    alike = along[0] != along[1]
    for side in range(2):
        across[pairs[alike, side], sides[side][alike]] = pairs[alike, 1 - side]
    return across
