"""The stub that tells type checkers and editors which methods `MeshSet` has for pymeshfair's filters."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pymeshfair.declaration import Enum, Filter, Parameter
from pymeshfair.meshset.methods import annotation_text, method_docstring, shown_default
from pymeshfair.registry import custom_filters

STUB = Path(__file__).parents[1] / "src/pymeshfair/meshset/filter_methods.pyi"

_LINE = 130
_HEAD = '''\
# Written by `python tools/generate.py stubs` from the declarations of the filters; change those instead.
"""The filters of plugins as methods, for `MeshSet` to inherit."""

from collections.abc import Sequence
from typing import Any, Literal

from .methods import LengthLike

class FilterMethods:
    """One method for each filter of a plugin."""

    def __getattr__(self, name: str) -> Any: ...
'''


def format_stub() -> str:
    """The text of the stub for the filters that pymeshfair itself declares."""
    own = sorted((known for known in custom_filters() if known.origin == "pymeshfair"), key=lambda known: known.python_name)
    text = _HEAD + "".join(f"{line}\n" for known in own for line in method_text(known))
    unused = {"Sequence": "from collections.abc import Sequence\n", "Literal": ", Literal", "LengthLike": "LengthLike"}
    body = text.removeprefix(_HEAD)
    for name in ("Sequence", "Literal"):
        if name not in body:
            text = text.replace(unused[name], "", 1)
    return text.rstrip("\n") + "\n"


def method_text(known: Filter) -> Iterator[str]:
    """The lines of a filter's method within the class."""
    if known.parameters:
        yield f"    def {known.python_name}("
        yield "        self,"
        yield "        *,"
        for parameter in known.parameters:
            yield from _argument(parameter)
        yield "    ) -> dict[str, Any] | None:"
    else:
        yield f"    def {known.python_name}(self) -> dict[str, Any] | None:"
    first, *rest = method_docstring(known).replace("\\", "\\\\").replace('"""', '\\"\\"\\"').splitlines()
    yield f'        """{first}'
    for line in rest:
        yield f"        {line}".rstrip()
    yield '        """'
    yield ""


def _argument(parameter: Parameter) -> Iterator[str]:
    annotation = annotation_text(parameter).replace("'", '"')
    default = repr(shown_default(parameter))
    if default.startswith("'") and '"' not in default:
        default = f'"{default[1:-1]}"'
    line = f"        {parameter.name}: {annotation} = {default},"
    if len(line) <= _LINE or not isinstance(parameter, Enum):
        yield line
    else:
        yield f"        {parameter.name}: Literal["
        yield f"            {annotation.removeprefix('Literal[').removesuffix(']')}"
        yield f"        ] = {default},"
