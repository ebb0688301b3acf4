"""Parameters that filters share as one annotated dataclass."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import typing
from collections.abc import Callable
from typing import Any, TypeGuard

from .layer import Edit, Layer


def is_group(hint: Any) -> TypeGuard[type[Any]]:
    """Whether a parameter's type is a dataclass, whose fields then are parameters of the filter."""
    return isinstance(hint, type) and dataclasses.is_dataclass(hint)


def gathering(function: Callable[..., Edit]) -> Callable[..., Edit]:
    """The function that takes the fields of its groups one by one; the function itself if it has no group."""
    hints = typing.get_type_hints(function)
    groups = {
        name: hints[name]
        for name, argument in inspect.signature(function).parameters.items()
        if argument.kind is argument.KEYWORD_ONLY and is_group(hints.get(name))
    }
    if not groups:
        return function

    @functools.wraps(function)
    def gathered(layer: Layer, **values: Any) -> Edit:
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in dataclasses.fields(group)})
        return function(layer, **values)

    return gathered
