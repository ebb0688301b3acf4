"""What a filter of ours must find on a layer before it may run."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..declaration import Filter, MeshElement
from ..write_back import MeshLayer

_CHECKS: dict[MeshElement, tuple[str, Callable[[MeshLayer], bool]]] = {
    MeshElement.FACENUMBER: ("faces", lambda layer: len(layer.faces) > 0),
    MeshElement.EDGENUMBER: ("edges", lambda layer: len(layer.edges) > 0),
    MeshElement.VERTNUMBER: ("vertices", lambda layer: len(layer.vertices) > 0),
    MeshElement.VERTCOLOR: ("vertex colors", lambda layer: layer.has_vertex_colors),
    MeshElement.VERTQUALITY: ("vertex scalars", lambda layer: layer.has_vertex_scalars),
    MeshElement.FACECOLOR: ("face colors", lambda layer: layer.has_face_colors),
    MeshElement.FACEQUALITY: ("face scalars", lambda layer: layer.has_face_scalars),
    MeshElement.WEDGTEXCOORD: ("texture coordinates of its faces' corners", lambda layer: layer.has_wedge_tex_coords),
    MeshElement.VERTFLAGSELECT: ("selected vertices", lambda layer: bool(layer.vertex_selection.any())),
    MeshElement.FACEFLAGSELECT: ("selected faces", lambda layer: bool(layer.face_selection.any())),
}


def missing(known: Filter, layer: MeshLayer) -> list[str]:
    """What the layer lacks of what the filter requires, in words."""
    return list(_missing(known, layer))


def _missing(known: Filter, layer: MeshLayer) -> Iterator[str]:
    for element, (words, is_there) in _CHECKS.items():
        if known.requires & element and not is_there(layer):
            yield words
