"""What filters that move vertices share: what they change, which vertices move, how often, and up to which size of details."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pymeshfair.declaration import Bool, Bools, Enum, Float, Int, Layer, MeshElement, Percentage
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.topology import BORDER_POLICIES, BorderPolicy

#: what follows when the vertices of a mesh move
MOVES_VERTICES = MeshElement.VERTCOORD | MeshElement.VERTNORMAL | MeshElement.FACENORMAL

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
        label="Border",
        choices=BORDER_POLICIES,
        help="What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours on "
        "the border alone; 'free' move like any other vertex, so that borders recede.",
    ),
]
Iterations: TypeAlias = Annotated[
    int, Int(label="Iterations", minimum=0, maximum=100_000, help="How many steps are taken. More are smoother and slower.")
]


def detail_size_parameter(unless: str, *, default: str = "6edge", of_band: str = "", of_edges: bool = False) -> Percentage:
    """The wavelength at which a low-pass filter halves the amplitude.

    Args:
        unless: the sentence that says when it is not used.
        default: as a length.
        of_band: the sentence on responses that are no low pass.
        of_edges: whether mean edges are those of polylines.
    """
    sentences = (
        "Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay.",
        of_band,
        "Larger is smoother.",
        "Mean edges are those of the curves." if of_edges else "",
        unless,
    )
    return Percentage(label="Detail size", default=default, of_edges=of_edges, help=" ".join(s for s in sentences if s))


def time_step_parameter(meaning: str) -> Float:
    """The expert's parameter of implicit steps, which replaces the detail size."""
    sentences = f"{meaning} Larger is smoother; any value is stable. 0: not used, the detail size decides."
    return Float(label="Time step", minimum=0, advanced=True, help=sentences)


def no_amount(other: str) -> FilterInputError:
    """The error of a filter that gets neither a detail size nor the other parameter that says how much to smooth."""
    return FilterInputError(f"detail_size is 0 and so is {other}: nothing to do; give one of them")


def movable_vertices(layer: Layer, selected: bool) -> Bools | None:
    """(n,) the vertices that a filter may move, None for all of them."""
    return layer.selected_vertices() if selected else None
