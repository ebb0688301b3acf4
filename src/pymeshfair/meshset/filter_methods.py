"""The filters as methods, for `MeshSet` to inherit. Type checkers read ``filter_methods.pyi``, which is generated."""

from __future__ import annotations

import functools
from types import MethodType
from typing import Any

import pymeshlab

from ..declaration import Filter
from ..meshlab.errors import UnknownFilterError
from ..meshlab.facts import meshlab_filters
from ..registry import custom_filters
from .listing import known_filter
from .methods import filter_method


class FilterMethods:
    """One method for each filter, MeshLab's and the plugins'; each calls `apply_filter` of the class that inherits it."""

    def __getattr__(self, name: str) -> Any:
        # Filters of plugins that were installed after the class was made; any other name gets a reason or a suggestion.
        text = f"{type(self).__name__!r} object has no attribute {name!r}"
        if name.startswith("_"):
            raise AttributeError(text)
        try:
            known = known_filter(name)
        except UnknownFilterError as error:
            hint = f"; {error.cause}" if error.cause else f"; did you mean {error.suggestion!r}?" if error.suggestion else ""
            raise AttributeError(f"{text}{hint}") from None
        if known is None or known.python_name != name:
            raise AttributeError(text)
        return functools.partial(filter_method(known), self)


class _MadeWhenAskedFor:
    """Stands for the method of a filter until somebody asks for it: to document all three hundred takes a tenth of a second."""

    def __init__(self, known: Filter) -> None:
        self._known = known

    def __get__(self, instance: object | None, owner: type) -> Any:
        method = filter_method(self._known)
        setattr(FilterMethods, self._known.python_name, method)
        return method if instance is None else MethodType(method, instance)


for _known in (*meshlab_filters(), *custom_filters()):
    if _known.is_builtin == hasattr(pymeshlab.MeshSet, _known.python_name):  # a method that MeshLab lacks, or one of its filters
        setattr(FilterMethods, _known.python_name, _MadeWhenAskedFor(_known))
