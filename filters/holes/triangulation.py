"""The rim of a hole closed with triangles between its own vertices, a long rim in parts."""

import numpy as np

from ..compilation import compiled
from ..execution import Progress, ignore_progress
from ..mesh import Floats, Ints, Longs
from .minimal_triangulation import minimal_triangulation
from .retriangulation import retriangulated
from .vertex_pairs import VertexPairs, is_pair

#: A rim with more vertices than this is first cut in two by a short chord: time grows with the cube of this, memory with the
#: square.
LARGEST_WHOLE = 300


def triangulate_rim(
    points: Floats, opposite: Floats, forbidden: VertexPairs, *, progress: Progress = ignore_progress, whole: int = LARGEST_WHOLE
) -> Ints | None:
    """The triangulation of a rim that minimises (largest dihedral angle, area), compared in this order [liepa2003].

    A rim of up to `whole` vertices is triangulated by `minimal_triangulation`. A longer one is cut in two by the chord that is
    shortest relative to the rim between its ends, again and again; the parts are triangulated one after the other, each with the
    triangles of those before it as neighbours. Then what lies around each chord is triangulated again, so that it need not stay
    an edge: the result is at least as good as that of the parts.

    Args:
        points: (k, 3) the vertices of the rim in order, in the direction of the new faces.
        opposite: (k, 3) the third vertex of the face of the mesh at the edge from i to i + 1; NaN if there is none.
        forbidden: which diagonals must not be used: those that are edges of the mesh.
        progress: called with the share that is done; may raise to stop.
        whole: the largest part that is triangulated at once, from 4.

    Returns:
        (k - 2, 3) indices from 0 to k - 1, in the rim's orientation; None if there is no triangulation without degenerate
        triangles and forbidden diagonals.
    """
    n = len(points)
    size = float(np.abs(points - points.mean(axis=0)).max())
    if n < 3 or not size > 0.0:
        return None
    # Products of four lengths stay in range whatever the unit.
    centre = points.mean(axis=0)
    p, q = (points - centre) / size, (opposite - centre) / size
    parts = [(np.arange(n, dtype=np.int32), q)]
    done: list[Ints] = []
    chords: list[tuple[int, int]] = []
    while parts:
        part, across = parts.pop()
        if len(part) > whole:
            i, j = _chord(p[part], part, forbidden.keys, forbidden.size)
            if i >= 0:
                chords.append((int(part[i]), int(part[j])))
                # The part from i to j is done first; its triangle at the chord is then the neighbour of the other part.
                rest = np.concatenate([part[: i + 1], part[j:]])
                parts.append((rest, np.concatenate([across[:i], np.full((1, 3), np.nan), across[j:]])))
                parts.append((part[i : j + 1], np.concatenate([across[i:j], np.full((1, 3), np.nan)])))
                continue
        for k in np.flatnonzero(np.isnan(across[:, 0])):
            across[k] = _apex(done, int(part[k]), int(part[(k + 1) % len(part)]), p)
        before, own = sum(map(len, done)), len(part) - 2

        def partial(share: float, before: int = before, own: int = own) -> None:
            progress((before + own * share) / (n - 2))

        triangles = minimal_triangulation(p[part], across, forbidden.among(part), partial)
        if triangles is None:
            return None
        done.append(part[triangles])
    return retriangulated(np.concatenate(done), chords, p, q, forbidden)


def _apex(done: list[Ints], a: int, b: int, points: Floats) -> Floats:
    """The third vertex of the triangle with the edge from b to a among those made so far; NaN if there is none."""
    for triangles in done:
        for k in range(3):
            found = np.flatnonzero((triangles[:, k] == b) & (triangles[:, (k + 1) % 3] == a))
            if len(found):
                return np.asarray(points[triangles[found[0], (k + 2) % 3]])
    return np.full(3, np.nan)


@compiled
def _chord(p: Floats, part: Ints, keys: Longs, count: int) -> tuple[int, int]:
    """The shortest diagonal relative to the shorter way along the rim between its ends; (-1, -1) if all are forbidden.

    Each of the two parts gets at least a quarter of the edges.
    """
    n = p.shape[0]
    along = np.zeros(n + 1)
    for i in range(n):
        j = (i + 1) % n
        along[i + 1] = along[i] + np.sqrt((p[j, 0] - p[i, 0]) ** 2 + (p[j, 1] - p[i, 1]) ** 2 + (p[j, 2] - p[i, 2]) ** 2)
    best, best_i, best_j = np.inf, -1, -1
    for i in range(n):
        for j in range(i + n // 4, min(n, i + n - n // 4)):
            way = min(along[j] - along[i], along[n] - along[j] + along[i])
            length = np.sqrt((p[j, 0] - p[i, 0]) ** 2 + (p[j, 1] - p[i, 1]) ** 2 + (p[j, 2] - p[i, 2]) ** 2)
            if length > 0.0 and length < best * way and not is_pair(keys, count, part[i], part[j]):
                best, best_i, best_j = length / way, i, j
    return best_i, best_j
