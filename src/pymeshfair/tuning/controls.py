"""A recipe as the controls of a page, and a page's settings as a script again."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from ..declaration import AUTO, Bool, Enum, Float, Int, Length, Parameter, Percentage, Shot, String
from ..errors import ParameterError
from ..recipe import Recipe
from ..scripts.script import Script, Step
from ..scripts.values import number_text, parse_value

#: the choices of a page for one step: texts by parameter name, in the form that `parse_value` reads, empty where MeshLab is to
#: find the value; None if the step is off
StepChoices: TypeAlias = Mapping[str, str] | None


class ChoiceError(ParameterError):
    """A value that a parameter does not allow."""

    def __init__(self, step: int, parameter: str, reason: str) -> None:
        super().__init__(reason)
        self.step = step  # its number, from 0
        self.parameter = parameter  # its name


def controls(recipe: Recipe) -> dict[str, Any]:
    """The recipe in terms of JSON: its words, and for each step and parameter what a control needs."""
    info = recipe.info
    return {
        "name": recipe.name,
        "title": recipe.title,
        "purpose": info.purpose,
        "does": info.does,
        "tune": info.tune,
        "steps": [
            {
                "name": step.filter.name,
                "summary": step.filter.summary,
                "parameters": [_control(p, step.values.get(p.name)) for p in step.filter.parameters if not isinstance(p, Shot)],
            }
            for step in (step.with_defaults() for step in recipe.script.steps)
        ],
    }


def choices_of(documents: Sequence[Any]) -> list[StepChoices]:
    """The settings that a page sent; what has another form is refused."""
    choices: list[StepChoices] = []
    for document in documents:
        values = document.get("values") if isinstance(document, dict) else None
        if not isinstance(values, dict) or not all(isinstance(text, str) for text in values.values()):
            raise ParameterError("the page sent settings that are none")
        choices.append(values if document.get("on") is True else None)
    return choices


def script_with(script: Script, settings: Sequence[StepChoices]) -> Script:
    """The script with the steps that are on, and with these values; a `ChoiceError` says where one is not allowed."""
    if len(settings) != len(script.steps):
        raise ParameterError(f"the page has settings for {len(settings)} steps, the recipe has {len(script.steps)}")
    pairs = enumerate(zip(script.steps, settings, strict=True))
    steps = [_set(k, step, setting) for k, (step, setting) in pairs if setting is not None]
    if not steps:
        raise ParameterError("every step is switched off: switch one on")
    return script.with_steps(steps)


def in_mesh_units(script: Script, diagonal: float, mean_edge: float) -> Script:
    """The script with all its lengths in mesh units, so that on a part of a scan they are those of the whole."""
    steps = script.with_defaults().steps
    return script.with_steps(step.in_mesh_units(diagonal=diagonal, mean_edge=mean_edge) for step in steps)


def saved_comment(recipe: Recipe, scan: str, note: str) -> str:
    """The head comment of a tuned recipe: what it was made of, and the words of the original."""
    title, origin = (
        f"{recipe.title}, tuned on {_plain(scan)}",
        f"Tuned with `pymeshfair tune`, from the recipe {_plain(recipe.name)}.",
    )
    notes = [_plain(note)] if note.strip() else []
    return "\n\n".join([title, origin, *notes, recipe.description]).strip()


def _plain(text: str) -> str:
    """Words that an XML comment may hold."""
    return "".join(letter if letter.isprintable() else " " for letter in text).replace("--", "- -").rstrip("-")


def _set(number: int, step: Step, setting: Mapping[str, str]) -> Step:
    values = {}
    shown = step.with_defaults().values
    for name, text in setting.items():
        if text == value_text(shown.get(name)):
            continue  # an unchanged value keeps the setting of the recipe that it comes from
        try:
            parameter = step.filter.parameter(name)
            if text == "" and not isinstance(parameter, String):
                continue  # what MeshLab finds for the mesh
            values[name] = parse_value(parameter, text)
        except ParameterError as error:
            raise ChoiceError(number, name, str(error)) from error
    return step.with_checked(values)


def _control(parameter: Parameter, value: Any) -> dict[str, Any]:
    kind: dict[str, Any] = {"kind": "text"}
    if isinstance(parameter, Bool):
        kind = {"kind": "switch"}
    elif isinstance(parameter, Enum):
        kind = {"kind": "menu", "choices": list(parameter.choices)}
    elif isinstance(parameter, Percentage):
        shown = parameter.default if value == AUTO else value  # the slider has the reach of the filter's own default
        kind = {"kind": "length", **_bounds(parameter.minimum, None, shown.amount if isinstance(shown, Length) else 0.0)}
    elif isinstance(parameter, Int | Float):
        bounds = _bounds(parameter.minimum, parameter.maximum, value if isinstance(value, int | float) else 0)
        kind = {"kind": "whole" if isinstance(parameter, Int) else "number", **bounds}
    return {
        "name": parameter.name,
        "label": parameter.label or parameter.name,
        "help": parameter.help,
        "allowed": parameter.describe_allowed(),
        "advanced": parameter.advanced,
        "automatic": AUTO if parameter.automatic is not None else None,
        "value": value_text(value),
        **kind,
    }


def _bounds(minimum: float | None, maximum: float | None, value: float) -> dict[str, Any]:
    """The ends of a slider; where the declaration sets none, far enough from the value. The field beside it takes more."""
    reach = max(4.0 * abs(value), 10.0 if value == 0 or abs(value) >= 2 else 1.0)
    return {
        "low": minimum if minimum is not None else min(0.0, value - reach),
        "high": maximum if maximum is not None and maximum <= 100.0 * reach else reach,
        "least": minimum,
        "most": maximum,
    }


def value_text(value: Any) -> str:
    """A checked value in the form that `parse_value` reads; empty for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return number_text(value)
    if isinstance(value, tuple):
        return ",".join(value_text(part) for part in value)
    return str(value)
