"""Normal filtering of a mesh in parts: one round at a time, each vertex with as many rings of faces around it as it looks at."""

import math

import numpy as np

from ..checks import FilterInputError
from ..geometry import measure_faces
from ..mesh import Bools, Floats, Ints, Whole, normalised_mesh
from ..topology import BorderPolicy
from .adjacency import Adjacency
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, centre_distance_sums
from .normal_filter import NormalFilter
from .rounds import RINGS_OF_LOOKS, rounds
from .vertex_update import VertexUpdate

#: and those of the means on which deviations are measured
_GUIDE = {"averaged": 1, "guided": 3}
#: points that are normalised already are normalised by this box without the change of a bit
_AS_THEY_ARE = Whole(np.full(3, -0.25), np.full(3, 0.25))
#: the methods that weigh by distance, in the unit of the mean distance of centres
_BY_DISTANCE = ("bilateral", "averaged", "guided")


def rings_of_round(settings: NormalFilter, vertex_iterations: int) -> int:
    """How many rings of faces around a vertex decide where one round takes it.

    Raises:
        FilterInputError: a distance does, in place of a number of rings.
    """
    if settings.neighborhood not in RINGS_OF_NEIGHBORHOOD or settings.method == "vertex_normals":
        raise FilterInputError(f"neighborhood {settings.neighborhood!r} with method {settings.method!r} has no rings of faces")
    rings_of_iteration = RINGS_OF_NEIGHBORHOOD[settings.neighborhood] + _GUIDE.get(settings.method, 0)
    return 2 + vertex_iterations + settings.normal_iterations * rings_of_iteration + RINGS_OF_LOOKS


def needs_distance(settings: NormalFilter) -> bool:
    """Whether a round needs the mean distance of the centres of the whole mesh."""
    return settings.method in _BY_DISTANCE and settings.space_kernel != "constant"


def round_of_part(
    points: Floats,
    faces: Ints,
    settings: NormalFilter,
    *,
    distance: float,
    vertex_iterations: int,
    vertex_update: VertexUpdate,
    border: BorderPolicy,
) -> Floats:
    """(n, 3) the points after one round of `normal_filtering`; those with `rings_of_round` around them as in the whole.

    Args:
        points: (n, 3) coordinates, normalised as those of the whole, in the order of the whole.
        faces: (m, 3) triangles, in the order of the whole.
        settings: the filter of the normals.
        distance: the mean distance of centres in the whole, if `needs_distance`.
        vertex_iterations: steps of the vertices.
        vertex_update: "sun" or "ohtake".
        border: see `normal_filtering`.
    """
    mesh = normalised_mesh(points, faces, whole=_AS_THEY_ARE)
    adjacency = Adjacency.of(mesh)
    mesh = mesh.in_order(adjacency.places)
    found = rounds(
        mesh,
        adjacency,
        settings,
        vertex_iterations=vertex_iterations,
        vertex_update=vertex_update,
        border=border,
        distance=distance,
    )
    moved = points.copy()
    moved[mesh.used] = next(found, mesh.points)
    return moved


def distances_of_part(points: Floats, faces: Ints, own: Bools) -> tuple[list[float], int]:
    """The sum of the distances of the centres of faces that share an edge, and their number, over the faces of a part.

    The numbers of all parts, in one `math.fsum`, give the exact sum over the whole, rounded once.

    Args:
        points: (n, 3) normalised coordinates.
        faces: (m, 3) triangles, two rings around those that count.
        own: (m,) which faces count.

    Returns:
        Numbers whose exact sum is that of the distances; how many distances that are.
    """
    mesh = normalised_mesh(points, faces, whole=_AS_THEY_ARE)
    kept = np.isin(faces, mesh.used).all(axis=1)
    adjacency = Adjacency.of(mesh)
    edge = adjacency.around("edge")
    sums = centre_distance_sums(measure_faces(mesh.in_order(adjacency.places).points, adjacency.faces), edge)[own[kept]]
    return _expansion(sums), int(np.diff(edge.offsets)[own[kept]].sum())


def _expansion(values: Floats) -> list[float]:
    """A few numbers with the exact sum of the values."""
    found: list[float] = []
    while rest := math.fsum([*values.tolist(), *(-part for part in found)]):
        found.append(rest)
    return found
