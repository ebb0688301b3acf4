"""Two parts of a mesh joined by a smooth neck."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from pymeshfair.declaration import Bool, Edit, FilterClass, Layer, MeshElement, mesh_filter
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.fairing import blend_parts

from .region import FairingEnergy


@mesh_filter(
    name="Bridge Rims by Fairing",
    classes=FilterClass.REMESHING,
    requires=MeshElement.FACENUMBER,
    changes=MeshElement.VERTNUMBER | MeshElement.FACENUMBER | MeshElement.VERTFLAGSELECT | MeshElement.FACEFLAGSELECT,
    references=("fuchs1977", "botsch2004"),
)
def meshing_bridge_rims_by_fairing(
    layer: Layer,
    *,
    energy: FairingEnergy = "thin_plate",
    selected: Annotated[
        bool,
        Bool(
            label="Selected rims only",
            help="Join the two selected rims that lie nearest each other, which may belong to one part; a rim is selected when "
            "all of its vertices are. Otherwise the two nearest rims of different parts are joined.",
        ),
    ] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Joins two parts of a mesh by a smooth neck between the two rims that face each other.

    A rim is a loop of border edges. The two rims nearest each other get a band of triangles between them, as dense as they are,
    whose inside is then faired; the parts themselves stay as they are. The new vertices and triangles are selected. Parts in
    several layers are merged into one first (Flatten Visible Layers). Returns how many vertices and triangles are new, and how
    many edges each rim has.
    """
    among = layer.selected_vertices() if selected else None
    blend = blend_parts(layer.vertices, layer.faces, energy=energy, among=among, progress=progress)
    new_vertices, new_faces = len(blend.vertices), len(blend.faces)
    doubt = (
        "The two rims do not face each other clearly enough to tell whether both parts are the right way out; if the neck is "
        "twisted, turn the faces of one part over (invert faces orientation) and join them again."
    )
    return Edit(
        added_vertices=blend.vertices,
        added_faces=blend.faces,
        vertex_selection=np.arange(len(layer.vertices) + new_vertices) >= len(layer.vertices),
        face_selection=np.arange(len(layer.faces) + new_faces) >= len(layer.faces),
        values={
            "new_vertices": new_vertices,
            "new_faces": new_faces,
            "first_rim_edges": len(blend.rims[0]),
            "second_rim_edges": len(blend.rims[1]),
        },
        notes=(doubt,) if blend.doubtful else (),
    )
