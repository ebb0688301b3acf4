"""`MeshSet`: pymeshlab's mesh set with the filters of plugins as methods beside MeshLab's own."""

from __future__ import annotations

import functools
from typing import Any

import pymeshlab

from ..registry import custom_filters
from .errors import UnknownFilterError
from .listing import filter_list, known_filter
from .methods import filter_method
from .script import ScriptedMeshSet


class MeshSet(ScriptedMeshSet):
    """A set of meshes that filters are applied to, a drop-in for `pymeshlab.MeshSet`.

    Filters of plugins, pymeshfair's own among them, behave as MeshLab's do: each is a method, a name for `apply_filter`, and a
    step of filter scripts. They change the current mesh in place and keep everything else of it; a `pymeshlab.Mesh` fetched
    before shows the new state.

    A filter that moves the vertices of a mesh with faces uses up one of MeshLab's ids, and one that adds elements two, so those
    of layers made later skip numbers. Scripts do not count them.
    """

    filter_list = staticmethod(filter_list)

    def __getattr__(self, name: str) -> Any:
        # Filters of plugins that were installed after the class was made; a misspelt name gets a suggestion.
        text = f"{type(self).__name__!r} object has no attribute {name!r}"
        if name.startswith("_"):
            raise AttributeError(text)
        try:
            known = known_filter(name)
        except UnknownFilterError as error:
            raise AttributeError(f"{text}; did you mean {error.suggestion!r}?" if error.suggestion else text) from None
        if known is None or known.python_name != name:
            raise AttributeError(text)
        return functools.partial(filter_method(known), self)


for _known in custom_filters():
    if not hasattr(pymeshlab.MeshSet, _known.python_name):
        setattr(MeshSet, _known.python_name, filter_method(_known))
