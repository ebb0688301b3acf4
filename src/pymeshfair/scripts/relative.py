"""Lengths of a script that were meant for one mesh, as parts of the size of any mesh."""

from __future__ import annotations

from ..declaration import Length
from .script import Script, Step


def relative_script(script: Script, *, diagonal: float) -> Script:
    """The script with every absolute length as a percentage of the diagonal of the mesh that it was meant for.

    Args:
        script: the steps; a length of 0 stays, as it is 0 on every mesh.
        diagonal: of the bounding box of that mesh, above 0.
    """
    return script.with_steps(_relative(step, diagonal) for step in script.steps)


def _relative(step: Step, diagonal: float) -> Step:
    lengths = {
        name: Length(100.0 * value.amount / diagonal, "percent")
        for name, value in step.values.items()
        if isinstance(value, Length) and value.unit == "absolute" and value.amount
    }
    return step.with_checked(lengths)
