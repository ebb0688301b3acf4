"""Scripts with one more step, setting or tag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..declaration import Filter, nearest
from ..errors import ParameterError
from ..scripts import Script, Step
from ..scripts.expressions import check_expressions
from ..scripts.guards import ATTRIBUTES as LIMITS
from ..scripts.guards import Guards
from ..scripts.settings import Setting, is_name
from ..scripts.value_text import parse_value


def with_step(script: Script, known: Filter, given: Mapping[str, Any]) -> Script:
    """The script with one more step, some of whose values may be settings.

    Raises:
        UnknownNameError: the filter has no such parameter.
        ParameterError: a value that the filter does not take, or another setting of a name that is there.
    """
    settings = {name: value for name, value in given.items() if isinstance(value, Setting)}
    chosen = {name: parse_value(known.parameter(name), setting.default) for name, setting in settings.items()}
    values = known.check({**given, **chosen})
    check_expressions(known, values)
    step = Step(known, values, settings={name: setting.name for name, setting in settings.items()})
    every = script.settings
    for setting in settings.values():
        every = _with_setting(every, setting)
    return replace(script, steps=(*script.steps, step), settings=every)


def _with_setting(settings: tuple[Setting, ...], new: Setting) -> tuple[Setting, ...]:
    for setting in settings:
        if setting.name == new.name:
            if setting == new:
                return settings
            raise ParameterError(f"the recipe has another setting {new.name!r}, whose default is {setting.default}")
    return (*settings, new)


def with_tag(script: Script, index: int, name: str) -> Script:
    """The script with a tag on the step of that index.

    Raises:
        ParameterError: no tag can be called so, or there is no such step.
    """
    check_name(name, "a tag")
    steps = list(script.steps)
    if not -len(steps) <= index < len(steps):
        raise ParameterError(f"there is no step {index}; the recipe has {len(steps)}")
    steps[index] = replace(steps[index], tag=name)
    return script.with_steps(steps)


def with_limits(script: Script, limits: Mapping[str, str]) -> Script:
    """The script with these limits over its own.

    Raises:
        ParameterError: there is no such limit, or a text that is none of what it takes.
    """
    for name in limits:
        if name not in LIMITS:
            near = nearest(name, LIMITS)
            hint = f"did you mean {near!r}?" if near else f"there are {', '.join(LIMITS)}"
            raise ParameterError(f"there is no limit {name!r}; {hint}")
    return replace(script, guards=script.guards.overridden(Guards.parse(limits)))


def check_name(name: str, of_what: str) -> None:
    """Check that a setting or a tag can be called so; the message begins with `of_what`.

    Raises:
        ParameterError: it cannot.
    """
    if not is_name(name):
        raise ParameterError(f"{of_what} takes letters, digits and underscores, got {name!r}")
