"""The stderr of a worker: our marks between the lines of MeshLab's log."""

import re
from dataclasses import dataclass

_MARK = "pymeshfair-step"
_LOG = re.compile(r"LOG: (\d+) (.*?)\s*(?:\[ (\d{1,3})% \])?\s*")
#: lines about nothing, and numbers that the values of the step have
_NOTHING = re.compile(
    r"(?:Successfully )?(?:removed|deleted|split|closed) 0 .*|Nothing done: .*"
    r"|\|.*\||(?:Inertia Tensor is|Principal axes are|axis momenta are) :",
    re.IGNORECASE,
)


def mark(step: int) -> bytes:
    """The line on stderr after which MeshLab's lines belong to that step; 0 for none."""
    return f"\n{_MARK} {step}\n".encode("ascii")


@dataclass(frozen=True)
class Talk:
    """One line that a worker wrote to stderr."""

    text: str  # what it says, without MeshLab's prefix; empty of MeshLab's lines that say that nothing was done, and of tensors
    level: int | None = None  # of MeshLab's log (0 system, 1 warning, 2 filter, 3 debug); None if the line is not MeshLab's
    fraction: float | None = None  # how far a filter is, from 0 to 1, if the line tells that and nothing else
    step: int | None = None  # the step that begins here, if the line is a mark


def parse_talk(line: str) -> Talk:
    """Parse one line of stderr."""
    words = line.split()
    if len(words) == 2 and words[0] == _MARK and words[1].isdigit():
        return Talk("", step=int(words[1]))
    match = _LOG.fullmatch(line)
    if match is None:
        return Talk(line)
    level, text, percent = match.groups()
    text = "" if _NOTHING.fullmatch(text.strip()) else text.strip()
    return Talk(text, int(level), None if percent is None else min(int(percent), 100) / 100)
