"""The values that texts give to parameters, as a command line and the settings of a recipe write them."""

import re
from typing import Any

from ..declaration import Bool, Color, Enum, Float, Int, Matrix, Mesh, Parameter, Percentage, Point

_TRUE = frozenset({"true", "yes", "on", "1"})
_FALSE = frozenset({"false", "no", "off", "0"})


def parse_value(parameter: Parameter, text: str) -> Any:
    """The value that a text gives to a parameter.

    "auto" where a number or a length may be automatic. Switches are true or false (also yes, no, on, off, 1, 0); lengths ``1%``,
    ``0.5edge`` or mesh units; choices their word; points ``1,2,3``; colours ``255,128,0`` or with an opacity; matrices sixteen
    numbers row by row.

    Raises:
        ParameterError: the text is no value of the parameter's kind, or lies outside its bounds.
    """
    plain = text.strip()
    value: Any = text
    if isinstance(parameter, Bool):
        value = True if plain.lower() in _TRUE else False if plain.lower() in _FALSE else text
    elif isinstance(parameter, Int | Mesh):
        value = int(plain) if re.fullmatch(r"[+-]?[0-9]{1,20}", plain) else plain
    elif isinstance(parameter, Float):
        value = _number(plain)
    elif isinstance(parameter, Enum | Percentage):
        value = plain
    elif isinstance(parameter, Point | Color | Matrix):
        value = [_number(part) for part in re.split(r"[,;\s]+", plain)]
        if isinstance(parameter, Color) and len(value) == 3:
            value.append(255.0)
        if isinstance(parameter, Matrix) and len(value) == 16:
            value = [value[i : i + 4] for i in range(0, 16, 4)]
    return parameter.check(value)


def _number(text: str) -> Any:
    """The number, or the text itself, which the parameter's check then refuses."""
    try:
        return float(text) if "_" not in text else text
    except ValueError:
        return text
