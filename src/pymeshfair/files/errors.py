"""Files that cannot be read or written."""

from pathlib import Path

from ..errors import PymeshfairError, RunError


class ContentsError(PymeshfairError, ValueError):
    """A file is none of its format, or contradicts itself; the message is the reason, with the place."""


class FileError(RunError):
    """A file, or one that it names or that lies beside it, cannot be used, for a reason of one sentence."""

    verb = "use"

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"cannot {self.verb} {path}: {reason}")
        self.path = path
        self.reason = reason


class InputError(FileError):
    """The input cannot be read, or is no mesh."""

    verb = "read"


class OutputError(FileError):
    """The output cannot be written, or must not be."""

    verb = "write"


class OutputBusyError(OutputError):
    """Another run is writing the output at this moment."""
