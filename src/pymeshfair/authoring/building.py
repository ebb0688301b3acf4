"""Scripts with one more step, setting or tag; the differences of two scripts."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from difflib import SequenceMatcher
from typing import Any

from ..declaration import Filter, nearest
from ..errors import ParameterError
from ..scripts import Script, Step
from ..scripts.expressions import check_expressions
from ..scripts.guards import ATTRIBUTES as LIMITS
from ..scripts.guards import Guards
from ..scripts.script import Setting, is_name
from ..scripts.value_text import parse_value


def with_step(script: Script, declared: Filter, values: Mapping[str, Any]) -> Script:
    """The script with one more step, some of whose values may be settings."""
    settings = {name: value for name, value in values.items() if isinstance(value, Setting)}
    defaults = {name: parse_value(declared.parameter(name), setting.default) for name, setting in settings.items()}
    checked = declared.check({**values, **defaults})
    check_expressions(declared, checked)
    step = Step(declared, checked, settings={name: setting.name for name, setting in settings.items()})
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
    """The script with a tag on the step of that index."""
    check_name(name, "a tag")
    steps = list(script.steps)
    if not -len(steps) <= index < len(steps):
        raise ParameterError(f"there is no step {index}; the recipe has {len(steps)}")
    steps[index] = replace(steps[index], tag=name)
    return script.with_steps(steps)


def with_limits(script: Script, limits: Mapping[str, str]) -> Script:
    """The script with these limits over its own."""
    for name in limits:
        if name not in LIMITS:
            near = nearest(name, LIMITS)
            hint = f"did you mean {near!r}?" if near else f"there are {', '.join(LIMITS)}"
            raise ParameterError(f"there is no limit {name!r}; {hint}")
    return replace(script, guards=script.guards.overridden(Guards.parse(limits)))


def check_name(name: str, of_what: str) -> None:
    """Check that a setting or a tag can be called so; the message begins with `of_what`."""
    if not is_name(name):
        raise ParameterError(f"{of_what} takes letters, digits and underscores, got {name!r}")


def differences(first: Script, second: Script) -> list[str]:
    """One sentence for each step of only one script and for each value that differs; absent values count as their defaults."""
    ours, theirs = first.with_defaults().steps, second.with_defaults().steps
    names, other_names = ([step.filter.python_name for step in steps] for steps in (ours, theirs))
    sentences: list[str] = []
    for kind, i, i_end, j, j_end in SequenceMatcher(None, names, other_names, autojunk=False).get_opcodes():
        if kind == "equal":
            for k in range(i_end - i):
                sentences += _changed(ours[i + k], theirs[j + k], j + k + 1)
            continue
        sentences += [f"step {k + 1}, {ours[k].filter.name}, is left out" for k in range(i, i_end)]
        sentences += [f"step {k + 1}, {theirs[k].filter.name}, is new" for k in range(j, j_end)]
    if first.guards != second.guards:
        sentences.append(f"limits are {second.guards.texts() or 'none'}, not {first.guards.texts() or 'none'}")
    if first.unit != second.unit:
        sentences.append(f"the unit of scans is {second.unit or 'none'}, not {first.unit or 'none'}")
    return sentences


def _changed(ours: Step, theirs: Step, number: int) -> Iterator[str]:
    for parameter in theirs.filter.parameters:
        before, after = (step.values.get(parameter.name) for step in (ours, theirs))
        if before != after:
            now, was = ("what suits the mesh" if value is None else value for value in (after, before))
            yield f"step {number}, {theirs.filter.name}: {parameter.name} is {now}, not {was}"
