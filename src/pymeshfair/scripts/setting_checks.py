"""Whether the settings of a recipe and the steps that use them agree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..declaration import nearest
from ..errors import ParameterError
from .problems import Problem, shortened
from .script import Step
from .settings import Setting
from .value_text import parse_value


def setting_problems(file: str, settings: Sequence[Setting], steps: Sequence[Step]) -> Iterator[Problem]:
    """Names that stand twice or for nothing, and defaults that are not the values of the steps that use them."""
    by_name: dict[str, Setting] = {}
    for setting in settings:
        if setting.name in by_name:
            yield Problem(file=file, line=setting.line, message=f"the setting {setting.name!r} stands there twice")
        by_name.setdefault(setting.name, setting)
    used: set[str] = set()
    for step in steps:
        for name, wanted in step.settings.items():
            used.add(wanted)
            if (message := _disagreement(step, name, by_name.get(wanted), wanted)) is not None:
                near = None if wanted in by_name else nearest(wanted, by_name)
                xml_name = step.filter.parameter(name).xml_name
                yield Problem(
                    file=file, line=step.line, filter=step.filter.name, parameter=xml_name, message=message, suggestion=near
                )
    for setting in by_name.values():
        if setting.name not in used:
            message = f"no step uses the setting {setting.name!r}; write setting={setting.name!r} in a <Param>, or leave it out"
            yield Problem(file=file, line=setting.line, message=message)


def _disagreement(step: Step, name: str, setting: Setting | None, wanted: str) -> str | None:
    if setting is None:
        return f"is set by {shortened(wanted)!r}, and the recipe has no setting of that name"
    try:
        value = parse_value(step.filter.parameter(name), setting.default)
    except ParameterError as error:
        return f"cannot take the default {shortened(setting.default)!r} of the setting {wanted!r}: {error}"
    if value != step.values[name]:
        given = shortened(str(step.values[name]))
        return (
            f"is {given}, but the default of its setting {wanted!r} is {shortened(setting.default)}; MeshLab would run the first"
        )
    return None
