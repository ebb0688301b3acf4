"""The errors of `MeshSet` and of MeshLab's filters: ours and pymeshlab's at once, for ``except PyMeshLabException``."""

from pymeshlab import PyMeshLabException

from ..errors import MeshError, ParameterError, PymeshfairError, StepFailedError, UnknownNameError


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
