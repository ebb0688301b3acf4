"""The syntax of the expressions in MeshLab's filters "by function" and "by condition".

MeshLab evaluates them with muParser. Coordinates, colours and normals by an expression that does not parse become 0 without a
word, so the syntax is checked before anything runs. Names of variables are not: custom attributes of the mesh are variables too.
"""

import re
from collections.abc import Mapping
from typing import Any

from ..declaration import Filter, Parameter, String
from ..errors import ParameterError
from .script import shortened

#: muParser's functions as MeshLab registers them, with the fewest and the most arguments
FUNCTIONS: dict[str, tuple[int, int | None]] = {
    **dict.fromkeys(("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"), (1, 1)),
    **dict.fromkeys(("log2", "log10", "log", "ln", "exp", "sqrt", "sign", "rint", "abs"), (1, 1)),
    **dict.fromkeys(("min", "max", "sum", "avg"), (1, None)),
    "atan2": (2, 2),
    "rnd": (0, 0),
}
OPERATORS = frozenset({"<=", ">=", "!=", "==", "&&", "||", "+", "-", "*", "/", "^", "<", ">"})

MOST_CHARACTERS = 10_000
MOST_PARENTHESES = 64

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?P<mark><=|>=|!=|==|&&|\|\||\S)|(?P<end>\Z))"
)
_FILTERS = re.compile(r"_by_function|_by_condition|_new_custom_|_implicit_surface")


def is_expression(filter_name: str, parameter_name: str) -> bool:
    """Whether that text of the filter of that Python name is an expression; the filters of new attributes take a name, too."""
    return _FILTERS.search(filter_name) is not None and parameter_name != "name"


def check_expressions(declared: Filter, values: Mapping[str, Any]) -> None:
    """Check the values of a filter, by Python parameter name, that are expressions."""
    for parameter in declared.parameters:
        if parameter.name in values:
            check_expression(declared.python_name, parameter, values[parameter.name])


def check_expression(filter_name: str, parameter: Parameter, text: Any) -> None:
    """Check the value of a parameter if it is an expression."""
    is_one = isinstance(parameter, String) and is_expression(filter_name, parameter.xml_name)
    if is_one and (error := expression_error(text)) is not None:
        words = f"{shortened(text)!r} is no expression that MeshLab can evaluate: {error}"
        raise ParameterError(f"parameter {parameter.name!r}: {words}")


def expression_error(text: str) -> str | None:
    """The reason why muParser would not parse the text, or None if it would.

    An assignment (``q = 0``) and several results (``x, y``), which muParser lets pass, are refused too: where a filter asks for
    one value they are slips.
    """
    if not text.strip():
        return "it is empty"
    if len(text) > MOST_CHARACTERS:
        return f"it has more than {MOST_CHARACTERS} characters"
    tokens = list(_TOKEN.finditer(text))
    opened: list[tuple[str, int]] = []  # what is open: "(", "?", or a function with the number of its arguments that are complete
    wants_value, signed = True, False
    for before, token, after in zip([None, *tokens], tokens, [*tokens[1:], None], strict=False):
        word, kind = token.group().strip(), token.lastgroup
        place = f"{word!r} at character {token.start(kind or 0) + 1}"
        name, arguments = opened[-1] if opened else ("", 0)
        if kind == "end":
            return "it ends where more must follow" if wants_value or opened else None
        if word == "=":
            return f"{place} assigns; write == to compare"
        if word == ")" and name in FUNCTIONS and before is not None and (not wants_value or before.group() == "("):
            (fewest, most), count = FUNCTIONS[name], arguments + (not wants_value)
            if count < fewest or (most is not None and count > most):
                takes = f"it takes {fewest}{'' if fewest == most else ' or more'}"
                return f"{place} ends {name}() after {count} arguments; {takes}"
            opened.pop()
            wants_value = False
        elif not wants_value:
            if word in OPERATORS or word == "?" or (word == ":" and name == "?") or (word == "," and name in FUNCTIONS):
                wants_value, signed = True, False
            elif word != ")" or name != "(":
                return f"{place} {'is not expected there' if word in (')', ':', ',') else 'follows a value without an operator'}"
            if word == "?":
                opened.append(("?", 0))
            elif word == ",":
                opened[-1] = name, arguments + 1
            elif word in (":", ")"):
                opened.pop()
        elif word in ("+", "-") and not signed:  # muParser takes one sign, not two
            signed = True
        elif kind == "name":
            called = after is not None and after.group() == "("  # no blank between: muParser does not take one
            if called and word not in FUNCTIONS:
                return f"{place} is not a function of {', '.join(FUNCTIONS)}"
            if not called and word in FUNCTIONS:
                return f"{place} is a function and needs parentheses right after it"
            wants_value = called
        elif word == "(":
            is_call = before is not None and before.lastgroup == "name"
            opened.append((before.group().strip() if is_call and before is not None else "(", 0))
            signed = False
        elif kind == "number":
            wants_value = False
        else:
            return f"{place} stands where a value must"
        if len(opened) > MOST_PARENTHESES:
            return f"it nests more than {MOST_PARENTHESES} deep"
    return None
