"""Held-out vertices for the cross-validation of filters [batson2019], and means over one-rings."""

import numpy as np

from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import OneRings, border_vertices, edges

# Probability that a vertex is a candidate; of two adjacent candidates one is dropped, which leaves a ninth of the vertices.
_CANDIDATES = 0.35
# A random number is the fractional part of a length times (multiple + step * number of the mask).
_MULTIPLES = (997.0, 1511.0)
_STEPS = (137.7, 211.1)


def held_out_vertices(points: Floats, faces_or_edges: Ints, *, scored: Bools, masks: int, seed: int = 0) -> list[Ints]:
    """Random independent sets: no two vertices of a set are adjacent.

    The sets are disjoint until less than 35 % of the scored vertices are left; then all may be drawn again. The random numbers
    follow from the edge lengths at a vertex over the mean length: up to rounding they do not change if the mesh is moved, turned,
    scaled or renumbered.

    Args:
        points: (n, 3) coordinates.
        faces_or_edges: (m, 3) triangles; or (e, 2) edges, each once, such as those between neighbours in a cloud.
        scored: (n,) the vertices that may be held out.
        masks: how many sets.
        seed: another number gives other sets.

    Returns:
        The vertices of every set, ascending.
    """
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    sums = _lengths_around(points, pairs)
    left, held_out = scored.copy(), []
    for mask in range(seed * masks, (seed + 1) * masks):
        draws, ranks = ((sums * (multiple + step * mask)) % 1.0 for multiple, step in zip(_MULTIPLES, _STEPS, strict=True))
        chosen = left & (draws < _CANDIDATES)
        a, b = pairs[chosen[pairs].all(axis=1)].T
        chosen[np.where(ranks[a] < ranks[b], a, b)] = False
        held_out.append(np.flatnonzero(chosen).astype(np.int32))
        left &= ~chosen
        if np.count_nonzero(left) < _CANDIDATES * np.count_nonzero(scored):
            left = scored.copy()
    return held_out


def random_numbers(points: Floats, pairs: Ints, seed: int) -> Floats:
    """(n,) random numbers from 0 to 1, from the lengths of the (e, 2) edges at a vertex and its distance from the centroid.

    The distance distinguishes the vertices of a regular mesh, whose edges are equally long.
    """
    distances = np.linalg.norm(points - points.mean(axis=0), axis=1) / mean_edge_length(points, pairs)
    of_lengths, of_distances = (multiple + step * seed for multiple, step in zip(_MULTIPLES, _STEPS, strict=True))
    return np.asarray((_lengths_around(points, pairs) * of_lengths + distances * of_distances) % 1.0)


def random_signs(points: Floats, pairs: Ints, seed: int) -> Floats:
    """(n,) random signs, 1 or -1, from `random_numbers`: noise with a standard deviation of 1."""
    return np.where(random_numbers(points, pairs, seed) < 0.5, -1.0, 1.0)


def _lengths_around(points: Floats, pairs: Ints) -> Floats:
    """(n,) the sum of the edge lengths at each vertex, in mean edge lengths."""
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) / mean_edge_length(points, pairs)
    return np.asarray(np.bincount(pairs.ravel(), np.repeat(lengths, 2), minlength=len(points)), dtype=np.float64)


def without(points: Floats, rings: OneRings, held: Ints) -> Floats:
    """(n, 3) the points, with each held-out vertex at the mean of its neighbours that are not held out.

    A vertex without such neighbours stays.
    """
    hidden = np.zeros(len(points), dtype=np.bool_)
    hidden[held] = True
    result = points.copy()
    result[held] = means_of_others(points, rings, held, hidden)
    return result


def means_of_others(points: Floats, rings: OneRings, vertices: Ints, hidden: Bools) -> Floats:
    """(k, 3) for k vertices the mean of the neighbours that are not hidden; without such neighbours the vertex itself."""
    counts = np.diff(rings.offsets)[vertices]
    # Indices into rings.neighbours, vertex after vertex.
    starts = np.cumsum(counts) - counts
    places = np.arange(counts.sum()) + np.repeat(rings.offsets[vertices] - starts, counts)
    owners, near = np.repeat(np.arange(len(vertices)), counts), rings.neighbours[places]
    visible = ~hidden[near]
    owners, near = owners[visible], near[visible]
    degrees = np.bincount(owners, minlength=len(vertices))
    sums = np.column_stack([np.bincount(owners, points[near, axis], len(vertices)) for axis in range(3)])
    return np.where(degrees[:, None] > 0, sums / np.maximum(degrees, 1)[:, None], points[vertices])


def heights_of_means(points: Floats, rings: OneRings, normals: Floats, vertices: Ints) -> Floats:
    """(k,) for k vertices the height of the mean of the neighbours along the vertex normal."""
    offsets = means_of_others(points, rings, vertices, np.zeros(len(points), dtype=np.bool_)) - points[vertices]
    return np.asarray(np.einsum("ij,ij->i", offsets, normals[vertices]))


def with_neighbours(marked: Bools, pairs: Ints) -> Bools:
    """(n,) the marked vertices and their neighbours along the (e, 2) edges."""
    a, b = pairs.T
    reached = marked.copy()
    reached[b[marked[a]]] = reached[a[marked[b]]] = True
    return reached


def far_from_border(faces: Ints, n_vertices: int, *, rings: int = 2) -> Bools:
    """(n,) the vertices of faces that are more than `rings` edges from the border: they have so many complete rings."""
    pairs = edges(faces)
    near = border_vertices(faces, n_vertices)
    for _ in range(rings):
        near = with_neighbours(near, pairs)
    far = np.zeros(n_vertices, dtype=np.bool_)
    far[pairs] = True
    return np.asarray(far & ~near)


def local_means(values: Floats, counted: Bools, pairs: Ints, *, times: int) -> Floats:
    """(n,) means of the counted values over neighbourhoods of `times` rings.

    Sums over one-rings are repeated, so that near values weigh more.

    Args:
        values: (n,) numbers.
        counted: (n,) the values that count.
        pairs: (e, 2) the edges.
        times: the number of repetitions, and of rings.

    Returns:
        The means; 0 where no value of the neighbourhood counts.
    """
    sums, weights = np.where(counted, values, 0.0), counted.astype(np.float64)
    a, b = pairs.T
    for _ in range(times):
        for numbers in (sums, weights):
            numbers += np.bincount(a, numbers[b], len(numbers)) + np.bincount(b, numbers[a], len(numbers))
    return np.divide(sums, weights, out=np.zeros(len(values)), where=weights > 0.0)
