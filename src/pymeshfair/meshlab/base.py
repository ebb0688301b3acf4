"""pymeshlab's own class of mesh sets, the lock for calls from threads, the reset after a failed filter, and the errors.

`BASE` stays pymeshlab's class if a program sets ``pymeshlab.MeshSet = pymeshfair.MeshSet``.
"""

import tempfile
import threading
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from pymeshlab import PyMeshLabException

from ..errors import MeshError, ParameterError, PymeshfairError, StepFailedError, UnknownNameError

BASE: Any = pymeshlab.MeshSet
#: MeshLab's filters, readers and writers share global state, so only one thread at a time may run them
MESHLAB = threading.RLock()
#: mesh sets that MeshLab still holds pointers to
_KEPT: list[Any] = []


def apply_filter(meshset: Any, name: str, values: Mapping[str, Any], *, verbose: bool, script: str = "") -> dict[str, Any]:
    """Applies a filter, or the .mlx text `script` instead; returns the report, {} of a script. Clears MeshLab's own script."""
    with MESHLAB:
        try:
            if script:
                with tempfile.TemporaryDirectory() as folder:
                    Path(folder, "step.mlx").write_text(script, "utf-8")
                    BASE.load_filter_script(meshset, f"{folder}/step.mlx")
                BASE.apply_filter_script(meshset)
            result: dict[str, Any] = {} if script else BASE.apply_filter(meshset, name, **values)
        except Exception:
            after_failure(meshset, verbose=verbose)
            raise
        BASE.clear_filter_script(meshset)
    return result


def after_failure(meshset: Any, *, verbose: bool) -> None:
    """Makes MeshLab drop its pointer to the mesh set in which a filter has just failed.

    Until the next filter succeeds, MeshLab writes messages to the log of that mesh set, even after the set is freed. So a filter
    runs here on a mesh set that is never freed. MeshLab never drops the log of a verbose mesh set, so such a set is kept, too.
    """
    keeper = _keeper()
    keeper.apply_filter("set_selection_none")
    keeper.clear_filter_script()
    if verbose and not any(kept is meshset for kept in _KEPT):
        _KEPT.append(meshset)


@cache
def _keeper() -> Any:
    keeper = BASE()
    keeper.add_mesh(pymeshlab.Mesh(vertex_matrix=np.zeros((1, 3))))
    return keeper


class UnknownFilterError(UnknownNameError, PyMeshLabException):  # type: ignore[misc]
    """No filter, or no parameter of a filter, has this name."""


class FilterParameterError(ParameterError, PyMeshLabException):  # type: ignore[misc]
    """A filter does not take that value."""


class FilterFailedError(MeshError, PyMeshLabException):  # type: ignore[misc]
    """A filter could not do its work; ``__cause__`` is the filter's own error, if it raised one."""


class UnknownLayerError(MeshError, UnknownNameError, PyMeshLabException):  # type: ignore[misc]
    """The mesh set has no layer of that id; pymeshlab itself would go on without a mesh, or crash."""


class ScriptStepFailedError(StepFailedError, FilterFailedError):
    """A step of a filter script failed; the steps before it stay applied."""


class ForeignMeshError(PymeshfairError, TypeError):
    """An object to add has an unsupported class, is a scene of no or several kinds of parts, or has too many or few values."""
