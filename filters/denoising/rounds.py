"""The rounds of two-step denoising: measure the faces, filter their normals, move the vertices; and again."""

import math
from collections.abc import Iterator
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..geometry import NORMAL, measure_faces
from ..mesh import Bools, Floats, Ints
from ..robust import KernelName
from .face_neighbourhoods import NEIGHBORHOODS, FaceNeighbourhoods, Neighborhood, mean_centre_distance
from .guided import guide_normals
from .normal_filters import RANGE_MEASURES, SPACE_KERNELS, RangeMeasure, SpaceKernel, mean_normals, weighted_normals
from .surroundings import Surroundings
from .vertex_normals import RINGS_OF_VERTICES, corner_means, measure_vertices, vertex_neighbourhoods
from .vertex_update import VertexUpdate, fit_vertices

#: "mean": weights are areas alone [belyaev2001]. "unilateral": areas and a kernel of the deviation of normals [yadav2021].
#: "bilateral": and a kernel of the distance [zheng2011]. "averaged": bilateral, the deviation measured on normals averaged over
#: the faces at the vertices of a face. "guided": bilateral, the deviation measured on guide normals [zhang2015].
#: "vertex_normals": bilateral, on the normals of vertices; a face gets the mean of its corners'. It is there to compare with.
NormalFilterMethod: TypeAlias = Literal["mean", "unilateral", "bilateral", "averaged", "guided", "vertex_normals"]
NORMAL_FILTER_METHODS: tuple[NormalFilterMethod, ...] = get_args(NormalFilterMethod)


class NormalFilter(NamedTuple):
    """What one filter pass does and how often; see `normal_filtering`."""

    method: NormalFilterMethod
    range_kernel: KernelName
    space_kernel: SpaceKernel
    range_measure: RangeMeasure
    range_sigma: float
    range_floor: float
    space_sigma: float
    neighborhood: Neighborhood
    radius: float
    normal_iterations: int

    def checked(self) -> "NormalFilter":
        """Itself, if every value is one that is allowed."""
        check_choice("method", self.method, NORMAL_FILTER_METHODS)
        check_choice("range_kernel", self.range_kernel, SPACE_KERNELS[1:])
        check_choice("space_kernel", self.space_kernel, SPACE_KERNELS)
        check_choice("range_measure", self.range_measure, RANGE_MEASURES)
        check_choice("neighborhood", self.neighborhood, NEIGHBORHOODS)
        check_count("normal_iterations", self.normal_iterations)
        for name in ("range_sigma", "space_sigma", "radius"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise FilterInputError(f"{name} {value} is not finite and above 0")
        if self.method == "vertex_normals":
            check_choice("neighborhood of the method 'vertex_normals'", self.neighborhood, tuple(RINGS_OF_VERTICES))
        if not (math.isfinite(self.range_floor) and self.range_floor >= 0.0):
            raise FilterInputError(f"range_floor {self.range_floor} is not finite and at least 0")
        return self


def rounds(
    points: Floats,
    known: Surroundings,
    rule: NormalFilter,
    *,
    vertex_iterations: int,
    vertex_update: VertexUpdate = "sun",
    moves: Bools,
    along_normal: Bools | None,
    progress: Progress = ignore_progress,
) -> Iterator[Floats]:
    """The vertices after one round, after two, and so on without end; see `normal_filtering`.

    Args:
        points: (n, 3) of ordinary size, in the order of `known`.
        known: the connectivity.
        rule: the filter of the normals.
        vertex_iterations: steps of the vertices in a round.
        vertex_update: how they are fitted.
        moves: (n,) which vertices move, in that order.
        along_normal: (n,) which move along their normal only; None for none.
        progress: called with the share of a round after each of its passes over the normals.
    """
    around = Around.of(points, known, rule)
    now, table = points, None
    while True:
        table = measure_faces(now, known.faces, table)
        normals = wanted_normals(now, known.faces, table, around, rule, progress)
        now = fit_vertices(
            now,
            known.faces,
            known.corners,
            normals,
            update=vertex_update,
            iterations=vertex_iterations,
            moves=moves,
            along_normal=along_normal,
        )
        yield now


class Around(NamedTuple):
    """Which faces, or vertices, a filter looks at."""

    edge: FaceNeighbourhoods
    patches: FaceNeighbourhoods
    averaged: FaceNeighbourhoods

    @staticmethod
    def of(points: Floats, known: Surroundings, rule: NormalFilter) -> "Around":
        if rule.method == "vertex_normals":
            rings = RINGS_OF_VERTICES[rule.neighborhood]
            near = vertex_neighbourhoods(known.faces, len(points), 1)
            return Around(near, near, near if rings == 1 else vertex_neighbourhoods(known.faces, len(points), rings))
        edge = known.around("edge")
        patches = known.around("vertex") if rule.method in ("averaged", "guided") else edge
        return Around(edge, patches, known.within(rule.neighborhood, points, rule.radius))


def wanted_normals(points: Floats, faces: Ints, table: Floats, around: Around, rule: NormalFilter, progress: Progress) -> Floats:
    """The normals that the faces are to have; those in the table may be written over."""
    if rule.method != "vertex_normals":
        return _filtered(table, around, rule, progress)
    filtered = _filtered(measure_vertices(points, faces, table), around, rule, progress)
    return corner_means(filtered, faces, table[:, NORMAL])


def _filtered(table: Floats, around: Around, rule: NormalFilter, progress: Progress) -> Floats:
    """The normals of the table, filtered; those in the table are written over."""
    distance = mean_centre_distance(table, around.edge)
    normals = np.ascontiguousarray(table[:, NORMAL])
    for iteration in range(rule.normal_iterations):
        if rule.method == "mean":
            normals = mean_normals(normals, table, around.averaged)
        else:
            guide = None
            if rule.method == "averaged":
                guide = mean_normals(normals, table, around.patches)
            elif rule.method == "guided":
                guide = guide_normals(normals, table, around.patches, around.edge)
            normals = weighted_normals(
                normals,
                table,
                around.averaged,
                guide=guide,
                range_kernel=rule.range_kernel,
                range_sigma=rule.range_sigma,
                range_measure=rule.range_measure,
                range_floor=rule.range_floor,
                space_kernel="constant" if rule.method == "unilateral" else rule.space_kernel,
                space_sigma=rule.space_sigma * distance,
                # A normal deviates from itself by 0, which outweighs all others in a kernel such as 1 / x; but a guide is a mean.
                itself=guide is not None,
            )
        progress((iteration + 1) / rule.normal_iterations)
    return normals


def check_choice(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    """Refuse a value that is not allowed."""
    if value not in allowed:
        raise FilterInputError(f"{name} {value!r} is not one of {', '.join(map(repr, allowed))}")


def check_count(name: str, value: int) -> None:
    """Refuse what is not a whole number of at least 0."""
    if value != int(value) or value < 0:
        raise FilterInputError(f"{name} is {value}: it is a whole number of at least 0")
