"""Vertices that are kept from a filter, so that it can be judged by what it says of them [batson2019]."""

import numpy as np

from ..geometry import mean_edge_length
from ..mesh import Bools, Floats, Ints
from ..topology import OneRings, border_vertices, edges

# Each vertex asks to be held out with this probability; of two neighbours that ask, one gives in: about a ninth is left.
_ASKS = 0.35
# Random numbers are the fractions of these many times a length of the geometry, other multiples for every mask.
_MULTIPLES = (997.0, 1511.0)
_STEPS = (137.7, 211.1)


def held_out_vertices(points: Floats, faces_or_edges: Ints, *, scored: Bools, masks: int, seed: int = 0) -> list[Ints]:
    """Sets of vertices, no two of a set adjacent, the sets disjoint as long as there are vertices left.

    The random numbers are made of the lengths of the edges at a vertex over the mean length: moving, turning, scaling and
    renumbering the mesh changes none of them by more than rounding.

    Args:
        points: (n, 3) coordinates.
        faces_or_edges: (m, 3) triangles, or (e, 2) edges, each once: those of a cloud join neighbours.
        scored: (n,) the vertices that may be held out.
        masks: how many sets.
        seed: other sets for another number.

    Returns:
        A list of ascending vertices for every set.
    """
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    sums = _lengths_around(points, pairs)
    left, found = scored.copy(), []
    for mask in range(seed * masks, (seed + 1) * masks):
        asks, insists = ((sums * (multiple + step * mask)) % 1.0 for multiple, step in zip(_MULTIPLES, _STEPS, strict=True))
        chosen = left & (asks < _ASKS)
        a, b = pairs[chosen[pairs].all(axis=1)].T
        chosen[np.where(insists[a] < insists[b], a, b)] = False
        found.append(np.flatnonzero(chosen).astype(np.int32))
        left &= ~chosen
        if np.count_nonzero(left) < _ASKS * np.count_nonzero(scored):
            left = scored.copy()
    return found


def random_numbers(points: Floats, pairs: Ints, seed: int) -> Floats:
    """(n,) numbers from 0 to 1, made as those of `held_out_vertices` of the (e, 2) edges, and of the distances from the middle.

    The distances tell vertices of a regular mesh apart.
    """
    distances = np.linalg.norm(points - points.mean(axis=0), axis=1) / mean_edge_length(points, pairs)
    multiple, other = (of + step * seed for of, step in zip(_MULTIPLES, _STEPS, strict=True))
    return np.asarray((_lengths_around(points, pairs) * multiple + distances * other) % 1.0)


def random_signs(points: Floats, pairs: Ints, seed: int) -> Floats:
    """(n,) 1 or -1 at every vertex, by `random_numbers`: noise with a standard deviation of 1."""
    return np.where(random_numbers(points, pairs, seed) < 0.5, -1.0, 1.0)


def _lengths_around(points: Floats, pairs: Ints) -> Floats:
    """(n,) the sums of the lengths of the edges at a vertex, in mean lengths."""
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) / mean_edge_length(points, pairs)
    return np.asarray(np.bincount(pairs.ravel(), np.repeat(lengths, 2), minlength=len(points)), dtype=np.float64)


def without(points: Floats, rings: OneRings, held: Ints) -> Floats:
    """(n, 3) the points, each held-out vertex at the mean of its neighbours that are not held out: it has no part in it.

    One that has no such neighbour stays.
    """
    hidden = np.zeros(len(points), dtype=np.bool_)
    hidden[held] = True
    result = points.copy()
    result[held] = means_of_others(points, rings, held, hidden)
    return result


def means_of_others(points: Floats, rings: OneRings, which: Ints, hidden: Bools) -> Floats:
    """(k, 3) for some vertices the means of those neighbours that are not hidden; of none, the vertex itself."""
    counts = np.diff(rings.offsets)[which]
    # The places of the neighbours of all of them, one after the other.
    starts = np.cumsum(counts) - counts
    places = np.arange(counts.sum()) + np.repeat(rings.offsets[which] - starts, counts)
    owners, near = np.repeat(np.arange(len(which)), counts), rings.neighbours[places]
    seen = ~hidden[near]
    owners, near = owners[seen], near[seen]
    number = np.bincount(owners, minlength=len(which))
    sums = np.column_stack([np.bincount(owners, points[near, axis], len(which)) for axis in range(3)])
    return np.where(number[:, None] > 0, sums / np.maximum(number, 1)[:, None], points[which])


def heights_of_means(points: Floats, rings: OneRings, normals: Floats, which: Ints) -> Floats:
    """(k,) how far along their normals the means of their neighbours are from some vertices."""
    ways = means_of_others(points, rings, which, np.zeros(len(points), dtype=np.bool_)) - points[which]
    return np.asarray(np.einsum("ij,ij->i", ways, normals[which]))


def with_neighbours(which: Bools, pairs: Ints) -> Bools:
    """(n,) some vertices and those that (e, 2) edges join to them."""
    a, b = pairs.T
    reached = which.copy()
    reached[b[which[a]]] = reached[a[which[b]]] = True
    return reached


def far_from_border(faces: Ints, n_vertices: int, *, rings: int = 2) -> Bools:
    """(n,) the vertices of the faces that more than that many edges separate from the border: their surroundings are whole."""
    pairs = edges(faces)
    near = border_vertices(faces, n_vertices)
    for _ in range(rings):
        near = with_neighbours(near, pairs)
    far = np.zeros(n_vertices, dtype=np.bool_)
    far[pairs] = True
    return np.asarray(far & ~near)


def local_means(values: Floats, counted: Bools, pairs: Ints, *, times: int) -> Floats:
    """(n,) the means of the values around, added up over the one-rings so many times; what is not counted has no part in them.

    Args:
        values: (n,) numbers.
        counted: (n,) which of them count.
        pairs: (e, 2) the edges.
        times: how often; the neighbourhoods are as many rings wide.

    Returns:
        The means; 0 where nothing around counts.
    """
    sums, weights = np.where(counted, values, 0.0), counted.astype(np.float64)
    a, b = pairs.T
    for _ in range(times):
        for numbers in (sums, weights):
            numbers += np.bincount(a, numbers[b], len(numbers)) + np.bincount(b, numbers[a], len(numbers))
    return np.divide(sums, weights, out=np.zeros(len(values)), where=weights > 0.0)
