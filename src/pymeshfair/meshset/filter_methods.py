"""Methods of `MeshSet` for all filters, made at their first use. Type checkers read the generated ``filter_methods.pyi``."""

from __future__ import annotations

from types import MethodType
from typing import TYPE_CHECKING, Any

import pymeshlab

from ..filters.libraries import ImportedWhenUsed
from ..meshlab.base import BASE, UnknownFilterError

if TYPE_CHECKING:
    from .. import registry
    from . import methods
else:  # their import takes longer than that of pymeshlab
    registry, methods = ImportedWhenUsed("pymeshfair.registry"), ImportedWhenUsed("pymeshfair.meshset.methods")


class LateMethods(type):
    """Adds the methods of plugin filters when a missing method or the list of methods is requested."""

    def __getattr__(cls, name: str) -> Any:
        if not name.startswith("_"):
            _add_plugin_methods()
            if name in vars(FilterMethods):
                return getattr(cls, name)
        raise AttributeError(f"type object {cls.__name__!r} has no attribute {name!r}")

    def __dir__(cls) -> list[str]:
        _add_plugin_methods()
        return super().__dir__()


class FilterMethods(metaclass=LateMethods):
    """Has a method for each filter of MeshLab and of plugins, which calls `apply_filter` of the subclass."""

    def __getattr__(self, name: str) -> Any:
        text = f"{type(self).__name__!r} object has no attribute {name!r}"
        if name.startswith("_"):
            raise AttributeError(text)
        _add_plugin_methods()
        if name in vars(FilterMethods):
            return getattr(self, name)
        try:
            methods.known_filter(name)
        except UnknownFilterError as error:
            hint = f"; {error.cause}" if error.cause else f"; did you mean {error.suggestion!r}?" if error.suggestion else ""
            raise AttributeError(f"{text}{hint}") from None
        raise AttributeError(text)

    def __dir__(self) -> list[str]:
        _add_plugin_methods()
        return list(super().__dir__())


class _LateMethod:
    """Descriptor that makes the method of a filter at its first use, as documenting all 300 methods takes a tenth of a second."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, instance: object | None, owner: type) -> Any:
        declared = methods.known_filter(self._name)
        method: Any = getattr(BASE, self._name) if declared is None else methods.filter_method(declared)
        setattr(FilterMethods, self._name, method)
        return method if instance is None else MethodType(method, instance)


def _add_plugin_methods() -> None:
    for declared in registry.custom_filters():
        name = declared.python_name
        if not hasattr(BASE, name) and name not in vars(FilterMethods):
            setattr(FilterMethods, name, _LateMethod(name))


for _name in pymeshlab.filter_list():
    if hasattr(BASE, _name):
        setattr(FilterMethods, _name, _LateMethod(_name))
