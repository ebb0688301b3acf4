"""What every filter refuses, in the same words: the errors, and the checks of parameters."""

from .errors import ConvergenceError, FilterInputError, PymeshfairError, UnstableStepError
from .parameters import check_choice, check_finite, check_positive, check_whole_number

__all__ = [
    "ConvergenceError",
    "FilterInputError",
    "PymeshfairError",
    "UnstableStepError",
    "check_choice",
    "check_finite",
    "check_positive",
    "check_whole_number",
]
