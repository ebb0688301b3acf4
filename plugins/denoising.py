"""Denoising that keeps edges: in two steps, by face normals that vertices follow, and by bilateral filters of positions."""

import inspect
from collections.abc import Set as AbstractSet
from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Float, Int, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.errors import MeshError
from pymeshfair.filters import denoising
from pymeshfair.filters.choosing import Projection, chosen_projection, compare_smoothers
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.inspection import folded_faces, triangle_shapes
from pymeshfair.filters.mesh import Bools, Floats
from pymeshfair.filters.robust import KernelName
from pymeshfair.filters.topology import BorderPolicy, border_vertices, referenced_vertices

from .moving_vertices import NOTHING_TO_REMOVE, Border, Selected, movable_vertices, reported, vertex_smoother

#: the ways to choose parameters without a value
Chooser: TypeAlias = Literal["held_out", "fixed"]
CHOICE = Enum(
    help="How what is not given is found. 'held_out': some 140 settings are tried on the mesh, or on patches of a large one, and "
    "one of those is taken that best predict vertices which they have not seen. 'fixed': all-round values, at once."
)
SPACE_KERNEL = Enum(choices=("auto", *denoising.SPACE_KERNELS), advanced=True)  # 'constant' comes first
ITERATIONS = Int(minimum=0, maximum=10_000, help="How many steps are taken. More are smoother, slower, and shrink more.")
Auto: TypeAlias = Literal["auto"]


@dataclass(frozen=True, kw_only=True)
class NormalFilterParameters:
    """How face normals are filtered; see `NormalFilter`. What is automatic is chosen for the mesh.

    Attributes:
        method: What weighs a neighbouring face, besides its area. 'mean': nothing, which rounds edges. 'unilateral': how far its
            normal deviates. 'bilateral': and how far away it is. 'averaged': bilateral on normals averaged before, for strong
            noise. 'guided': on the normals of the most even patches, for sharp edges. 'vertex_normals': on those of vertices.
        range_kernel: How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2' and 'tukey' reach 0 and keep
            edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.
        space_kernel: How weight falls with distance; 'constant' does not.
        range_measure: How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2; 'angle'
            in radians; 'squared', the square of that length.
        range_sigma: The deviation of normals at which the range kernel falls, in the unit of the range measure; 0.5 is about 30
            degrees. Larger smooths more, and across sharper edges.
        range_floor: Smaller deviations count as this one; 0.03 keeps 'l1' and 'truncated_l1' from locking normals that happen to
            agree. Larger smooths more.
        space_sigma: The distance at which the space kernel falls, in mean distances of neighbouring triangles' centres. Larger
            smooths larger details.
        neighborhood: Which faces are averaged over: those across the edges, those at the vertices, those in two or three rings,
            or those within a radius of twice the mean distance of centres, straight ('radius') or along the surface ('geodesic'),
            which does not jump across a thin wall. Larger smooths larger details and is slower.
        normal_iterations: How often the normals are filtered before the vertices follow. More smooth more.
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


#: the parameters of `filter_face_normals`; the others are those of the vertices
STEP_ONE = tuple(field.name for field in fields(NormalFilterParameters))
CHOOSING = 0.7  # the share of the time that a choice takes, if there is one
#: the parameters of normal filtering that are chosen for a mesh
CHOSEN = frozenset(field.name for field in fields(denoising.AutomaticParameters))
BEFORE = ("outliers", "rounding", "relaxation", "relaxation_direction")  # of what comes before both steps, see `denoised`
#: triangles below this of `triangle_shapes` are slivers, as 1:10; more than this share of them is worth a word
SLIVER, MANY_SLIVERS = 0.2, 0.05
#: the defaults of `normal_filtering`, where neither the caller nor the mesh decides
_STEPS = inspect.signature(denoising.normal_filtering).parameters
DEFAULTS: dict[str, Any] = {
    **{field.name: field.default for field in fields(denoising.NormalFilter) if field.name in STEP_ONE},
    **{name: _STEPS[name].default for name in ("vertex_iterations", "outer_iterations", "vertex_update")},
    **dict(zip(BEFORE, ("keep", "keep", 0, "all"), strict=True)),
}


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
    choice: Annotated[Chooser, CHOICE] = "held_out",
    compare: Annotated[bool, Bool(label="Compare smoothers", advanced=True)] = False,
    border: Annotated[BorderPolicy, Enum()] = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps edges: filters the normals of the faces robustly, then moves the vertices so that the faces follow.

    Without any parameter many settings are tried, and the one is taken that best predicts vertices which it has not seen; what is
    given, all of them have. Returns the parameters that were used, what was found and tried, the mean displacement in mean edges
    as drift, and how many faces look away from those around them, before and after.

    Args:
        vertex_iterations: How many steps the vertices take towards faces with the filtered normals. More follow more closely.
        outer_iterations: How often both are repeated, the normals measured anew; more are smoother. 20 to 30 times one normal
            iteration keep edges better than once 20. 0: outliers and relaxation alone.
        vertex_update: How vertices follow: 'sun' by the mean of the projections onto their faces' planes, 'ohtake' by their mean
            weighted by area, 'conjugate_gradient' by descent on the sum of squared deviations.
        outliers: Vertices that stand out, as those of stray measurements: 'keep' filters them like the others, 'replace' puts
            them first where the others expect them, 'only' moves nothing but them. 'auto' keeps them where all else is given.
        rounding: Coordinates that were rounded, all or along one axis, as depths of a camera: 'keep' filters the steps like any
            noise, 'undo' puts the vertices first on a smoother surface within half a step. 'auto' keeps where all else is given.
        relaxation: How many pairs of Taubin's steps come before, of 0.5 and -0.53. More calm noise that turns faces over, and
            round edges, which the filter sharpens again. 'auto' takes 0 where all else is given.
        relaxation_direction: Where these steps go: 'all' directions, or along the 'normal' alone, so that no vertex slides.
        compare: Say, too, how well low-pass filters predict the same vertices, each with the amount that suits the mesh best:
            Taubin's, implicit, bi-Laplacian and spectral smoothing. The result is the same. Only where all is automatic.
        border: What the vertices of open borders do: 'fixed' stay; 'along' move along the normal alone, so that the outline
            stays; 'free' move like any other vertex.
    """
    set_values = _given(
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
    notes: tuple[str, ...] = ()
    if set_values or choice == "fixed":
        choosing = part_of(progress, 0.0, CHOOSING)
        effective, findings = _completed(layer, set_values, choice, choosing, border=border, movable=movable)
        how: dict[str, Any] = {name: effective[name] for name in BEFORE}
        how["filtering"] = {name: value for name, value in effective.items() if name not in BEFORE}
        rest = part_of(progress, CHOOSING if findings else 0.0, 1.0)
        vertices = denoising.denoised(layer.vertices, layer.faces, **how, border=border, movable=movable, progress=rest)
    else:
        how = {"border": border, "movable": movable, "progress": part_of(progress, 0.0, CHOOSING if compare else 1.0)}
        vertices, made = denoising.denoise_automatically(layer.vertices, layer.faces, **how)
        effective, findings = _parameters(made.setting), _findings(made)
        if compare:
            findings["smoothers"] = _comparison(layer, made, movable, part_of(progress, CHOOSING, 1.0))
        if made.kind == "clean":
            notes = (NOTHING_TO_REMOVE,)
        elif made.kind == "correlated" and made.setting.rounding == "keep" and border_vertices(layer.faces, len(vertices)).any():
            notes = (
                "neighbours share the noise, and the filter is chosen by the faces inside: at the border, as at silhouettes, "
                "faces may end farther from the truth than they were",
            )
    before, after = (int(folded_faces(points, layer.faces).sum()) for points in (layer.vertices, vertices))
    told = {"drift": _mean_displacement(layer, vertices), "folded_before": before, "folded_after": after}
    return Edit(vertices=vertices, values={**effective, **findings, **told}, notes=(*notes, *_warnings(layer, before, after)))


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
    choice: Annotated[Chooser, CHOICE] = "held_out",
    selected: Annotated[bool, Bool(label="Selected faces only")] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Averages the normals of the faces without rounding edges, and leaves the vertices where they are.

    It is the first half of Normal Filtering, for shading and for filters that read face normals; automatic normal iterations are
    as many as Normal Filtering takes in all. Returns the parameters that were used.

    Args:
        selected: Only the selected faces get a new normal; the others are seen by their neighbours but keep theirs.
    """
    if selected and not layer.face_selection.any():
        raise MeshError(f"nothing is selected in {layer.label!r}: select faces, or use selected=False")
    set_values = _given(**asdict(normals))
    effective, findings = _completed(layer, set_values, choice, part_of(progress, 0.0, CHOOSING), of=frozenset(STEP_ONE))
    if "normal_iterations" not in set_values:
        effective["normal_iterations"] *= effective["outer_iterations"]
    effective = {name: effective[name] for name in STEP_ONE}
    filtered = denoising.filter_face_normals(
        layer.vertices, layer.faces, **effective, progress=part_of(progress, CHOOSING if findings else 0.0, 1.0)
    )
    if selected:
        filtered = np.where(layer.face_selection[:, None], filtered, layer.face_normals)
    return Edit(face_normals=filtered, values={**effective, **findings})


def _given(**values: Any) -> dict[str, Any]:
    """The parameters that are not automatic."""
    automatic = {"range_floor": -1.0, "outer_iterations": -1, "relaxation": -1}
    return {name: value for name, value in values.items() if value not in (automatic.get(name, 0), "auto")}


def _completed(
    layer: Layer, set_values: dict[str, Any], choice: Chooser, progress: Progress, *, of: AbstractSet[str] = CHOSEN, **how: Any
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The given parameters and those that are chosen for the mesh where none is given, to go with them; and what that rests on.

    The mesh is only looked at if the choice has a say in one of those that the filter is made `of`; `how` goes to
    `automatic_choice`.
    """
    if CHOSEN & of <= set_values.keys():
        return {**DEFAULTS, **set_values}, {}
    if choice == "fixed":
        return {**DEFAULTS, **asdict(denoising.FIXED), **set_values}, {}
    # Passes are no part of what is tried: twenty of them would cost twenty times as much. Rounding is undone or not, in all.
    no_part = ("normal_iterations", "rounding")
    tried = denoising.REPERTOIRE.narrowed(**{name: value for name, value in set_values.items() if name not in no_part})
    made = denoising.automatic_choice(layer.vertices, layer.faces, repertoire=tried, progress=progress, **how)
    chosen = _parameters(made.setting)
    if made.setting.parameters is None:
        # A mesh that asks for no normal filtering: what is given is then completed as the authors of the filter would.
        del chosen["outer_iterations"]
    return {**DEFAULTS, **chosen, **set_values}, _findings(made)


def _parameters(setting: denoising.Setting) -> dict[str, Any]:
    """The setting as parameters of the filter."""
    filtering = {"outer_iterations": 0} if setting.parameters is None else asdict(setting.parameters)
    before = {name: getattr(setting, name) for name in BEFORE}
    return {**DEFAULTS, **filtering, **before}


def _findings(made: denoising.AutomaticChoice) -> dict[str, Any]:
    """The kind of mesh and noise that was found, and the numbers behind it."""
    findings: dict[str, Any] = {"shape": made.kind, "noise": made.noise.deviation, "sure": made.sure}
    return findings if made.evidence is None else {**findings, "tried": reported(made.evidence, asdict)}


def _comparison(layer: Layer, made: denoising.AutomaticChoice, movable: Bools | None, progress: Progress) -> list[dict[str, Any]]:
    """The families of smoothers by their error at held-out vertices; none of a clean mesh, or where neighbours share noise."""
    how: dict[str, Any] = {"setting": made.setting, "movable": movable, "progress": progress}
    comparison = compare_smoothers(layer.vertices, layer.faces, **how) if made.kind == "noisy" else None
    if comparison is None:
        return []
    rows = reported(comparison, lambda way: {"smoother": way.smoother or "nothing", "amount": way.amount})
    return [{**row, "chosen": trial == comparison.chosen} for row, trial in zip(rows, comparison.trials, strict=True)]


def _warnings(layer: Layer, before: int, after: int) -> tuple[str, ...]:
    """In words, where faces are folded over still, and slivers are why."""
    slivers = float(np.mean(triangle_shapes(layer.vertices, layer.faces) < SLIVER)) if after else 0.0
    if slivers <= MANY_SLIVERS:
        return ()
    why = f"{slivers:.0%} of the triangles are slivers, which noise folds over"
    return (f"{after} faces are folded over, {before} were before; {why}: remesh it first, or use Taubin Fairing",)


def _mean_displacement(layer: Layer, vertices: Floats) -> float:
    """The mean distance of the vertices that a face uses from where they were, in mean edges."""
    used = referenced_vertices(layer.faces, len(vertices))
    if not used.any() or layer.mean_edge == 0.0:
        return 0.0
    # In edges first, so that squares neither overflow nor vanish.
    moved = (vertices - layer.vertices)[used] / layer.mean_edge
    return float(np.linalg.norm(moved, axis=1).mean())


# ----------------------------------------------------------------------------------------------------------- of positions


@dataclass(frozen=True, kw_only=True)
class Kernels:
    """Kernels and scales: the parameters that bilateral filters share.

    Attributes:
        range_kernel: How a neighbour counts that disagrees: features stay but with 'huber' and 'l1', which respect them less, and
            'l2', which does not.
        space_kernel: How neighbours count by their distance, up to 1.4 times the space sigma. 'gaussian' is the paper's, 'l2'
            counts all alike, 'l1' favours the nearest.
        range_sigma: Differences in height below it are taken for noise, larger ones for features. Larger removes stronger noise,
            and flattens larger features. 'auto' estimates it from the mesh.
    """

    range_kernel: Annotated[KernelName, Enum()] = "gaussian"
    space_kernel: Annotated[KernelName, Enum()] = "gaussian"
    range_sigma: Annotated[float, Percentage(automatic=0, default="auto")]
    space_sigma: Annotated[float, Percentage(automatic=0, default="auto")]

    def arguments(self) -> dict[str, Any]:
        """The arguments of a bilateral filter; a scale of 0 is estimated."""
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
    """Removes noise and keeps features: every vertex moves along its normal to the mean height of neighbours that roughly agree.

    Fast, and enough for light noise; triangles keep their shape. The surface shrinks a little with each iteration.

    Args:
        space_sigma: How far away neighbours count. Larger averages over more, is smoother and slower. 'auto': 1.4 mean edges.
    """
    how: dict[str, Any] = {**kernels.arguments(), "iterations": iterations, "border": border}
    how |= {"movable": movable_vertices(layer, selected), "progress": progress}
    return Edit(vertices=denoising.bilateral_fleishman(layer.vertices, layer.faces, **how))


@vertex_smoother(name="Bilateral Denoising by Triangle Predictors (Jones)", references=("jones2003",))
def apply_coord_bilateral_jones(
    layer: Layer,
    *,
    kernels: Kernels,
    border: Annotated[denoising.JonesBorder, Enum()] = "free",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps features in one step: every vertex goes to the mean of its projections to the planes of triangles.

    Near triangles that roughly agree count most. Triangles are found by place, so that non-manifold meshes and loose triangles
    are filtered too; curved surfaces shrink less than along normals.

    Args:
        space_sigma: How far away triangles count. Larger averages over more, is smoother and slower. 'auto': 2 mean edges.
        border: What the vertices of open borders do: 'fixed' stay; 'free' move like any other vertex.
    """
    how: dict[str, Any] = {**kernels.arguments(), "border": border, "progress": progress}
    movable = movable_vertices(layer, selected)
    return Edit(vertices=denoising.bilateral_jones(layer.vertices, layer.faces, **how, movable=movable))


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
    """Removes noise from a point cloud: every point moves along its normal to where neighbours that roughly agree expect it.

    Triangles play no part. The normals themselves are not changed: compute them anew afterwards. With automatic iterations it
    returns what was chosen and what was tried, with errors in spacings; a cloud without noise stays as it is.

    Args:
        neighbors: How many nearest points count. More are smoother, slower, and round off edges.
        space_sigma: How neighbours count by their distance. Larger weighs distant ones more like near ones. 'auto' takes it from
            the mean distance of the farthest neighbour.
        iterations: How many steps are taken. More are smoother, slower, and shrink more. 'auto' takes the iterations, neighbours,
            degree and, if that is automatic, range sigma that best predict points which the filter has not seen.
        degree: 1 moves points to the mean height of their neighbours, 2 onto the quadric that fits these heights best. Quadrics
            follow curved surfaces, which then shrink less, but need 40 neighbours and more.
        use_normals: Move along the normals that the points have. Otherwise they are estimated anew in each iteration.
    """
    how: dict[str, Any] = {"normals": layer.vertex_normals if use_normals else None, **kernels.arguments()}
    how["movable"] = movable_vertices(layer, selected)
    values: dict[str, Any] = {}
    if iterations < 0:
        choice = chosen_projection(layer.vertices, **how, progress=part_of(progress, 0.0, 0.8))
        chosen = Projection() if choice is None else choice.chosen.label
        values = {"chosen": chosen._asdict(), "tried": reported(choice, Projection._asdict)}
        if chosen.iterations == 0:
            progress(1.0)
            return Edit(vertices=layer.vertices, values=values, notes=(NOTHING_TO_REMOVE,))
        neighbors, how["range_sigma"], iterations, degree = chosen
        progress = part_of(progress, 0.8, 1.0)
    how |= {"neighbors": neighbors, "iterations": iterations, "degree": degree}
    return Edit(vertices=denoising.bilateral_projection(layer.vertices, **how, progress=progress), values=values)
