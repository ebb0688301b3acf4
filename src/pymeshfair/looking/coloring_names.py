"""The names of colorings, which a command checks before it reads anything."""

from ..declaration import nearest
from ..errors import ParameterError

#: those that are numbers: `pymeshfair.looking.coloring.COLORINGS`
NUMBERS = ("curvature", "gaussian", "distance", "displacement", "shape", "scalar")
#: those that are no numbers: the colours of the mesh itself, and lines that follow from the direction of view
OTHERS = ("plain", "own", "reflection")


def check_coloring(name: str) -> None:
    """Raise `ParameterError` with the nearest name if there is no such coloring."""
    names = [*OTHERS, *NUMBERS]
    if name not in names:
        near = nearest(name, names)
        hint = f"did you mean {near!r}?" if near else f"it takes {', '.join(names)}"
        raise ParameterError(f"{name!r} is no coloring; {hint}")
