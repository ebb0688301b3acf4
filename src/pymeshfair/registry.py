"""Finds filters: pymeshfair's own and third parties' by the same entry points, MeshLab's from the table of facts about them."""

from __future__ import annotations

import functools
import importlib.metadata
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, replace

from .declaration import Filter, nearest
from .errors import UnknownNameError
from .meshlab_facts import meshlab_filters

#: Packages add filters under this entry-point group; the value names a module whose `Filter` objects are taken.
ENTRY_POINT_GROUP = "pymeshfair.plugins"


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or one filter of it, that could not be used.

    Attributes:
        distribution: the package that names the plugin.
        entry_point: as written in its metadata, e.g. ``scanlab = scanlab.filters``.
        reason: one sentence.
        details: the traceback, or an empty string.
    """

    distribution: str
    entry_point: str
    reason: str
    details: str = ""


@dataclass(frozen=True)
class _Registry:
    custom: dict[str, Filter]
    broken: tuple[BrokenPlugin, ...]

    @functools.cached_property
    def by_any_name(self) -> dict[str, Filter]:
        """Every filter under its Python name and under its GUI name."""
        found: dict[str, Filter] = {}
        for known in (*meshlab_filters(), *self.custom.values()):
            found[known.python_name] = known
            found[known.name] = known
        return found


def custom_filters() -> tuple[Filter, ...]:
    """The filters that plugins declare, ours first, in the order of their names."""
    return tuple(_load().custom.values())


def all_filters() -> tuple[Filter, ...]:
    """Every filter, MeshLab's and the plugins', in the order of their Python names."""
    return tuple(sorted((*meshlab_filters(), *custom_filters()), key=lambda f: f.python_name))


def broken_plugins() -> tuple[BrokenPlugin, ...]:
    """Plugins that could not be loaded and filters that were refused; they stop nothing else."""
    return _load().broken


def find_filter(name: str) -> Filter:
    """The filter of that Python name or GUI name.

    Raises:
        UnknownNameError: there is none; the message and the attribute `suggestion` give the nearest name of the same kind.
    """
    known = _load().by_any_name
    try:
        return known[name]
    except KeyError:
        near = nearest(name, known)
        hint = f"; did you mean {near!r}?" if near else "; `pymeshfair list filters` names them all"
        raise UnknownNameError(f"there is no filter {name!r}{hint}", suggestion=near) from None


def reload_plugins() -> None:
    """Forget what was found, so that the next call looks again; needed after a package was installed into a running Python."""
    _load.cache_clear()


@functools.cache
def _load() -> _Registry:
    taken = {name for known in meshlab_filters() for name in (known.python_name, known.name)}
    custom: list[Filter] = []
    broken: list[BrokenPlugin] = []
    for entry in _entry_points():
        distribution = entry.dist.name if entry.dist else "?"
        written = f"{entry.name} = {entry.value}"
        try:
            declared = [f for f in vars(entry.load()).values() if isinstance(f, Filter)]
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
            broken.append(BrokenPlugin(distribution, written, reason, traceback.format_exc()))
            continue
        for found in declared:
            clash = {found.python_name, found.name} & taken
            if clash:
                reason = f"filter {found.python_name!r}: the name {min(clash)!r} is taken by another filter"
                broken.append(BrokenPlugin(distribution, written, reason))
                continue
            taken |= {found.python_name, found.name}
            custom.append(replace(found, origin=distribution))
    custom.sort(key=lambda f: (f.origin != "pymeshfair", f.python_name))
    return _Registry({f.python_name: f for f in custom}, tuple(broken))


def _entry_points() -> Iterator[importlib.metadata.EntryPoint]:
    """The plugins' entry points, ours first so that no other package can take a name of ours."""
    found = importlib.metadata.entry_points(group=ENTRY_POINT_GROUP)
    return iter(
        sorted(found, key=lambda e: (e.dist is None or e.dist.name != "pymeshfair", e.dist.name if e.dist else "", e.name))
    )
