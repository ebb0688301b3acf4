"""Joins two parts: a band of triangles between two facing rims, whose interior is then faired."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..holes.rims import find_rims
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable
from ..topology import connected_components
from .region import Energy, fair_region
from .rim_directions import rim_directions

__all__ = ["Blend", "blend_parts", "bridge_rims", "facing_rims"]

# A byte each is needed for the spans between two rims; the most are 400 MB and 3 s. So many are between two calls of progress.
_MOST_SPANS, _SPANS_AT_A_TIME = 400_000_000, 10_000_000


@dataclass(frozen=True, eq=False)
class Blend:
    """What joins two rims.

    Attributes:
        vertices: (k, 3) the new vertices.
        faces: (b, 3) the new triangles, oriented as those on the rims. An index below n names a vertex of the mesh, n + i the new
            vertex i.
        rims: the vertices of the two rims, in the direction of these triangles.
        doubtful: whether the rims do not tell that both parts are the right way out: neither way bends the neck clearly less.
    """

    vertices: Floats
    faces: Ints
    rims: tuple[Ints, Ints]
    doubtful: bool = False


def blend_parts(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    energy: Energy = "thin_plate",
    among: ArrayLike | None = None,
    progress: Progress = ignore_progress,
) -> Blend:
    """A smooth neck between the two rims that face each other.

    The band of `bridge_rims` with its new vertices placed by `fair_region`; those of the mesh stay.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles of both parts.
        energy: "membrane" meets the parts with a crease, as a soap film would; "thin_plate" continues their tangent planes,
            "minimum_variation" their curvatures too.
        among: as in `facing_rims`.
        progress: called with the share that is done; may raise to stop.

    Raises:
        FilterInputError: as `facing_rims` and `bridge_rims`.
    """
    points, triangles = check_mesh(vertices, faces)
    first, second = facing_rims(points, triangles, among=among, progress=lambda done: progress(0.1 * done))
    band = bridge_rims(points, triangles, first, second, progress=lambda done: progress(0.1 + 0.4 * done))
    if len(band.vertices) == 0:
        progress(1.0)
        return band
    joined = np.concatenate([points, band.vertices])
    free = np.arange(len(joined)) >= len(points)
    everything = np.concatenate([triangles, band.faces])
    fair = fair_region(joined, everything, free, energy=energy, progress=lambda done: progress(0.5 + 0.5 * done))
    return replace(band, vertices=fair.vertices[len(points) :])


def facing_rims(
    vertices: ArrayLike, faces: ArrayLike, *, among: ArrayLike | None = None, progress: Progress = ignore_progress
) -> tuple[Ints, Ints]:
    """The two rims that lie nearest each other, as `find_rims` gives them: in the direction of the faces that would close them.

    How near is the mean distance from the vertices of a rim to the nearest of the other, both ways. Rims that meet a vertex twice
    do not count.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        among: (n,) bool. None: the rims are of different components. Otherwise they are rims all of whose vertices are true, and
            may belong to one component, which gets a handle.
        progress: called now and then with the share that is done; may raise to stop.

    Raises:
        FilterInputError: there are no two such rims.
    """
    points, triangles = check_mesh(vertices, faces)
    rims = [rim.vertices for rim in find_rims(points, triangles)[0] if len(np.unique(rim.vertices)) == len(rim.vertices)]
    component = connected_components(triangles, len(points))[0]
    if among is not None:
        chosen = check_movable(among, len(points))
        rims = [rim for rim in rims if chosen[rim].all()]
    second, first = np.tril_indices(len(rims), -1)
    if among is None:
        part = np.array([component[rim[0]] for rim in rims], dtype=np.int64)
        first, second = (ends[part[first] != part[second]] for ends in (first, second))
    if len(first) == 0:
        where = "of different components" if among is None else "all of whose vertices are selected"
        raise FilterInputError(
            f"there are no two rims {where} to join: {len(rims)} found; put both parts into one layer (merge the visible layers) "
            "and open each where they are to meet"
        )
    low, high = (np.array([bound(points[rim], axis=0) for rim in rims]) for bound in (np.min, np.max))
    gaps = np.linalg.norm(np.maximum(0.0, np.maximum(low[first] - high[second], low[second] - high[first])), axis=1)
    trees: dict[int, cKDTree] = {}
    nearest, found = np.inf, 0
    for step, k in enumerate(np.argsort(gaps, kind="stable")):
        if gaps[k] >= nearest:  # nor is any later pair nearer than the boxes around its rims
            break
        progress(step / len(gaps))
        a, b = int(first[k]), int(second[k])
        for end in (a, b):
            if end not in trees:
                trees[end] = cKDTree(points[rims[end]])
        distance = (trees[a].query(trees[b].data)[0].mean() + trees[b].query(trees[a].data)[0].mean()) / 2
        if distance < nearest:
            nearest, found = distance, int(k)
    return rims[first[found]], rims[second[found]]


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

    The rims are joined by spans whose squared lengths have the least sum among all triangulations without new vertices that
    contain the shortest span; the search is that of [fuchs1977]. Rows of new vertices divide the spans evenly, and neighbouring
    rows are joined in the same way.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        first: (a,) the vertices of one rim, in the direction of the faces that would close it, as `facing_rims` gives them.
        second: (b,) those of the other, which shares none with the first.
        rows: how many rows of triangles. None: as many as make them equilateral on average, that is the mean span over
            sqrt(3) / 2 of the rims' mean edge, rounded, at least 1. More are finer across the band alone. A single row
            between rims that tilt strongly may use a span twice, as an edge of four triangles.
        progress: called now and then with the share that is done; may raise to stop.

    Returns:
        The band; its vertices lie on straight lines between the rims.

    Raises:
        FilterInputError: a rim is not one of border edges, the rims meet, the product of their numbers of edges is above 400
            million, or they belong to two components of which one is clearly inside out: see `rim_directions`.
    """
    points, triangles = check_mesh(vertices, faces)
    border = {edge for rim in find_rims(points, triangles)[0] for edge in _edges(rim.vertices)}
    a, b = (_checked_rim(rim, border, name) for rim, name in ((first, "first"), (second, "second")))
    if len(np.intersect1d(a, b)):
        raise FilterInputError(f"the rims share vertex {np.intersect1d(a, b)[0]}: a band joins rims that do not touch")
    if rows is not None and (rows != int(rows) or rows < 1):
        raise FilterInputError(f"rows is {rows}: it is a whole number of at least 1, or None")
    if len(a) * len(b) > _MOST_SPANS:
        raise FilterInputError(
            f"the rims have {len(a):,} and {len(b):,} edges: a band is searched among the spans between them, which may be up to "
            f"{_MOST_SPANS:,}; simplify the parts, or open them where their rims are shorter"
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
    a = a[::-1]  # now both run the same way round
    (lower, upper) = _spans(points[a], points[b], lambda done: progress(0.3 * done))
    span = np.linalg.norm(points[a[lower]] - points[b[upper]], axis=1).mean()
    edge = np.concatenate([_steps(points[a]), _steps(points[b])]).mean()
    count = rows or max(1, round(float(span / (np.sqrt(0.75) * edge))))
    loops, added = [a], [np.empty((0, 3))]
    total = len(points)
    for row in range(1, count):
        share = row / count
        between = (1.0 - share) * points[a[lower]] + share * points[b[upper]]
        size = round((1.0 - share) * len(a) + share * len(b))
        # Each row is shifted by half an edge against the one before: triangles come out nearer to equilateral.
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


def _strip(points: Floats, low: Ints, high: Ints, progress: Progress) -> Ints:
    """(a + b, 3) the triangles between two loops that run the same way round."""
    i, j = _spans(points[low], points[high], progress)
    along_low = np.roll(i, -1) != i
    here, there = low[i], high[j]
    turned = np.where(along_low, np.roll(here, -1), here)
    faces: Ints = np.column_stack([turned, np.where(along_low, here, there), np.where(along_low, there, np.roll(there, -1))])
    return faces


def _spans(first: Floats, second: Floats, progress: Progress) -> tuple[Ints, Ints]:
    """The ends of the spans, a + b of them, in the loops (a, 3) and (b, 3)."""
    low = np.minimum(first.min(axis=0), second.min(axis=0))
    extent = max(float((first - low).max()), float((second - low).max())) or 1.0
    first, second = (first - low) / extent, (second - low) / extent  # whose squares are ordinary numbers
    nearest, index = cKDTree(second).query(first)
    i, j = int(nearest.argmin()), int(index[nearest.argmin()])
    path = _shortest(np.roll(first, -i, axis=0), np.roll(second, -j, axis=0), progress)
    return (path[:, 0] + i) % len(first), (path[:, 1] + j) % len(second)


def _shortest(first: Floats, second: Floats, progress: Progress) -> Ints:
    """The cheapest way through the grid of spans from (0, 0) once round to (a, b), without its last span, which is its first."""
    closed, other = (np.concatenate([loop, loop[:1]]) for loop in (first, second))
    from_first = np.empty((len(closed), len(other)), dtype=np.bool_)
    costs = np.empty(len(other))
    rows = max(1, _SPANS_AT_A_TIME // len(other))
    for start in range(0, len(closed), rows):
        progress(start / len(closed))
        _cheapest(closed, other, start, min(start + rows, len(closed)), costs, from_first)
    return _way_back(from_first)


@njit(cache=True)
def _cheapest(first: Floats, second: Floats, start: int, end: int, costs: Floats, from_first: Bools) -> None:
    """Rows start to end of the grid; `costs` are those of the row before, and then of the last."""
    for i in range(start, end):
        for j in range(second.shape[0]):
            length = 0.0
            for k in range(3):
                length += (first[i, k] - second[j, k]) ** 2
            if i > 0 and (j == 0 or costs[j] <= costs[j - 1]):
                from_first[i, j] = True
                costs[j] += length
            else:
                from_first[i, j] = False
                costs[j] = length + costs[j - 1] if j > 0 else length
            # Round one rim alone the way would come back to its first span, and that edge would get four triangles.
            if (i == 0 and j == second.shape[0] - 1) or (i == first.shape[0] - 1 and j == 0):
                costs[j] = np.inf


@njit(cache=True)
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


def _resampled(loop: Floats, count: int, shift: float) -> Floats:
    """(count, 3) points at equal distances along a closed polyline, the first one `shift` of them after its start."""
    lengths = np.concatenate([[0.0], np.cumsum(_steps(loop))])
    places = (np.arange(count) + shift) / count * lengths[-1]
    closed = np.concatenate([loop, loop[:1]])
    return np.column_stack([np.interp(places, lengths, closed[:, k]) for k in range(3)])


def _steps(loop: Floats) -> Floats:
    """The length of every edge of a closed polyline."""
    return np.asarray(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))


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
