"""Held-out vertices for the cross-validation of filters [batson2019], and means over rings."""

import numpy as np

from ..geometry import mean_edge_length
from ..libraries import sparse
from ..mesh import Bools, Floats, Ints, mask_of
from ..topology import OneRings, border_vertices, edges

# Probability that a vertex is a candidate. One of two adjacent candidates is dropped; a set gets 9 to 14 % of the vertices.
_CANDIDATES = 0.35
#: Rings of a ball. Its middle and the vertices just outside correlate by 0.1 to 0.2 if noise is averaged twice over one-rings.
BALL = 2
# Random numbers are fractional parts of lengths at vertices times (multiple + step * k); k is the number of a set, or the seed.
_MULTIPLES, _STEPS = (997.0, 1511.0), (137.7, 211.1)


def held_out_vertices(points: Floats, faces_or_edges: Ints, *, scored: Bools, sets: int, seed: int = 0) -> list[Ints]:
    """Returns up to `sets` random independent sets of the `scored` vertices: no two vertices of a set are adjacent.

    Each set is sorted and not empty. The sets are disjoint until less than 35 % of the scored vertices are left; then all may
    be drawn again. Random numbers depend on the seed and on the edge lengths at a vertex divided by the mean edge length: not on
    the place, rotation, size and numbering of a mesh. (e, 2) edges, such as neighbours in a cloud, must be unique.
    """
    pairs = edges(faces_or_edges) if faces_or_edges.shape[1] == 3 else faces_or_edges
    sums = lengths_around(points, pairs, mean_edge_length(points, pairs))
    remaining, held_out = scored.copy(), []
    for number in range(seed * sets, (seed + 1) * sets):
        draws, ranks = ((sums * (multiple + step * number)) % 1.0 for multiple, step in zip(_MULTIPLES, _STEPS, strict=True))
        chosen = remaining & (draws < _CANDIDATES)
        a, b = pairs[chosen[pairs].all(axis=1)].T
        chosen[np.where(ranks[a] < ranks[b], a, b)] = False
        held_out.append(np.flatnonzero(chosen).astype(np.int32))
        remaining &= ~chosen
        if np.count_nonzero(remaining) < _CANDIDATES * np.count_nonzero(scored):
            remaining = scored.copy()
    return [indices for indices in held_out if len(indices)]


def middles_of_balls(points: Floats, faces: Ints, *, scored: Bools, sets: int, seed: int = 0) -> list[Ints]:
    """Returns up to `sets` random sets of `scored` vertices: the middles of balls of two rings that do not touch.

    Scored vertices with the least random number within five edges become middles, the vertices within five edges of them are left
    out, and so on. Random numbers are as in `held_out_vertices`; in a regular lattice they are equal, and balls overlap.
    """
    pairs, held_out = edges(faces), list[Ints]()
    a, b = np.concatenate([pairs, pairs[:, ::-1]]).T
    sums = lengths_around(points, pairs, mean_edge_length(points, pairs))
    for number in range(seed * sets, (seed + 1) * sets):
        numbers = (sums * (_MULTIPLES[0] + _STEPS[0] * number)) % 1.0
        free, middles = scored.copy(), np.zeros_like(scored)
        while free.any():
            least = np.where(free, numbers, 1.0)
            for _ in range(2 * BALL + 1):
                np.minimum.at(least, a, least[b])
            chosen = free & (least == numbers)
            middles |= chosen
            free &= ~with_neighbours(chosen, pairs, 2 * BALL + 1)
        held_out.append(np.flatnonzero(middles).astype(np.int32))
    return [middles for middles in held_out if len(middles)]


def random_signs(points: Floats, pairs: Ints, seed: int) -> Floats:
    """Returns (n,) random signs, 1 or -1: noise of standard deviation 1.

    Signs depend on the lengths of the (e, 2) edges and, as these are equal in regular meshes, on distances from the centroid.
    """
    edge = mean_edge_length(points, pairs)
    distances = np.linalg.norm(points - points.mean(axis=0), axis=1) / edge
    of_lengths, of_distances = (multiple + step * seed for multiple, step in zip(_MULTIPLES, _STEPS, strict=True))
    numbers = (lengths_around(points, pairs, edge) * of_lengths + distances * of_distances) % 1.0
    return np.where(numbers < 0.5, -1.0, 1.0)


def lengths_around(points: Floats, pairs: Ints, unit: float) -> Floats:
    """Returns (n,) the sum of the lengths of the (e, 2) edges at each vertex, divided by `unit`."""
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) / unit
    return np.asarray(np.bincount(pairs.ravel(), np.repeat(lengths, 2), minlength=len(points)), dtype=np.float64)


def put_at_means(points: Floats, rings: OneRings, held: Ints) -> Floats:
    """Returns (n, 3) the points, each held-out vertex at the mean of its neighbours that are not held out."""
    result = points.copy()
    result[held] = means_of_others(points, rings, held, mask_of(held, len(points)))
    return result


def means_of_others(points: Floats, rings: OneRings, vertices: Ints, hidden: Bools) -> Floats:
    """Returns (k, 3) for each of k vertices the mean of its neighbours that are not hidden, or the vertex if there are none."""
    visible = np.where(hidden[rings.neighbours], 0.0, 1.0)
    around = sparse.csr_matrix((visible, rings.neighbours, rings.offsets), shape=(len(points), len(points)))[vertices]
    counts = np.asarray(around.sum(axis=1))
    return np.where(counts > 0.0, around @ points / np.maximum(counts, 1.0), points[vertices])


def with_neighbours(vertices: Bools, pairs: Ints, rings: int = 1) -> Bools:
    """Returns (n,) the mask `vertices`, grown by `rings` rings of neighbours along the (e, 2) edges."""
    a, b = pairs.T
    for _ in range(rings):
        reached = vertices.copy()
        reached[b[vertices[a]]] = reached[a[vertices[b]]] = True
        vertices = reached
    return vertices


def far_from_border(faces: Ints, n_vertices: int, *, rings: int = 2) -> Bools:
    """Returns (n,) which vertices of faces have `rings` complete rings: they are more than `rings` edges from the border."""
    pairs = edges(faces)
    near = with_neighbours(border_vertices(faces, n_vertices), pairs, rings)
    return np.asarray(mask_of(pairs, n_vertices) & ~near)


def local_means(values: Floats, counted: Bools, pairs: Ints, *, times: int) -> Floats:
    """Returns (n,) weighted means of the `counted` values over neighbourhoods of `times` rings; near values weigh more.

    Values are summed over one-rings of the (e, 2) edges, `times` times. The mean is 0 if a neighbourhood has no counted value.
    """
    sums, weights = np.where(counted, values, 0.0), counted.astype(np.float64)
    a, b = pairs.T
    for numbers in (sums, weights):
        for _ in range(times):
            numbers += np.bincount(a, numbers[b], len(numbers)) + np.bincount(b, numbers[a], len(numbers))
    return np.divide(sums, weights, out=np.zeros(len(values)), where=weights > 0.0)
