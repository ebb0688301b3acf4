"""Shows an error to users: one message on stderr and, with ``--json``, one document on stdout."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .json_document import print_document
from .streams import complain


@dataclass(frozen=True)
class Failure:
    """The error that ended a command."""

    kind: str  # the name of the exception, e.g. ``"ScriptError"``.
    message: str  # the mistake, its place, and advice
    exit_code: int  # 1 the run failed, 2 wrong usage or an invalid recipe, 130 interrupted
    #: further attributes of the exception, such as the problems of a script or the step that failed
    details: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, error: Exception) -> Failure:
        """The failure for an exception."""
        from ..errors import ParameterError, PymeshfairError, UnknownNameError

        kind, message = type(error).__name__, str(error)
        details = {name: value for name, value in vars(error).items() if not name.startswith("_")}
        if isinstance(error, PymeshfairError):
            invalid = isinstance(error, UnknownNameError | ParameterError) or "problems" in details
            return cls(kind, message, 2 if invalid else 1, details)
        if isinstance(error, OSError):
            return cls(kind, message, 1)
        message = f"unexpected {kind}: {message}\nthis is a defect of pymeshfair or of a plugin; --debug shows where it happened"
        return cls(kind, message, 1)

    def show(self, *, json: bool) -> None:
        """Print the message on stderr and, with `json`, the document on stdout."""
        complain(self.message, color=False if os.environ.get("NO_COLOR") else None)
        if json:
            print_document({"error": {**self.details, "kind": self.kind, "message": self.message}})


def check_working_folder() -> None:
    """Refuse a working folder that has been removed: relative paths cannot be read or written there."""
    from ..errors import RunError

    try:
        os.getcwd()  # noqa: PTH109 - pathlib would load more
    except OSError:
        raise RunError("the working folder does not exist any more; change to another one, and give the command again") from None


INTERRUPTED = Failure("Interrupted", "interrupted", 130)
