"""Reads and writes values of parameters as texts: on the command line, in settings, and in the attributes of a ``<Param>``.

MeshLab drops a value that it cannot read, or takes 0. Here every fault of a ``<Param>`` is a complaint, and so is an expression
that MeshLab's muParser cannot evaluate. All names of variables are valid, since custom attributes of a mesh are variables.
"""

import contextlib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..declaration import Bool, Color, Enum, FileOpen, Filter, Float, Int, Length, Matrix
from ..declaration.parameters import Mesh, Parameter, Percentage, Point, Shot, String
from ..errors import ParameterError, shortened

Attributes = Mapping[str, str]
Complaint = tuple[str, "str | None"]  # the mistake, and the text that was probably meant, or None

#: by type of parameter: the attributes that hold the numbers of a value; for all other types ``value``
_ATTRIBUTES: Mapping[str, Sequence[str]] = {
    "RichPosition": "xyz",
    "RichDirection": "xyz",
    "RichColor": "rgba",
    "RichMatrix44f": [f"val{i}" for i in range(16)],
}
_NUMBERS, _POINTS = ("RichFloat", "RichDynamicFloat", "RichAbsPerc"), ("RichPosition", "RichDirection")
#: by type of parameter: the types that MeshLab reads as the same kind of value
_ACCEPTED: Mapping[str, Sequence[str]] = {
    **dict.fromkeys(_NUMBERS, _NUMBERS),
    **dict.fromkeys(_POINTS, _POINTS),
    **{name: (name, "RichInt") for name in ("RichEnum", "RichMesh")},
    **{name: (name, "RichString") for name in ("RichOpenFile", "RichSaveFile")},
}
#: by type of parameter: the attributes without which MeshLab drops the value, and whether each is a whole number
_REQUIRED: Mapping[str, Mapping[str, bool]] = {
    "RichDynamicFloat": {"min": False, "max": False},
    "RichAbsPerc": {"min": False, "max": False},
    "RichEnum": {"enum_cardinality": True},
    "RichOpenFile": {"exts_cardinality": True},
}
OLD_TYPES = frozenset({"RichPoint3f"})  # former names of types
_MOST_CHOICES = 1000  # MeshLab allocates memory for as many words as a script declares

_WHOLE = re.compile(r"\s*[+-]?[0-9]{1,20}\s*")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_MOST_DIGITS = 400  # the most characters of a number
_SWITCH = dict.fromkeys(("true", "yes", "on", "1"), True) | dict.fromkeys(("false", "no", "off", "0"), False)


def parse_value(parameter: Parameter, text: str) -> Any:
    """The value of a parameter from its text on a command line or in a setting.

    A switch is true, false, yes, no, on, off, 1 or 0; a length ``1%``, ``0.5edge`` or a number in mesh units; a choice its name;
    a point ``1,2,3``; a colour ``255,128,0``, or four numbers with opacity; a matrix 16 numbers by rows. Some take ``auto``.
    """
    plain = text.strip()
    value: Any = text if isinstance(parameter, String) else plain
    if isinstance(parameter, Bool):
        value = _SWITCH.get(plain.lower(), text)
    elif isinstance(parameter, Int | Mesh | Float):
        value = _spelled(parameter, plain)
    elif isinstance(parameter, Point | Color | Matrix):
        numbers = [_spelled(parameter, part) for part in re.split(r"[,;\s]+", plain)]
        value = _assembled(parameter, [*numbers, 255] if isinstance(parameter, Color) and len(numbers) == 3 else numbers)
    return parameter.check(value)


def parsed(text: str) -> float | None:
    """The finite number in a text, which may have blanks around it, as MeshLab reads it; None if it is no number."""
    if len(text) > _MOST_DIGITS or _NUMBER.fullmatch(text.strip()) is None:
        return None
    number = float(text)
    return number if math.isfinite(number) else None


def number_text(number: float) -> str:
    """The text with the fewest significant digits that reads back as the same number: 0.1, 10, 1e-05."""
    return repr(float(number)).removesuffix(".0")


def _spelled(parameter: Parameter, text: str) -> float | str:
    """The number in a text, an int if the parameter takes whole numbers; the text itself if it is no such number."""
    if isinstance(parameter, Int | Mesh | Enum | Color):
        return int(text) if _WHOLE.fullmatch(text) else text
    return text if (number := parsed(text)) is None else number


def spelled(parameter: Parameter, attributes: Attributes) -> list[float | str]:
    """The numbers of a ``<Param>``; a wrong one stays a text, and a missing one is ""."""
    return [_spelled(parameter, attributes.get(name, "")) for name in _names(parameter)]


def _names(parameter: Parameter) -> Sequence[str]:
    return _ATTRIBUTES.get(parameter.xml_type, ("value",))


def _assembled(parameter: Parameter, numbers: Sequence[Any]) -> Any:
    if isinstance(parameter, Matrix) and len(numbers) == 16:
        return [numbers[i : i + 4] for i in range(0, 16, 4)]
    return numbers if isinstance(parameter, Point | Color | Matrix) else numbers[0]


def type_complaints(parameter: Parameter, attributes: Attributes) -> Iterator[Complaint]:
    """Complaints about what MeshLab needs to read the value: a fitting type, and attributes that the type requires."""
    written, wanted = attributes.get("type"), parameter.xml_type
    dropped = "is missing; MeshLab would drop the parameter and take its default"
    if written is None:
        yield f"the attribute type {dropped}", wanted
    elif written in OLD_TYPES:
        yield f"type {written!r} is an old name", wanted
    elif written not in _ACCEPTED.get(wanted, (wanted,)):
        yield f"has the type {wanted}, not {shortened(written)!r}; MeshLab would take 0 or the default", wanted
    else:
        for name, whole in _REQUIRED.get(written, {}).items():
            text = attributes.get(name)
            if text is None:
                yield f"the attribute {name} {dropped}", None
            elif not (_WHOLE.fullmatch(text) and 0 <= int(text) <= _MOST_CHOICES if whole else parsed(text) is not None):
                needed = f"a whole number from 0 to {_MOST_CHOICES}" if whole else "a number"
                yield f"the attribute {name} must be {needed}, got {shortened(text)!r}", None


class _RefusedError(Exception):
    """The value cannot be read; the arguments are the complaint."""


def read_value(parameter: Parameter, attributes: Attributes, *, filter_name: str) -> tuple[Any, list[Complaint]]:
    """The value in the attributes of a ``<Param>``, None if it cannot be read or is not allowed, and all complaints."""
    complaints = list(type_complaints(parameter, attributes))
    try:
        value = parameter.check(_read(parameter, attributes))
        check_expression(filter_name, parameter, value)
    except ParameterError as wrong:
        return None, [*complaints, (str(wrong).removeprefix(f"parameter {parameter.name!r}").lstrip(": "), None)]
    except _RefusedError as wrong:
        return None, [*complaints, wrong.args]
    return value, complaints


def _read(parameter: Parameter, attributes: Attributes) -> Any:
    if isinstance(parameter, Shot):
        words = "cannot be given in a script: MeshLab reads and writes no cameras there; leave the parameter out"
        raise _RefusedError(words, None)
    for name in _names(parameter):
        if name not in attributes:
            raise _RefusedError(f"the attribute {name} is missing", None)
    text = attributes.get("value", "")
    if isinstance(parameter, String):
        return text
    if isinstance(parameter, Bool):
        if text not in ("true", "false"):
            suggestion = {True: "true", False: "false"}.get(_SWITCH.get(text.strip().lower()))  # type: ignore[arg-type]
            note = "; MeshLab would read it as true" if text.lower() == "false" else ""
            raise _RefusedError(f"takes true or false in small letters, got {shortened(text)!r}{note}", suggestion)
        return text == "true"
    if isinstance(parameter, Enum):
        return _read_choice(parameter, attributes)
    if isinstance(parameter, Float) and "relative" in attributes:
        raise _RefusedError("relative= belongs to lengths alone, and this parameter is a plain number", None)
    numbers = spelled(parameter, attributes)
    for number in numbers:
        if isinstance(number, str):
            of_length = "a number as value= (1% or 0.5edge belongs in relative=)"
            allowed = of_length if isinstance(parameter, Percentage) else parameter.describe_allowed()
            raise _RefusedError(f"takes {allowed}, got {shortened(number)!r}", None)
    if isinstance(parameter, Percentage):
        return _read_length(float(numbers[0]), attributes.get("relative"))
    return _assembled(parameter, numbers)


def _read_length(amount: float, relative: str | None) -> Length:
    if relative is None:
        return Length(amount)
    with contextlib.suppress(ParameterError):
        length = Length.parse(relative)
        if length.unit == "absolute":
            raise _RefusedError(f"relative= takes a length with a unit, got {shortened(relative)!r}", f"{relative}%")
        if length.unit in ("percent", "edge"):
            return length
    raise _RefusedError(f"relative= takes a length such as 1% or 0.5edge, got {shortened(relative)!r}", None)


def _read_choice(parameter: Enum, attributes: Attributes) -> str:
    text, choices = attributes["value"], parameter.choices
    allowed = "; ".join(f"{i}: {shortened(word)}" for i, word in enumerate(choices))
    index = _spelled(parameter, text)
    if isinstance(index, str) or not 0 <= index < len(choices):
        hint = str(choices.index(text)) if text in choices else None
        raise _RefusedError(f"takes the number of a choice ({allowed}), got {shortened(text)!r}", hint)
    today = choices[int(index)]
    word = attributes.get(f"enum_val{index}", today)
    if word != today and word in choices:
        wrong = f"says that {index} means {word!r}, but here it means {today!r}"
        raise _RefusedError(f"{wrong}: the script was written for other choices ({allowed})", str(choices.index(word)))
    return today


def param_attributes(parameter: Parameter, value: Any, *, diagonal: float, mean_edge: float) -> dict[str, str]:
    """The attributes of the ``<Param>`` for a checked value, in order."""
    written = {"type": parameter.xml_type, "name": parameter.xml_name}
    value = parameter.to_number(value)
    if isinstance(parameter, Bool):
        written["value"] = "true" if value else "false"
    elif isinstance(parameter, Float):
        written["value"] = number_text(value)
        if parameter.minimum is not None and parameter.maximum is not None:
            least = min(parameter.minimum, parameter.minimum if parameter.automatic is None else parameter.automatic)
            written |= {"min": number_text(least), "max": number_text(parameter.maximum)}
    elif isinstance(parameter, Percentage):
        value = value if isinstance(value, Length) else Length(value)
        amount = value.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)
        written |= {"value": number_text(amount), "min": number_text(min(0.0, amount)), "max": number_text(max(diagonal, amount))}
        if value.unit != "absolute":
            written["relative"] = f"{number_text(value.amount)}{'%' if value.unit == 'percent' else 'edge'}"
    elif isinstance(parameter, Enum):
        written |= {"value": str(parameter.choices.index(value)), "enum_cardinality": str(len(parameter.choices))}
        written |= {f"enum_val{i}": word for i, word in enumerate(parameter.choices)}
    elif isinstance(parameter, Point | Color | Matrix):
        numbers = [x for row in value for x in row] if isinstance(parameter, Matrix) else value
        written |= dict(zip(_names(parameter), map(number_text, numbers), strict=True))
    else:
        written["value"] = str(value)
        if isinstance(parameter, FileOpen):
            written["exts_cardinality"] = "0"
    return written


#: muParser's functions as MeshLab registers them: the number of arguments, where n is one or more
FUNCTIONS = {
    **dict.fromkeys(("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"), "1"),
    **dict.fromkeys(("log2", "log10", "log", "ln", "exp", "sqrt", "sign", "rint", "abs"), "1"),
    **dict.fromkeys(("min", "max", "sum", "avg"), "n"),
    **{"atan2": "2", "rnd": "0"},
}
_MOST_CHARACTERS, _DEEPEST = 10_000, 64  # of an expression; the depth is that of nested parentheses and choices
_WORD = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[A-Za-z_][A-Za-z0-9_]*")
_ROW = re.compile(r"[+-]?v(?:(?:<=|>=|!=|==|&&|\|\||[-+*/^<>])[+-]?v)*")  # muParser takes one sign, not two
_INNERMOST = re.compile(r"([012n]?)\(([^()]*)\)")
_FILTERS = re.compile(r"_by_function|_by_condition|_new_custom_|_implicit_surface")


def is_expression(filter_name: str, parameter_name: str) -> bool:
    """Whether a text parameter of the filter with this Python name is an expression; the name of a new attribute is not."""
    return _FILTERS.search(filter_name) is not None and parameter_name != "name"


def check_expressions(declared: Filter, values: Mapping[str, Any]) -> None:
    """`check_expression` for all of a filter's values."""
    for parameter in declared.parameters:
        if parameter.name in values:
            check_expression(declared.python_name, parameter, values[parameter.name])


def check_expression(filter_name: str, parameter: Parameter, text: Any) -> None:
    """Raises `ParameterError` if the value must be an expression and `evaluates` refuses it."""
    if isinstance(parameter, String) and is_expression(filter_name, parameter.xml_name) and not evaluates(text):
        raise ParameterError(
            f"parameter {parameter.name!r}: {shortened(text)!r} is no expression that MeshLab can evaluate: it knows "
            f"+ - * / ^ < <= > >= == != && || ?: and the functions {', '.join(FUNCTIONS)}"
        )


def evaluates(text: str) -> bool:
    """Whether a text is one valid expression of muParser: valid parts are replaced by ``v`` until one ``v`` is left.

    Assignments and several results are refused, although muParser accepts them: a filter needs one value.
    """
    if len(text) > _MOST_CHARACTERS:
        return False
    plain, count = re.sub(" ?([^ v]) ?", r"\1", " ".join(_WORD.sub(_mark_of_word, text).split())), 0
    for _ in range(_DEEPEST + 1):
        plain, count = _INNERMOST.subn(_mark_of_call, plain)
        if not count:
            break
    return not count and _is_value(plain)


def _mark_of_word(word: re.Match[str]) -> str:
    """A function's number of arguments if a parenthesis follows, else "f"; "v" for a number or a variable."""
    called = word.string[word.end() : word.end() + 1] == "("
    return FUNCTIONS.get(word[0], "v") if called else "f" if word[0] in FUNCTIONS else "v"


def _mark_of_call(call: re.Match[str]) -> str:
    """The replacement of a function call or a parenthesis: ``v`` if it is valid, else ``!``."""
    values = call[2].split(",") if call[2] else []
    fits = bool(values) if call[1] == "n" else len(values) == int(call[1] or 1)
    return "v" if fits and all(map(_is_value, values)) else "!"


def _is_value(text: str) -> bool:
    """Whether a text without parentheses is one value: values joined by operators, or choices ``?:`` of such values."""
    text = _ROW.sub("v", text)
    for _ in range(_DEEPEST):
        text = text.replace("v?v:v", "v")
    return text == "v"
