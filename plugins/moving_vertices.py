"""Parameters and results shared by filters that move vertices."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Int, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.choosing import DETAIL_SIZES, chosen_amount
from pymeshfair.filters.denoising import unfolded
from pymeshfair.filters.evidence import Choice
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.mesh import Bools, Floats, Ints
from pymeshfair.filters.topology import BorderPolicy

#: the elements that change when the vertices of a mesh move
MOVES_VERTICES = MeshElement.VERTCOORD | MeshElement.VERTNORMAL | MeshElement.FACENORMAL
#: the elements that change where vertices and faces are added and selected, see `additions`
ADDS_ELEMENTS = MeshElement.VERTNUMBER | MeshElement.FACENUMBER | MeshElement.VERTFLAGSELECT | MeshElement.FACEFLAGSELECT
#: declares a filter that smooths a mesh by moving its vertices: `mesh_filter`, whose arguments may be given all the same
vertex_smoother = partial(mesh_filter, classes=FilterClass.SMOOTHING, requires=MeshElement.FACENUMBER, changes=MOVES_VERTICES)
NOTHING_TO_REMOVE = "there is no noise to remove: the vertices stay where they are"  # the note on an automatic amount of 0
#: a filter by how much it smooths: vertices, faces, amount; which vertices are `movable` and the `progress` by name
Smooth: TypeAlias = Callable[..., Floats]
Selected: TypeAlias = Annotated[
    bool,
    Bool(
        label="Selected vertices only",
        help="Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is selected, "
        "the vertices all of whose triangles are selected.",
    ),
]
Border: TypeAlias = Annotated[
    BorderPolicy,
    Enum(
        help="What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours on "
        "the border alone; 'free' move like any other vertex, so that borders recede."
    ),
]
Iterations: TypeAlias = Annotated[
    int, Int(minimum=0, maximum=100_000, help="How many steps are taken. More are smoother and slower.")
]


_WAVES = "Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay. Larger is smoother. "
#: the wavelength at which a low-pass filter halves the amplitude, on meshes and on curves
DETAIL_SIZE = Percentage(
    default="6edge",
    automatic=-1,
    help=_WAVES + "'auto' takes the size whose slopes are expected to be nearest to the true ones. Not used when the amount is "
    "given otherwise.",
)
SIZE_ON_CURVES = Percentage(default="12edge", of_edges=True, help=_WAVES + "For 'implicit' with 'inverse_length'.")


def no_amount(other: str) -> FilterInputError:
    """The error of a filter with neither a detail size nor the other parameter for the amount."""
    return FilterInputError(f"detail_size is 0 and so is {other}: nothing to do; give one of them")


class Smoothed(NamedTuple):
    """The (n, 3) vertices, the amount of smoothing, 0 for none, and the report of its choice."""

    vertices: Floats
    amount: float
    values: dict[str, Any]
    notes: tuple[str, ...]

    def edit(self, **values: Any) -> Edit:
        """The edit, which reports these values, too."""
        return Edit(vertices=self.vertices, values={**values, **self.values}, notes=self.notes)


def smoothed_by_amount(
    layer: Layer, amount: float, smooth: Smooth, tried: Sequence[float], *, unit: float = 1.0, selected: bool, progress: Progress
) -> Smoothed:
    """Smooths by `amount`; "auto", below 0, takes the best of `tried` (`chosen_amount`), and folds no more faces over.

    `tried` are amounts for a mesh whose mean edge is 1, `unit` is their factor for the layer.
    """
    movable = movable_vertices(layer, selected)
    if amount >= 0.0:
        return Smoothed(smooth(layer.vertices, layer.faces, amount, movable=movable, progress=progress), amount, {}, ())
    if not len(layer.faces):
        raise FilterInputError("an automatic amount needs faces, and there are none: say how much to smooth")

    def silent(points: Floats, faces: Ints, much: float, moves: Bools | None) -> Floats:
        return smooth(points, faces, much, movable=moves, progress=ignore_progress)

    choosing = part_of(progress, 0.0, 0.8)
    choice = chosen_amount(layer.vertices, layer.faces, silent, tried, movable=movable, progress=choosing)
    amount = 0.0 if choice is None else choice.chosen.label * unit
    values = {"chosen": amount, "tried": reported(choice, lambda much: {"amount": much})}
    if amount == 0.0:
        progress(1.0)
        return Smoothed(layer.vertices, amount, values, (NOTHING_TO_REMOVE,))
    smoothed = smooth(layer.vertices, layer.faces, amount, movable=movable, progress=part_of(progress, 0.8, 1.0))
    return Smoothed(unfolded(layer.vertices, smoothed, layer.faces), amount, values, ())


def smoothed_by_size(layer: Layer, size: float, smooth: Smooth, *, selected: bool, progress: Progress) -> Smoothed:
    """The same by the detail size in mesh units."""
    return smoothed_by_amount(layer, size, smooth, DETAIL_SIZES, unit=layer.mean_edge, selected=selected, progress=progress)


def reported(choice: Choice[Any] | None, labelled: Callable[[Any], Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The report of what was tried: the label in words, and the scores."""
    scores = ("error", "excess", "uncertainty")
    trials = choice.trials if choice is not None else ()
    return [{**labelled(trial.label), **{name: getattr(trial, name) for name in scores}} for trial in trials]


def squared_mean_edge(layer: Layer) -> float:
    """The square of the mean length of the edges, the unit of time steps; `FilterInputError` if it is out of range."""
    squared = layer.mean_edge * layer.mean_edge
    if layer.mean_edge > 0.0 and not np.finfo(float).tiny <= squared < np.inf:
        raise FilterInputError(
            f"mean edge {layer.mean_edge:.3g} is too {'short' if squared < 1.0 else 'long'} to be squared: scale the mesh"
        )
    return squared


def movable_vertices(layer: Layer, selected: bool) -> Bools | None:
    """(n,) the vertices that a filter may move, None for all of them."""
    return layer.selected_vertices() if selected else None


def additions(layer: Layer, vertices: Floats, faces: Ints) -> dict[str, Any]:
    """The fields of an `Edit` that add vertices and faces, and select these alone."""
    n, m = len(layer.vertices), len(layer.faces)
    return {
        "added_vertices": vertices,
        "added_faces": faces,
        "vertex_selection": np.arange(n + len(vertices)) >= n,
        "face_selection": np.arange(m + len(faces)) >= m,
    }


def displacement(before: Floats, after: Floats) -> dict[str, float]:
    """The report of moved vertices: their number and the largest displacement, in mesh units."""
    way = after - before
    unit = float(np.abs(way).max(initial=0.0)) or 1.0  # in which squares are ordinary numbers
    furthest = unit * float(np.linalg.norm(way / unit, axis=1).max(initial=0.0))
    return {"moved": int((way != 0.0).any(axis=1).sum()), "largest_displacement": furthest}


def irregular_note(count: int) -> str:
    """The note on vertices that were placed by connectivity alone."""
    return (
        f"The triangles around {count:,} vertices are so uneven that their angles and areas would throw some out: these parts "
        "were smoothed by connectivity alone. Better triangles (Tangential Smoothing, remeshing) give a better surface."
    )
