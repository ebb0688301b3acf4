"""What an upgrade changed in a script, and whether the script still means the same."""

from __future__ import annotations

from dataclasses import dataclass

from .problems import shortened


@dataclass(frozen=True, kw_only=True)
class Change:
    """One thing that an upgrade changed.

    Attributes:
        line: of the old script, counted from 1.
        filter: its name in the old script.
        parameter: its name in the old script; None if the change is not about one.
        what: what is written now.
        meaning: how the result differs from what the script once did, or from what MeshLab does with it today; empty if the
            meaning is the same.
    """

    line: int
    filter: str
    what: str
    parameter: str | None = None
    meaning: str = ""

    @property
    def same_meaning(self) -> bool:
        """Whether the script still does what it did."""
        return not self.meaning

    def __str__(self) -> str:
        parameter = "" if self.parameter is None else f": parameter {shortened(self.parameter)!r}"
        grade = "same meaning" if self.same_meaning else f"meaning changes: {self.meaning}"
        return f"line {self.line}: filter {shortened(self.filter)!r}{parameter}: {self.what} ({grade})"
