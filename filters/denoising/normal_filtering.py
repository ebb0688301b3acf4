"""Denoising in two steps: the face normals are filtered, then the vertices are fitted to them."""

import math
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..geometry import NORMAL, measure_faces
from ..mesh import Bools, Floats, Ints, check_mesh, check_movable, enter, leave, ordered_frame
from ..robust import KernelName
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices
from .face_neighbourhoods import NEIGHBORHOODS, FaceNeighbourhoods, Neighborhood, mean_centre_distance
from .guided import guide_normals
from .normal_filters import RANGE_MEASURES, SPACE_KERNELS, RangeMeasure, SpaceKernel, mean_normals, weighted_normals
from .surroundings import Surroundings
from .vertex_normals import RINGS_OF_VERTICES, corner_means, measure_vertices, vertex_neighbourhoods
from .vertex_update import VERTEX_UPDATES, VertexUpdate, fit_vertices

#: "mean": weights are areas alone [belyaev2001]. "unilateral": areas and a kernel of the deviation of normals [yadav2021].
#: "bilateral": and a kernel of the distance [zheng2011]. "averaged": bilateral, the deviation measured on normals averaged over
#: the faces at the vertices of a face. "guided": bilateral, the deviation measured on guide normals [zhang2015].
#: "vertex_normals": bilateral, on the normals of vertices; a face gets the mean of its corners'. It is there to compare with.
NormalFilterMethod: TypeAlias = Literal["mean", "unilateral", "bilateral", "averaged", "guided", "vertex_normals"]
NORMAL_FILTER_METHODS: tuple[NormalFilterMethod, ...] = get_args(NormalFilterMethod)


def normal_filtering(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    method: NormalFilterMethod = "bilateral",
    range_kernel: KernelName = "gaussian",
    space_kernel: SpaceKernel = "gaussian",
    range_measure: RangeMeasure = "euclidean",
    range_sigma: float = 0.35,
    range_floor: float = 0.0,
    space_sigma: float = 1.0,
    neighborhood: Neighborhood = "vertex",
    radius: float = 2.0,
    normal_iterations: int = 20,
    vertex_iterations: int = 10,
    outer_iterations: int = 1,
    vertex_update: VertexUpdate = "sun",
    border: BorderPolicy = "along",
    movable: ArrayLike | None = None,
    surroundings: Surroundings | None = None,
    progress: Progress = ignore_progress,
) -> Floats:
    """Filter the face normals, fit the vertices to them, and again, `outer_iterations` times.

    Each filter pass takes n_i to normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j) over the faces j around face i, of area A and
    centre c; see `weighted_normals`. Areas, centres and normals are measured anew at the start of every outer iteration. The
    defaults are those of [zheng2011] in their authors' code: once 20 passes, then 10 steps. Many outer iterations of one pass
    each keep features better, since every pass sees normals that a surface has.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        method: how weights come about; see `NormalFilterMethod`.
        range_kernel: g; not used by "mean". Kernels that reach 0 ("truncated_l1", "truncated_l2", "tukey") keep edges; "huber",
            "lorentzian" and "gaussian" suit smooth shapes.
        space_kernel: f; used by "bilateral", "averaged" and "guided".
        range_measure: how the deviation x of two normals is measured.
        range_sigma: the scale of g, in the unit of the measure. Larger smooths more and across sharper features. For "gaussian"
            the standard deviation.
        range_floor: smaller deviations count as this one, in the unit of the measure. Above 0 it keeps "l1" and "truncated_l1",
            whose weight is 1 / x, from letting two faces that happen to agree hold each other; 0.03 does them good.
        space_sigma: the scale of f, in mean distances of the centres of faces that share an edge, of the mesh as it is by then.
            Larger smooths larger details, as far as the neighbourhood reaches. For "gaussian" the standard deviation.
        neighborhood: which faces are averaged over; see `Neighborhood`. Larger smooths larger details, and costs in proportion.
            With "vertex_normals" rings of vertices: one for "edge" and "vertex", two, or three; distances are then in mean edges.
        radius: for the neighbourhoods "radius" and "geodesic", in mean distances of the centres of the input.
        normal_iterations: filter passes an outer iteration. More smooth more.
        vertex_iterations: steps of the vertices an outer iteration. More fit more closely, and follow errors of the normals more.
        outer_iterations: how often the two are repeated.
        vertex_update: how vertices are fitted; see `VertexUpdate`.
        border: "fixed": border vertices stay. "along": they move along the mean normal of their faces alone, so that the outline
            stays seen from above. "free": they move like any other.
        movable: (n,) bool, which vertices may move, None for all. The others stay where they are and are seen by those that do.
        surroundings: ``Surroundings.of(faces, n)``, to save finding them again where the same faces are filtered more than once.
        progress: called after every pass and every fit; may raise to stop.

    Returns:
        (n, 3) float64. Vertices that do not move keep every bit: those that no face uses, that are not `movable`, or on a fixed
        border. Deterministic, for any number of threads.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
    """
    points, triangles = check_mesh(vertices, faces)
    for name, value in (("vertex_iterations", vertex_iterations), ("outer_iterations", outer_iterations)):
        _check_count(name, value)
    _check_choice("vertex_update", vertex_update, VERTEX_UPDATES)
    _check_choice("border", border, BORDER_POLICIES)
    rule = NormalFilter(
        method,
        range_kernel,
        space_kernel,
        range_measure,
        range_sigma,
        range_floor,
        space_sigma,
        neighborhood,
        radius,
        normal_iterations,
    ).checked()
    known = Surroundings.of(triangles, len(points)) if surroundings is None else surroundings
    used = known.restored(np.diff(known.corners.offsets) > 0)
    moves = used if movable is None else used & check_movable(movable, len(points))
    on_border = np.zeros(len(points), dtype=np.bool_) if border == "free" else border_vertices(triangles, len(points))
    if border == "fixed":
        moves = moves & ~on_border
    frame = ordered_frame(_without_strays(points, used), None)
    start = enter(points, frame)
    now = known.ordered(start)
    rounds = outer_iterations if moves.any() else 0
    around = _Around.of(now, known, rule)
    moves, along_normal = known.ordered(moves), known.ordered(on_border) if border == "along" else None
    table = None
    for outer in range(rounds):

        def partial(share: float, done: int = outer) -> None:
            progress((done + 0.9 * share) / outer_iterations)

        table = measure_faces(now, known.faces, table)
        now = fit_vertices(
            now,
            known.faces,
            known.corners,
            _wanted(now, known.faces, table, around, rule, partial),
            update=vertex_update,
            iterations=vertex_iterations,
            moves=moves,
            along_normal=along_normal,
        )
        progress((outer + 1) / outer_iterations)
    return leave(points, start, known.restored(now), frame)


def filter_face_normals(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    method: NormalFilterMethod = "bilateral",
    range_kernel: KernelName = "gaussian",
    space_kernel: SpaceKernel = "gaussian",
    range_measure: RangeMeasure = "euclidean",
    range_sigma: float = 0.35,
    range_floor: float = 0.0,
    space_sigma: float = 1.0,
    neighborhood: Neighborhood = "vertex",
    radius: float = 2.0,
    normal_iterations: int = 20,
    progress: Progress = ignore_progress,
) -> Floats:
    """(m, 3) the filtered unit normals of the faces, the vertices left alone; arguments and errors as `normal_filtering`.

    A face without area, whose own normal is 0, gets the normal of its surroundings.
    """
    points, triangles = check_mesh(vertices, faces)
    rule = NormalFilter(
        method,
        range_kernel,
        space_kernel,
        range_measure,
        range_sigma,
        range_floor,
        space_sigma,
        neighborhood,
        radius,
        normal_iterations,
    ).checked()
    known = Surroundings.of(triangles, len(points))
    start = known.ordered(_framed(points, known))
    return _wanted(start, known.faces, measure_faces(start, known.faces), _Around.of(start, known, rule), rule, progress)


def folded_faces(vertices: ArrayLike, faces: ArrayLike) -> int:
    """How many faces look away from the mean normal of the faces at their vertices, weighted by area."""
    points, triangles = check_mesh(vertices, faces)
    known = Surroundings.of(triangles, len(points))
    table = measure_faces(known.ordered(_framed(points, known)), known.faces)
    normals = np.ascontiguousarray(table[:, NORMAL])
    means = mean_normals(normals, table, known.around("vertex"))
    return int((np.einsum("ij,ij->i", normals, means) < 0.0).sum())


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
        _check_choice("method", self.method, NORMAL_FILTER_METHODS)
        _check_choice("range_kernel", self.range_kernel, SPACE_KERNELS[1:])
        _check_choice("space_kernel", self.space_kernel, SPACE_KERNELS)
        _check_choice("range_measure", self.range_measure, RANGE_MEASURES)
        _check_choice("neighborhood", self.neighborhood, NEIGHBORHOODS)
        _check_count("normal_iterations", self.normal_iterations)
        for name in ("range_sigma", "space_sigma", "radius"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise FilterInputError(f"{name} {value} is not finite and above 0")
        if self.method == "vertex_normals":
            _check_choice("neighborhood of the method 'vertex_normals'", self.neighborhood, tuple(RINGS_OF_VERTICES))
        if not (math.isfinite(self.range_floor) and self.range_floor >= 0.0):
            raise FilterInputError(f"range_floor {self.range_floor} is not finite and at least 0")
        return self


class _Around(NamedTuple):
    """Which faces, or vertices, a filter looks at."""

    edge: FaceNeighbourhoods
    patches: FaceNeighbourhoods
    averaged: FaceNeighbourhoods

    @staticmethod
    def of(points: Floats, known: Surroundings, rule: NormalFilter) -> "_Around":
        if rule.method == "vertex_normals":
            rings = RINGS_OF_VERTICES[rule.neighborhood]
            near = vertex_neighbourhoods(known.faces, len(points), 1)
            return _Around(near, near, near if rings == 1 else vertex_neighbourhoods(known.faces, len(points), rings))
        edge = known.around("edge")
        patches = known.around("vertex") if rule.method in ("averaged", "guided") else edge
        return _Around(edge, patches, known.within(rule.neighborhood, points, rule.radius))


def _wanted(points: Floats, faces: Ints, table: Floats, around: _Around, rule: NormalFilter, progress: Progress) -> Floats:
    """The normals that the faces are to have; those in the table may be written over."""
    if rule.method != "vertex_normals":
        return _filtered(table, around, rule, progress)
    filtered = _filtered(measure_vertices(points, faces, table), around, rule, progress)
    return corner_means(filtered, faces, table[:, NORMAL])


def _filtered(table: Floats, around: _Around, rule: NormalFilter, progress: Progress) -> Floats:
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


def _framed(points: Floats, known: Surroundings) -> Floats:
    """The points, in coordinates of ordinary size."""
    return enter(points, ordered_frame(_without_strays(points, known.restored(np.diff(known.corners.offsets) > 0)), None))


def _without_strays(points: Floats, used: Bools) -> Floats:
    """The points that a face uses, or all if none does, so that the others do not decide on the frame."""
    return points if used.all() or not used.any() else points[used]


def _check_choice(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise FilterInputError(f"{name} {value!r} is not one of {', '.join(map(repr, allowed))}")


def _check_count(name: str, value: int) -> None:
    if value != int(value) or value < 0:
        raise FilterInputError(f"{name} is {value}: it is a whole number of at least 0")
