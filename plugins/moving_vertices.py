"""Parameters and results shared by filters that move vertices."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Int, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.choosing import DETAIL_SIZES, chosen_amount
from pymeshfair.filters.denoising import NOTHING_TO_REMOVE, reported, unfolded
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.mesh import Bools, Floats, Ints, check_points, normalised_mesh
from pymeshfair.filters.topology import BorderPolicy

#: the elements that change when the vertices of a mesh move
MOVES_VERTICES = MeshElement.VERTCOORD | MeshElement.VERTNORMAL | MeshElement.FACENORMAL
#: the elements that change when vertices and faces are added and selected, see `additions`
ADDS_ELEMENTS = MeshElement.VERTNUMBER | MeshElement.FACENUMBER | MeshElement.VERTFLAGSELECT | MeshElement.FACEFLAGSELECT
#: `mesh_filter` with the defaults for a filter that smooths a mesh by moving its vertices
vertex_smoother = partial(mesh_filter, classes=FilterClass.SMOOTHING, requires=MeshElement.FACENUMBER, changes=MOVES_VERTICES)
#: a smoother called with vertices, faces, amount, and the keywords `movable` and `progress`
Smooth: TypeAlias = Callable[..., Floats]
Selected: TypeAlias = Annotated[
    bool,
    Bool(
        label="Selected vertices only",
        help="Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is selected, "
        "the vertices whose triangles are all selected change.",
    ),
]
Border: TypeAlias = Annotated[
    BorderPolicy,
    Enum(
        help="How vertices on open borders move. 'fixed': they stay. 'along': they are smoothed as a curve, with only their "
        "neighbours on the border. 'free': they move like any other vertex, so that borders recede."
    ),
]
Iterations: TypeAlias = Annotated[int, Int(minimum=0, maximum=100_000, help="The number of steps. More steps smooth more.")]
_WAVES = "Waves of this length keep half their amplitude: smaller details vanish, larger ones stay. Larger is smoother. "
#: the wavelength at which a low-pass filter halves the amplitude, on meshes and on curves
DETAIL_SIZE = Percentage(default="6edge", automatic=-1, help=_WAVES + "'auto' chooses the size for the noise of the mesh.")
SIZE_ON_CURVES = Percentage(default="12edge", of_edges=True, help=_WAVES + "Only for 'implicit' with weights 'inverse_length'.")


def no_amount(layer: Layer, other: str, amount: str = "detail_size") -> FilterInputError:
    """The error if neither the detail size nor the other parameter gives an amount."""
    if layer.mean_edge == 0.0:
        has_cells = len(layer.faces) or len(layer.edges)
        lacking = "no edge with a length" if has_cells else "only duplicate points" if len(layer.vertices) > 1 else "no faces"
        return FilterInputError(f"the mesh has {lacking}, so that {amount} is 0: nothing to do")
    return FilterInputError(f"detail_size is 0 and so is {other}: nothing to do; give one of them")


class Smoothed(NamedTuple):
    """The (n, 3) smoothed vertices, the amount of smoothing (0: none), and the report on the choice of the amount."""

    vertices: Floats
    amount: float
    values: dict[str, Any]
    notes: tuple[str, ...]

    def edit(self, **values: Any) -> Edit:
        return Edit(vertices=self.vertices, values={**values, **self.values}, notes=self.notes)


def smoothed_by_amount(
    layer: Layer, amount: float, smooth: Smooth, tried: Sequence[float], *, unit: float = 1.0, selected: bool, progress: Progress
) -> Smoothed:
    """Smooths by `amount`; if it is below 0 ("auto"), by the best amount of `tried`, see `chosen_amount`.

    `tried` are amounts for a mesh with mean edge 1; `unit` scales them to the layer. With "auto" no additional faces are folded.
    """
    movable = movable_vertices(layer, selected)
    if amount >= 0.0:
        return Smoothed(smooth(layer.vertices, layer.faces, amount, movable=movable, progress=progress), amount, {}, ())
    if not len(layer.faces):
        raise FilterInputError("an automatic amount needs faces, and the mesh has none: give an amount, or a mesh with faces")

    def silent(points: Floats, faces: Ints, trial: float, moves: Bools | None) -> Floats:
        return smooth(points, faces, trial, movable=moves, progress=ignore_progress)

    choosing = part_of(progress, 0.0, 0.8)
    choice = chosen_amount(layer.vertices, layer.faces, silent, tried, movable=movable, progress=choosing)
    amount = 0.0 if choice is None else choice.chosen.label * unit
    values = {"chosen": amount, "tried": reported(choice, lambda trial: {"amount": trial})}
    if amount == 0.0:
        progress(1.0)
        return Smoothed(layer.vertices, amount, values, (NOTHING_TO_REMOVE,))
    smoothed = smooth(layer.vertices, layer.faces, amount, movable=movable, progress=part_of(progress, 0.8, 1.0))
    return Smoothed(unfolded(layer.vertices, smoothed, layer.faces), amount, values, ())


def smoothed_by_size(layer: Layer, size: float, smooth: Smooth, *, selected: bool, progress: Progress) -> Smoothed:
    """`smoothed_by_amount` with a detail size in mesh units as the amount."""
    return smoothed_by_amount(layer, size, smooth, DETAIL_SIZES, unit=layer.mean_edge, selected=selected, progress=progress)


def squared_mean_edge(layer: Layer) -> float:
    """The squared mean edge length, the unit of time steps; raises `FilterInputError` if it is 0, over- or underflows."""
    squared = layer.mean_edge * layer.mean_edge
    if layer.mean_edge == 0.0:
        raise no_amount(layer, "", "its mean edge")
    if not np.finfo(float).tiny <= squared < np.inf:
        size = "short" if squared < 1.0 else "long"
        raise FilterInputError(f"mean edge {layer.mean_edge:.3g} is too {size} to be squared: scale the mesh")
    return squared


def movable_vertices(layer: Layer, selected: bool) -> Bools | None:
    """(n,) which vertices a filter may move; None for all. Refuses a far vertex by `NormalisedMesh.check_far`."""
    normalised_mesh(check_points(layer.vertices), layer.faces if len(layer.faces) else layer.edges).check_far()
    return layer.selected_vertices() if selected else None


def additions(layer: Layer, vertices: Floats, faces: Ints) -> dict[str, Any]:
    """The fields of an `Edit` that add vertices and faces, and select only the added ones."""
    n, m = len(layer.vertices), len(layer.faces)
    return {
        "added_vertices": vertices,
        "added_faces": faces,
        "vertex_selection": np.arange(n + len(vertices)) >= n,
        "face_selection": np.arange(m + len(faces)) >= m,
    }


def displacement(before: Floats, after: Floats) -> dict[str, float]:
    """The report of moved vertices: their number and the largest displacement, in mesh units."""
    vectors = after - before
    unit = float(np.abs(vectors).max(initial=0.0)) or 1.0  # so that squares neither overflow nor vanish
    furthest = unit * float(np.linalg.norm(vectors / unit, axis=1).max(initial=0.0))
    return {"moved": int((vectors != 0.0).any(axis=1).sum()), "largest_displacement": furthest}


def irregular_note(count: int) -> str:
    """The note on vertices that were smoothed by connectivity alone."""
    return (
        f"The triangles around {count:,} vertices are so uneven that weights by angles and areas would move some vertices far "
        "off: connectivity alone smoothed these parts. Better triangles (Tangential Smoothing, remeshing) improve the surface."
    )
