"""Files that cannot be read or written."""

from pathlib import Path

from ..errors import PymeshfairError, RunError


class ContentsError(PymeshfairError, ValueError):
    """A file is none of its format, or lies; the message is the reason, and says where."""


class InputError(RunError):
    """The input cannot be read, or what was read is no mesh.

    Attributes:
        path: the input, or the file that it names.
        reason: one sentence.
    """

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"cannot read {path}: {reason}")
        self.path = path
        self.reason = reason


class OutputError(RunError):
    """The output cannot be written, or must not be.

    Attributes:
        path: the output, or a file beside it.
        reason: one sentence.
    """

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"cannot write {path}: {reason}")
        self.path = path
        self.reason = reason


class OutputBusyError(OutputError):
    """Another run is writing the output at this moment."""
