"""Why a step failed, in words."""

from __future__ import annotations

from ..scripts.script import Step


def reason_of(error: Exception, step: Step) -> str:
    """The message of an error without the filter's name, which the supervisor adds."""
    words = " ".join(str(error).split())
    for prefix in (f"Failed to apply filter: {step.filter.python_name} Details: ", f"{step.filter.python_name}: "):
        words = words.removeprefix(prefix)
    return words


def caused_by_memory(error: BaseException | None) -> bool:
    """Whether an error, or one that it comes from, says that there was no memory left."""
    while error is not None:
        if isinstance(error, MemoryError) or "bad_alloc" in str(error):
            return True
        error = error.__cause__
    return False
