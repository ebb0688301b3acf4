"""What every filter refuses, in the same words: the errors, and the checks of parameters."""

from .errors import ConvergenceError, FilterInputError, UnstableStepError

__all__ = [
    "ConvergenceError",
    "FilterInputError",
    "UnstableStepError",
]
