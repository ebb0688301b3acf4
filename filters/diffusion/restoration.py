"""Volume and dimensions that smoothing has taken from a shape, measured and restored."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..checks import FilterInputError
from ..execution import Progress, part_of
from ..geometry import vertex_normals_by_area
from ..libraries import optimize, sparse
from ..mesh import Bools, Floats, Ints, Longs
from ..topology import proper_faces

# A volume below this share of the sum of the sizes of its parts is rounding: a flat sheet with two sides encloses nothing.
_LEAST_VOLUME = 1e-9
# Coordinates exact to 1e-10 of the diagonal are no longer so after growing back by more than this.
_LARGEST_GROWTH = 1e3
# How often a step gives back. Each time brings long waves nearer to their former amplitude.
_TIMES = 2
# How often the loss is smoothed each time, to remove noise from it.
_PASSES = 2
#: How often the loss is smoothed in all.
SOLVES = _TIMES * _PASSES


class Volumes(NamedTuple):
    """The components that enclose a volume."""

    faces: Ints  # (f, 3) their triangles
    component: Longs  # (f,) a label from 0 for each of these
    vertex_component: Longs  # (n,) the same for the vertices, -1 for those of other components
    volumes: Floats  # the signed volume of each, in cubed mesh units


def enclosed_volumes(points: Floats, faces: Ints, components: Ints, movable: Bools | None) -> Volumes:
    """The volumes of the components without boundary all of whose vertices may move.

    A component has no boundary if its faces run through every edge as often one way as the other; edges may be non-manifold. Of
    the (n,) `components`, unreferenced vertices have -1.
    """
    proper = faces[proper_faces(faces)]
    n, count = len(points), int(components.max(initial=-1)) + 1
    start, end = proper.ravel(), np.roll(proper, -1, axis=1).ravel()
    runs = np.where(start < end, 1, -1), (np.minimum(start, end), np.maximum(start, end))
    balance = sparse.coo_matrix(runs, shape=(n, n)).tocsr().tocoo()
    whole = np.ones(count, dtype=np.bool_)
    whole[components[balance.row[balance.data != 0]]] = False
    if movable is not None:
        whole[components[~movable & (components >= 0)]] = False
    labels = np.where(whole, np.cumsum(whole) - 1, -1)
    vertex_component = np.where(components >= 0, labels[components], -1) if count else np.full(n, -1)
    chosen = proper[vertex_component[proper[:, 0]] >= 0]
    enclosing = Volumes(chosen, vertex_component[chosen[:, 0]], vertex_component, np.zeros(int(whole.sum())))
    return enclosing._replace(volumes=_measure(points, enclosing)[0])


def restore_volumes(points: Floats, original: Volumes) -> Floats:
    """The points, every enclosing component scaled about the centroid of its surface to its original volume, unless that is 0.

    Raises:
        FilterInputError: hardly anything of a component is left to be scaled.
    """
    volumes, centroids = _measure(points, original)
    former = original.volumes
    with np.errstate(divide="ignore", invalid="ignore"):
        growth = np.where(former == 0.0, 1.0, np.cbrt(former / volumes))
    lost = np.flatnonzero(~((growth > 0.0) & (growth <= _LARGEST_GROWTH)))
    if len(lost):
        left = volumes[lost[0]] / former[lost[0]]
        raise FilterInputError(
            f"preserve_volume: of the volume of a closed component {left:.3g} is left after a step, too little a share to scale "
            f"it back ({len(lost)} such components): take a shorter time step, or more of them with flow='conformalized'"
        )
    inside = original.vertex_component >= 0
    component = original.vertex_component[inside]
    result = points.copy()
    result[inside] += (points[inside] - centroids[component]) * (growth[component] - 1.0)[:, None]
    return result


def _measure(points: Floats, volumes: Volumes) -> tuple[Floats, Floats]:
    """The volumes, 0 where they are only rounding, and the centroids of the surfaces."""
    count = len(volumes.volumes)

    def per_component(values: Floats) -> Floats:
        return np.asarray(np.bincount(volumes.component, weights=values, minlength=count), dtype=np.float64)

    a, b, c = (points[volumes.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    total = np.maximum(per_component(areas), np.finfo(float).tiny)
    middles = (a + b + c) / 3.0
    centroids = np.column_stack([per_component(areas * middles[:, k]) / total for k in range(3)])
    # About the centroid: far from the origin the parts would be large and cancel.
    here = centroids[volumes.component]
    parts = np.einsum("ij,ij->i", a - here, np.cross(b - here, c - here)) / 6.0
    sums = per_component(parts)
    return np.where(np.abs(sums) > _LEAST_VOLUME * per_component(np.abs(parts)), sums, 0.0), centroids


def dimensions_restored(
    before: Floats, after: Floats, faces: Ints, smoothed: Callable[[Floats, Progress], Floats], progress: Progress
) -> Floats:
    """The points after a step of smoothing, moved along their normals by what their surroundings have lost in common.

    A step draws convex parts in and hollow ones out. There the loss h = (p - p') . n along the normals n of p' varies slowly,
    while on noise it changes sign from vertex to vertex. So the same smoothing S separates the two: p'' = p' + S(S(h)) n, and
    once more. It is twicing [tukey1977] of the shape along its normals. A sphere, whose h is constant, gets its radius back;
    a wave of a plane of which S leaves the share s comes out with 1 - (1 - s) (1 - s^2)^2.

    `smoothed` is S for (n, 1) values, with its progress. Vertices that the step has not moved and S leaves at 0 stay.
    """
    for time in range(_TIMES):
        normals = vertex_normals_by_area(after, faces)
        loss = np.einsum("ij,ij->i", before - after, normals)[:, None]
        for solve in range(time * _PASSES, (time + 1) * _PASSES):
            loss = smoothed(loss, part_of(progress, solve / SOLVES, (solve + 1) / SOLVES))
        after = after + loss * normals
    return after


def share_with_dimensions(amplitude: float) -> float:
    """The share s of a wave that a step alone leaves, if with kept dimensions it leaves 1 - (1 - s) (1 - s^2)^2 = amplitude."""
    return float(optimize.brentq(lambda s: 1.0 - (1.0 - s) * (1.0 - s**_PASSES) ** _TIMES - amplitude, 0.0, 1.0, xtol=1e-15))
