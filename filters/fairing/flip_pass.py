"""One pass of edge flips over a mesh: the kernels."""

from ..compilation import compiled
from ..geometry import nearest_by_walk, quality_and_normal
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import diamond, fan_size, flip

# A flip gains at least this much, far above rounding, so that no two flips undo each other for ever.
_LEAST_GAIN = 1e-6
# The least cosine of the angle between the normals of a new triangle and an old one, and of the two new ones.
_LEAST_COSINE = 0.25


@compiled
def flip_pass(
    points: Floats,
    faces: Ints,
    across: Ints,
    valences: Longs,
    may: Bools,
    surface_points: Floats,
    surface_faces: Ints,
    offsets: Longs,
    around: Ints,
    at: Ints,
    near: float,
) -> int:
    """Goes through the faces once and flips, of each, the first edge that qualifies; the number of flips.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles, changed in place.
        across: (m, 3) as `faces_across` gives it, changed in place.
        valences: (n,) the number of faces at each vertex, changed in place.
        may: (n,) the vertices whose faces may change.
        surface_points: with the next three, the `WalkableSurface` that the faces keep to.
        surface_faces: its triangles.
        offsets: its lists of faces at vertices.
        around: these faces.
        at: (n,) the face of the surface where a walk from each vertex starts.
        near: the square of the largest distance from the surface.
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
                if nearest_by_walk(surface_points, surface_faces, offsets, around, x, y, z, at[end], near)[4] > near:
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
