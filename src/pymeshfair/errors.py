"""The exceptions that pymeshfair raises; every message names what was wrong, where, and what to do next."""

from __future__ import annotations


class PymeshfairError(Exception):
    """Base of all errors of pymeshfair that a caller may want to catch."""


class UnknownNameError(PymeshfairError, LookupError):
    """A filter, parameter, choice or recipe of that name does not exist.

    Attributes:
        suggestion: the nearest name that does exist, or None.
    """

    def __init__(self, message: str, *, suggestion: str | None = None) -> None:
        super().__init__(message)
        self.suggestion = suggestion


class ParameterError(PymeshfairError, ValueError):
    """A parameter's value has the wrong type or lies outside its bounds."""


class DeclarationError(PymeshfairError, TypeError):
    """A plugin declares a filter that contradicts itself; raised where the filter is defined, never while it runs."""


class MeshError(PymeshfairError):
    """The current mesh lacks what a filter needs, or a filter's result does not fit the mesh."""


class RunError(PymeshfairError):
    """A run did not come to its end; no output was written, and what was there before is untouched."""
