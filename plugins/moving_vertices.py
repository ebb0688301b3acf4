"""What the declarations of filters that change vertices have in common."""

from __future__ import annotations

from pymeshfair.declaration import Bool, Bools, Layer, MeshElement

#: what follows when the vertices of a mesh move
MOVES_VERTICES = MeshElement.VERTCOORD | MeshElement.VERTNORMAL | MeshElement.FACENORMAL

SELECTED = Bool(
    label="Selected vertices only",
    help="Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is selected, the "
    "vertices all of whose triangles are selected.",
)


def movable_vertices(layer: Layer, selected: bool) -> Bools | None:
    """(n,) the vertices that a filter may move, None for all of them."""
    return layer.selected_vertices() if selected else None
