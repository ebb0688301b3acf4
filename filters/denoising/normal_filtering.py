"""Denoising in two steps: the face normals are filtered, then the vertices are fitted to them."""

import numpy as np
from numpy.typing import ArrayLike

from ..execution import Progress, ignore_progress
from ..geometry import NORMAL, measure_faces
from ..mesh import Bools, Floats, check_mesh, check_movable, enter, leave, ordered_frame
from ..robust import KernelName
from ..topology import BORDER_POLICIES, BorderPolicy, border_vertices
from .face_neighbourhoods import Neighborhood
from .normal_filters import RangeMeasure, SpaceKernel, mean_normals
from .rounds import Around, NormalFilter, NormalFilterMethod, check_choice, check_count, rounds, wanted_normals
from .surroundings import Surroundings
from .vertex_update import VERTEX_UPDATES, VertexUpdate


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
        check_count(name, value)
    check_choice("vertex_update", vertex_update, VERTEX_UPDATES)
    check_choice("border", border, BORDER_POLICIES)
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
    finished = 0
    passes = rounds(
        now,
        known,
        rule,
        vertex_iterations=vertex_iterations,
        vertex_update=vertex_update,
        moves=known.ordered(moves),
        along_normal=known.ordered(on_border) if border == "along" else None,
        progress=lambda share: progress((finished + 0.9 * share) / outer_iterations),
    )
    while finished < outer_iterations and moves.any():
        now = next(passes)
        finished += 1
        progress(finished / outer_iterations)
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
    return wanted_normals(start, known.faces, measure_faces(start, known.faces), Around.of(start, known, rule), rule, progress)


def folded_faces(vertices: ArrayLike, faces: ArrayLike) -> int:
    """How many faces look away from the mean normal of the faces at their vertices, weighted by area."""
    points, triangles = check_mesh(vertices, faces)
    known = Surroundings.of(triangles, len(points))
    table = measure_faces(known.ordered(_framed(points, known)), known.faces)
    normals = np.ascontiguousarray(table[:, NORMAL])
    means = mean_normals(normals, table, known.around("vertex"))
    return int((np.einsum("ij,ij->i", normals, means) < 0.0).sum())


def _framed(points: Floats, known: Surroundings) -> Floats:
    """The points, in coordinates of ordinary size."""
    return enter(points, ordered_frame(_without_strays(points, known.restored(np.diff(known.corners.offsets) > 0)), None))


def _without_strays(points: Floats, used: Bools) -> Floats:
    """The points that a face uses, or all if none does, so that the others do not decide on the frame."""
    return points if used.all() or not used.any() else points[used]
