"""Problems of a script and changes by an upgrade: place, fault, and suggestion."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import PymeshfairError

#: So many problems of a script are listed at most; so many usually have one cause.
MOST_PROBLEMS = 100


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One thing that is wrong with a script."""

    message: str  # the mistake, the written text and the allowed one
    file: str  # the path or name of the script
    line: int | None = None  # counted from 1; None if the whole file is meant
    filter: str | None = None  # the name of the filter as written there
    parameter: str | None = None  # the name of the parameter as written there
    suggestion: str | None = None  # the text to write instead, where one is likely

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        step = "" if self.filter is None else f": filter {shortened(self.filter)!r}"
        parameter = "" if self.parameter is None else f": parameter {shortened(self.parameter)!r}"
        hint = "" if self.suggestion is None else f" (did you mean {self.suggestion!r}?)"
        return f"{place}{step}{parameter}: {self.message}{hint}"


class ScriptError(PymeshfairError):
    """A script cannot be read, or something in it is wrong; the message has one line for each problem."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)  # all of them, in the order of the file
        super().__init__("\n".join(map(str, self.problems)))


def shortened(text: str) -> str:
    """The text, cut to a length that a message can hold."""
    return text if len(text) <= 80 else f"{text[:77]}..."


@dataclass(frozen=True, kw_only=True)
class Change:
    """One thing that an upgrade changed."""

    line: int  # of the old script, counted from 1
    filter: str  # its name in the old script
    what: str  # the change
    parameter: str | None = None  # its name in the old script; None if the change is not about one
    #: how the result differs from what the script once did, or from what MeshLab does with it today; empty if the meaning is the
    #: same
    meaning: str = ""

    @property
    def same_meaning(self) -> bool:
        """Whether the script still does what it did."""
        return not self.meaning

    def __str__(self) -> str:
        parameter = "" if self.parameter is None else f": parameter {shortened(self.parameter)!r}"
        grade = "same meaning" if self.same_meaning else f"meaning changes: {self.meaning}"
        return f"line {self.line}: filter {shortened(self.filter)!r}{parameter}: {self.what} ({grade})"
