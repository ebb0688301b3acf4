"""What to do after one of MeshLab's filters has failed, so that the next file can be loaded."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab

#: A mesh set that lives as long as the process.
_KEEPER: list[Any] = []
#: Mesh sets that MeshLab still holds pointers to.
_KEPT: list[Any] = []


def after_failure(meshset: Any, *, verbose: bool) -> None:
    """Make MeshLab let go of the mesh set in which a filter has just failed.

    MeshLab keeps a pointer to the log of the mesh set whose filter failed, and the next progress message of anything, such as
    the loading of a file into another mesh set, is written there, wherever that is by then. A filter that succeeds resets the
    pointer, so one is applied to a mesh set of our own. A verbose mesh set has also given its log to the filter's plugin for
    good; such a mesh set must never go.
    """
    if not _KEEPER:
        keeper = pymeshlab.MeshSet()
        keeper.add_mesh(pymeshlab.Mesh(vertex_matrix=np.zeros((1, 3))))
        _KEEPER.append(keeper)
    (keeper,) = _KEEPER
    keeper.apply_filter("set_selection_none")
    keeper.clear_filter_script()
    if verbose and not any(kept is meshset for kept in _KEPT):
        _KEPT.append(meshset)
