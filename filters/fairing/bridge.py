"""A band of triangles between two rims."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..execution import Progress, ignore_progress
from ..geometry import side_lengths
from ..mesh import Floats, Ints, check_mesh
from ..topology import boundary_loops, connected_components
from .rim_directions import rim_directions
from .spans import MOST_SPANS, shortest_spans

#: vertices of the largest band
MOST_ADDED = 10_000_000


@dataclass(frozen=True, eq=False)
class Blend:
    """What joins two rims.

    Attributes:
        vertices: (k, 3) the new vertices.
        faces: (b, 3) the new triangles, oriented as those on the rims. An index below n names a vertex of the mesh, n + i the new
            vertex i.
        rims: the vertices of the two rims, in the direction of these triangles.
        doubtful: whether one of the parts may be inside out: turning one of them over would bend the neck neither clearly more
            nor clearly less.
    """

    vertices: Floats
    faces: Ints
    rims: tuple[Ints, Ints]
    doubtful: bool = False


def bridge_rims(
    vertices: ArrayLike,
    faces: ArrayLike,
    first: ArrayLike,
    second: ArrayLike,
    *,
    rows: int | None = None,
    progress: Progress = ignore_progress,
) -> Blend:
    """A band of triangles between two rims, as dense as the rims.

    The spans are the edges from one rim to the other in the triangulation without new vertices that contains the shortest span
    and has the least sum of squared spans; the search is that of [fuchs1977]. Rows of new vertices divide the spans evenly, and
    neighbouring rows are joined in the same way.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        first: (a,) the vertices of one rim, in the direction of the faces that would close it, as `facing_rims` gives them.
        second: (b,) those of the other, which shares none with the first.
        rows: the number of rows of triangles. More are finer across the band, not along it. A single row between strongly tilted
            rims may use a span twice, as an edge of four triangles. None: the mean span over sqrt(3) / 2 of the mean edge of the
            rims, rounded, at least 1, which makes triangles equilateral on average.
        progress: called with the share that is done; may raise to stop.

    Returns:
        The band; its vertices lie on straight lines between the rims.

    Raises:
        FilterInputError: a rim is not one of border edges, the rims meet, the product of their numbers of edges is above 400
            million, they are too far apart for their edges, or they belong to two components of which one is clearly inside out:
            see `rim_directions`.
    """
    points, triangles = check_mesh(vertices, faces)
    border = {edge for loop in boundary_loops(points, triangles).loops for edge in _edges(loop.vertices)}
    a, b = (_checked_rim(rim, border, name) for rim, name in ((first, "first"), (second, "second")))
    if len(np.intersect1d(a, b)):
        raise FilterInputError(f"the rims share vertex {np.intersect1d(a, b)[0]}: a band joins rims that do not touch")
    if rows is not None:
        check_whole_number("rows", rows, least=1, note=", or None")
    if len(a) * len(b) > MOST_SPANS:
        raise FilterInputError(
            f"the rims have {len(a):,} and {len(b):,} edges: a band is searched among the spans between them, which may be up to "
            f"{MOST_SPANS:,}; simplify the parts, or open them where their rims are shorter"
        )
    component = connected_components(triangles, len(points))[0]
    directions = "agree" if component[a[0]] == component[b[0]] else rim_directions(points[a], points[b])
    if directions == "disagree":
        raise FilterInputError(
            f"one of the parts is inside out, that of vertex {a[0]} or that of vertex {b[0]}: their rims are turned so that a "
            "neck between them would have to turn back; turn the faces of one of them over (invert faces orientation) before "
            "joining them"
        )
    rims = a, b
    a = a[::-1]  # now both have the same direction
    lower, upper = shortest_spans(points[a], points[b], lambda done: progress(0.3 * done))
    count = rows or _rows_between(points, a, b, a[lower], b[upper])
    loops, added = [a], [np.empty((0, 3))]
    total = len(points)
    for row in range(1, count):
        share = row / count
        between = (1.0 - share) * points[a[lower]] + share * points[b[upper]]
        size = round((1.0 - share) * len(a) + share * len(b))
        # Each row is shifted by half an edge against the one before, which makes triangles more equilateral.
        added.append(_resampled(between, size, 0.5 * (row % 2)))
        loops.append(np.arange(total, total + size, dtype=np.int32))
        total += size
    loops.append(b)
    everything = np.concatenate([points, *added])
    strips = []
    for row, (low, high) in enumerate(pairwise(loops)):

        def partial(done: float, before: int = row) -> None:
            progress(0.3 + 0.7 * (before + done) / count)

        strips.append(_strip(everything, low, high, partial))
    return Blend(np.concatenate(added), np.concatenate(strips), rims, directions == "unclear")


def _rows_between(points: Floats, a: Ints, b: Ints, lower: Ints, upper: Ints) -> int:
    """How many rows of triangles as long as the edges of the rims fill the spans between them."""
    with np.errstate(over="ignore"):
        span = float(np.linalg.norm(points[lower] - points[upper], axis=1).mean())
        edge = float(np.concatenate([side_lengths(points[a]), side_lengths(points[b])]).mean())
    if not (0.0 < edge < np.inf and span < np.inf):
        raise FilterInputError("the rims have no length, or one that is no ordinary number: there is nothing to join")
    count = round(span / (math.sqrt(0.75) * edge))
    if count * (len(a) + len(b)) > MOST_ADDED:
        raise FilterInputError(
            f"the rims are {span:.3g} apart and their edges {edge:.3g} long: a band of {count:,} rows would be more than "
            f"{MOST_ADDED:,} vertices; bring the parts closer together, or give the number of rows"
        )
    return max(1, count)


def _strip(points: Floats, low: Ints, high: Ints, progress: Progress) -> Ints:
    """(a + b, 3) the triangles between two loops of the same direction."""
    i, j = shortest_spans(points[low], points[high], progress)
    along_low = np.roll(i, -1) != i
    here, there = low[i], high[j]
    first = np.where(along_low, np.roll(here, -1), here)
    faces: Ints = np.column_stack([first, np.where(along_low, here, there), np.where(along_low, there, np.roll(there, -1))])
    return faces


def _resampled(loop: Floats, count: int, shift: float) -> Floats:
    """(count, 3) points at equal distances along a closed polyline, the first one `shift` of such a distance after its start."""
    lengths = np.concatenate([[0.0], np.cumsum(side_lengths(loop))])
    places = (np.arange(count) + shift) / count * lengths[-1]
    closed = np.concatenate([loop, loop[:1]])
    return np.column_stack([np.interp(places, lengths, closed[:, k]) for k in range(3)])


def _edges(rim: Ints) -> list[tuple[int, int]]:
    return list(zip(rim.tolist(), np.roll(rim, -1).tolist(), strict=True))


def _checked_rim(rim: ArrayLike, border: set[tuple[int, int]], name: str) -> Ints:
    given = np.asarray(rim)
    if given.ndim != 1 or len(given) < 3 or not np.issubdtype(given.dtype, np.integer) or len(np.unique(given)) < len(given):
        raise FilterInputError(f"the {name} rim must be at least 3 different vertices in order, got {given.tolist()!r:.80}")
    for u, v in _edges(given):
        if (u, v) not in border:
            raise FilterInputError(
                f"the {name} rim goes from vertex {u} to {v}, where the mesh has no border edge that a face could close in this "
                "direction: give the vertices against the direction of the faces along the rim"
            )
    return given.astype(np.int32)
