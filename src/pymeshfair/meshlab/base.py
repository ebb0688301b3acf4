"""Pymeshlab's own class of mesh sets, the lock under which threads call it, and its reset after a filter has failed.

Imported with `pymeshfair.MeshSet`, since a program may put that in the place of pymeshlab's afterwards.
"""

import threading
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pymeshlab

BASE: Any = pymeshlab.MeshSet
#: MeshLab's filters, readers and writers share state of the process: one thread at a time may be within them
MESHLAB = threading.RLock()
#: mesh sets that MeshLab still holds pointers to
_KEPT: list[Any] = []


def apply_filter(meshset: Any, name: str, values: Mapping[str, Any], *, verbose: bool) -> dict[str, Any]:
    """Apply a filter of that name to a mesh set without adding it to MeshLab's own script; what it reports."""
    with MESHLAB:
        try:
            result: dict[str, Any] = BASE.apply_filter(meshset, name, **values)
        except Exception:
            after_failure(meshset, verbose=verbose)
            raise
        BASE.clear_filter_script(meshset)
    return result


def after_failure(meshset: Any, *, verbose: bool) -> None:
    """Make MeshLab let go of the mesh set in which a filter has just failed.

    MeshLab keeps a pointer to the log of the mesh set whose filter failed. It writes the next progress message to it, such as
    that of loading a file into another mesh set, although the log may be gone by then. A filter that succeeds resets the
    pointer, so one is applied to a mesh set of our own. A verbose mesh set has also given its log to the filter's plugin for
    good, so it is kept as long as the process runs.
    """
    keeper = _keeper()
    keeper.apply_filter("set_selection_none")
    keeper.clear_filter_script()
    if verbose and not any(kept is meshset for kept in _KEPT):
        _KEPT.append(meshset)


@cache
def _keeper() -> Any:
    """A mesh set that is kept as long as the process runs."""
    keeper = BASE()
    keeper.add_mesh(pymeshlab.Mesh(vertex_matrix=np.zeros((1, 3))))
    return keeper
