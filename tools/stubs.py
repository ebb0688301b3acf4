"""The stub that tells type checkers and editors which methods `MeshSet` has for the filters, pymeshfair's and MeshLab's."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pymeshfair.declaration import AUTO, Color, Enum, Filter, FilterClass, Matrix, Parameter, Percentage, Point, Shot
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.meshset.methods import method_docstring, shown_default
from pymeshfair.registry import custom_filters

STUB = Path(__file__).parents[1] / "src/pymeshfair/meshset/filter_methods.pyi"

_LINE = 130
#: a default of more characters, such as a grammar, is left out
_LONGEST_DEFAULT = 90
#: the kinds of parameter whose type has a name in `pymeshfair.meshset.methods`
_LIKE = {Percentage: "LengthLike", Point: "PointLike", Color: "ColorLike", Matrix: "MatrixLike", Shot: "Any"}
_HEAD = '''\
# Written by `python tools/generate.py stubs` from the declarations of the filters; change those instead.
"""The filters as methods, for `MeshSet` to inherit."""

from typing import Any, Literal

from .methods import ColorLike, LengthLike, MatrixLike, PointLike

class LateMethods(type): ...

class FilterMethods(metaclass=LateMethods):
    """One method for each filter, MeshLab's and pymeshfair's; those of other plugins are given to `apply_filter`."""

'''


def format_stub() -> str:
    """The text of the stub for MeshLab's filters and those that pymeshfair itself declares."""
    known = [*meshlab_filters(), *(found for found in custom_filters() if found.origin == "pymeshfair")]
    lines = (line for found in sorted(known, key=lambda found: found.python_name) for line in method_text(found))
    return (_HEAD + "".join(f"{line}\n" for line in lines)).rstrip("\n") + "\n"


def method_text(known: Filter) -> Iterator[str]:
    """The lines of a filter's method within the class."""
    reports = "dict[str, Any]" if measures(known) else "Any" if known.is_builtin else "dict[str, Any] | None"
    if known.parameters:
        yield f"    def {known.python_name}("
        yield "        self,"
        yield "        *,"
        for parameter in known.parameters:
            yield from _argument(parameter)
        yield f"    ) -> {reports}:"
    else:
        yield f"    def {known.python_name}(self) -> {reports}:"
    first, *rest = method_docstring(known).replace("\\", "\\\\").replace('"""', '\\"\\"\\"').splitlines()
    yield f'        """{first}'
    for line in rest:
        yield f"        {line}".rstrip()
    yield '        """'
    yield ""


def measures(known: Filter) -> bool:
    """Whether a filter always reports something; of MeshLab's others no table says it."""
    return FilterClass.MEASURE in known.classes and known.python_name.startswith("get_")


def annotation_text(parameter: Parameter) -> str:
    """The type of a parameter as the stub says it."""
    if isinstance(parameter, Enum):
        return f"Literal[{', '.join(map(repr, parameter.choices))}]".replace("'", '"')
    own = parameter.python_type.__name__
    text = next((like for of, like in _LIKE.items() if isinstance(parameter, of)), own)
    return text if parameter.automatic is None or text == "LengthLike" else f'{text} | Literal["{AUTO}"]'


def _argument(parameter: Parameter) -> Iterator[str]:
    annotation = annotation_text(parameter)
    default = repr(shown_default(parameter))
    if parameter.default is None or len(default) > _LONGEST_DEFAULT:
        default = "..."
    if default.startswith("'") and '"' not in default:
        default = f'"{default[1:-1]}"'
    line = f"        {parameter.name}: {annotation} = {default},"
    if len(line) <= _LINE or not isinstance(parameter, Enum):
        yield line
    else:
        choices = f"            {annotation.removeprefix('Literal[').removesuffix(']')}"
        yield f"        {parameter.name}: Literal["
        if len(choices) <= _LINE:
            yield choices
        else:
            yield from (f'            "{word}",' for word in parameter.choices)
        yield f"        ] = {default},"
