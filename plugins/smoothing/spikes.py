"""Removing spikes: single vertices that stand up like needles."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from pymeshfair.declaration import Edit, FilterClass, Float, Layer, MeshElement, mesh_filter
from pymeshfair.filters.diffusion import remove_spikes
from pymeshfair.filters.execution import Progress, ignore_progress

from ..moving_vertices import MOVES_VERTICES, Selected, movable_vertices


@mesh_filter(
    name="Remove Spikes",
    classes=FilterClass.SMOOTHING | FilterClass.CLEANING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES,
)
def apply_coord_spike_removal(
    layer: Layer,
    *,
    steepness: Annotated[
        float,
        Float(
            label="Steepness",
            minimum=0,
            help="A vertex farther from the mean of its neighbours than this many times their spread is the tip of a spike. "
            "Larger removes thinner spikes alone; below 1 the corners of boxes go.",
        ),
    ] = 1.5,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Puts single vertices that stand up like needles among their neighbours; all others stay to the bit.

    Vertices on open borders stay. Returns the number of spikes.
    """
    vertices, spikes = remove_spikes(
        layer.vertices, layer.faces, steepness=steepness, movable=movable_vertices(layer, selected), progress=progress
    )
    return Edit(vertices=vertices, values={"spikes": int(np.count_nonzero(spikes))})
