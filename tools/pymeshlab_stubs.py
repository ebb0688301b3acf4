"""The stub of pymeshlab's classes, which pymeshfair hands on: from what pymeshlab says of itself, as it ships no types."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pymeshlab

from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.meshset import methods

STUB = Path(__file__).parents[1] / "src/pymeshfair/meshset/pymeshlab_classes.pyi"
_HEAD = '''\
# Written by `python tools/generate.py stubs` from what pymeshlab says of itself.
"""Pymeshlab's classes and functions, for type checkers; there is no such module when a program runs."""

from collections.abc import Iterator
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray
'''
_SPECIAL = {"__init__", "__len__", "__getitem__", "__iter__"}
_LINE = 130
_OVERLOAD = re.compile(r"^\d+\. ", re.MULTILINE)


def format_stub() -> str:
    """The text of the stub."""
    public = {name: value for name, value in vars(pymeshlab).items() if not name.startswith("_")}
    exceptions = [f"class {name}(Exception): ..." for name, kind in public.items() if _is(kind, error=True)]
    classes = [_class(name, kind) for name, kind in public.items() if _is(kind, error=False)]
    functions = [
        _signature(f.__doc__ or "", "") for name, f in public.items() if inspect.isbuiltin(f) and not hasattr(methods, name)
    ]
    text = "\n".join([*sorted(exceptions), "", *sorted(classes), *sorted(functions), ""])
    names = sorted(re.findall(r"^(?:class|def) ([A-Za-z]\w*)", text, re.MULTILINE))
    return "\n".join([_HEAD, "__all__ = [", *(f'    "{name}",' for name in names), "]", "", text])


def _is(kind: object, *, error: bool) -> bool:
    return inspect.isclass(kind) and issubclass(kind, Exception) == error


def _class(name: str, kind: type) -> str:
    # the one that `pymeshfair.MeshSet` extends is not handed on
    return "\n".join([f"class {'_MeshSet' if kind is pymeshlab.MeshSet else name}:", *_methods(kind), ""])


def _methods(kind: type) -> Iterator[str]:
    filters = {known.python_name for known in meshlab_filters()}
    for name, member in vars(kind).items():
        text = getattr(member, "__doc__", None) or ""
        if name in filters or (name.startswith("_") and name not in _SPECIAL) or f"{name}(" not in text:
            continue
        several = _OVERLOAD.split(text)[1:]
        for one in several or [text]:
            if several:
                yield "    @overload"
            yield _signature(one, "    ")


def _signature(text: str, margin: str) -> str:
    """The line of a stub for the first line of a docstring as pybind11 writes it."""
    found = re.match(r"(\w+)\((.*)\) -> (.*)", text.splitlines()[0])
    assert found is not None, text
    name, given, result = found.groups()
    given = re.sub(r"= array\(.*?dtype=\w+\)", "= ...", given)
    given = re.sub(r"self: [\w.]+", "self", given)
    given = given.replace("**kwargs", "**kwargs: Any")
    given = re.sub(r"arg\d: ([\w.]+)(?=$|, )", r"value: \1, /", given).replace("'", '"')
    line = f"{margin}def {name}({_types(given)}) -> {_types(result)}: ..."
    if len(line) <= _LINE:
        return line
    parameters = "".join(f"{margin}    {part},\n" for part in _types(given).split(", "))
    return f"{margin}def {name}(\n{parameters}{margin}) -> {_types(result)}: ..."


def _types(text: str) -> str:
    def array(match: re.Match[str]) -> str:
        kind = {"bool": "np.bool_"}.get(match[1], match[1].replace("numpy.", "np."))
        return f"NDArray[{kind}]"

    text = re.sub(r"numpy\.ndarray\[([\w.]+)\[[^\]]*\]\]", array, text).replace("pymeshlab.pmeshlab.", "")
    return re.sub(r"\bdict\b(?!\[)", "dict[str, Any]", re.sub(r": object\b", ": Any", text))
