"""The errors of `MeshSet`: ours and pymeshlab's at once, so that a program's ``except PyMeshLabException`` catches them."""

from __future__ import annotations

from pymeshlab import PyMeshLabException

from ..errors import MeshError, ParameterError, UnknownNameError


class UnknownFilterError(UnknownNameError, PyMeshLabException):  # type: ignore[misc]
    """There is no filter, or no parameter of a filter, of that name; `suggestion` is the nearest one."""


class FilterParameterError(ParameterError, PyMeshLabException):  # type: ignore[misc]
    """A filter does not take that value; the message says what it takes."""


class FilterFailedError(MeshError, PyMeshLabException):  # type: ignore[misc]
    """A filter could not do its work; the message names the filter and the reason, ``__cause__`` is the filter's own error."""


class UnknownLayerError(MeshError, UnknownNameError, PyMeshLabException):  # type: ignore[misc]
    """The mesh set has no layer of that id; pymeshlab itself would go on without a mesh, or crash."""


class StepFailedError(FilterFailedError):
    """A step of a filter script failed; the mesh is as the step before it left it.

    Attributes:
        number: of the step in its script, from 1.
        filter: the filter's name in scripts.
        file: the script's file, or None.
        line: where in that file the step begins, or None.
    """

    def __init__(self, reason: str, *, number: int, filter: str, file: str | None = None, line: int | None = None) -> None:
        place = "" if file is None else f" ({file}:{line})" if line is not None else f" ({file})"
        super().__init__(f"step {number}, {filter!r}{place}: {reason}")
        self.number = number
        self.filter = filter
        self.file = file
        self.line = line
        self._reason = reason

    def __reduce__(self) -> tuple[object, ...]:
        # Exceptions are rebuilt from their arguments; keyword-only ones need saying, or the error could not cross a process.
        return _step_failed, (self._reason, self.number, self.filter, self.file, self.line)


def _step_failed(reason: str, number: int, name: str, file: str | None, line: int | None) -> StepFailedError:
    return StepFailedError(reason, number=number, filter=name, file=file, line=line)
