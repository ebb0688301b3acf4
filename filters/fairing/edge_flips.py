"""Edge flips towards better triangles on the same surface."""

import numpy as np

from ..compilation import compiled
from ..geometry import WalkableSurface, nearest_by_walk, quality_and_normal
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import diamond, faces_across, fan_size, flip

# Every pass raises the mean quality; after this many passes it rises by next to nothing.
_PASSES = 50
# A flip gains at least this much, far above rounding, so that no two flips undo each other for ever.
_LEAST_GAIN = 1e-6
# The least cosine of the angle between the normals of a new triangle and an old one, and of the two new ones.
_LEAST_COSINE = 0.25


def flip_towards_quality(
    points: Floats, faces: Ints, may: Bools, surface: WalkableSurface, at: Ints, allowed: float
) -> tuple[Ints, int]:
    """Flips edges while that makes the two triangles at them better, and neither worse than the worse one was [lawson1977].

    The quality of a triangle is l / (sqrt(3) R), l its shortest edge and R its circumradius: 1 for equilateral ones, towards 0
    for slivers. An edge is flipped where the sum of the two qualities rises and the lower of them does not fall, so the mean
    quality of the mesh rises with every flip and the lowest does not fall. A flip is not made if the normal of a new triangle
    would be more than 75 degrees from that of an old one, if the new edge exists already, or if the middle or a quarter point of
    the edge or the centroid of a new triangle would be further from the surface than allowed. Edges with other than two faces
    stay, as do those whose faces are oriented against each other. Vertices do not move.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles, none of which names a vertex twice.
        may: (n,) the vertices whose triangles may change: an edge is flipped only between four of them.
        surface: the surface that the triangles keep to.
        at: (n,) the face of the surface where a walk from each vertex starts.
        allowed: the largest distance from the surface.

    Returns:
        (m, 3) the triangles, of which those that no flip has changed keep their rows, and the number of flips.
    """
    flipped, across = faces.copy(), faces_across(faces)
    valences = np.bincount(faces.ravel(), minlength=len(points))
    # Points of a plane are off it by rounding.
    near = (allowed + 1e-14 * float(np.abs(points[faces]).max(initial=0.0))) ** 2
    total = 0
    for _ in range(_PASSES):
        count = int(flip_pass(points, flipped, across, valences, may, surface, at, near))
        total += count
        if count == 0:
            break
    return flipped, total


@compiled
def flip_pass(
    points: Floats, faces: Ints, across: Ints, valences: Longs, may: Bools, surface: WalkableSurface, at: Ints, near: float
) -> int:
    """Goes through the faces once and flips, of each, the first edge that qualifies; the number of flips.

    Arguments as of `flip_towards_quality`, in place; `across` as `faces_across` gives it, (n,) `valences` the number of faces at
    each vertex, `near` the square of the largest distance from the surface.
    """
    count = 0
    for f in range(faces.shape[0]):
        for k in range(3):
            if across[f, k] < 0:
                continue
            a, b, c, d = diamond(faces, across, f, k)
            if c == d or not (may[a] and may[b] and may[c] and may[d]) or not _is_better(points, a, b, c, d):
                continue
            far = False
            # Points on the new edge and the centroids of the new triangles, by their weights of c, d and an end of the old edge.
            for u, v, w, end in (
                (0.5, 0.5, 0.0, a),
                (0.75, 0.25, 0.0, a),
                (0.25, 0.75, 0.0, a),
                (1 / 3, 1 / 3, 1 / 3, a),
                (1 / 3, 1 / 3, 1 / 3, b),
            ):
                x = u * points[c, 0] + v * points[d, 0] + w * points[end, 0]
                y = u * points[c, 1] + v * points[d, 1] + w * points[end, 1]
                z = u * points[c, 2] + v * points[d, 2] + w * points[end, 2]
                if nearest_by_walk(surface, x, y, z, at[end], near)[4] > near:
                    far = True
                    break
            # An edge from c to d can lie in another fan of faces at c, which this one does not reach.
            if far or fan_size(faces, across, f, (k + 2) % 3, d) != valences[c]:
                continue
            flip(faces, across, f, k)
            valences[a] -= 1
            valences[b] -= 1
            valences[c] += 1
            valences[d] += 1
            count += 1
            break
    return count


@compiled
def _is_better(points: Floats, a: int, b: int, c: int, d: int) -> bool:
    """Whether (a, d, c) and (d, b, c) are better triangles than (a, b, c) and (b, a, d), with nearly the same normals."""
    first, n1x, n1y, n1z = quality_and_normal(points, a, b, c)
    second, n2x, n2y, n2z = quality_and_normal(points, b, a, d)
    third, n3x, n3y, n3z = quality_and_normal(points, a, d, c)
    fourth, n4x, n4y, n4z = quality_and_normal(points, d, b, c)
    if not (third + fourth > first + second + _LEAST_GAIN and min(third, fourth) >= min(first, second)):
        return False
    # An old triangle without area has the normal 0, which any new one satisfies.
    least = _LEAST_COSINE
    return (
        n1x * n3x + n1y * n3y + n1z * n3z >= least * (n1x * n1x + n1y * n1y + n1z * n1z)
        and n1x * n4x + n1y * n4y + n1z * n4z >= least * (n1x * n1x + n1y * n1y + n1z * n1z)
        and n2x * n3x + n2y * n3y + n2z * n3z >= least * (n2x * n2x + n2y * n2y + n2z * n2z)
        and n2x * n4x + n2y * n4y + n2z * n4z >= least * (n2x * n2x + n2y * n2y + n2z * n2z)
        and n3x * n4x + n3y * n4y + n3z * n4z >= least
    )
