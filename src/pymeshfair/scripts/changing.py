"""Changes scripts: sets other values, or adds a step."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..declaration import Filter
from ..errors import ParameterError, UnknownNameError, hint, nearest, plain_name
from .script import Script, Setting, Step
from .values import check_expressions, parse_value


def override(script: Script, overrides: Sequence[str]) -> Script:
    """The script with these values. A value for a step wins over a value for a setting; otherwise the later value wins.

    A text is ``NAME=VALUE`` for a setting, or ``STEP.PARAM=VALUE`` for a parameter. STEP is a tag, which several steps may have;
    the step's number, from 1; or a filter's name or a part of it that fits one step. `parse_value` says how VALUE is written.
    """
    for text in sorted(overrides, key=lambda text: "." in text.partition("=")[0]):
        place, equals, value = text.partition("=")
        step_name, dot, name = (part.strip() for part in place.rpartition("."))
        if not equals or not name or bool(dot) != bool(step_name) or not (dot or script.settings):
            names = ", ".join(setting.name for setting in script.settings)
            settings = f"NAME=VALUE for a setting ({names}) or " if names else ""
            raise ParameterError(f"cannot set {text!r}: write {settings}STEP.PARAM=VALUE, for example 2.iterations=5")
        try:
            script = with_parameter(script, step_name, name, value) if dot else _with_setting(script, name, value.strip())
        except ParameterError as error:
            raise ParameterError(f"cannot set {text!r}: {error}") from error
        except UnknownNameError as error:
            raise UnknownNameError(f"cannot set {text!r}: {error}", suggestion=error.suggestion) from error
    return script


def _with_setting(script: Script, name: str, value: str) -> Script:
    names = [setting.name for setting in script.settings]
    if name not in names:
        words = hint(name, names, f"it has {', '.join(names)}")
        raise UnknownNameError(f"the recipe has no setting {name!r}; {words}", suggestion=nearest(name, names))
    settings = tuple(replace(s, default=value) if s.name == name else s for s in script.settings)
    steps = []
    for step in script.steps:
        values = _parsed(step.filter, {p: value for p, setting in step.settings.items() if setting == name})
        steps.append(replace(step, values=step.filter.in_order({**step.values, **values})))
    return replace(script, steps=tuple(steps), settings=settings)


def _parsed(declared: Filter, texts: Mapping[str, str]) -> dict[str, Any]:
    values = {name: parse_value(declared.parameter(name), text) for name, text in texts.items()}
    check_expressions(declared, values)
    return values


def with_parameter(script: Script, step_name: str, name: str, value: str) -> Script:
    """The script with another value for a parameter of one step, or of all steps that have the tag and the parameter."""
    steps = list(script.steps)
    tagged = [i for i, step in enumerate(steps) if step.tag == step_name]
    having = [i for i in tagged if any(name in (p.name, p.xml_name) for p in steps[i].filter.parameters)]
    for index in having or tagged[:1] or [_step_index(steps, step_name)]:
        declared = steps[index].filter
        names = {n: p.name for p in declared.parameters for n in (p.name, p.xml_name)}
        if name not in names:
            words = hint(name, names, f"it has {', '.join(declared.defaults) or 'none'}")
            suggestion = nearest(name, names)
            raise UnknownNameError(f"filter {declared.name!r} has no parameter {name!r}; {words}", suggestion=suggestion)
        steps[index] = steps[index].with_checked(_parsed(declared, {names[name]: value}))
    return script.with_steps(steps)


def _step_index(steps: Sequence[Step], name: str) -> int:
    names = [(step.filter.python_name, step.filter.name) for step in steps]
    listed = [f"{i} {in_menus}" for i, (_, in_menus) in enumerate(names, 1)]
    it_has = f"the script has {', '.join([*listed[:20], *(['...'] if listed[20:] else [])])}"
    if re.fullmatch(r"[0-9]{1,9}", name):
        if not 1 <= int(name) <= len(steps):
            raise UnknownNameError(f"there is no step {name}; {it_has}")
        return int(name) - 1
    exact = [i for i, pair in enumerate(names) if name in pair]
    indices = exact or [i for i, pair in enumerate(names) if any(plain_name(name) in plain_name(n) for n in pair)]
    if len(indices) == 1:
        return indices[0]
    if indices:
        several = ", ".join(f"{i + 1} ({names[i][1]})" for i in indices)
        raise UnknownNameError(f"{name!r} fits several steps, {several}; give the step's number")
    words = [n for pair in names for n in (*pair, *pair[1].split())]
    raise UnknownNameError(f"no step's filter is called {name!r}; {hint(name, words, it_has)}", suggestion=nearest(name, words))


def with_step(script: Script, declared: Filter, values: Mapping[str, Any]) -> Script:
    """The script with one more step and without a path; settings in `values` become settings of the script."""
    used = {name: value for name, value in values.items() if isinstance(value, Setting)}
    checked = declared.check({**values, **_parsed(declared, {name: setting.default for name, setting in used.items()})})
    check_expressions(declared, checked)
    settings = {setting.name: setting for setting in script.settings}
    for new in used.values():
        if settings.setdefault(new.name, new) != new:
            default = settings[new.name].default
            raise ParameterError(f"the recipe has another setting {new.name!r} already, whose default is {default}")
    step = Step(declared, checked, settings={name: setting.name for name, setting in used.items()})
    return replace(script, steps=(*script.steps, step), settings=tuple(settings.values()), path=None)
