"""Stands for a module until something of it is used."""

from __future__ import annotations

import importlib
from typing import Any


class ImportedWhenUsed:
    """A module that is imported when an attribute of it is first asked for.

    Unlike `importlib.util.LazyLoader` it may be used by several threads, before Python 3.12 too, and knows submodules.
    """

    def __init__(self, name: str) -> None:
        """See the class; `name` is that of the module."""
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        """The attribute of the module, or its submodule of that name."""
        if attribute.startswith("__"):
            raise AttributeError(attribute)  # whoever looks at this object, such as a debugger, does not use the module
        module = importlib.import_module(self._name)
        try:
            value = getattr(module, attribute)
        except AttributeError:
            value = importlib.import_module(f"{self._name}.{attribute}")
        setattr(self, attribute, value)
        return value
