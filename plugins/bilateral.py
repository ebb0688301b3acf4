"""Bilateral filters of positions: of the vertices of meshes, and of points."""

from dataclasses import dataclass
from typing import Annotated, Any

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Int, Layer, MeshElement, Percentage
from pymeshfair.filters.choosing import Projection, chosen_projection
from pymeshfair.filters.denoising import JonesBorder, bilateral_fleishman, bilateral_jones, bilateral_projection
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.robust import KernelName
from pymeshfair.filters.topology import BorderPolicy

from .moving_vertices import NOTHING_TO_REMOVE, Selected, movable_vertices, reported, vertex_smoother

ITERATIONS = Int(minimum=0, maximum=10_000, help="How many steps are taken. More are smoother, slower, and shrink more.")


@dataclass(frozen=True, kw_only=True)
class Kernels:
    """Kernels and scales: the parameters that bilateral filters share.

    Attributes:
        range_kernel: How a neighbour counts that disagrees. With 'gaussian', 'tukey', 'hampel', 'lorentzian' and the truncated
            kernels it counts little or nothing far beyond the range sigma: features stay. 'huber' and 'l1' respect them less,
            'l2' not at all.
        space_kernel: How neighbours count by their distance; beyond 1.4 times the space sigma none does. 'gaussian' is the
            paper's, 'l2' counts all alike, 'l1' favours the nearest.
        range_sigma: Differences in height below it are taken for noise, larger ones for features. Larger removes stronger noise,
            and flattens larger features. 'auto' estimates it from the mesh.
    """

    range_kernel: Annotated[KernelName, Enum()] = "gaussian"
    space_kernel: Annotated[KernelName, Enum()] = "gaussian"
    range_sigma: Annotated[float, Percentage(automatic=0, default="auto")]

    def with_space_sigma(self, space_sigma: float) -> dict[str, Any]:
        """The arguments of a bilateral filter; a scale of 0 is estimated."""
        return {
            "range_kernel": self.range_kernel,
            "space_kernel": self.space_kernel,
            "range_sigma": self.range_sigma or None,
            "space_sigma": space_sigma or None,
        }


@vertex_smoother(name="Bilateral Denoising along Normals (Fleishman)", references=("fleishman2003",))
def apply_coord_bilateral_fleishman(
    layer: Layer,
    *,
    kernels: Kernels,
    space_sigma: Annotated[float, Percentage(automatic=0, default="auto")],
    iterations: Annotated[int, ITERATIONS] = 2,
    border: Annotated[BorderPolicy, Enum()] = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise and keeps features: every vertex moves along its normal to the mean height of neighbours that roughly agree.

    Fast, and enough for light noise; triangles keep their shape. The surface shrinks a little with each iteration.

    Args:
        space_sigma: How far away neighbours count. Larger averages over more, is smoother and slower. 'auto': 1.4 mean edges.
        border: What the vertices of open borders do: 'fixed' stay; 'along' see their neighbours on the border alone; 'free' see
            all of their neighbours.
    """
    vertices = bilateral_fleishman(
        layer.vertices,
        layer.faces,
        **kernels.with_space_sigma(space_sigma),
        iterations=iterations,
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices)


@vertex_smoother(name="Bilateral Denoising by Triangle Predictors (Jones)", references=("jones2003",))
def apply_coord_bilateral_jones(
    layer: Layer,
    *,
    kernels: Kernels,
    space_sigma: Annotated[float, Percentage(automatic=0, default="auto")],
    border: Annotated[JonesBorder, Enum()] = "free",
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
    vertices = bilateral_jones(
        layer.vertices,
        layer.faces,
        **kernels.with_space_sigma(space_sigma),
        border=border,
        movable=movable_vertices(layer, selected),
        progress=progress,
    )
    return Edit(vertices=vertices)


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
    space_sigma: Annotated[float, Percentage(automatic=0, default="auto")],
    iterations: Annotated[int, Int(minimum=0, maximum=10_000, automatic=-1)] = 2,
    degree: Annotated[int, Int(minimum=1, maximum=2)] = 1,
    use_normals: Annotated[bool, Bool(label="Use the points' normals")] = False,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes noise from a point cloud: every point moves along its normal to where neighbours that roughly agree expect it.

    Triangles, if there are any, play no part. The normals themselves are not changed: compute them anew afterwards. With
    automatic iterations it returns what was chosen and what was tried, with errors in spacings; a cloud without noise stays as it
    is.

    Args:
        neighbors: How many nearest points count. More are smoother, slower, and round off edges. Chosen too with automatic
            iterations.
        space_sigma: How neighbours count by their distance. Larger weighs distant ones more like near ones. 'auto' takes it from
            the mean distance of the farthest neighbour.
        iterations: How many steps are taken. More are smoother, slower, and shrink more. 'auto' takes the iterations, the
            neighbours, the degree and, if that is automatic, the range sigma that best predict points which the filter has not
            seen.
        degree: 1 moves points to the mean height of their neighbours, 2 onto the quadric that fits these heights best. Quadrics
            follow curved surfaces, which then shrink less, but need 40 neighbours and more. Chosen too with automatic iterations.
        use_normals: Move along the normals that the points have, in all iterations. Otherwise normals are estimated from the same
            neighbours, anew in each iteration.
    """
    normals = layer.vertex_normals if use_normals else None
    movable = movable_vertices(layer, selected)
    arguments = kernels.with_space_sigma(space_sigma)
    values: dict[str, Any] = {}
    if iterations < 0:
        choice = chosen_projection(
            layer.vertices, normals=normals, **arguments, movable=movable, progress=part_of(progress, 0.0, 0.8)
        )
        chosen = Projection() if choice is None else choice.chosen.label
        values = {"chosen": chosen._asdict(), "tried": reported(choice, Projection._asdict)}
        if chosen.iterations == 0:
            progress(1.0)
            return Edit(vertices=layer.vertices, values=values, notes=(NOTHING_TO_REMOVE,))
        neighbors, arguments["range_sigma"], iterations, degree = chosen
        progress = part_of(progress, 0.8, 1.0)
    points = bilateral_projection(
        layer.vertices,
        normals=normals,
        neighbors=neighbors,
        **arguments,
        iterations=iterations,
        degree=degree,
        movable=movable,
        progress=progress,
    )
    return Edit(vertices=points, values=values)
