"""What a filter raises when it cannot do what was asked."""

from __future__ import annotations

from typing import Any


class PymeshfairError(Exception):
    """Base of all errors of pymeshfair that a caller may want to catch; `pymeshfair.errors` has it, too."""

    def __reduce__(self) -> tuple[Any, ...]:  # unpickling would otherwise call the class with the message alone
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[PymeshfairError], arguments: tuple[Any, ...], attributes: dict[str, Any]) -> PymeshfairError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(attributes)
    return error


class FilterInputError(PymeshfairError, ValueError):
    """The mesh or a parameter is not one that the technique is defined for; the message says which, why and what to do."""


class UnstableStepError(FilterInputError):
    """An explicit step is longer than the operator's spectrum allows.

    Attributes:
        largest_stable: the longest step that does not amplify any mode, in the unit of the step that was asked for.
    """

    def __init__(self, message: str, *, largest_stable: float) -> None:
        super().__init__(message)
        self.largest_stable = largest_stable


class ConvergenceError(PymeshfairError, RuntimeError):
    """An iterative solver ended above its tolerance; the message gives the residual that it reached."""
