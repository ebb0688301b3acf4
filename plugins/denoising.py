"""Denoising that keeps edges: filters of face normals, which the vertices follow, and bilateral filters of positions."""

from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Float, Int, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.errors import MeshError
from pymeshfair.filters import denoising
from pymeshfair.filters.choosing import Projection, chosen_projection, compare_smoothers
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.inspection import folded_faces
from pymeshfair.filters.mesh import Floats
from pymeshfair.filters.robust import KernelName
from pymeshfair.filters.topology import BorderPolicy, border_vertices, referenced_vertices

from .moving_vertices import Border, Selected, movable_vertices, vertex_smoother

CHOICE = Enum(
    help="How automatic parameters are chosen. 'held_out': tries about 150 settings on the mesh, or on patches of a large mesh, "
    "and takes one of the settings with the least estimated error. 'fixed': takes all-round values without trials."
)
SPACE_KERNEL = Enum(choices=("auto", *denoising.SPACE_KERNELS), advanced=True)  # `Enum()` would list 'constant' last
ITERATIONS = Int(minimum=0, maximum=10_000, help="The number of steps. More steps smooth more, take longer, and shrink more.")
Auto: TypeAlias = Literal["auto"]


@dataclass(frozen=True, kw_only=True)
class NormalFilterParameters:
    """The parameters of the filter of face normals, see `NormalFilter`; automatic parameters are chosen for the mesh.

    Attributes:
        method: How a neighbouring face is weighted. 'mean': by its area, which rounds edges. 'unilateral': also by the deviation
            of its normal. 'bilateral': also by its distance. 'averaged': the same with the deviation of averaged normals, for
            strong noise; 'guided': with that of the normals of the most even patches, for sharp edges.
        range_kernel: How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2', 'tukey' and 'hampel' reach 0
            and keep edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.
        space_kernel: How weight falls with distance; 'constant': not at all.
        range_measure: How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2; 'angle'
            in radians; 'squared', the square of that length.
        range_sigma: The deviation of normals at which the range kernel falls, in units of range_measure; 0.5 is about 30 degrees,
            41 if squared. Larger smooths more, and across sharper edges.
        range_floor: Smaller deviations are raised to this value; 0.03 keeps 'l1' and 'truncated_l1' from giving nearly all weight
            to normals that agree by chance. Larger smooths more.
        space_sigma: The distance at which the space kernel falls, in mean distances between centres of adjacent triangles. Larger
            smooths larger details.
        neighborhood: The faces to average: across the edges, at the vertices, in two or three rings, or within twice the mean
            distance of centres. The distance is straight ('radius') or along the surface ('geodesic'), which does not jump across
            a thin wall. A larger neighbourhood smooths larger details and is slower.
        normal_iterations: How often the normals are filtered before the vertices follow. More iterations smooth more.
    """

    method: Annotated[Auto | denoising.NormalFilterMethod, Enum()] = "auto"
    range_kernel: Annotated[Auto | KernelName, Enum()] = "auto"
    space_kernel: Annotated[Auto | denoising.SpaceKernel, SPACE_KERNEL] = "auto"
    range_measure: Annotated[Auto | denoising.RangeMeasure, Enum(advanced=True)] = "auto"
    range_sigma: Annotated[float, Float(minimum=0, automatic=0)] = 0.0
    range_floor: Annotated[float, Float(minimum=0, maximum=4, automatic=-1, advanced=True)] = -1.0
    space_sigma: Annotated[float, Float(minimum=0, automatic=0)] = 0.0
    neighborhood: Annotated[Auto | denoising.Neighborhood, Enum()] = "auto"
    normal_iterations: Annotated[int, Int(minimum=1, maximum=10_000, automatic=0)] = 0


#: the parameters of `filter_face_normals`
STEP_ONE = tuple(field.name for field in fields(NormalFilterParameters))
CHOOSING = 0.7  # the share of the progress that a choice takes, if there is one


@vertex_smoother(
    name="Normal Filtering", references=("zheng2011", "zhang2015", "sun2007", "ohtake2001", "belyaev2001", "yadav2021")
)
def apply_coord_normal_filtering(
    layer: Layer,
    *,
    normals: NormalFilterParameters,
    vertex_iterations: Annotated[int, Int(minimum=1, maximum=10_000, automatic=0)] = 0,
    outer_iterations: Annotated[int, Int(minimum=0, maximum=10_000, automatic=-1)] = -1,
    vertex_update: Annotated[Auto | denoising.VertexUpdate, Enum(advanced=True)] = "auto",
    outliers: Annotated[Auto | denoising.Outliers, Enum()] = "auto",
    rounding: Annotated[Auto | denoising.RoundingPolicy, Enum(advanced=True)] = "auto",
    relaxation: Annotated[int, Int(minimum=0, maximum=10_000, automatic=-1)] = -1,
    relaxation_direction: Annotated[Auto | denoising.RelaxationDirection, Enum(advanced=True)] = "auto",
    choice: Annotated[denoising.Chooser, CHOICE] = "held_out",
    compare: Annotated[bool, Bool(label="Compare smoothers", advanced=True)] = False,
    border: Annotated[BorderPolicy, Enum()] = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps edges: filters the face normals robustly, then moves the vertices to fit the filtered normals.

    Without parameters it tries many settings, and takes one of those with the least estimated error; given parameters keep
    their values. If all parameters of the normal filter and the vertex update are given, 'auto' means 'keep' for outliers and
    rounding, and 0 for relaxation. Returns the parameters in use, the kind and level of the noise, whether the choice is sure,
    the trials, the drift (mean displacement in mean edges), and how many faces are folded, before and after.

    Args:
        vertex_iterations: The number of steps of the vertices towards the filtered normals. More steps fit them more closely.
        outer_iterations: The number of rounds of filtering normals and moving vertices; more rounds smooth more. 20 to 30 rounds
            of one normal iteration keep edges better than one round of 20 iterations. 0: normals are not filtered.
        vertex_update: How vertices follow: 'sun' to the mean of their projections onto the planes of their faces, 'ohtake' to the
            mean weighted by area, 'conjugate_gradient' by descent on the sum of squared deviations of normals.
        outliers: Vertices far from the surface, such as stray measurements: 'keep' filters them like the others, 'replace' first
            moves them to predicted places, 'only' moves them alone.
        rounding: Rounded coordinates, all or along one axis, such as depths of a camera: 'keep' filters them like noise, 'undo'
            first moves them to a smoother surface within half a rounding step.
        relaxation: The number of pairs of Taubin steps, 0.5 and -0.53, before the filter. More pairs reduce noise that turns
            faces over, but round the edges, which the filter sharpens again.
        relaxation_direction: The direction of Taubin steps: 'all', or only along the 'normal', so that no vertex slides.
        compare: Also report the prediction errors of Taubin, implicit, bi-Laplacian and spectral smoothing at held-out vertices,
            each with its best amount, if the noise is independent. The filtered mesh is the same. No effect with 'fixed', or if a
            value replaces an 'auto'.
        border: How vertices on open borders move: 'fixed' stay; 'along' move along the normal, in Taubin steps also along
            the surface but no further than others, so that the outline stays; 'free' move like any other vertex.
    """
    set_values = _not_automatic(
        **asdict(normals),
        vertex_iterations=vertex_iterations,
        outer_iterations=outer_iterations,
        vertex_update=vertex_update,
        outliers=outliers,
        rounding=rounding,
        relaxation=relaxation,
        relaxation_direction=relaxation_direction,
    )
    movable = movable_vertices(layer, selected)
    options: dict[str, Any] = {"border": border, "movable": movable}
    denoise = part_of(progress, 0.0, CHOOSING if compare else 1.0)
    choosing = part_of(denoise, 0.0, CHOOSING)
    effective, made = denoising.parameters_for_mesh(layer.vertices, layer.faces, set_values, choice, **options, progress=choosing)
    findings = denoising.findings_of_choice(made)
    filtering = dict(effective)
    steps = {name: filtering.pop(name) for name in denoising.PREPARATION}
    remaining = part_of(denoise, CHOOSING if made else 0.0, 1.0)
    vertices = denoising.denoised(layer.vertices, layer.faces, **steps, filtering=filtering, **options, progress=remaining)
    if made is not None and not set_values and compare:
        smoothers = None  # they are compared only if the noise is independent
        if made.kind == "noisy":
            last: dict[str, Any] = {"setting": made.setting, "movable": movable, "progress": part_of(progress, CHOOSING, 1.0)}
            smoothers = compare_smoothers(layer.vertices, layer.faces, **last)
        findings["smoothers"] = denoising.reported(smoothers, lambda t: {"smoother": t.smoother or "nothing", "amount": t.amount})
    is_open = made is not None and bool(border_vertices(layer.faces, len(vertices)).any())
    notes = denoising.notes_of_choice(made, effective, is_open=is_open)
    before, after = (int(folded_faces(points, layer.faces).sum()) for points in (layer.vertices, vertices))
    changes = {"drift": _mean_displacement(layer, vertices), "folded_before": before, "folded_after": after}
    if after:
        causes = denoising.causes_of_folds(layer.vertices, layer.faces, np.ones(len(vertices), np.bool_))
        notes += denoising.notes_on_folds(before, after, *causes)
    progress(1.0)
    return Edit(vertices=vertices, values={**effective, **findings, **changes}, notes=notes)


@mesh_filter(
    name="Robust Filtering of Face Normals",
    classes=FilterClass.NORMAL,
    requires=MeshElement.FACENUMBER,
    changes=MeshElement.FACENORMAL,
    references=("zheng2011", "zhang2015", "belyaev2001", "yadav2021"),
)
def apply_normal_robust_filtering_per_face(
    layer: Layer,
    *,
    normals: NormalFilterParameters,
    choice: Annotated[denoising.Chooser, CHOICE] = "held_out",
    selected: Annotated[bool, Bool(label="Selected faces only")] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Averages the normals of the faces without rounding edges, and leaves the vertices where they are.

    This is the first half of Normal Filtering, for shading and filters that read face normals. The automatic number of normal
    iterations is the total over all its rounds. Returns the parameters in use, and the noise and trials of a choice.

    Args:
        selected: Only the selected faces get a new normal; the other faces keep their normals, and still count as neighbours.
    """
    if selected and not layer.face_selection.any():
        raise MeshError(f"nothing is selected in {layer.label!r}: select faces, or use selected=False")
    set_values = _not_automatic(**asdict(normals))
    effective, made = set_values, None
    if len(set_values) < len(STEP_ONE):
        choosing = part_of(progress, 0.0, CHOOSING)
        effective, made = denoising.parameters_for_mesh(layer.vertices, layer.faces, set_values, choice, progress=choosing)
    if "normal_iterations" not in set_values:
        effective["normal_iterations"] *= effective["outer_iterations"]  # 0: the choice filters no normals
    effective = {name: effective[name] for name in STEP_ONE}
    filtered = denoising.filter_face_normals(
        layer.vertices, layer.faces, **effective, progress=part_of(progress, CHOOSING if made else 0.0, 1.0)
    )
    if selected:
        filtered = np.where(layer.face_selection[:, None], filtered, layer.face_normals)
    return Edit(face_normals=filtered, values={**effective, **denoising.findings_of_choice(made)})


def _not_automatic(**values: Any) -> dict[str, Any]:
    automatic = {"range_floor": -1.0, "outer_iterations": -1, "relaxation": -1}
    return {name: value for name, value in values.items() if value not in (automatic.get(name, 0), "auto")}


def _mean_displacement(layer: Layer, vertices: Floats) -> float:
    used = referenced_vertices(layer.faces, len(vertices))
    if not used.any() or layer.mean_edge == 0.0:
        return 0.0
    # Divide by the edge first, so that squares neither overflow nor vanish.
    return float(np.linalg.norm((vertices - layer.vertices)[used] / layer.mean_edge, axis=1).mean())


@dataclass(frozen=True, kw_only=True)
class Kernels:
    """The common parameters of bilateral filters: kernels and scales.

    Attributes:
        range_kernel: How weight falls with the difference in height of a neighbour. 'huber' and 'l1' keep features less, 'l2' not
            at all; the others keep them.
        space_kernel: How weight falls with distance. 'gaussian' is the papers' kernel, 'l2' weights all neighbours equally, 'l1'
            favours the nearest.
        range_sigma: Differences in height below this value count as noise, above it as features. A larger value removes stronger
            noise, and flattens larger features. 'auto' estimates the value from the mesh.
    """

    range_kernel: Annotated[KernelName, Enum()] = "gaussian"
    space_kernel: Annotated[KernelName, Enum()] = "gaussian"
    range_sigma: Annotated[float, Percentage(automatic=0, default="auto")]
    space_sigma: Annotated[float, Percentage(automatic=0, default="auto")]

    def arguments(self) -> dict[str, Any]:
        """The arguments of a bilateral filter; a scale of None is estimated."""
        return {**asdict(self), "range_sigma": self.range_sigma or None, "space_sigma": self.space_sigma or None}


@vertex_smoother(name="Bilateral Denoising along Normals (Fleishman)", references=("fleishman2003",))
def apply_coord_bilateral_fleishman(
    layer: Layer,
    *,
    kernels: Kernels,
    iterations: Annotated[int, ITERATIONS] = 2,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps features: every vertex moves along its normal to the mean height of neighbours at similar heights.

    Fast, and enough for light noise; triangles keep their shape. The surface shrinks a little with each iteration.

    Args:
        space_sigma: Neighbours count up to 1.4 times this distance. Larger is smoother and slower. 'auto': 1.4 mean edges.
    """
    options: dict[str, Any] = {**kernels.arguments(), "iterations": iterations, "border": border}
    options |= {"movable": movable_vertices(layer, selected), "progress": progress}
    return Edit(vertices=denoising.bilateral_fleishman(layer.vertices, layer.faces, **options))


@vertex_smoother(name="Bilateral Denoising by Triangle Predictors (Jones)", references=("jones2003",))
def apply_coord_bilateral_jones(
    layer: Layer,
    *,
    kernels: Kernels,
    border: Annotated[denoising.JonesBorder, Enum()] = "free",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps features in one step: every vertex moves to the mean of its projections onto triangle planes.

    A triangle counts more if it and its plane are near the vertex. Triangles are found by distance, so that non-manifold meshes
    and loose triangles are filtered too; curved surfaces shrink less than with the filter along normals.

    Args:
        space_sigma: Triangles count up to 1.4 times this distance. Larger is smoother and slower. 'auto': 2 mean edges.
        border: How vertices on open borders move: 'fixed' stay; 'free' move like any other vertex.
    """
    options: dict[str, Any] = {**kernels.arguments(), "border": border, "progress": progress}
    movable = movable_vertices(layer, selected)
    return Edit(vertices=denoising.bilateral_jones(layer.vertices, layer.faces, **options, movable=movable))


@vertex_smoother(
    name="Bilateral Projection of Points",
    classes=FilterClass.SMOOTHING | FilterClass.POINT_SET,
    requires=MeshElement.NONE,
    references=("fleishman2003", "cazals2005"),
)
def apply_coord_bilateral_projection_of_points(
    layer: Layer,
    *,
    neighbors: Annotated[int, Int(label="Neighbours", minimum=3)] = 18,
    kernels: Kernels,
    iterations: Annotated[int, Int(minimum=0, maximum=10_000, automatic=-1)] = 2,
    degree: Annotated[int, Int(minimum=1, maximum=2)] = 1,
    use_normals: Annotated[bool, Bool(label="Use the points' normals")] = False,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise from a point cloud: every point moves along its normal to a height fitted to neighbours at similar heights.

    Triangles are ignored. The normals do not change: compute them again afterwards. With automatic iterations a cloud
    without noise stays as it is, and the choice and the trials are returned; errors are in median distances of near points.

    Args:
        neighbors: The number of nearest points that count. More points smooth more, take longer, and round off edges.
        space_sigma: The distance at which the weight of neighbours falls. Larger makes distant neighbours count more. 'auto'
            takes it from the mean distance of the farthest neighbour.
        iterations: The number of steps. More steps smooth more, take longer, and shrink more. 'auto' chooses the iterations,
            neighbours, degree and, if automatic, range sigma together, for a small prediction error at held-out points.
        degree: 1 moves points to the mean height of their neighbours, 2 onto the quadric that fits these heights best. With
            quadrics curved surfaces shrink less, but quadrics need 40 or more neighbours.
        use_normals: Move along the given normals of the points. Otherwise each iteration estimates the normals again.
    """
    normals = layer.vertex_normals if use_normals else None
    if normals is not None and not normals.any():
        raise MeshError(f"the points of {layer.label!r} have no normals: compute them first, or use use_normals=False")
    options: dict[str, Any] = {**kernels.arguments(), "normals": normals, "movable": movable_vertices(layer, selected)}
    values: dict[str, Any] = {}
    if iterations < 0:
        choice = chosen_projection(layer.vertices, **options, progress=part_of(progress, 0.0, 0.8))
        chosen = Projection() if choice is None else choice.chosen.label
        values = {"chosen": chosen._asdict(), "tried": denoising.reported(choice, Projection._asdict)}
        if chosen.iterations == 0:
            progress(1.0)
            return Edit(vertices=layer.vertices, values=values, notes=(denoising.NOTHING_TO_REMOVE,))
        neighbors, options["range_sigma"], iterations, degree = chosen
        progress = part_of(progress, 0.8, 1.0)
    options |= {"neighbors": neighbors, "iterations": iterations, "degree": degree}
    return Edit(vertices=denoising.bilateral_projection(layer.vertices, **options, progress=progress), values=values)
