"""Everything that a valid script may surprise with, known before it runs."""

from __future__ import annotations

from .needs import unmet_needs
from .script import Script
from .traps import lengths_out_of_proportion, traps


def script_warnings(script: Script, *, layers: int = 1, diagonal: float | None = None) -> list[str]:
    """What runs and hardly does what was meant, and what the steps will not find, one sentence each.

    Args:
        script: the steps.
        layers: how many layers there are when the script begins.
        diagonal: of the bounding box of the mesh that the lengths must suit; None if that is not to be looked at.
    """
    found = [*traps(script), *(str(problem) for problem in unmet_needs(script, layers=layers))]
    return found if diagonal is None else [*found, *lengths_out_of_proportion(script, diagonal=diagonal)]
