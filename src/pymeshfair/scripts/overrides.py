"""Sets values from a command line: of a setting, ``detail_size=4edge``, or of a step's parameter, ``taubin.lambda=0.4``."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..declaration import Filter, Parameter, nearest
from ..errors import ParameterError, UnknownNameError
from .expressions import check_expressions
from .script import Script, Step
from .value_text import parse_value


def override(script: Script, overrides: Sequence[str]) -> Script:
    """The script with these values put over its own; later ones win.

    Each is written ``NAME=VALUE``, where NAME is a setting of the recipe, or ``STEP.PARAM=VALUE``. STEP is the tag of one step or
    several, a number, counted from 1, or a filter's Python or MeshLab name, or a part of one that fits a single step. PARAM is a
    parameter's name in Python or in scripts. How VALUE is written depends on the parameter: see `parse_value`.

    Raises:
        UnknownNameError: no setting, step or parameter is called so, or several steps are.
        ParameterError: the text has another form, or the value is not allowed.
    """
    for text in overrides:
        place, equals, value = text.partition("=")
        step_name, dot, name = (part.strip() for part in place.rpartition("."))
        if not equals or not name or bool(dot) != bool(step_name) or not (dot or script.settings):
            settings = f"NAME=VALUE for a setting ({_listed(script)}) or " if script.settings else ""
            raise ParameterError(f"cannot set {text!r}: write {settings}STEP.PARAM=VALUE, for example 2.iterations=5")
        try:
            script = _with_parameter(script, step_name, name, value) if dot else _with_setting(script, name, value)
        except ParameterError as error:
            raise ParameterError(f"cannot set {text!r}: {error}") from error
        except UnknownNameError as error:
            raise UnknownNameError(f"cannot set {text!r}: {error}", suggestion=error.suggestion) from error
    return script


def _listed(script: Script) -> str:
    return ", ".join(setting.name for setting in script.settings)


def _with_setting(script: Script, name: str, value: str) -> Script:
    """The script with another value for one of its settings, in all steps that use it."""
    names = [setting.name for setting in script.settings]
    if name not in names:
        near = nearest(name, names)
        hint = f"did you mean {near!r}?" if near else f"it has {_listed(script)}"
        raise UnknownNameError(f"the recipe has no setting {name!r}; {hint}", suggestion=near)
    settings = tuple(replace(s, default=value.strip()) if s.name == name else s for s in script.settings)
    return replace(script, steps=tuple(_set(step, name, value.strip()) for step in script.steps), settings=settings)


def _set(step: Step, name: str, value: str) -> Step:
    chosen = {p: parse_value(step.filter.parameter(p), value) for p, setting in step.settings.items() if setting == name}
    check_expressions(step.filter, chosen)
    return replace(step, values=step.filter.in_order({**step.values, **chosen}))


def _with_parameter(script: Script, step_name: str, name: str, value: str) -> Script:
    """The script with another value for a parameter of one step, or of all steps of a tag that have it."""
    tagged = [i for i, step in enumerate(script.steps) if step.tag == step_name]
    having = [i for i in tagged if any(name in (p.name, p.xml_name) for p in script.steps[i].filter.parameters)]
    steps = list(script.steps)
    for index in having or tagged[:1] or [_step_index(steps, step_name)]:
        parameter = _parameter(steps[index].filter, name)
        chosen = {parameter.name: parse_value(parameter, value)}
        check_expressions(steps[index].filter, chosen)
        steps[index] = steps[index].with_checked(chosen)
    return script.with_steps(steps)


def _step_index(steps: Sequence[Step], name: str) -> int:
    if re.fullmatch(r"[0-9]{1,9}", name):
        if not 1 <= int(name) <= len(steps):
            raise UnknownNameError(f"there is no step {name}; the script has {_counted(steps)}")
        return int(name) - 1
    exact = [i for i, step in enumerate(steps) if name in (step.filter.python_name, step.filter.name)]
    indices = exact or [i for i, step in enumerate(steps) if any(_plain(name) in _plain(n) for n in _names(step))]
    if len(indices) == 1:
        return indices[0]
    if indices:
        listed = ", ".join(f"{i + 1} ({steps[i].filter.name})" for i in indices)
        raise UnknownNameError(f"{name!r} fits several steps, {listed}; give the step's number")
    near = nearest(name, [n for step in steps for n in (*_names(step), *step.filter.name.split())])
    hint = f"; did you mean {near!r}?" if near else f"; the script has {_counted(steps)}"
    raise UnknownNameError(f"no step's filter is called {name!r}{hint}", suggestion=near)


def _parameter(declared: Filter, name: str) -> Parameter:
    names: Mapping[str, Parameter] = {n: p for p in declared.parameters for n in (p.name, p.xml_name)}
    if name in names:
        return names[name]
    near = nearest(name, names)
    hint = f"; did you mean {near!r}?" if near else f"; it has {', '.join(p.name for p in declared.parameters) or 'none'}"
    raise UnknownNameError(f"filter {declared.name!r} has no parameter {name!r}{hint}", suggestion=near)


def _names(step: Step) -> tuple[str, str]:
    return step.filter.python_name, step.filter.name


def _counted(steps: Sequence[Step]) -> str:
    shown = [f"{i} {step.filter.name}" for i, step in enumerate(steps[:20], 1)]
    return ", ".join([*shown, "..."] if len(steps) > 20 else shown)


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.casefold()).strip()
