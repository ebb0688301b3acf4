"""Errors about files that cannot be read or written."""

from pathlib import Path

from ..errors import PymeshfairError, RunError


class ContentsError(PymeshfairError, ValueError):
    """A file breaks the rules of its format or cannot be read here, or a format cannot hold a mesh; the message says why."""


def reason_of(error: OSError) -> str:
    """The reason of an error of the system, as a part of a sentence."""
    return (error.strerror or str(error)).lower()


class FileError(RunError):
    """A file, or one of its side files, cannot be used; `reason` says why."""

    verb = "use"

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"cannot {self.verb} {path}: {reason}")
        self.path = path
        self.reason = reason


class InputError(FileError):
    """The input cannot be read, or is not a mesh."""

    verb = "read"


class OutputError(FileError):
    """The output cannot or must not be written."""

    verb = "write"


class VerifyError(FileError):
    """An output cannot be compared with the run that made it."""

    verb = "verify"


class OutputBusyError(OutputError):
    """Another run is writing the output at this moment."""
