"""Checks the elements of a script: a ``<filter>`` becomes a step, a ``<Param>`` one of its values."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from .. import declaration
from ..declaration import Enum, Filter, Length, Parameter, String, nearest
from ..errors import ParameterError, UnknownNameError
from ..meshlab.facts import former_filter, former_parameters
from ..registry import find_filter
from .expressions import expression_error, is_expression
from .problems import MOST_PROBLEMS, Problem, ScriptError, shortened
from .script import Document, FilterElement, ParamElement, Script, Setting, Step, is_name
from .suggestions import close_spelling, former_parameter_hint, gone, invented, renamed, same_but_case, suggested_filter
from .value_text import parse_value

Attributes = Mapping[str, str]
#: the mistake, and the text to write instead
Complaint = tuple[str, "str | None"]

_NUMBERS = frozenset({"RichFloat", "RichDynamicFloat", "RichAbsPerc"})
_POINTS = frozenset({"RichPosition", "RichDirection"})
#: the types that MeshLab reads into the same kind of value, by the parameter's own type
_ACCEPTED: Mapping[str, frozenset[str]] = {
    **dict.fromkeys(_NUMBERS, _NUMBERS),
    **dict.fromkeys(_POINTS, _POINTS),
    "RichEnum": frozenset({"RichEnum", "RichInt"}),
    "RichMesh": frozenset({"RichMesh", "RichInt"}),
    "RichOpenFile": frozenset({"RichOpenFile", "RichString"}),
    "RichSaveFile": frozenset({"RichSaveFile", "RichString"}),
}
#: the attributes that MeshLab needs to keep a parameter of that type, and whether each is a whole number
_REQUIRED: Mapping[str, Mapping[str, bool]] = {
    "RichDynamicFloat": {"min": False, "max": False},
    "RichAbsPerc": {"min": False, "max": False},
    "RichEnum": {"enum_cardinality": True},
    "RichOpenFile": {"exts_cardinality": True},
}
#: names that types once had
OLD_TYPES = frozenset({"RichPoint3f"})
#: MeshLab allocates as many words as a script announces
_MOST_CHOICES = 1000

WHOLE = re.compile(r"\s*[+-]?[0-9]{1,20}\s*")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_MOST_DIGITS = 400


def type_complaints(parameter: Parameter, attributes: Attributes) -> Iterator[Complaint]:
    """Faults by which MeshLab cannot read the value: a type of another kind, or a missing attribute."""
    written = attributes.get("type")
    if written is None:
        yield "the attribute type is missing; MeshLab would drop the parameter and take its default", parameter.xml_type
        return
    if written not in _ACCEPTED.get(parameter.xml_type, {parameter.xml_type}):
        if written in OLD_TYPES:
            yield f"type {written!r} is an old name", parameter.xml_type
        else:
            yield (
                f"has the type {parameter.xml_type}, not {shortened(written)!r}; MeshLab would take 0 or the default",
                parameter.xml_type,
            )
        return
    for name, whole in _REQUIRED.get(written, {}).items():
        text = attributes.get(name)
        if text is None:
            yield f"the attribute {name} is missing; MeshLab would drop the parameter and take its default", None
        elif not (WHOLE.fullmatch(text) and 0 <= int(text) <= _MOST_CHOICES if whole else parsed(text) is not None):
            needed = f"a whole number from 0 to {_MOST_CHOICES}" if whole else "a number"
            yield f"the attribute {name} must be {needed}, got {shortened(text)!r}", None


def parsed(text: str) -> float | None:
    """The finite number that the text spells as MeshLab reads it, with blanks around it; None if it spells none."""
    if len(text) > _MOST_DIGITS or _NUMBER.fullmatch(text.strip()) is None:
        return None
    number = float(text)
    return number if math.isfinite(number) else None


class _RefusedError(Exception):
    """The value cannot be read; carries the complaint."""

    def __init__(self, message: str, suggestion: str | None = None) -> None:
        super().__init__(message)
        self.complaint: Complaint = (message, suggestion)


def read_value(parameter: Parameter, attributes: Attributes, *, filter_name: str) -> tuple[Any, list[Complaint]]:
    """The value that the attributes of a ``<Param>`` give to the parameter, and everything that is wrong with them."""
    complaints = list(type_complaints(parameter, attributes))
    try:
        value = _READERS.get(type(parameter), _read_nothing)(parameter, attributes)
        if (
            isinstance(parameter, String)
            and is_expression(filter_name, parameter.xml_name)
            and (error := expression_error(value))
        ):
            raise _RefusedError(f"{shortened(value)!r} is no expression that MeshLab can evaluate: {error}")
    except _RefusedError as wrong:
        return None, [*complaints, wrong.complaint]
    return value, complaints


def _checked(parameter: Parameter, value: Any) -> Any:
    try:
        return parameter.check(parameter.from_number(value))
    except ParameterError as error:
        raise _RefusedError(str(error).removeprefix(f"parameter {parameter.name!r} ")) from None


def _text(attributes: Attributes, name: str = "value") -> str:
    try:
        return attributes[name]
    except KeyError:
        raise _RefusedError(f"the attribute {name} is missing") from None


def _whole(parameter: Parameter, text: str) -> int:
    if WHOLE.fullmatch(text) is None:
        number = parsed(text)
        suggestion = None if number is None or not number.is_integer() or abs(number) >= 2**31 else str(int(number))
        raise _RefusedError(f"takes {parameter.describe_allowed()}, got {shortened(text)!r}", suggestion)
    return int(text)


def _number(parameter: Parameter, text: str) -> float:
    number = parsed(text)
    if number is None:
        pointed = text.replace(",", ".")
        suggestion = pointed if pointed != text and parsed(pointed) is not None else None
        raise _RefusedError(f"takes {parameter.describe_allowed()}, got {shortened(text)!r}", suggestion)
    return number


def _read_bool(parameter: Parameter, attributes: Attributes) -> bool:
    text = _text(attributes)
    if text not in ("true", "false"):
        meant = {"true": "true", "yes": "true", "1": "true", "false": "false", "no": "false", "0": "false"}
        note = "; MeshLab would read it as true" if text.lower() == "false" else ""
        raise _RefusedError(
            f"takes true or false in small letters, got {shortened(text)!r}{note}", meant.get(text.strip().lower())
        )
    return text == "true"


def _read_float(parameter: Parameter, attributes: Attributes) -> Any:
    text = _text(attributes)
    if "relative" in attributes:
        raise _RefusedError("relative= belongs to lengths alone, and this parameter is a plain number")
    return _checked(parameter, _number(parameter, text))


def _read_length(parameter: Parameter, attributes: Attributes) -> Any:
    length = Length(_number(parameter, _text(attributes)))
    if "relative" in attributes:
        text = attributes["relative"]
        try:
            length = Length.parse(text)
        except ParameterError:
            raise _RefusedError(f"relative= takes a length such as 1% or 0.5edge, got {shortened(text)!r}") from None
        if length.unit == "absolute":
            raise _RefusedError(f"relative= takes a length with a unit, got {shortened(text)!r}", f"{text}%")
    return _checked(parameter, length)


def _read_enum(parameter: Parameter, attributes: Attributes) -> Any:
    assert isinstance(parameter, Enum)
    text = _text(attributes)
    allowed = "; ".join(f"{i}: {shortened(word)}" for i, word in enumerate(parameter.choices))
    if WHOLE.fullmatch(text) is None:
        suggestion = str(parameter.choices.index(text)) if text in parameter.choices else None
        raise _RefusedError(f"takes the number of a choice ({allowed}), got {shortened(text)!r}", suggestion)
    index = int(text)
    if not 0 <= index < len(parameter.choices):
        raise _RefusedError(f"takes the number of a choice ({allowed}), got {shortened(text)!r}")
    word = attributes.get(f"enum_val{index}", parameter.choices[index])
    if word != parameter.choices[index] and word in parameter.choices:
        raise _RefusedError(
            f"says that {index} means {word!r}, but here it means {parameter.choices[index]!r}: "
            f"the script was written for other choices ({allowed})",
            str(parameter.choices.index(word)),
        )
    return parameter.choices[index]


def _several(names: Sequence[str], read: Callable[[Parameter, str], float]) -> Callable[[Parameter, Attributes], Any]:
    """A reader of values with an attribute for each of their numbers; those of a matrix stand row by row."""

    def read_numbers(parameter: Parameter, attributes: Attributes) -> Any:
        texts = [_text(attributes, name) for name in names]
        numbers = [read(parameter, text) for text in texts]
        return _checked(parameter, [numbers[i : i + 4] for i in range(0, 16, 4)] if len(numbers) == 16 else numbers)

    return read_numbers


def _read_nothing(parameter: Parameter, attributes: Attributes) -> Any:
    raise _RefusedError("cannot be given in a script: MeshLab reads and writes no cameras there; leave the parameter out")


_TEXTS = (declaration.String, declaration.FileOpen, declaration.FileSave)
_READERS: Mapping[type[Parameter], Callable[[Parameter, Attributes], Any]] = {
    declaration.Bool: _read_bool,
    **dict.fromkeys((declaration.Int, declaration.Mesh), lambda p, attributes: _checked(p, _whole(p, _text(attributes)))),
    declaration.Float: _read_float,
    declaration.Percentage: _read_length,
    declaration.Enum: _read_enum,
    **dict.fromkeys((declaration.Point, declaration.Direction), _several("xyz", _number)),
    declaration.Color: _several("rgba", _whole),
    declaration.Matrix: _several([f"val{k}" for k in range(16)], _number),
    **dict.fromkeys(_TEXTS, lambda p, attributes: _checked(p, _text(attributes))),
}


def build_script(document: Document, path: Path | None = None) -> Script:
    """The script that the elements make."""
    problems, steps = list(document.problems), list[Step]()
    for element in document.filters:
        complain = partial(Problem, file=document.name, filter=element.name)
        step, wrong = _step(element, complain)
        steps += [] if step is None else [step]
        problems += wrong
        if len(problems) > MOST_PROBLEMS:
            break
    if not problems:
        problems += setting_problems(document.name, document.settings, steps)
    problems = sorted(problems, key=lambda problem: problem.line or 0)
    if len(problems) > MOST_PROBLEMS:
        more = Problem(file=document.name, message=f"has more problems; only the first {MOST_PROBLEMS} are listed")
        problems = [*problems[:MOST_PROBLEMS], more]
    if problems:
        raise ScriptError(problems)
    return Script(tuple(steps), document.comment, path, document.guards, document.settings, document.unit)


def _step(element: FilterElement, complain: Callable[..., Problem]) -> tuple[Step | None, list[Problem]]:
    """The step that an element means, and what is wrong with it; `complain` makes a problem of its filter."""
    name, line = element.name, element.line
    if element.kind == "xmlfilter":
        words = f"<xmlfilter> is of MeshLab 2016, which alone can run it{_today(name)}; `pymeshfair upgrade` rewrites it"
        return None, [complain(message=words, line=line, suggestion="filter")]
    if name is None:
        return None, [complain(message="<filter> has no name; MeshLab would fail there", line=line)]
    try:
        declared = find_filter(name)
    except UnknownNameError as error:
        message, suggestion = _unknown(name, error.cause)
        return None, [complain(message=message, line=line, suggestion=suggestion)]
    if declared.name != name:
        message = "that is the filter's name in Python; scripts use the one in MeshLab's menus"
        return None, [complain(message=message, line=line, suggestion=declared.name)]
    problems: list[Problem] = []
    if element.tag and not is_name(element.tag):
        words = f"the tag {shortened(element.tag)!r} takes letters, digits and underscores"
        problems.append(complain(message=words, line=line))
    values: dict[str, Any] = {}
    for param in element.params:
        of_param = partial(complain, line=param.line, parameter=param.attributes.get("name"))
        problems += [of_param(message=message, suggestion=hint) for message, hint in _add_param(declared, param, values)]
    return Step(declared, declared.in_order(values), line, element.tag, _settings(declared, element)), problems


def _add_param(declared: Filter, param: ParamElement, values: dict[str, Any]) -> list[Complaint]:
    """Put the value of an element among those of its filter; what is wrong with it."""
    name = param.attributes.get("name")
    if name is None:
        return [("<Param> has no name; MeshLab would drop it", None)]
    parameter = next((p for p in declared.parameters if p.xml_name == name), None)
    if parameter is None:
        names = [p.xml_name for p in declared.parameters]
        hint, suggestion = former_parameter_hint(former_parameters(declared.name), name)
        in_python = next((p.xml_name for p in declared.parameters if p.name == name), None)
        suggestion = suggestion or in_python or (None if hint else close_spelling(name, names))
        allowed = f"it has {', '.join(names)}" if names else "it has none"
        return [(f"the filter has no such parameter; {hint or allowed}", suggestion)]
    if parameter.name in values:
        return [("is given twice; MeshLab would take the last", None)]
    values[parameter.name], complaints = read_value(parameter, param.attributes, filter_name=declared.python_name)
    return complaints


def _settings(declared: Filter, element: FilterElement) -> dict[str, str]:
    """By Python parameter name, the settings that the ``<Param>`` elements name."""
    named = {param.attributes.get("name"): param.attributes.get("setting") for param in element.params}
    return {p.name: setting for p in declared.parameters if (setting := named.get(p.xml_name)) is not None}


def _unknown(name: str, cause: str | None) -> tuple[str, str | None]:
    """The problem with an unknown filter's name, and a suggestion."""
    former = former_filter(name)
    if former is None:
        why = f": {cause}" if cause else ""
        return f"there is no filter of that name{why}", None if cause else same_but_case(name) or suggested_filter(name)
    if former.now is None:
        return gone(former), None
    return (invented(former) if former.invented else renamed(former)), former.now


def _today(name: str | None) -> str:
    """Today's name of the filter of an ``<xmlfilter>``, as the end of a sentence."""
    former = former_filter(name or "")
    return "" if former is None or former.now is None else f"; the filter is called {former.now!r} now"


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
        own = shortened(str(step.values[name]))
        return f"is {own}, but the default of its setting {wanted!r} is {shortened(setting.default)}; MeshLab would run the first"
    return None
