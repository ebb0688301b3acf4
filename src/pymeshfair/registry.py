"""Finds filters: pymeshfair's own and third parties' by the same entry points, MeshLab's from the table of facts about them."""

from __future__ import annotations

import functools
import importlib
import logging
from collections.abc import Iterable
from dataclasses import dataclass, replace
from keyword import iskeyword

from .declaration import Filter, nearest
from .errors import UnknownNameError
from .meshlab.facts import meshlab_filters
from .plugin_loading import ENTRY_POINT_GROUP, BrokenPlugin, load_plugins

__all__ = [
    "ENTRY_POINT_GROUP",
    "BrokenPlugin",
    "all_filters",
    "broken_plugins",
    "custom_filters",
    "find_filter",
    "reload_plugins",
]

_LOG = logging.getLogger("pymeshfair")


@dataclass(frozen=True)
class _Registry:
    custom: dict[str, Filter]
    broken: tuple[BrokenPlugin, ...]

    @functools.cached_property
    def by_any_name(self) -> dict[str, Filter]:
        """Every filter under its Python name and under its GUI name."""
        return _by_any_name((*meshlab_filters(), *self.custom.values()))


def custom_filters() -> tuple[Filter, ...]:
    """The filters that plugins declare, ours first, in the order of their names."""
    return tuple(_load().custom.values())


def all_filters() -> tuple[Filter, ...]:
    """Every filter, MeshLab's and the plugins', in the order of their Python names."""
    return tuple(sorted((*meshlab_filters(), *custom_filters()), key=lambda f: f.python_name))


def broken_plugins() -> tuple[BrokenPlugin, ...]:
    """Plugins that could not be loaded and filters that were refused; they stop nothing else."""
    return _load().broken


def is_known(name: str) -> bool:
    """Whether there is a filter of that Python name or GUI name; takes no time over one that there is not."""
    return name in _load().by_any_name


def find_filter(name: str) -> Filter:
    """The filter of that Python name or GUI name.

    If a plugin declares another filter of that name, which was refused, a warning says so once.

    Raises:
        UnknownNameError: there is none. If a plugin that may declare it cannot be used, message and attribute `cause` name the
            plugin and what is wrong with it; else message and attribute `suggestion` give the nearest name of the same kind.
    """
    registry = _load()
    try:
        declared = registry.by_any_name[name]
    except KeyError:
        raise _unknown(name, registry) from None
    for broken in registry.broken:
        if name in broken.names:
            _warn_once(f"filter {name!r} is that of {declared.origin}; {broken}")
    return declared


def reload_plugins() -> None:
    """Look for plugins again; needed after a package was installed into a running Python, such as a notebook's."""
    importlib.invalidate_caches()
    _load.cache_clear()
    _warn_once.cache_clear()


def _unknown(name: str, registry: _Registry) -> UnknownNameError:
    """Why there is no filter of that name."""
    guilty = [broken for broken in registry.broken if broken.declares(name)]
    if guilty:
        why = "; ".join(map(str, guilty))
        return UnknownNameError(f"filter {name!r} is not there: {why}", cause=why)
    near = _nearest(name, registry.by_any_name)
    hint = f"; did you mean {near!r}?" if near else "; `pymeshfair list filters` names them all"
    cause = "; ".join(str(broken) for broken in registry.broken if broken.details) or None
    also = f" ({cause})" if cause else ""
    return UnknownNameError(f"there is no filter {name!r}{hint}{also}", suggestion=near, cause=cause)


@functools.cache
def _warn_once(text: str) -> None:
    _LOG.warning("%s", text)


def _nearest(name: str, known: Iterable[str]) -> str | None:
    """The nearest Python name to what looks like one, else the nearest GUI name; if there is none, the other way round."""
    kinds: dict[bool, list[str]] = {True: [], False: []}
    for each in known:
        kinds[_looks_like_python(each)].append(each)
    kind = _looks_like_python(name)
    return nearest(name, kinds[kind]) or nearest(name, kinds[not kind])


def _looks_like_python(name: str) -> bool:
    return name.isidentifier() and "_" in name


def _by_any_name(filters: Iterable[Filter]) -> dict[str, Filter]:
    return {name: known for known in filters for name in (known.python_name, known.name)}


@functools.cache
def _load() -> _Registry:
    taken = _by_any_name(meshlab_filters())
    custom: list[Filter] = []
    broken: list[BrokenPlugin] = []
    for plugin in load_plugins(broken):
        for declared in plugin.filters:
            if any(declared.function is other.function for other in custom):
                continue  # imported from another plugin
            reason = _why_unusable(declared, taken)
            if reason is not None:
                broken.append(
                    plugin.broken(f"filter {declared.python_name!r} {reason}", names=(declared.python_name, declared.name))
                )
                continue
            custom.append(replace(declared, origin=plugin.distribution))
            taken |= _by_any_name(custom[-1:])
    custom.sort(key=lambda f: (f.origin != "pymeshfair", f.python_name))
    return _Registry({f.python_name: f for f in custom}, tuple(broken))


def _why_unusable(found: Filter, taken: dict[str, Filter]) -> str | None:
    if found.function is None:
        return "has no function"
    if not found.python_name.isidentifier() or iskeyword(found.python_name) or not found.name.strip():
        return f"needs a Python name and a name for menus; they are {found.python_name!r} and {found.name!r}"
    for name in (found.python_name, found.name):
        if name in taken:
            other = taken[name]
            return f"cannot be added: the name {name!r} is taken by {other.python_name!r} of {other.origin}"
    return None
