"""The syntax of the expressions in MeshLab's filters "by function" and "by condition".

MeshLab evaluates them with muParser. Coordinates, colours and normals by an expression that does not parse become 0 without a
word, so the syntax is checked before anything runs. Names of variables are not: custom attributes of the mesh are variables too.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

#: muParser's functions as MeshLab registers them, with the fewest and the most arguments
FUNCTIONS = {
    **dict.fromkeys(("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"), (1, 1)),
    **dict.fromkeys(("log2", "log10", "log", "ln", "exp", "sqrt", "sign", "rint", "abs"), (1, 1)),
    **dict.fromkeys(("min", "max", "sum", "avg"), (1, None)),
    "atan2": (2, 2),
    "rnd": (0, 0),
}

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?P<operator><=|>=|!=|==|&&|\|\||[-+*/^<>])|(?P<mark>[()?:,])|(?P<end>\Z)|(?P<other>\S))"
)
_WITH_EXPRESSIONS = re.compile(r"_by_function|_by_condition|_new_custom_|_implicit_surface")


def is_expression(filter_name: str, parameter_name: str) -> bool:
    """Whether that text of the filter of that Python name is an expression; the filters of new attributes take a name, too."""
    return _WITH_EXPRESSIONS.search(filter_name) is not None and parameter_name != "name"


@dataclass
class _Level:
    """What is open between two parentheses: of a function, its name and arguments so far; the question marks without a colon."""

    function: str | None = None
    arguments: int = 0
    questions: int = 0


def expression_error(text: str) -> str | None:
    """Why muParser would not parse the text, or None if it would.

    An assignment (``q = 0``) and several results (``x, y``), which muParser lets pass, are refused too: where a filter asks for
    one value they are slips.
    """
    levels = [_Level()]
    wants_value = True
    signed = False  # muParser takes one sign before a value, not two
    position = 0
    previous: str | None = None
    while True:
        token = _TOKEN.match(text, position)
        assert token is not None  # the pattern takes any character and the end
        kind, word = token.lastgroup or "", token.group().strip()
        where = f"{word!r} at character {token.start(kind) + 1}"
        position = token.end()
        level = levels[-1]
        if kind == "end":
            break
        if kind == "other":
            return f"{where} has no meaning there" if word != "=" else f"{where} assigns; write == to compare"
        if kind in ("number", "name"):
            if not wants_value:
                return f"{where} follows a value; an operator is missing"
            if kind == "name" and word in FUNCTIONS and text[position:].lstrip()[:1] != "(":
                return f"{where} is a function and needs parentheses"
            wants_value, signed = False, False
            previous = word if kind == "name" else None
            if text[position:].lstrip()[:1] == "(":
                if previous not in FUNCTIONS:
                    return f"{where} is not a function; these are: {', '.join(sorted(FUNCTIONS))}"
                levels.append(_Level(function=word, arguments=1))
                position = text.index("(", position) + 1
                wants_value = True
                if text[position:].lstrip()[:1] == ")":
                    levels[-1].arguments = 0
                    wants_value = False
        elif word == "(":
            if not wants_value:
                return f"{where} follows a value; an operator is missing"
            levels.append(_Level())
            signed = False
        elif wants_value:
            if word not in ("+", "-") or signed:
                return f"{where} stands where a value must"
            signed = True
        elif kind == "operator":
            wants_value = True
        elif word == "?":
            level.questions += 1
            wants_value = True
        elif word == ":":
            if level.questions == 0:
                return f"{where} has no question mark before it"
            level.questions -= 1
            wants_value = True
        else:
            if level.questions:
                return f"a question mark before character {position} has no colon"
            if word == ",":
                if level.function is None:
                    return f"{where} is outside a function"
                level.arguments += 1
                wants_value = True
            elif len(levels) == 1:
                return f"{where} closes nothing"
            else:
                if error := _argument_error(level):
                    return error
                levels.pop()
                wants_value = False
    if wants_value:
        return "it is empty" if not text.strip() else "it ends where a value must follow"
    if levels[-1].questions:
        return "a question mark has no colon"
    return "a parenthesis is not closed" if len(levels) > 1 else None


def _argument_error(level: _Level) -> str | None:
    if level.function is None:
        return None
    fewest, most = FUNCTIONS[level.function]
    if level.arguments < fewest or (most is not None and level.arguments > most):
        needed = str(fewest) if fewest == most else f"at least {fewest}"
        return f"{level.function!r} takes {needed} argument{'' if needed == '1' else 's'}, got {level.arguments}"
    return None
