"""Pymeshlab's own class of mesh sets, the lock under which threads call it, its reset after a filter has failed, and the errors.

Imported with `pymeshfair.MeshSet`, since a program may put that in the place of pymeshlab's. Errors are ours and pymeshlab's.
"""

import threading
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pymeshlab
from pymeshlab import PyMeshLabException

from ..errors import MeshError, ParameterError, PymeshfairError, StepFailedError, UnknownNameError

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

    It keeps a pointer to the log of that mesh set until a filter succeeds, and writes its next message there, although it may be
    gone; so a filter is applied to a mesh set of our own. A verbose one has given its log to a plugin for good: it is kept.
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


class UnknownFilterError(UnknownNameError, PyMeshLabException):  # type: ignore[misc]
    """There is no filter, or no parameter of a filter, of that name; `suggestion` is the nearest one."""


class FilterParameterError(ParameterError, PyMeshLabException):  # type: ignore[misc]
    """A filter does not take that value; the message has the allowed values."""


class FilterFailedError(MeshError, PyMeshLabException):  # type: ignore[misc]
    """A filter could not do its work; the message names the filter and the reason, ``__cause__`` is the filter's own error."""


class UnknownLayerError(MeshError, UnknownNameError, PyMeshLabException):  # type: ignore[misc]
    """The mesh set has no layer of that id; pymeshlab itself would go on without a mesh, or crash."""


class ScriptStepFailedError(StepFailedError, FilterFailedError):
    """A step of a filter script failed; the mesh is as the last complete step left it."""


def reason(error: Exception) -> str:
    """The cause of an error, as the end of a sentence; an unexpected error is named by its class."""
    foreseen = isinstance(error, PymeshfairError | PyMeshLabException)
    return str(error) if foreseen else f"{type(error).__name__}: {error}"


class ForeignMeshError(PymeshfairError, TypeError):
    """An object to add is no mesh that pymeshfair knows, or has elements that MeshLab cannot hold."""
