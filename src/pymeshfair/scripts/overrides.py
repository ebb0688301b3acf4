"""Sets values from a command line: ``taubin.lambda=0.4`` names a step of a script, a parameter and its value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..declaration import Bool, Color, Enum, Filter, Float, Int, Length, Matrix, Mesh, Parameter, Percentage, Point, nearest
from ..errors import ParameterError, UnknownNameError
from .script import Script, Step

_TRUE = frozenset({"true", "yes", "on", "1"})
_FALSE = frozenset({"false", "no", "off", "0"})


def override(script: Script, overrides: Sequence[str]) -> Script:
    """The script with these values, each written ``STEP.PARAM=VALUE``, put over its own; later ones win.

    STEP is a number, counted from 1, or a filter's Python or MeshLab name, or a part of one that fits a single step. PARAM is a
    parameter's name in Python or in scripts. How VALUE is written depends on the parameter: see `parse_value`.

    Raises:
        UnknownNameError: no step or parameter is called so, or several steps are.
        ParameterError: the text has another form, or the value is not allowed.
    """
    steps = list(script.steps)
    for text in overrides:
        place, equals, value = text.partition("=")
        step_name, dot, parameter_name = place.rpartition(".")
        if not (equals and dot and step_name.strip() and parameter_name.strip()):
            raise ParameterError(f"cannot set {text!r}: write STEP.PARAM=VALUE, for example 2.iterations=5")
        index = _step_index(steps, step_name.strip(), text)
        parameter = _parameter(steps[index].filter, parameter_name.strip(), text)
        try:
            steps[index] = steps[index].with_checked({parameter.name: parse_value(parameter, value)})
        except ParameterError as error:
            raise ParameterError(f"cannot set {text!r}: {error}") from error
    return replace(script, steps=tuple(steps))


def parse_value(parameter: Parameter, text: str) -> Any:
    """The value that a text gives to a parameter.

    Switches are true or false (also yes, no, on, off, 1, 0); lengths ``1%``, ``0.5edge`` or mesh units; choices their word;
    points ``1,2,3``; colours ``255,128,0`` or with an opacity; matrices sixteen numbers row by row.

    Raises:
        ParameterError: the text is no value of the parameter's kind, or lies outside its bounds.
    """
    plain = text.strip()
    value: Any = text
    if isinstance(parameter, Bool):
        value = True if plain.lower() in _TRUE else False if plain.lower() in _FALSE else text
    elif isinstance(parameter, Int | Mesh):
        value = int(plain) if re.fullmatch(r"[+-]?[0-9]{1,20}", plain) else text
    elif isinstance(parameter, Float):
        value = _number(plain)
    elif isinstance(parameter, Percentage):
        value = Length.parse(plain)
    elif isinstance(parameter, Enum):
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


def _step_index(steps: Sequence[Step], name: str, text: str) -> int:
    if re.fullmatch(r"[0-9]{1,9}", name):
        if not 1 <= int(name) <= len(steps):
            raise UnknownNameError(f"cannot set {text!r}: there is no step {name}; the script has {_counted(steps)}")
        return int(name) - 1
    exact = [i for i, step in enumerate(steps) if name in (step.filter.python_name, step.filter.name)]
    found = exact or [i for i, step in enumerate(steps) if any(_plain(name) in _plain(n) for n in _names(step))]
    if len(found) == 1:
        return found[0]
    if found:
        listed = ", ".join(f"{i + 1} ({steps[i].filter.name})" for i in found)
        raise UnknownNameError(f"cannot set {text!r}: {name!r} fits several steps, {listed}; give the step's number")
    near = nearest(name, [n for step in steps for n in (*_names(step), *step.filter.name.split())])
    hint = f"; did you mean {near!r}?" if near else f"; the script has {_counted(steps)}"
    raise UnknownNameError(f"cannot set {text!r}: no step's filter is called {name!r}{hint}", suggestion=near)


def _parameter(known: Filter, name: str, text: str) -> Parameter:
    names: Mapping[str, Parameter] = {n: p for p in known.parameters for n in (p.name, p.xml_name)}
    if name in names:
        return names[name]
    near = nearest(name, names)
    hint = f"; did you mean {near!r}?" if near else f"; it has {', '.join(p.name for p in known.parameters) or 'none'}"
    raise UnknownNameError(f"cannot set {text!r}: filter {known.name!r} has no parameter {name!r}{hint}", suggestion=near)


def _names(step: Step) -> tuple[str, str]:
    return step.filter.python_name, step.filter.name


def _counted(steps: Sequence[Step]) -> str:
    shown = [f"{i} {step.filter.name}" for i, step in enumerate(steps[:20], 1)]
    return ", ".join([*shown, "..."] if len(steps) > 20 else shown)


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.casefold()).strip()
