"""Blends: joins the rims of two parts by a band of triangles, then fairs the interior of the band."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..compilation import compiled
from ..execution import Progress, ignore_progress, part_of, rising
from ..geometry import area_vector, side_lengths
from ..libraries import spatial
from ..mesh import Bools, Floats, Ints, check_mesh, check_vertex_mask
from ..topology import boundary_loops, connected_components
from .region import Energy, fair_region

# `one_is_inside_out` gives None if the smaller of the two bendings that it compares is above `_CLEARLY` times the larger.
_CLEARLY = 0.5
# If the centres of two rims are closer than this many mean radii, the line between them does not give the direction of the neck.
_NEAR = 1.0
# Then the normals of the rims decide, if the cosine of the angle between them exceeds this in absolute value.
_PARALLEL = 0.7
#: The most triangles of a band.
MOST_ADDED = 10_000_000
#: The most spans (edges from one rim to the other) in the search for a band. Each takes a byte: 400 MB in all, and 3 s.
MOST_SPANS = 400_000_000
# The number of spans between two calls of `progress`.
_SPANS_AT_A_TIME = 10_000_000


def blend_parts(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    energy: Energy = "thin_plate",
    among: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> "Blend":
    """Joins the two rims that are nearest to each other by a smooth neck.

    `bridge_rims` makes the band, and `fair_region` places its new vertices; the vertices of the mesh stay.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles of both parts.
        energy: "membrane" meets the parts with a crease, as a soap film would; "thin_plate" continues their tangent planes,
            "minimum_variation" their curvatures too.
        among: (n,) bool: only rims whose vertices are all True are joined; both may belong to one component. None: any two rims
            of different components.
        progress: called with the share that is done; may raise to stop.

    Raises:
        FilterInputError: not a mesh; there are no two rims; the rims share a vertex, or one passes a vertex twice; the product of
            the numbers of edges of two rims or rows is above 400 million; the band would have more than `MOST_ADDED` triangles;
            one of the two components is clearly inside out; a length is 0 or out of range; or as for `fair_region`.
        ConvergenceError: as for `fair_region`.
    """
    points, triangles = check_mesh(vertices, faces)
    first, second = nearest_rims(points, triangles, among=among, progress=part_of(progress, 0.0, 0.1))
    band = bridge_rims(points, triangles, first, second, progress=part_of(progress, 0.1, 0.5))
    if len(band.vertices) == 0:
        progress(1.0)
        return band
    joined = np.concatenate([points, band.vertices])
    free = np.arange(len(joined)) >= len(points)
    fair = fair_region(joined, np.concatenate([triangles, band.faces]), free, energy=energy, progress=part_of(progress, 0.5, 1.0))
    return replace(band, vertices=fair.vertices[len(points) :])


def nearest_rims(
    points: Floats, triangles: Ints, *, among: ArrayLike | None = None, progress: Progress = ignore_progress
) -> tuple[Ints, Ints]:
    """Returns the two rims that are nearest to each other, each in the direction of the faces that would close it.

    The distance of two rims is the mean distance from the vertices of one to the nearest vertex of the other, averaged over both
    directions.
    """
    rims = [loop.vertices for loop in boundary_loops(points, triangles).loops]
    component = connected_components(triangles, len(points))[0]
    if among is not None:
        chosen = check_vertex_mask("among", among, len(points))
        rims = [rim for rim in rims if chosen[rim].all()]
    second, first = np.tril_indices(len(rims), -1)
    if among is None:
        part = np.array([component[rim[0]] for rim in rims], dtype=np.int64)
        first, second = (ends[part[first] != part[second]] for ends in (first, second))
    if len(first) == 0:
        where = "of different components" if among is None else "with only selected vertices"
        raise FilterInputError(
            f"there are no two rims {where} to join: {len(rims)} found; put both parts into one layer (merge the visible layers) "
            "and open each where they are to meet"
        )
    low, high = (np.array([bound(points[rim], axis=0) for rim in rims]) for bound in (np.min, np.max))
    gaps = np.linalg.norm(np.maximum(0.0, np.maximum(low[first] - high[second], low[second] - high[first])), axis=1)
    trees: dict[int, spatial.cKDTree] = {}
    nearest, pair = np.inf, 0
    for step, k in enumerate(np.argsort(gaps, kind="stable")):
        if gaps[k] >= nearest:  # rims are at least as far apart as their boxes, and all later gaps are larger
            break
        progress(step / len(gaps))
        a, b = int(first[k]), int(second[k])
        for end in (a, b):
            if end not in trees:
                trees[end] = spatial.cKDTree(points[rims[end]])
        distance = (trees[a].query(trees[b].data)[0].mean() + trees[b].query(trees[a].data)[0].mean()) / 2
        if distance < nearest:
            nearest, pair = distance, int(k)
    return rims[first[pair]], rims[second[pair]]


def one_is_inside_out(first: Floats, second: Floats) -> bool | None:
    """Returns True if turning one part over would at least halve the bending of the neck, False if at least double it, else None.

    The rims, (a, 3) and (b, 3), have the direction of the faces that would close them. Then the area vector of a rim points out
    of a correct part, and into a part that is inside out. A neck leaves one rim along its area vector s, and enters the other rim
    along t, against the area vector of that rim. The axis of the neck is modelled as the cubic between the centres of the rims
    with the unit tangents s and t, at a scale where the chord d has length 1. Its bending is a fourth of the integral of its
    squared second derivative: |s - d|^2 + (s - d) . (t - d) + |t - d|^2. For near rims s . t decides. None if a rim has no area.
    """
    centre = first.mean(axis=0)
    extent = float(max(np.abs(first - centre).max(), np.abs(second - centre).max()))
    if extent == 0.0:
        return None
    loops = (first - centre) / extent, (second - centre) / extent
    areas = [area_vector(loop) for loop in loops]
    sizes = [float(np.linalg.norm(area)) for area in areas]
    if min(sizes) == 0.0:
        return None
    out, into = areas[0] / sizes[0], -areas[1] / sizes[1]
    chord = loops[1].mean(axis=0) - loops[0].mean(axis=0)
    apart = float(np.linalg.norm(chord))
    if apart <= _NEAR * float(np.sqrt(np.array(sizes) / np.pi).mean()):
        same = float(out @ into)
        return same < 0.0 if abs(same) > _PARALLEL else None
    chord /= apart
    alike = min(_bending(out, into, chord), _bending(-out, -into, chord))
    opposite = min(_bending(out, -into, chord), _bending(-out, into, chord))
    return opposite < alike if min(alike, opposite) <= _CLEARLY * max(alike, opposite) else None


def _bending(start: Floats, end: Floats, chord: Floats) -> float:
    a, b = start - chord, end - chord
    return float(a @ a + a @ b + b @ b)


@dataclass(frozen=True, eq=False)
class Blend:
    """A band that joins two rims."""

    vertices: Floats  # (k, 3) the new vertices
    faces: Ints  # (b, 3) the new triangles, oriented like those at the rims; n + i is new vertex i of a mesh of n vertices
    rims: tuple[Ints, Ints]  # their vertices, in the direction of the new triangles
    doubtful: bool  # whether a part may be inside out: `one_is_inside_out` gave None


def bridge_rims(points: Floats, triangles: Ints, a: Ints, b: Ints, *, progress: Progress = ignore_progress) -> "Blend":
    """Builds a band of triangles between two rims, as dense as the rims.

    Spans are edges from one rim to the other. The search of [fuchs1977] finds a triangulation without new vertices: it contains
    the shortest span, and its sum of squared span lengths is the least. Rows of new vertices divide its spans evenly. The same
    search joins neighbouring rows by triangles, which are equilateral on average.
    """
    passed, visits = np.unique(np.concatenate([a, b]), return_counts=True)
    if visits.max() > 1:
        raise FilterInputError(
            f"the rims share vertex {passed[visits.argmax()]}, or one passes it twice: a band joins rims that do not touch; "
            "delete the faces there, or select two other rims"
        )
    component = connected_components(triangles, len(points))[0]
    inside_out = component[a[0]] != component[b[0]] and one_is_inside_out(points[a], points[b])
    if inside_out:
        raise FilterInputError(
            f"one of the parts is inside out, the part with vertex {a[0]} or the part with vertex {b[0]}: a neck between their "
            "rims would have to turn back; turn the faces of one part over (invert faces orientation) before you join them"
        )
    rims = a, b
    a = a[::-1]  # now both have the same direction
    lower, upper = shortest_spans(points[a], points[b], part_of(progress, 0.0, 0.3))
    count = _rows_between(points, a, b, a[lower], b[upper])
    loops, added = [a], [np.empty((0, 3))]
    total = len(points)
    for row in range(1, count):
        share = row / count
        between = (1.0 - share) * points[a[lower]] + share * points[b[upper]]
        size = round((1.0 - share) * len(a) + share * len(b))
        # Every second row is shifted by half an edge, which makes triangles more equilateral.
        added.append(_resampled(between, size, 0.5 * (row % 2)))
        loops.append(np.arange(total, total + size, dtype=np.int32))
        total += size
    loops.append(b)
    all_points = np.concatenate([points, *added])
    strips = []
    for row, (low, high) in enumerate(pairwise(loops)):
        partial = part_of(progress, 0.3 + 0.7 * row / count, 0.3 + 0.7 * (row + 1) / count)
        strips.append(_strip(all_points, low, high, partial))
    return Blend(np.concatenate(added), np.concatenate(strips), rims, inside_out is None)


def _rows_between(points: Floats, a: Ints, b: Ints, lower: Ints, upper: Ints) -> int:
    """Returns how many rows of equilateral triangles, with the rims' mean edge as side, fit in the mean span; at least 1."""
    with np.errstate(over="ignore"):
        span = float(np.linalg.norm(points[lower] - points[upper], axis=1).mean())
        edge = float(np.concatenate([side_lengths(points[a]), side_lengths(points[b])]).mean())
    if not (0.0 < edge < np.inf and span < np.inf):
        raise FilterInputError("the rims have no length, or rims or spans have a length out of range: nothing can be joined")
    count = round(span / (math.sqrt(0.75) * edge))
    if count * (len(a) + len(b)) > MOST_ADDED:
        raise FilterInputError(
            f"the rims are {span:.3g} apart and their edges {edge:.3g} long: a band of {count:,} rows would have more than "
            f"{MOST_ADDED:,} triangles; bring the parts closer together"
        )
    return max(1, count)


def _strip(points: Floats, low: Ints, high: Ints, progress: Progress) -> Ints:
    """Returns (a + b, 3) the triangles between loops of a and b vertices in the same direction."""
    i, j = shortest_spans(points[low], points[high], progress)
    along_low = np.roll(i, -1) != i
    lows, highs = low[i], high[j]
    first = np.where(along_low, np.roll(lows, -1), lows)
    return np.column_stack([first, np.where(along_low, lows, highs), np.where(along_low, highs, np.roll(highs, -1))])


def _resampled(loop: Floats, count: int, shift: float) -> Floats:
    """Returns (count, 3) points at equal distances along a closed polyline; the first lies `shift` distances after the start."""
    lengths = np.concatenate([[0.0], np.cumsum(side_lengths(loop))])
    places = (np.arange(count) + shift) / count * lengths[-1]
    closed = np.concatenate([loop, loop[:1]])
    return np.column_stack([np.interp(places, lengths, closed[:, k]) for k in range(3)])


def shortest_spans(first: Floats, second: Floats, progress: Progress) -> tuple[Ints, Ints]:
    """Finds spans between two loops with the least sum of squared lengths, the shortest span of all among them.

    The loops have the same direction. Returns the (a + b,) indices of both ends of each span, in order along the band. If the
    least sum would take a span twice, a slightly larger sum is accepted.
    """
    if len(first) * len(second) > MOST_SPANS:
        raise FilterInputError(
            f"the rims or rows have {len(first):,} and {len(second):,} edges: a band is searched among all spans between them, "
            f"at most {MOST_SPANS:,}; simplify the parts, or open them where their rims are shorter"
        )
    low = np.minimum(first.min(axis=0), second.min(axis=0))
    extent = max(float((first - low).max()), float((second - low).max())) or 1.0
    first, second = (first - low) / extent, (second - low) / extent  # so that squares stay in range
    nearest, index = spatial.cKDTree(second).query(first)
    i, j = int(nearest.argmin()), int(index[nearest.argmin()])
    # The path of least cost through the grid of spans, from (i, j) once round both loops and back to (i, j).
    closed, other = (np.take(loop, range(k, k + len(loop) + 1), axis=0, mode="wrap") for loop, k in ((first, i), (second, j)))
    from_first = np.empty((len(closed), len(other)), dtype=np.bool_)
    costs = np.empty(len(other))
    rows = max(1, _SPANS_AT_A_TIME // len(other))
    # The last row and column repeat the first. A span that the path takes twice would have four triangles: then we search again.
    progress = rising(progress)
    for apart in (False, True):
        for start in range(0, len(closed), rows):
            progress(start / len(closed))
            _cheapest(closed, other, start, min(start + rows, len(closed)), apart, costs, from_first)
        path = _way_back(from_first)
        spans = (path[:, 0] + i) % len(first), (path[:, 1] + j) % len(second)
        if len(np.unique(np.column_stack(spans), axis=0)) == len(path):
            break
    return spans


@compiled
def _cheapest(first: Floats, second: Floats, start: int, end: int, apart: bool, costs: Floats, from_first: Bools) -> None:
    """Fills rows `start` to `end` - 1 of the grid; `costs` holds the costs of row start - 1, afterwards of row end - 1.

    Each path begins at (0, 0) and ends at the opposite corner, the same span. No path goes through the other two corners, which
    are this span, too. With `apart` a path meets the first column only in the first half of the rows and the last column only in
    the second half; the same holds for rows.
    """
    n, m = first.shape[0], second.shape[0]
    for i in range(start, end):
        for j in range(m):
            length = 0.0
            for k in range(3):
                length += (first[i, k] - second[j, k]) ** 2
            from_first[i, j] = i > 0 and (j == 0 or costs[j] <= costs[j - 1])
            if not from_first[i, j]:
                costs[j] = costs[j - 1] if j > 0 else 0.0
            costs[j] += length
            barred_column, barred_row = m - 1 if 2 * i < n else 0, n - 1 if 2 * j < m else 0
            if ((apart or i == 0) and j == barred_column) or ((apart or j == 0) and i == barred_row):
                costs[j] = np.inf


@compiled
def _way_back(from_first: Bools) -> Ints:
    i, j = from_first.shape[0] - 1, from_first.shape[1] - 1
    path = np.empty((i + j, 2), dtype=np.int32)
    for k in range(i + j - 1, -1, -1):
        if from_first[i, j]:
            i -= 1
        else:
            j -= 1
        path[k, 0], path[k, 1] = i, j
    return path
