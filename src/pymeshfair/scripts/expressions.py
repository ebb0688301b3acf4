"""The syntax of the expressions in MeshLab's filters "by function" and "by condition".

MeshLab evaluates them with muParser. Coordinates, colours and normals by an expression that does not parse become 0 without a
word, so the syntax is checked before anything runs. Names of variables are not: custom attributes of the mesh are variables too.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any

from ..declaration import Filter, String
from ..errors import ParameterError

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


def check_expressions(known: Filter, values: Mapping[str, Any]) -> None:
    """Check the values of a filter, by Python parameter name, that are expressions."""
    for parameter in known.parameters:
        if parameter.name in values and isinstance(parameter, String) and is_expression(known.python_name, parameter.xml_name):
            text = values[parameter.name]
            if (error := expression_error(text)) is not None:
                raise ParameterError(
                    f"parameter {parameter.name!r}: {text!r} is no expression that MeshLab can evaluate: {error}"
                )


def expression_error(text: str) -> str | None:
    """The reason why muParser would not parse the text, or None if it would.

    An assignment (``q = 0``) and several results (``x, y``), which muParser lets pass, are refused too: where a filter asks for
    one value they are slips.
    """
    if not text.strip():
        return "it is empty"
    if len(text) > MOST_CHARACTERS:
        return f"it has more than {MOST_CHARACTERS} characters"
    try:
        _Expression(text).parse()
    except _SyntaxRefusedError as error:
        return str(error)
    return None


class _SyntaxRefusedError(Exception):
    """The expression does not parse; the message says where and why."""


class _Expression:
    """Descends through: choice = sum ["?" choice ":" choice]; sum = operand {operator operand}."""

    def __init__(self, text: str) -> None:
        self._tokens = list(_TOKEN.finditer(text))
        self._next = 0
        self._depth = 0

    @property
    def _word(self) -> str:
        return self._tokens[self._next].group().strip()

    @property
    def _kind(self) -> str | None:
        return self._tokens[self._next].lastgroup

    def parse(self) -> None:
        self._choice()
        if self._kind != "end":
            self._refuse("is not expected there" if self._word in (")", ":", ",") else "follows a value without an operator")

    def _refuse(self, reason: str) -> None:
        token = self._tokens[self._next]
        if self._kind == "end":
            raise _SyntaxRefusedError("it ends where more must follow")
        if self._word == "=":
            reason = "assigns; write == to compare"
        raise _SyntaxRefusedError(f"{self._word!r} at character {token.start(token.lastgroup or 0) + 1} {reason}")

    def _accept(self, word: str) -> bool:
        if self._word != word:
            return False
        self._next += 1
        return True

    def _expect(self, word: str) -> None:
        if not self._accept(word):
            self._refuse(f"stands where {word!r} must")

    def _choice(self) -> None:
        self._sum()
        while self._accept("?"):
            self._deeper(self._choice)
            self._expect(":")
            self._sum()

    def _sum(self) -> None:
        self._operand()
        while self._word in OPERATORS:
            self._next += 1
            self._operand()

    def _operand(self) -> None:
        if self._word in ("+", "-"):  # muParser takes one sign, not two
            self._next += 1
        if self._accept("("):
            self._deeper(self._choice)
            self._expect(")")
        elif self._kind == "number":
            self._next += 1
        elif self._kind == "name":
            self._variable_or_function()
        else:
            self._refuse("stands where a value must")

    def _variable_or_function(self) -> None:
        name = self._word
        called = self._tokens[self._next + 1].group() == "("  # no blank between: muParser does not take one
        if called and name not in FUNCTIONS:
            self._refuse(f"is not a function of {', '.join(FUNCTIONS)}")
        if not called and name in FUNCTIONS:
            self._refuse("is a function and needs parentheses right after it")
        self._next += 1
        if not called:
            return
        self._expect("(")
        arguments = 0
        if self._word != ")":
            arguments = 1
            self._deeper(self._choice)
            while self._accept(","):
                arguments += 1
                self._deeper(self._choice)
        fewest, most = FUNCTIONS[name]
        if self._word == ")" and (arguments < fewest or (most is not None and arguments > most)):
            self._refuse(f"ends {name}() after {arguments} arguments; it takes {fewest}{'' if fewest == most else ' or more'}")
        self._expect(")")

    def _deeper(self, part: Callable[[], None]) -> None:
        self._depth += 1
        if self._depth > MOST_PARENTHESES:
            raise _SyntaxRefusedError(f"it nests more than {MOST_PARENTHESES} deep")
        part()
        self._depth -= 1
