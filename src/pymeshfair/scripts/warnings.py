"""Everything that a valid script may surprise with, known before it runs."""

from __future__ import annotations

from ..errors import ParameterError
from .fits import parse_fits
from .head import paragraphs
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
    found = [*_head_warnings(script), *traps(script), *(str(problem) for problem in unmet_needs(script, layers=layers))]
    return found if diagonal is None else [*found, *lengths_out_of_proportion(script, diagonal=diagonal)]


def _head_warnings(script: Script) -> list[str]:
    """That the script is superseded; and what the head says of the scans that it fits, where that cannot be understood."""
    said = paragraphs(script.comment.partition("\n")[2])[0]
    found = [f"superseded: {said['Superseded']}"] if "Superseded" in said else []
    try:
        parse_fits(said.get("Fits", ""))
    except ParameterError as error:
        found.append(f"head: {error}; no scan is checked against it")
    return found
